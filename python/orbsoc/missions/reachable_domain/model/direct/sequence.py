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

from .altitude import altitude_rows
from .arcs import Arcs, Collocation
from .condensed import condense
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


@dataclass(frozen=True, slots=True, eq=False)
class Sequences:
    """What B sequences arrived at. `ending` (B,) holds `Ending` values, `iterations` counts subproblems,
    `inner_iterations` the iterations of their solvers, `change` is the last step. The arcs have the multipliers of the
    last subproblem."""

    arcs: Arcs
    ending: NDArray[np.int8]
    iterations: NDArray[np.int32]
    inner_iterations: NDArray[np.int32]
    change: Array


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
    state = _State.of(start, rules or Rules())
    solve = solve or Subproblems.threaded()
    for _number in range(state.rules.max_iterations):
        which = np.flatnonzero(state.ending == Ending.RUNNING)
        if not which.size:
            break
        about, part = state.arcs[which], target[which]
        linear = collocation.end_map(about)
        path = None if lowest is None else altitude_rows(collocation, linear, about, lowest[which])
        batch = condense(linear, part.rows(about.ends), path=path)
        answers = solve(batch, about.multipliers, state.tight[which], state.rules)
        moved = collocation.arcs(linear, answers.controls.reshape(about.controls.shape))
        change = collocation.change(moved, about)
        state.advance(which, answers, moved, change)
        if watch is not None:
            watch(moved, np.where(answers.usable, change, np.nan))
    state.ending[state.ending == Ending.RUNNING] = Ending.MAX_ITERATIONS
    return Sequences(state.arcs, state.ending, state.iterations, state.inner_iterations, state.change)


@dataclass(slots=True, eq=False)
class _State:
    """The state of a batch of sequences; `tight` (B,) says which subproblems are solved tightly."""

    rules: Rules
    arcs: Arcs
    ending: NDArray[np.int8]
    tight: Flags
    iterations: NDArray[np.int32]
    inner_iterations: NDArray[np.int32]
    change: Array

    @classmethod
    def of(cls, start: Arcs, rules: Rules) -> _State:
        count = len(start)
        return cls(
            rules=rules,
            arcs=start.copy(),
            ending=np.zeros(count, np.int8),
            tight=np.zeros(count, bool),
            iterations=np.zeros(count, np.int32),
            inner_iterations=np.zeros(count, np.int32),
            change=np.full(count, np.inf),
        )

    def advance(self, which: Index, answers: Answers, moved: Arcs, step: Array) -> None:
        """Move the points `which` to the answers of their subproblems, and stop those that ended."""
        rules = self.rules
        self.iterations[which] += 1
        self.inner_iterations[which] += answers.iterations
        usable = answers.usable
        ok = which[usable]
        self.arcs.put(ok, moved[usable])
        self.arcs.multipliers[ok] = answers.multipliers[usable]
        self.change[ok] = step[usable]
        lost = which[~usable]
        self.ending[lost] = np.where(answers.infeasible[~usable], Ending.INFEASIBLE, Ending.SOLVER_FAILED)
        done = usable & answers.exact & (step < rules.step_tol) & self.tight[which]
        self.ending[which[done]] = Ending.CONVERGED
        self.tight[which] |= usable & (step < rules.tighten_below)
