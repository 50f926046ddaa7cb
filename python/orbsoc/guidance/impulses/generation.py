"""Impulse times by column generation: the primer says where another impulse pays, and how much at most."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire

from ..scp import Iteration, Solve, within_residual
from .programme import ImpulseProgramme
from .unknowns import KICK, Impulses

GRID = 240
"""Intervals of the window on which the primer is looked at before its maxima are refined."""
INSTANTS = 10_000
"""Of the window, at which the primer of a finished plan is looked at."""
NEGLIGIBLE = 1e-6
"""Of the total: smaller impulses are dropped from round to round."""


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One round: the impulse times, what the programme costs, a bound below every programme's cost, the primer."""

    times_s: Array
    cost: float
    lower_bound: float
    largest_primer: float
    """Relative to 1, where no other impulse pays."""
    at_s: float
    solution: Solution = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Generated:
    """How column generation ended: the impulses of the last round, the best bound, every round, every solve."""

    impulses: Impulses
    solution: Solution
    rounds: tuple[Round, ...]
    subproblems: tuple[Iteration, ...]

    @property
    def programme(self) -> ImpulseProgramme:
        """The impulses that are not negligible."""
        found = self.impulses.programme(self.solution)
        return found.without_small(NEGLIGIBLE * found.total_m_s)

    @property
    def solved(self) -> bool:
        """Whether the last solve counts, so that there is a programme."""
        return any(each.solution is self.solution for each in self.rounds)

    @property
    def lower_bound(self) -> float:
        """No programme with any number of impulses in the window costs less, by the primer at its refined maxima."""
        return max((each.lower_bound for each in self.rounds), default=-np.inf)

    @property
    def gap(self) -> float:
        """(cost − bound) / cost of the last round; NaN where nothing was solved."""
        if not self.rounds:
            return float("nan")
        cost = self.rounds[-1].cost
        return (cost - self.lower_bound) / max(abs(cost), 1e-12)


def generate(
    build: Callable[[Array], Impulses],
    times_s: ArrayLike,
    window_s: tuple[float, float],
    *,
    solve: Solve,
    candidates_s: ArrayLike | None = None,
    keep_s: ArrayLike = (),
    usable_residual: float = 0.0,
    gap: float = 1e-6,
    max_rounds: int = 30,
    tolerance: float = 1e-9,
    callback: Callable[[Iteration], None] | None = None,
) -> Generated:
    """The cheapest programme with impulses anywhere in `window_s`, from the times `times_s` on.

    `build` puts impulses at given increasing times on a builder, whose only cost is theirs, with all conditions. The
    multipliers of a round, divided by the largest primer over the window, are feasible in the dual of the problem
    with every time allowed: that is the bound. Within `gap`, neighbouring times are merged and negligible impulses left
    out, again until there are none, where that costs no more than it. It ends there,
    after `max_rounds`, or with the first solve that does not end SOLVED, which `Generated.solution` then is.
    With `candidates_s` (K,) impulses are at these times alone, the bound is that of all of them together, and nothing is
    merged. `keep_s` stay in every round. A solve that does not end SOLVED counts while its residuals are within `usable_residual`.
    """
    kept_s = np.asarray(keep_s, dtype=np.float64)
    times = np.unique(np.concatenate([np.asarray(times_s, dtype=np.float64), kept_s]))
    rounds: list[Round] = []
    subproblems: list[Iteration] = []
    ended: tuple[Impulses, Solution] | None = None
    for number in range(1, max_rounds + 1):
        impulses = build(times)
        problem = impulses.builder.build()
        solution = solve(problem, Settings(tol=tolerance))
        subproblems.append(Iteration(number, tolerance, problem, solution))
        if callback is not None:
            callback(subproblems[-1])
        if not within_residual(solution, usable_residual):
            break
        maxima, sizes = primer_maxima(impulses, solution, window_s, candidates_s)
        largest = float(sizes.max())
        bound = solution.dual_objective / max(1.0, largest)
        found = Round(times, solution.objective, bound, largest, float(maxima[sizes.argmax()]), solution)
        best = max(bound, *(each.lower_bound for each in rounds), -np.inf)
        within = found.cost - best <= gap * max(abs(found.cost), 1e-12)
        if ended is not None and not within:  # the merged times cost more than the gap: keep those before
            break
        rounds.append(found)
        if within and candidates_s is not None:
            ended = impulses, solution
            break
        merged = _merged(impulses.programme(solution), (window_s[1] - window_s[0]) / GRID)
        ended = (impulses, solution) if within else None
        if within:
            if merged.size == times.size:
                break
            times = merged
            continue
        programme = impulses.programme(solution)
        kept = times[programme.sizes_m_s > NEGLIGIBLE * programme.total_m_s]
        apart = 1e-9 * (window_s[1] - window_s[0])
        added = [t for t in maxima[sizes > 1.0] if not np.any(np.abs(kept - t) <= apart)]
        if not added:
            break
        times = np.unique(np.concatenate([kept, added, kept_s]))
    return Generated(*(ended or (impulses, solution)), tuple(rounds), tuple(subproblems))


def _merged(programme: ImpulseProgramme, apart_s: float) -> Array:
    """The times of a programme, neighbours closer than `apart_s` as one at their mean, weighted by their sizes."""
    kept = programme.without_small(NEGLIGIBLE * programme.total_m_s)
    groups = np.cumsum(np.diff(kept.times_s, prepend=-np.inf) > apart_s) - 1
    weights = np.bincount(groups, kept.sizes_m_s)
    return np.asarray(np.bincount(groups, kept.sizes_m_s * kept.times_s) / weights)


def primer_ceiling(
    impulses: Impulses, solution: Solution, window_s: tuple[float, float], instants: int = INSTANTS
) -> tuple[float, float]:
    """The largest primer at instants of the window, and a ceiling above it between them."""
    arcs = primer_arcs(impulses, solution, window_s, instants)
    return float(arcs[:, 2].max()), float(arcs[:, 3].max())


def primer_arcs(
    impulses: Impulses, solution: Solution, window_s: tuple[float, float], instants: int = INSTANTS
) -> Array:
    """Between conditions: start, end, the largest primer at instants, and a ceiling above it between them, (arcs, 4).

    Between instants h apart the primer is within h²/8 max‖p̈‖ of the chord, and a chord is no longer than its ends. About a
    circular target p̈ swings with an amplitude that two instants a quarter of a revolution apart give. About another,
    second differences stand for it, doubled: they vary by a small part over h, a ten-thousandth of the window.
    A cone, of a drift that must stay safe for all time, holds all along the drift: its multiplier is spread evenly until the
    next condition, so that the primer is continuous there. Any spread is feasible in the dual.
    """
    pulls, (low, high) = impulses.pulls(solution), window_s
    apart = (high - low) / (instants - 1)
    edges = np.unique([low, high, *(each.at_s for each in pulls if low < each.at_s < high)])
    at_edges = impulses.primer_size(solution, edges)
    found = []
    for k, (a, b) in enumerate(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)):
        times = np.linspace(a, b, max(9, int(np.ceil((b - a) / apart)) + 1))
        ahead = np.sum([each.pull for each in pulls if each.at_s >= b], axis=0)
        here = np.sum([np.zeros(6), *(each.pull for each in pulls if each.cone and each.at_s == a)], axis=0)
        wanted = ahead + ((b - times) / (b - a))[:, None] * here
        primer = np.array(
            [_primer(impulses, t, pull) for t, pull in zip(times.tolist(), wanted, strict=True)]
        )
        inside, ends = float(impulses.lengths(primer).max()), float(at_edges[k : k + 2].max())
        step = float(times[1] - times[0])
        between = inside + step**2 / 8.0 * _bend(impulses, primer, step, ahead, here, b - a)
        found.append([a, b, max(inside, ends), max(between, ends)])
    return np.array(found)


def _primer(impulses: Impulses, t_s: float, pull: Array) -> Array:
    return np.asarray(-KICK.T @ impulses.motion.transition(impulses.start_s, t_s).T @ pull)


def _bend(impulses: Impulses, primer: Array, step_s: float, ahead: Array, here: Array, arc_s: float) -> float:
    """Above the length of p̈ on an arc, on which p = −Kᵀ Φᵀ (ahead + here λ), and λ falls from 1 to 0."""
    motion, t0 = impulses.motion, impulses.start_s
    if not isinstance(motion, ClohessyWiltshire):
        bend = impulses.lengths(np.diff(primer[1:-1], 2, axis=0)) / step_s**2  # it may jump at the ends
        return 2.0 * float(bend.max(initial=0.0))
    n, quarter = motion.mean_motion_rad_s, 0.5 * np.pi / motion.mean_motion_rad_s
    swing = np.zeros(3)
    for pull in (
        ahead,
        here,
    ):  # p̈ of a fixed pull is −n² times what swings in it: p less its mean over half a revolution
        found = []
        for t in (t0, t0 + quarter):
            at = [_primer(impulses, t + k * quarter, pull) for k in (-2, 0, 2)]
            found.append(0.5 * at[1] - 0.25 * (at[0] + at[2]))
        swing += n**2 * np.hypot(*found)
    rate = np.array(
        [
            [1.0, 2.0, 0.0],
            [2.0, 7.0, 0.0],
            [0.0, 0.0, 1.0],
            [n, 2 * n, 0.0],
            [2 * n, 4 * n, 0.0],
            [0.0, 0.0, n],
        ]
    )
    return float(impulses.lengths((swing + 2.0 / arc_s * np.abs(here) @ rate)[None])[0])


def primer_maxima(
    impulses: Impulses,
    solution: Solution,
    window_s: tuple[float, float],
    candidates_s: ArrayLike | None = None,
) -> tuple[Array, Array]:
    """Times and sizes of the local maxima of the primer over the window, its ends included; or over `candidates_s`."""
    from scipy.optimize import minimize_scalar

    grid = np.linspace(*window_s, GRID + 1) if candidates_s is None else np.asarray(candidates_s, np.float64)
    sizes = impulses.primer_size(solution, grid)
    lower = np.concatenate([[-np.inf], sizes[:-1]])
    upper = np.concatenate([sizes[1:], [-np.inf]])
    peaks = np.flatnonzero((sizes >= lower) & (sizes >= upper))
    if candidates_s is not None:
        return grid[peaks], sizes[peaks]
    times, values = [], []
    for k in map(int, peaks):
        t, size = float(grid[k]), float(sizes[k])
        refined = minimize_scalar(
            lambda s: -float(impulses.primer_size(solution, [s])[0]),
            bounds=(grid[max(k - 1, 0)], grid[min(k + 1, GRID)]),
            method="bounded",
            options={"xatol": 1e-7 * (window_s[1] - window_s[0])},
        )
        if -refined.fun > size:
            t, size = float(refined.x), -float(refined.fun)
        times.append(t)
        values.append(size)
    return np.array(times), np.array(values)
