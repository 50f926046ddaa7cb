"""Sequential convex programming for many points side by side: one pattern, one `solve_batch` per iteration.

The same rules as `orbsoc.scp`, applied to every point by itself: a point leaves the batch when it converged, when its
subproblem has no feasible point, or when its solver failed.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.batch import BatchSolution, solve_batch
from orbsoc.scp import Rules
from orbsoc.settings import Settings
from orbsoc.solution import Status

from .arcs import Arcs, Collocation
from .condensed import CondensedBatch, condense
from .path import altitude_rows
from .terminal import Aim

Array = NDArray[np.float64]
Index = NDArray[np.intp]

MOST_EQUALITIES = 3
"""Equality rows of a subproblem: two of the plane, one of the perigee direction."""

SolveMany = Callable[[CondensedBatch, Settings], BatchSolution]
"""Solves a batch of condensed subproblems."""


class Ending(enum.IntEnum):
    """How the sequence of one point ended."""

    RUNNING = 0
    CONVERGED = 1
    INFEASIBLE = 2
    SOLVER_FAILED = 3
    MAX_ITERATIONS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Sequences:
    """What B sequences arrived at. `ending` (B,) holds `Ending` values, `iterations` counts subproblems,
    `inner_iterations` the interior-point iterations of all of them, `change` is the last step.

    `equal_duals` (B, p) and `perigee_duals` (B, 3) are the multipliers of the last subproblem's equalities
    and of its perigee cone; where the perigee direction is fixed, of its two bounds and a number to ignore.
    """

    arcs: Arcs
    ending: NDArray[np.int8]
    iterations: NDArray[np.int32]
    inner_iterations: NDArray[np.int32]
    change: Array
    equal_duals: Array
    perigee_duals: Array


def threaded(threads: int = 1) -> SolveMany:
    """`orbsoc.solve_batch` on so many threads."""

    def solve(batch: CondensedBatch, settings: Settings) -> BatchSolution:
        return solve_batch(
            batch.base,
            c=batch.c,
            A=batch.A,
            b=batch.b,
            G=batch.G,
            h=batch.h,
            settings=settings,
            threads=threads,
        )

    return solve


def sequences(
    collocation: Collocation,
    aim: Aim,
    start: Arcs,
    *,
    lowest: Array | None = None,
    solve: SolveMany | None = None,
    rules: Rules | None = None,
) -> Sequences:
    """Iterate every point of `aim` from its arc of `start` until a rule of `orbsoc.scp.Rules` stops it.

    `lowest` (B,) bounds the radius at the nodes from below, canonical.
    """
    state = _State.of(start, rules or Rules())
    solve = solve or threaded()
    for number in range(1, state.rules.max_iterations + 1):
        for tight in (False, True):
            running = (state.ending == Ending.RUNNING) & (state.tight == tight) & (state.iterations < number)
            which = np.flatnonzero(running)
            if not which.size:
                continue
            about, goal = state.arcs[which], aim[which]
            linear = collocation.end_map(about)
            path = None if lowest is None else altitude_rows(collocation, linear, about, lowest[which])
            batch = condense(linear, goal.rows(about.ends), path=path)
            solution = solve(batch, Settings(tol=state.tolerance(tight)))
            moved = collocation.arcs(linear, solution.x.reshape(about.controls.shape))
            state.advance(which, solution, moved, collocation.change(moved, about), cone=goal.has_cone)
    state.ending[state.ending == Ending.RUNNING] = Ending.MAX_ITERATIONS
    return state.result()


@dataclass(slots=True, eq=False)
class _State:
    """Where every point of a batch of sequences stands."""

    rules: Rules
    arcs: Arcs
    ending: NDArray[np.int8]
    tight: NDArray[np.bool_]
    iterations: NDArray[np.int32]
    inner_iterations: NDArray[np.int32]
    change: Array
    equal_duals: Array
    perigee_duals: Array

    @classmethod
    def of(cls, start: Arcs, rules: Rules) -> _State:
        count = len(start)
        return cls(
            rules=rules,
            arcs=Arcs(start.positions.copy(), start.controls.copy(), start.ends.copy()),
            ending=np.zeros(count, np.int8),
            tight=np.zeros(count, bool),
            iterations=np.zeros(count, np.int32),
            inner_iterations=np.zeros(count, np.int32),
            change=np.full(count, np.inf),
            equal_duals=np.full((count, MOST_EQUALITIES), np.nan),
            perigee_duals=np.full((count, 3), np.nan),
        )

    def tolerance(self, tight: bool) -> float:
        """Of the next subproblem of a point."""
        return self.rules.tight_tol if tight else self.rules.loose_tol

    def advance(self, which: Index, solution: BatchSolution, moved: Arcs, step: Array, *, cone: bool) -> None:
        """Take the solutions of the points `which`, all solved at one tolerance, and stop those that ended."""
        rules = self.rules
        tight = bool(self.tight[which[0]])
        self.iterations[which] += 1
        self.inner_iterations[which] += solution.iterations.astype(np.int32)
        usable, settled = _judge(solution, rules)
        ok = which[usable]
        self.arcs.put(ok, moved[usable])
        self.change[ok] = step[usable]
        self.equal_duals[ok, : solution.y.shape[1]] = solution.y[usable]
        self.perigee_duals[ok] = solution.z[usable, -3:] if cone else solution.z[usable, :3]
        infeasible = solution.status[~usable] == Status.PRIMAL_INFEASIBLE
        self.ending[which[~usable]] = np.where(infeasible, Ending.INFEASIBLE, Ending.SOLVER_FAILED)
        done = usable & settled & (step < rules.step_tol) & (self.tolerance(tight) <= rules.tight_tol)
        self.ending[which[done]] = Ending.CONVERGED
        self.tight[which] |= usable & (step < rules.tighten_below)

    def result(self) -> Sequences:
        return Sequences(
            self.arcs,
            self.ending,
            self.iterations,
            self.inner_iterations,
            self.change,
            self.equal_duals,
            self.perigee_duals,
        )


def _judge(solution: BatchSolution, rules: Rules) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether each point may move to its solution, and whether its solution is exact enough to end with."""
    worst = np.maximum(np.maximum(solution.primal_residual, solution.dual_residual), solution.gap)
    solved = solution.status == Status.SOLVED
    stopped_short = (Status.SOLVED_INACCURATE, Status.NUMERICAL_LIMIT, Status.MAX_ITERATIONS)
    short = np.array([status in stopped_short for status in solution.status], bool)
    return solved | (short & (worst <= rules.usable_residual)), solved | (worst <= rules.final_residual)
