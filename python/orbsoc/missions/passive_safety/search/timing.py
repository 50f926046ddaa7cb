"""When the impulses are: equally spaced, the second one where the plan is cheapest, or as many as pay.

The first drift has other rules than the later ones, so its end, the second impulse, is searched: a scan, then a golden
section in the cell of the best. A later impulse of size 0 adds a cone that the one before it implies, so impulses at
candidate times lose nothing, and those of size 0 are dropped. Where no time of the scan is feasible, the times are searched
at which the conditions are broken least; where these are none either, a proof is tried that holds between them. Without a
keep-out, impulses are generated over the whole window.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from math import ceil, inf, pi, sqrt

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.impulses import (
    INSTANTS,
    ImpulseProgramme,
    Impulses,
    Nowhere,
    primer_arcs,
    primer_ceiling,
)
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from ..model.margins import Margins
from ..model.problem import GIVEN_UP, MISS, assemble
from ..scenario import DEFAULT_COUNT
from .anywhere import generated_anywhere
from .impossible import proved_impossible

TOLERANCE = 1e-9
ACCEPTED = 1e-6
"""Residuals up to which a point is taken that its solver left short of its tolerance: at the end of the times that are
feasible the constraints leave no interior."""
SCAN = 48
"""Times of the second impulse that are tried before the best is refined."""
CANDIDATES = (24, 60)
"""An orbit of the duration: times between the second impulse and the end at which another one is tried, in the scan and then."""
MOST_CANDIDATES = 120
SMALL = 1e-5
"""Of the total: smaller impulses are left out before a generated plan is solved again without them."""
FEWER = 1e-3
"""Of the cost that a generated plan may give away for fewer impulses: where the bound of safety is followed for a while,
the optimum is a long row of small ones."""
PRIMER_ROUNDS, TOO_LONG = 3, 1.0 + 1e-4
"""Of times added to a generated plan in the middle of arcs on which the primer is longer than that."""
MANY = 16
"""Impulses after the second; of more, a quarter is left out at a time."""
LEAST_BROKEN = 8
"""Times, of those that break the conditions least, at which the whole problem is tried."""
WITHIN_S = 0.02
"""Of the second impulse's time."""


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One problem with given times; `cost` is infinite where it has no solution."""

    impulses: Impulses
    row: Iteration
    cost: float

    @property
    def solution(self) -> Solution:
        return self.row.solution

    @property
    def second_s(self) -> float:
        """Time of the second impulse."""
        return float(self.impulses.times_s[min(1, len(self.impulses.times_s) - 1)])


@dataclass(frozen=True, slots=True, eq=False)
class Timed:
    """The best trial, the programme it gives, and every trial in order; None where nothing was feasible."""

    best: Trial | None
    programme: ImpulseProgramme | None
    trials: tuple[Trial, ...] = field(repr=False)
    scanned: int = 0
    """How many of the trials are the scan's."""
    ends: bool = False
    """Whether the last impulse is at the end, to match a velocity there."""
    densest: Trial | None = field(default=None, repr=False)
    """Of a generated plan, the optimum over all candidate times."""

    later: float | None = None
    """Below the cost of every programme with the plan's first two times and impulses at any later times."""
    primer: tuple[float, float] | None = None
    """Of a plan generated over the whole window: the largest primer at `INSTANTS`, and a ceiling between them."""
    relaxed: int = 0
    """How many further times were tried for the conditions that they break least."""
    nowhere: Nowhere | None = None
    """The proof that no time of the second impulse will do."""

    @property
    def lower_bound(self) -> float | None:
        """Below the cost of every programme with impulses at any times; None where only given times were solved."""
        if self.primer is None or self.best is None:
            return None
        return self.best.solution.dual_objective / max(1.0, self.primer[1])

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        return tuple(trial.row for trial in self.trials)

    @property
    def wells(self) -> int:
        """Local minima of the scan."""
        costs = [inf, *(trial.cost for trial in self.trials[: self.scanned]), inf]
        return sum(b < inf and a > b <= c for a, b, c in zip(costs, costs[1:], costs[2:], strict=False))


def usable(solution: Solution) -> bool:
    """Whether a solution is a point to plan with: solved, or nearly so by its residuals on the original data."""
    if solution.status is Status.SOLVED:
        return True
    short = (Status.SOLVED_INACCURATE, Status.NUMERICAL_LIMIT, Status.MAX_ITERATIONS)
    found = solution.certificate
    return solution.status in short and max(found.primal_residual, found.dual_residual, found.gap) <= ACCEPTED


def plan_times(
    approach: Approach, solve: Solve, callback: Callable[[Iteration], None] | None = None
) -> Timed:
    """Solve the scenario's problem with its timing. `solve` raises KeyboardInterrupt where it was interrupted."""
    trials: list[Trial] = []

    def attempt(times: Array) -> Trial:
        margins = Margins.of(approach, times.size)
        impulses = assemble(approach, times, margins=margins)
        problem = impulses.builder.build()
        solution = solve(problem, Settings(tol=TOLERANCE))
        cost = solution.objective if usable(solution) else inf
        figures = {"second_s": float(times[min(1, times.size - 1)]), "cost_m_s": cost}
        row = Iteration(len(trials) + 1, TOLERANCE, problem, solution, figures=figures)
        trials.append(Trial(impulses, row, cost))
        if callback is not None:
            callback(row)
        return trials[-1]

    if approach.scenario.impulses.timing == "equal":
        attempt(equal_times(approach))
        return _timed(approach, trials, 0)
    if approach.scenario.impulses.timing == "generated" and not approach.guarded:
        return _anywhere(approach, solve, callback)
    latest = (
        min(approach.duration_s, pi / approach.mean_motion_rad_s) if approach.guarded else approach.duration_s
    )
    for second in np.linspace(0.0, latest, SCAN + 2)[1:-1]:
        attempt(times_after(approach, float(second), CANDIDATES[0]))
    cell, relaxed = latest / (SCAN + 1), 0
    if all(trial.cost == inf for trial in trials):
        seconds, relaxed = _least_broken(approach, solve, latest)
        for second in seconds:
            attempt(times_after(approach, second, CANDIDATES[0]))
    best = min(trials, key=lambda trial: trial.cost)
    if relaxed and best.cost < inf:
        _feasible_edges(attempt, approach, best.second_s, cell)
        good = [trial.second_s for trial in trials if trial.cost < inf]
        _golden(
            lambda second: attempt(times_after(approach, second, CANDIDATES[1])).cost, min(good), max(good)
        )
    elif best.cost < inf:
        _golden(
            lambda second: attempt(times_after(approach, second, CANDIDATES[1])).cost,
            max(0.01 * cell, best.second_s - cell),
            min(latest - 0.01 * cell, best.second_s + cell),
        )
    found = replace(_timed(approach, trials, SCAN), relaxed=relaxed)
    if all(trial.solution.status is Status.PRIMAL_INFEASIBLE for trial in trials):
        return replace(found, nowhere=_nowhere(approach, solve))
    if approach.scenario.impulses.timing == "generated" and found.best is not None:
        return _fewer(_any_later(approach, found, attempt), attempt, trials)
    return found


def _anywhere(approach: Approach, solve: Solve, callback: Callable[[Iteration], None] | None) -> Timed:
    """Impulses at any times, by primer rounds."""

    def row(found: Iteration, impulses: Impulses) -> Trial:
        cost = found.solution.objective if usable(found.solution) else inf
        second = float(impulses.times_s[min(1, impulses.times_s.size - 1)])
        return Trial(impulses, replace(found, figures={"second_s": second, "cost_m_s": cost}), cost)

    def note(iteration: Iteration) -> None:
        if callback is not None:
            callback(iteration)

    found, built = generated_anywhere(approach, solve, note)
    trials = tuple(row(each, made) for each, made in zip(found.subproblems, built, strict=True))
    best = next(trial for trial in trials if trial.solution is found.solution)
    if best.cost == inf:
        return Timed(None, None, trials)
    ceiling = primer_ceiling(found.impulses, found.solution, (0.0, approach.duration_s))
    return Timed(best, found.programme, trials, ends=approach.capture_velocity is not None, primer=ceiling)


def _nowhere(approach: Approach, solve: Solve) -> Nowhere | None:
    """With the other impulses where a plan has them; generated ones may be anywhere after the second."""
    if approach.scenario.impulses.timing == "generated":
        return proved_impossible(approach, None, solve)
    return proved_impossible(approach, lambda second: times_after(approach, second, CANDIDATES[0]), solve)


def _feasible_edges(
    attempt: Callable[[Array], Trial], approach: Approach, second_s: float, cell_s: float
) -> None:
    """Bisect for both ends of the interval of feasible times about one; what it finds is among the trials."""
    for step in (-cell_s, cell_s):
        inside, outside = second_s, second_s + step
        while abs(outside - inside) > WITHIN_S:
            middle = 0.5 * (inside + outside)
            good = attempt(times_after(approach, middle, CANDIDATES[0])).cost < inf
            inside, outside = (middle, outside) if good else (inside, middle)


def _least_broken(approach: Approach, solve: Solve, latest_s: float) -> tuple[list[float], int]:
    """Times of the second impulse at which the conditions, relaxed, are broken least; and how many were tried."""
    tried: dict[float, float] = {}

    def broken(second: float) -> float:
        if second not in tried:
            times = times_after(approach, second, CANDIDATES[0])
            impulses = assemble(approach, times, margins=Margins.of(approach, times.size), relaxed=True)
            solution = solve(impulses.builder.build(), Settings(tol=TOLERANCE))
            gaps = [float(impulses.builder.value(solution, name)[0]) for name in (MISS, GIVEN_UP)]
            tried[second] = sum(gaps) if usable(solution) else inf
        return tried[second]

    grid = np.linspace(0.0, latest_s, SCAN + 2)[1:-1].tolist()
    values = [inf, *map(broken, grid), inf]
    wells = [k for k in range(SCAN) if values[k + 1] < inf and values[k] > values[k + 1] <= values[k + 2]]
    cell = latest_s / (SCAN + 1)
    for k in wells:
        _golden(broken, max(0.01 * cell, grid[k] - cell), min(latest_s - 0.01 * cell, grid[k] + cell))
    return sorted(tried, key=lambda second: tried[second])[:LEAST_BROKEN], len(tried)


def equal_times(approach: Approach) -> Array:
    """(i − 1) T/N; with an impulse at the end, (i − 1) T/(N − 1)."""
    count = approach.scenario.impulses.count or DEFAULT_COUNT["equal"]
    times = np.linspace(0.0, approach.duration_s, count + (approach.capture_velocity is None))
    return times if approach.capture_velocity is not None else times[:-1]


def times_after(approach: Approach, second_s: float, candidates: int) -> Array:
    """The first impulse, the second at its time, and the others, or that many candidates an orbit, equally spaced to the end."""
    impulses = approach.scenario.impulses
    at_end = approach.capture_velocity is not None
    pieces = (impulses.count or DEFAULT_COUNT["free"] + at_end) - 1 - at_end
    if impulses.timing == "generated":
        # as many whenever the second one is, so that all problems of a scan have one pattern
        pieces = min(MOST_CANDIDATES, ceil(candidates * approach.duration_s / approach.period_s))
    rest = np.linspace(second_s, approach.duration_s, pieces + 1)
    return np.concatenate([[0.0], rest if at_end else rest[:-1]])


def _golden(cost: Callable[[float], float], low: float, high: float) -> None:
    """Golden section to `WITHIN_S`; what it finds is among the trials."""
    ratio = (sqrt(5.0) - 1.0) / 2.0
    one, two = high - ratio * (high - low), low + ratio * (high - low)
    at_one, at_two = cost(one), cost(two)
    while high - low > WITHIN_S:
        if at_one <= at_two:
            high, two, at_two = two, one, at_one
            one = high - ratio * (high - low)
            at_one = cost(one)
        else:
            low, one, at_one = one, two, at_two
            two = low + ratio * (high - low)
            at_two = cost(two)


def _any_later(approach: Approach, found: Timed, attempt: Callable[[Array], Trial]) -> Timed:
    """With impulses at more times between the candidates, where the primer asks for them, and the bound for all of them.

    Nothing with conditions that hold of one drift only, or at samples: another impulse would end them.
    """
    best, bound = found.best, 0.0
    assert best is not None
    if approach.scenario.safety != "cone" or approach.scenario.interruption_orbits:
        return found
    for number in range(PRIMER_ROUNDS + 1):
        times, solution = best.impulses.times_s, best.solution
        arcs = primer_arcs(
            best.impulses, solution, (float(times[1]), approach.duration_s), INSTANTS // PRIMER_ROUNDS
        )
        bound = max(bound, solution.dual_objective / max(1.0, float(arcs[:, 3].max())))
        long = arcs[:, 3] > TOO_LONG
        if not long.any() or number == PRIMER_ROUNDS:
            break
        denser = attempt(np.union1d(times, arcs[long, :2].mean(axis=1)))
        if denser.cost == inf:
            break
        best = denser
    programme = best.impulses.programme(best.solution)
    programme = programme.without_small(SMALL * programme.total_m_s)
    return replace(found, best=best, programme=programme, later=bound)


def _fewer(found: Timed, attempt: Callable[[Array], Trial], trials: list[Trial]) -> Timed:
    """The plan without its smallest impulses after the second, as long as that costs next to nothing: many at a time while
    there are many, then one by one.

    The first two stay, whatever their sizes: the rules of the first drift are theirs.
    """
    densest, programme = found.best, found.programme
    assert densest is not None
    assert programme is not None
    best, times, count, together = densest, densest.impulses.times_s, 1, True
    kept = np.unique(np.concatenate([times[:2], programme.times_s, times[-1:] if found.ends else []]))
    while True:
        trial = attempt(kept)
        if trial.cost <= densest.cost * (1.0 + FEWER):
            best = trial
        elif count == 1:
            break
        else:
            together = False
        sizes = best.impulses.programme(best.solution).sizes_m_s
        inner = sizes[2 : sizes.size - found.ends]
        if not inner.size:
            break
        count = inner.size // 4 if together and inner.size > MANY else 1
        kept = np.delete(best.impulses.times_s, 2 + np.argsort(inner, kind="stable")[:count])
    programme = best.impulses.programme(best.solution)
    worth = programme.worth_firing
    worth[:2] = True
    worth[len(worth) - found.ends :] = True
    programme = ImpulseProgramme(programme.times_s[worth], programme.dv_m_s[worth])
    return replace(found, best=best, programme=programme, trials=tuple(trials), densest=densest)


def _timed(approach: Approach, trials: list[Trial], scanned: int) -> Timed:
    best, ends = min(trials, key=lambda trial: trial.cost), approach.capture_velocity is not None
    if best.cost == inf:
        return Timed(None, None, tuple(trials), scanned)
    programme = best.impulses.programme(best.solution)
    if approach.scenario.impulses.timing == "generated":
        programme = programme.without_small(SMALL * programme.total_m_s)
    return Timed(best, programme, tuple(trials), scanned, ends=ends)
