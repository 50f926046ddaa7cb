"""Sequential convex programming for many points side by side: one pattern, one batch of subproblems per iteration.

The same rules as `orbsoc.guidance.scp`, applied to every point by itself: a point leaves the batch when it converged, when its
subproblem has no feasible point, or when its solver failed.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.scp import Rules
from orbsoc.orbit.array import Array, Flags, Index

from ..batch import Batch, column
from .arcs import Arcs, Collocation
from .condensed import altitude_rows, condense
from .subproblems import Answers, Subproblems
from .terminal import Target

Watch = Callable[[Arcs, Array], None]
"""Sees the arcs that a batch of subproblems leads to, and how far they moved (B,), NaN for those without a solution."""


class Ending(enum.IntEnum):
    """How the sequence of one point ended."""

    RUNNING = 0
    CONVERGED = 1
    INFEASIBLE = 2
    SOLVER_FAILED = 3
    MAX_ITERATIONS = 4


@dataclass(slots=True, eq=False)
class Sequences(Batch):
    """What B sequences arrived at. `ending` (B,) holds `Ending` values, `iterations` counts subproblems,
    `inner_iterations` the iterations of their solvers, and `tight` says whose next subproblem is solved tightly. The arcs
    have the multipliers of the last subproblem."""

    arcs: Arcs
    ending: NDArray[np.int8] = column(Ending.RUNNING, dtype=np.int8)
    tight: Flags = column(False, dtype=bool)
    iterations: NDArray[np.int32] = column(0, dtype=np.int32)
    inner_iterations: NDArray[np.int32] = column(0, dtype=np.int32)

    def advance(self, which: Index, answers: Answers, moved: Arcs, step: Array, rules: Rules) -> None:
        """Move the points `which` to the answers of their subproblems, and stop those that ended."""
        self.iterations[which] += 1
        self.inner_iterations[which] += answers.iterations
        usable = answers.usable
        ok = which[usable]
        self.arcs.put(ok, moved[usable])
        self.arcs.multipliers[ok] = answers.multipliers[usable]
        lost = which[~usable]
        self.ending[lost] = np.where(answers.infeasible[~usable], Ending.INFEASIBLE, Ending.SOLVER_FAILED)
        done = usable & answers.exact & (step < rules.step_tol) & self.tight[which]
        self.ending[which[done]] = Ending.CONVERGED
        self.tight[which] |= usable & (step < rules.tighten_below)


def sequences(
    collocation: Collocation,
    target: Target,
    start: Arcs,
    *,
    lowest: Array | None = None,
    solve: Subproblems | None = None,
    rules: Rules | None = None,
    watch: Watch | None = None,
) -> Sequences:
    """Iterate every point of `target` from its arc of `start` until a rule of `orbsoc.guidance.scp.Rules` stops it.

    `lowest` (B,) bounds the radius at the nodes from below, canonical; `watch` sees every batch of subproblems.
    """
    out = Sequences.blank(len(start), arcs=start.copy())
    rules, solve = rules or Rules(), solve or Subproblems.in_process()
    for _number in range(rules.max_iterations):
        which = np.flatnonzero(out.ending == Ending.RUNNING)
        if not which.size:
            break
        about, part = out.arcs[which], target[which]
        linear = collocation.end_map(about)
        path = None if lowest is None else altitude_rows(collocation, linear, about, lowest[which])
        batch = condense(linear, part.rows(about.ends), path=path)
        answers = solve(batch, about.multipliers, out.tight[which], rules)
        moved = collocation.arcs(linear, answers.controls.reshape(about.controls.shape))
        change = collocation.change(moved, about)
        out.advance(which, answers, moved, change, rules)
        if watch is not None:
            watch(moved, np.where(answers.usable, change, np.nan))
    out.ending[out.ending == Ending.RUNNING] = Ending.MAX_ITERATIONS
    return out
