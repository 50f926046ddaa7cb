"""Where each number of the shortest burn's problem stands in its data, and the data about a reference without building it anew.

For programs that plan many times on one pattern: the mission in C, and a guidance that plans again in flight.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Solution
from orbsoc.guidance.powered_flight import SHORTEST, Burn, Trajectory, linearise, weighted_sum
from orbsoc.guidance.scp import Step, Subproblem
from orbsoc.orbit.array import Array

from ..targets.rows import TERMINAL_ROWS
from ..targets.target_orbit import TargetOrbit
from .problems import Iterate

Places = NDArray[np.int64]

BY_STATE = [(k, 3 + k) for k in range(3)] + [(3 + i, j) for i in range(3) for j in range(3)]
"""Entries of ∂g/∂x that are stored, as rows and columns of its 6 × 6 block."""


def layout(problem: Problem, nodes: int) -> tuple[dict[str, int], dict[str, int]]:
    """First column of each group of unknowns, and first row of each group of rows."""
    sizes = {"states": 6 * nodes, "control_column": 3 * nodes, "end_column": 6, "duration_column": 1,
             "above_column": len(TERMINAL_ROWS), "below_column": len(TERMINAL_ROWS)}  # fmt: skip
    starts = np.cumsum([0, *sizes.values()]).tolist()
    rows = {"end_row": 6 * nodes, "target_row": 6 * nodes + 6, "longest_row": 1}
    wanted = (starts[-1], rows["target_row"] + len(TERMINAL_ROWS))
    if problem.A.shape[::-1] != wanted:
        raise RuntimeError(
            f"the subproblem has {problem.A.shape[::-1]} unknowns and equalities, not {wanted}"
        )
    return dict(zip(sizes, starts, strict=False)), rows


def places_of(
    problem: Problem, columns: Mapping[str, int], rows: Mapping[str, int], nodes: int
) -> dict[str, Places]:
    """Where each entry that a reference moves stands in the data of A."""
    matrix = problem.A
    of_column = np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))
    stored = {pair: k for k, pair in enumerate(zip(matrix.indices.tolist(), of_column.tolist(), strict=True))}
    control, end, duration = (columns[f"{name}_column"] for name in ("control", "end", "duration"))
    end_row, target_row = rows["end_row"], rows["target_row"]
    each = range(nodes)
    entries = {
        "state": [(6 * k + i, 6 * k + j) for k in each for i, j in BY_STATE],
        "control": [(6 * k + 3 + i, control + 3 * k + i) for k in each for i in range(3)],
        "duration": [(6 * k + i, duration) for k in each for i in range(6)],
        "end_state": [(end_row + i, 6 * k + j) for k in each for i, j in BY_STATE],
        "end_control": [(end_row + 3 + i, control + 3 * k + i) for k in each for i in range(3)],
        "end_duration": [(end_row + i, duration) for i in range(6)],
        "target": [(target_row + i, end + j) for i in range(len(TERMINAL_ROWS)) for j in range(6)],
    }
    return {name: np.array([stored[pair] for pair in pairs]) for name, pairs in entries.items()}


def fixed_data(
    problems: Sequence[Problem], places: Mapping[str, Places], longest_row: int
) -> dict[str, Array]:
    """The data that no reference moves, the others zero. Raises RuntimeError where the subproblems differ in them."""

    def kept(problem: Problem) -> dict[str, Array]:
        a, h = np.array(problem.A.data), np.array(problem.h)
        a[np.concatenate(list(places.values()))], h[longest_row] = 0.0, 0.0
        return {"a": a, "g": np.array(problem.G.data), "c": np.array(problem.c), "h": h}

    found = kept(problems[0])
    for problem in problems[1:]:
        for name, values in kept(problem).items():
            if problem.P.nnz or not np.array_equal(values, found[name]):
                raise RuntimeError(f"a reference moves data of {name} that should be fixed")
    return found


@dataclass(frozen=True, slots=True, eq=False)
class ProblemData:
    """The pattern of the shortest burn on a grid, for any burn and reference: `about` has the bits of `MinTime`."""

    pattern: Problem
    columns: Mapping[str, int]
    rows: Mapping[str, int]
    places: Mapping[str, Places]
    fixed: Mapping[str, Array]
    slack_weight: float

    @classmethod
    def of(cls, problem: Problem, nodes: int, slack_weight: float) -> ProblemData:
        """Of the problem that `MinTime` builds about some reference, onto an orbit that is given whole."""
        columns, rows = layout(problem, nodes)
        places = places_of(problem, columns, rows, nodes)
        return cls(
            problem, columns, rows, places, fixed_data([problem], places, rows["longest_row"]), slack_weight
        )

    def about(self, burn: Burn, target: TargetOrbit, reference: Iterate) -> Subproblem[Iterate]:
        """The convex subproblem about a reference."""
        arc = reference.trajectory
        problem = self._problem(burn, target, arc)
        return Subproblem(problem, lambda solution: self._read(solution, arc))

    def _problem(self, burn: Burn, target: TargetOrbit, arc: Trajectory) -> Problem:
        linear, place, grid = linearise(burn, arc, free_duration=True), self.places, arc.grid
        i, j = _ROWS, _COLUMNS
        a, h = self.fixed["a"].copy(), self.fixed["h"].copy()
        weights = grid.weights
        a[place["state"]] = -linear.by_state[:, i, j].ravel()
        a[place["control"]] = np.repeat(-linear.by_control, 3)
        a[place["duration"]] = -linear.by_duration.ravel()
        a[place["end_state"]] = (-weights[:, None] * linear.by_state[:, i, j]).ravel()
        a[place["end_control"]] = np.repeat(-weights * linear.by_control, 3)
        a[place["end_duration"]] = -weighted_sum(weights, linear.by_duration)
        block, goal = target.linear_rows(arc.end)
        a[place["target"]] = block.ravel()
        from_start = grid.differentiation[:, :1] * burn.start
        end = burn.start + weighted_sum(weights, linear.constant)
        b = np.concatenate([(linear.constant - from_start).ravel(), end, goal])
        h[self.rows["longest_row"]] = min(2.0 * arc.duration, burn.longest)
        old = self.pattern
        matrix = sparse.csc_matrix((a, old.A.indices, old.A.indptr), shape=old.A.shape)
        return Problem(c=old.c, A=matrix, b=b, G=old.G, h=h, cones=old.cones)

    def _read(self, solution: Solution, last: Trajectory) -> Step[Iterate]:
        x, at, nodes = solution.x, self.columns, last.grid.size
        control, end, above = at["control_column"], at["end_column"], at["above_column"]
        below, count = at["below_column"], len(TERMINAL_ROWS)
        trajectory = Trajectory(
            grid=last.grid,
            states=x[: 6 * nodes].reshape(nodes, 6),
            controls=x[control : control + 3 * nodes].reshape(nodes, 3),
            end=x[end : end + 6],
            duration=max(float(x[at["duration_column"]]), SHORTEST),
        )
        missed = ((x[below : below + count] - x[above : above + count]) / self.slack_weight).tolist()
        iterate = Iterate(trajectory, slack=tuple(zip(TERMINAL_ROWS, missed, strict=True)))
        return Step(iterate, trajectory.change_from(last), sum(map(abs, missed)), {})


_ROWS, _COLUMNS = (list(each) for each in zip(*BY_STATE, strict=True))
