"""Warm starts: along the subproblems of a sequence, and after every number changed by up to one per cent."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

import orbsoc
from benchmarks.batches import perturbed
from benchmarks.families import FAMILIES, Instance, instances
from benchmarks.measure import COUNTS_BELOW
from benchmarks.six_dof import landing
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Solution
from orbsoc.conic.verify import verify

CHANGE = 0.01
CHANGED = 4
"""Changed copies of each problem."""
SEQUENCES = ("mission004", "orbit_insertion")
LANDING_STEPS = 8
PERTURBED = (
    "orbit_insertion",
    "powered_descent",
    "six_dof",
    "rendezvous",
    "quadrotor",
    "portfolio",
    "lasso",
    "huber",
    "svm",
    "group_lasso",
    "robust_kalman",
    "small_lp",
)


@dataclass(frozen=True, slots=True)
class WarmStart:
    """One solve from another's solution beside the same solve from nothing."""

    group: str
    kind: str
    """"sequence" or "perturbed\""""
    problem: str
    cold: int
    warm: int
    fell_back: bool
    """Whether the solver says that it went back to a cold start."""
    verified: bool

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> WarmStart:
        return cls(**record)


def available() -> bool:
    """Whether this build takes `solve(warm_start=…)`."""
    return "warm_start" in inspect.signature(orbsoc.Solver.solve).parameters


def measure_warm(tol: float, *, quick: bool = False) -> list[WarmStart]:
    """All of them; `quick` takes the first problem of each group only. Empty where there is no warm start."""
    if not available():
        return []
    rows: list[WarmStart] = []
    for group, name, before, after in [*_steps(quick), *_changes(quick)]:
        solver = orbsoc.Solver(before, tol=tol)
        first = solver.solve()
        solver.update(**_data(after))
        warm = solve_warm(solver, first)
        cold = orbsoc.solve(after, tol=tol)
        rows.append(
            WarmStart(
                group=group,
                kind="sequence" if name.startswith("step") else "perturbed",
                problem=name,
                cold=cold.iterations,
                warm=warm.iterations,
                fell_back=warm.warm_start == "fell_back",
                verified=verify(after, warm).worst <= COUNTS_BELOW,
            )
        )
    return rows


def solve_warm(solver: Any, previous: Solution) -> Solution:
    """Through a name without a type: builds without warm starts are measured, too."""
    found: Solution = solver.solve(warm_start=previous)
    return found


_Pair = tuple[str, str, Problem, Problem]
"""Group, name, the problem solved before, and the one solved from its solution."""


def _steps(quick: bool) -> Iterator[_Pair]:
    """Successive subproblems of one pattern."""
    for family in SEQUENCES:
        members = list(FAMILIES[family].generate())
        for k, (before, after) in enumerate(pairwise(members)):
            if _same_sequence(before, after) and not (quick and k > 3):
                yield after.group, f"step to {after.name}", before.problem, after.problem
    for nodes in (10, 20, 30):
        problems = list(landing(nodes, seed=0, count=2 if quick else LANDING_STEPS))
        for k, (first, second) in enumerate(pairwise(problems)):
            yield f"6-DoF landing, {nodes} nodes", f"step to {k + 1}", first, second


def _same_sequence(before: Instance, after: Instance) -> bool:
    """By name (what comes before the step's number), and by size."""
    sizes = [(p.n, p.p, p.m, p.A.nnz, p.G.nnz) for p in (before.problem, after.problem)]
    return before.name.rpartition("-")[0] == after.name.rpartition("-")[0] and sizes[0] == sizes[1]


def _changes(quick: bool) -> Iterator[_Pair]:
    for family in PERTURBED:
        seen: set[str] = set()
        for instance in instances([family]):
            if instance.group in seen:
                continue
            seen.add(instance.group)
            count = 1 if quick else CHANGED
            for k, changed in enumerate(perturbed(instance.problem, CHANGE, count, seed=_seed_of(instance))):
                yield instance.group, f"change {k} of {instance.name}", instance.problem, changed


def _seed_of(instance: Instance) -> int:
    """A seed of the instance's own."""
    return sum(map(ord, instance.name))


def _data(problem: Problem) -> dict[str, Any]:
    data: dict[str, Any] = {"c": problem.c}
    for vector, matrix in (("b", "A"), ("h", "G")):
        if getattr(problem, vector).size:
            data |= {vector: getattr(problem, vector), matrix: getattr(problem, matrix)}
    return data | ({"P": problem.P} if problem.P.nnz else {})


def table(rows: Sequence[WarmStart]) -> str:
    """A Markdown table, a row each kind and group."""
    lines = [
        "| solved again | solves | cold, mean | warm, mean | warm, most | worse than cold by more than one "
        "| fell back to cold | verified |",
        "|---|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for kind, title in (("sequence", "next subproblem"), ("perturbed", f"changed by ≤ {CHANGE:.0%}")):
        chosen = [row for row in rows if row.kind == kind]
        for group in dict.fromkeys(row.group for row in chosen):
            lines.append(_line(f"{title}: {group}", [row for row in chosen if row.group == group]))
        if chosen:
            lines.append(_line(f"**{title}: all**", chosen))
    return "\n".join(lines)


def _line(title: str, rows: Sequence[WarmStart]) -> str:
    cells = [
        title,
        f"{len(rows)}",
        f"{np.mean([row.cold for row in rows]):.1f}",
        f"{np.mean([row.warm for row in rows]):.1f}",
        f"{max(row.warm for row in rows)}",
        f"{sum(row.warm > row.cold + 1 for row in rows)}",
        f"{sum(row.fell_back for row in rows)}",
        f"{sum(row.verified for row in rows)}",
    ]
    return f"| {' | '.join(cells)} |"
