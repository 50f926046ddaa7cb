"""Solve a batch of condensed subproblems: Newton on the dual from multipliers nearby, an interior-point method else.

Each subproblem is solved by one of them to the requested tolerance, by the same criteria (`dual`, docs/algorithm.md). Only the interior-point method says that a subproblem has no feasible point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.guidance.scp import Rules
from orbsoc.orbit.array import Array, Flags, Index
from orbsoc.solving.batch import solve_batch

from ..batch import Batch, column
from .arcs import MOST_EQUALITIES
from .condensed import PERIGEE_CONE, CondensedBatch
from .dual import solve_dual


@dataclass(frozen=True, slots=True, eq=False)
class SolvedBatch:
    """What an interior-point method says of B subproblems: `Status` members (B,), x (B, n), y (B, p), z (B, m), iterations
    and the largest verified residual (B,)."""

    status: NDArray[np.object_]
    x: Array
    y: Array
    z: Array
    iterations: NDArray[np.integer[Any]]
    residual: Array


SolveMany = Callable[[CondensedBatch, Settings], SolvedBatch]
"""Solves a batch of condensed subproblems by an interior-point method."""


@dataclass(slots=True, eq=False)
class Answers(Batch):
    """What became of B subproblems: controls (B, n), multipliers (B, 6) as `Arcs` keeps them, and (B,) iterations.

    `usable`: the point may move to its solution. `exact`: it is exact enough to end with. `infeasible`: there is none.
    """

    controls: Array
    multipliers: Array = column(np.nan, 2 * MOST_EQUALITIES)
    iterations: NDArray[np.int32] = column(0, dtype=np.int32)
    usable: Flags = column(False, dtype=bool)
    exact: Flags = column(False, dtype=bool)
    infeasible: Flags = column(False, dtype=bool)


@dataclass(frozen=True, slots=True)
class Subproblems:
    """The solver of a sweep's subproblems; without `dual` each of them goes to `interior`."""

    interior: SolveMany
    dual: bool = True

    @classmethod
    def in_process(cls, *, dual: bool = True) -> Subproblems:
        """With `orbsoc.solve_batch` on one thread."""

        def solve(batch: CondensedBatch, settings: Settings) -> SolvedBatch:
            data = {name: getattr(batch, name) for name in ("c", "A", "b", "G", "h")}
            found = solve_batch(batch.base, **data, settings=settings, threads=1)
            residual = np.maximum(np.maximum(found.primal_residual, found.dual_residual), found.gap)
            return SolvedBatch(found.status, found.x, found.y, found.z, found.iterations, residual)

        return cls(solve, dual)

    def __call__(self, batch: CondensedBatch, near: Array, tight: Flags, rules: Rules) -> Answers:
        """Answer each subproblem, at the tight tolerance of the rules where `tight` (B,), from multipliers `near`
        (B, 6), NaN where there are none."""
        out = Answers.blank(len(batch), controls=np.zeros((len(batch), batch.base.n)))
        if self.dual and not batch.base.cones.l and batch.base.cones.q[-1] == PERIGEE_CONE:
            _by_dual(batch, near, np.where(tight, rules.tight_tol, rules.loose_tol), out)
        left = ~out.usable
        for chosen, tolerance in ((left & ~tight, rules.loose_tol), (left & tight, rules.tight_tol)):
            which = np.flatnonzero(chosen)
            if which.size:
                part = batch if which.size == len(batch) else batch[which]
                _take_interior(out, which, part, self.interior(part, Settings(tol=tolerance)), rules)
        return out


def _by_dual(batch: CondensedBatch, near: Array, tolerance: Array, out: Answers) -> None:
    """Note what Newton on the dual solves of the points with multipliers nearby."""
    p = batch.base.p
    known = np.isfinite(near[:, :p]).all(axis=1) & np.isfinite(near[:, MOST_EQUALITIES:]).all(axis=1)
    which = np.flatnonzero(known)
    if not which.size:
        return
    part = batch if which.size == len(batch) else batch[which]
    found = solve_dual(part, near[which, :p], near[which, MOST_EQUALITIES:], tolerance[which])
    out.iterations[which] = found.steps
    good = np.flatnonzero(found.solved)
    which = which[good]
    out.controls[which] = found.x[good]
    out.multipliers[which, :p], out.multipliers[which, MOST_EQUALITIES:] = found.y[good], found.z[good]
    out.usable[which] = out.exact[which] = True


def _take_interior(
    out: Answers, which: Index, batch: CondensedBatch, found: SolvedBatch, rules: Rules
) -> None:
    """Note what the interior-point method says of the points `which`; KeyboardInterrupt when Ctrl-C stopped it."""
    if Status.INTERRUPTED in found.status:
        raise KeyboardInterrupt
    p = batch.base.p
    out.iterations[which] += found.iterations.astype(np.int32)
    out.controls[which] = found.x
    out.multipliers[which, :p] = found.y
    out.multipliers[which, MOST_EQUALITIES:] = found.z[:, :3] if batch.base.cones.l else found.z[:, -3:]
    solved = found.status == Status.SOLVED
    stopped_short = (Status.SOLVED_INACCURATE, Status.NUMERICAL_LIMIT, Status.MAX_ITERATIONS)
    short = np.array([status in stopped_short for status in found.status], bool)
    out.usable[which] = solved | (short & (found.residual <= rules.usable_residual))
    out.exact[which] = solved | (found.residual <= rules.final_residual)
    out.infeasible[which] = found.status == Status.PRIMAL_INFEASIBLE
