"""The rendezvous as conic problems: two impulses or as many as pay, with the solver's bound and the primer vector."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.impulses import Generated, ImpulseProgramme, Impulses, generate
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire

from ..model.transfer import PLANE, Cost, Minimum, Transfers, in_plane

TOLERANCE = 1e-9
STARTS = 5.7
"""Of an orbit, at which impulses are allowed first: never a whole orbit apart, where they would do the same."""
IN_PLANE = (0, 1)
"""Axes along which the engine fires, of (R, T, N)."""


@dataclass(frozen=True, slots=True, eq=False)
class Rendezvous:
    """A programme of impulses to rest at the target, every local minimum of two impulses, and what was solved for it."""

    cost: Cost
    time_s: float
    minima: tuple[Minimum, ...]
    impulses: Impulses
    solution: Solution
    subproblems: tuple[Iteration, ...] = field(repr=False)
    generated: Generated | None = None

    @property
    def programme(self) -> ImpulseProgramme:
        if self.generated is not None:
            return self.generated.programme
        return self.impulses.programme(self.solution)

    @property
    def value(self) -> float:
        """The cost as it is asked for."""
        sizes = self.programme.sizes_m_s
        return float(np.sum(sizes**2) if self.cost == "squares" else np.sum(sizes))

    @property
    def lower_bound(self) -> float:
        """The dual objective: no programme with impulses at these times costs less, or, generated, at any times."""
        return self.generated.lower_bound if self.generated else self.solution.dual_objective

    def primer(self, times_s: Array) -> Array:
        """Lengths (K,) of the primer vector, 1 at an impulse; above 1 a further impulse pays. Of "norms" alone."""
        return self.impulses.primer_size(self.solution, times_s)


def rendezvous(
    state: Array,
    motion: ClohessyWiltshire,
    *,
    cost: Cost,
    longest_s: float,
    time_s: float | None,
    generated: bool,
    solve: Solve,
    callback: Callable[[Iteration], None] | None = None,
) -> Rendezvous:
    """From a state (6,) in (R, T, N) to rest at the target, in `time_s` or in the best time up to `longest_s`.

    With generated impulses the best time is the longest, for a server at rest at the target stays there at no cost.
    """
    minima = Transfers.of(motion, longest_s).minima(in_plane(state), cost)
    best = min(minima, key=lambda each: each.cost).time_s

    def built(times: Array) -> Impulses:
        return to_rest(state, motion, times, end_s, cost, start_s=0.0)

    if generated:
        end_s = longest_s if time_s is None else time_s
        starts = np.linspace(0.0, end_s, 3 + round(STARTS * end_s / motion.period_s))

        def told(row: Iteration) -> Iteration:
            solved = row.solution.status is Status.SOLVED
            return replace(row, figures={"time_s": end_s, "dv_m_s": row.solution.objective} if solved else {})

        found = generate(
            built, starts, (0.0, end_s), solve=solve, tolerance=TOLERANCE,
            callback=callback and (lambda row: callback(told(row))),
        )  # fmt: skip
        rows = tuple(told(row) for row in found.subproblems)
        return Rendezvous(cost, end_s, minima, found.impulses, found.solution, rows, found)
    end_s = best if time_s is None else time_s
    impulses = built(np.array([0.0, end_s]))
    problem = impulses.builder.build()
    solution = solve(problem, Settings(tol=TOLERANCE))
    rows = (Iteration(1, TOLERANCE, problem, solution, figures=_figures(impulses, solution, end_s)),)
    if callback is not None:
        callback(rows[0])
    return Rendezvous(cost, end_s, minima, impulses, solution, rows)


def to_rest(
    state: Array,
    motion: ClohessyWiltshire,
    times_s: Array,
    end_s: float,
    cost: Cost,
    *,
    start_s: float | None = None,
) -> Impulses:
    """Impulses at times (K,) that take a state (6,) at `start_s`, by default the first of them, to rest at the target at `end_s`."""
    n = motion.mean_motion_rad_s
    target = np.diag([n, n, 1.0, 1.0]) @ np.eye(6)[PLANE]  # lengths as speeds
    builder = ConicBuilder()
    impulses = Impulses(builder, motion, times_s, state, start_s=start_s, axes=IN_PLANE)
    if cost == "norms":
        impulses.cost("norms")
    else:
        builder.quadratic_cost(impulses.dv, 2.0 * np.eye(impulses.dv.index.size))
    impulses.meet(end_s, np.zeros(4), matrix=target, name="rest at the target")
    return impulses


def _figures(impulses: Impulses, solution: Solution, end_s: float) -> dict[str, float]:
    if solution.status is not Status.SOLVED:
        return {}
    return {"time_s": end_s, "dv_m_s": impulses.programme(solution).total_m_s}
