"""Problems without a solution, drawn with the proof that there is none, and the same problems in nine other systems of units."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import project
from tests.zoo.case import Array

SCALINGS = ("rows 1e-8", "rows 1e8", "rows mixed", "columns 1e-8", "columns 1e8", "columns mixed",
            "objective 1e-8", "objective 1e8", "all mixed")  # fmt: skip
"""Factors of rows, columns and objective; mixed ones are a power of ten each, from 1e-8 to 1e8 (all mixed: to 1e4)."""


def drawn(seed: int) -> tuple[Problem, Status]:
    """A problem of 2 to 10 variables that is primal infeasible (even seeds) or unbounded (odd ones), and which."""
    rng = np.random.default_rng(seed)
    n, p, l = int(rng.integers(2, 11)), int(rng.integers(0, 3)), int(rng.integers(2, 12))
    cones = Cones(l=l, q=tuple(rng.integers(2, 6, size=int(rng.integers(0, 4)))))
    dense = rng.random() * 0.6 + 0.4
    A, G = (rng.normal(size=(rows, n)) * (rng.random((rows, n)) < dense) for rows in (p, cones.m))
    c, b, h = rng.normal(size=n), rng.normal(size=p), rng.normal(size=cones.m)
    factor = rng.normal(size=(int(rng.integers(1, n + 1)), n))
    P = factor.T @ factor if rng.random() < 0.4 else None
    if seed % 2 == 0:
        return _infeasible(rng, Problem(P=P, c=c, A=A, b=b, G=G, h=h, cones=cones))
    return _unbounded(rng, Problem(P=P, c=c, A=A, b=b, G=G, h=h, cones=cones))


def _infeasible(rng: np.random.Generator, start: Problem) -> tuple[Problem, Status]:
    """Such rows that Aᵀy + Gᵀz = 0 and bᵀy + hᵀz = −1 for drawn y and z ∈ K, and a dual feasible point inside K."""
    z = project(rng.normal(size=start.m), start.cones)
    z[0] = 1.0
    y, A, G = rng.normal(size=start.p), start.A.toarray(), start.G.toarray()
    G[0] -= A.T @ y + G.T @ z
    h = start.h.copy()
    h[0] -= start.b @ y + h @ z + 1.0
    inside = rng.normal(size=start.m)
    inside[: start.cones.l] = np.abs(inside[: start.cones.l]) + 0.1
    for cone in start.cones.second_order():
        inside[cone.start] = np.linalg.norm(inside[cone]) + 0.1
    c = -(start.P @ rng.normal(size=start.n) + A.T @ rng.normal(size=start.p) + G.T @ inside)
    return _with(start, G=G, h=h, c=c), Status.PRIMAL_INFEASIBLE


def _unbounded(rng: np.random.Generator, start: Problem) -> tuple[Problem, Status]:
    """A feasible point, and a drawn direction with cᵀx = −1, Px = 0, Ax = 0, −Gx ∈ K."""
    x = rng.normal(size=start.n)
    unit = x / (x @ x)
    P, A, G = (matrix.toarray() for matrix in (start.P, start.A, start.G))
    across = np.eye(start.n) - np.outer(x, unit)
    A -= np.outer(A @ x, unit)
    P = across.T @ P @ across
    recession = project(rng.normal(size=start.m), start.cones)
    G -= np.outer(G @ x + recession, unit)
    c = start.c - (start.c @ x + 1.0) * unit
    at = rng.normal(size=start.n)
    slack = project(rng.normal(size=start.m), start.cones)
    changed = {"A": A, "b": A @ at, "G": G, "h": G @ at + slack, "c": c}
    return _with(start, P=(P + P.T) / 2 if start.P.nnz else None, **changed), Status.DUAL_INFEASIBLE


def _with(problem: Problem, **changes: Array | None) -> Problem:
    data = {name: getattr(problem, name) for name in ("P", "c", "A", "b", "G", "h", "cones")}
    return Problem(**(data | changes))


def in_units(problem: Problem, scaling: str, seed: int) -> Problem:
    """The problem after one of the SCALINGS."""
    rng = np.random.default_rng(seed)
    what, size = scaling.split()
    most = 4 if what == "all" else 8

    def factors(count: int, of: str) -> Array:
        if what not in (of, "all"):
            return np.ones(count)
        return (
            10.0 ** rng.integers(-most, most + 1, count) if size == "mixed" else np.full(count, float(size))
        )

    rows, cone_rows = factors(problem.p, "rows"), factors(problem.m, "rows")
    for cone in problem.cones.second_order():
        cone_rows[cone] = cone_rows[cone.start]
    columns, cost = factors(problem.n, "columns"), float(factors(1, "objective")[0])
    P = problem.P.toarray() * np.outer(columns, columns) * cost if problem.P.nnz else None
    return Problem(
        P=P,
        c=problem.c * columns * cost,
        A=rows[:, None] * problem.A.toarray() * columns,
        b=problem.b * rows,
        G=cone_rows[:, None] * problem.G.toarray() * columns,
        h=problem.h * cone_rows,
        cones=problem.cones,
    )
