"""Problems on which a rule of stalls, starts or pivots once failed: loose bounds, second differences, slow gaps.

`python -m benchmarks.recovery` prints how many of each family orbsoc and Clarabel solve, in how many iterations.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import sparse as _sparse

from benchmarks.peers import solvers
from orbsoc.conic.problem import Cones, Problem

sparse: Any = _sparse  # published without types

TOL = 1e-8
BOUNDS = (1e6, 1e8, 1e9, 1e10, 1e12, 1e15)
KINDS = ("one", "empty", "all")
"""A bound on the first unknown, a row of zeros, bounds on both sides of every unknown."""


def loose_bounds(seed: int, bound: float, kind: str) -> Problem:
    """A random QP of 5 to 29 unknowns, and inequalities that are never active: `kind` ≤ `bound`."""
    random = np.random.default_rng([seed, 91])
    n = int(random.integers(5, 30))
    p = int(random.integers(0, n // 2 + 1))
    factor = random.standard_normal((n, int(random.integers(max(1, n // 2), n + 1))))
    curvature = 1e-3 if random.random() < 0.5 else 0.0
    inside, A, G = (
        random.standard_normal(n),
        random.standard_normal((p, n)),
        random.standard_normal((2 * n, n)),
    )
    h = G @ inside + random.random(2 * n)
    rows = {"one": np.eye(n)[:1], "empty": np.zeros((1, n)), "all": np.vstack([np.eye(n), -np.eye(n)])}[kind]
    return Problem(
        P=factor @ factor.T + curvature * np.eye(n),
        c=random.standard_normal(n),
        A=A,
        b=A @ inside,
        G=np.vstack([G, rows]),
        h=np.concatenate([h, np.full(len(rows), bound)]),
        cones=Cones(l=2 * n + len(rows)),
    )


def second_differences(seed: int, n: int) -> Problem:
    """The convex sequence nearest to noisy data, as LISWET: min ½‖x − d‖² with second differences ≥ 0."""
    random, t = np.random.default_rng([seed, 92]), np.linspace(0.0, 1.0, n)
    curve = (np.sqrt(t), 1.0 / (0.1 + t), np.exp(t), t**3, np.sin(3.0 * t))[seed % 5]
    noise = np.sin(np.arange(1, n + 1) * random.uniform(1.0, 3.0)) if seed % 2 else random.standard_normal(n)
    rows = sparse.diags_array([1.0, -2.0, 1.0], offsets=[0, 1, 2], shape=(n - 2, n))
    return Problem(
        P=sparse.eye_array(n, format="csc"), c=-(curve + 0.1 * noise), G=-rows.tocsc(), h=np.zeros(n - 2),
        cones=Cones(l=n - 2),
    )  # fmt: skip


def slow_gap(seed: int) -> Problem:
    """A factor model with bounds from 1 to 1e6 and costs over six decades: its dual variables grow before the gap falls."""
    random = np.random.default_rng([seed, 93])
    n, p = int(random.integers(20, 80)), int(random.integers(3, 12))
    scale = 10.0 ** random.uniform(-3.0, 0.0, (n, 1))
    factor = random.standard_normal((n, int(random.integers(2, 8)))) * scale
    upper = 10.0 ** random.uniform(0.0, 6.0, n)
    A = sparse.random_array((p, n), density=0.3, rng=random).toarray()
    return Problem(
        P=factor @ factor.T,
        c=random.standard_normal(n) * 10.0 ** random.uniform(-3.0, 3.0, n),
        A=A,
        b=A @ (random.random(n) * upper),
        G=np.vstack([-np.eye(n), np.eye(n)]),
        h=np.concatenate([np.zeros(n), upper]),
        cones=Cones(l=2 * n),
    )


FAMILIES: dict[str, Callable[[], list[Problem]]] = {
    **{
        f"{kind} ≤ {bound:.0e}": lambda kind=kind, bound=bound: [  # type: ignore[misc]
            loose_bounds(seed, bound, kind) for seed in range(40)
        ]
        for kind in KINDS
        for bound in BOUNDS
    },
    "second differences, 1000": lambda: [second_differences(seed, 1000) for seed in range(10)],
    "second differences, 3000": lambda: [second_differences(seed, 3000) for seed in range(10)],
    "slow gaps": lambda: [slow_gap(seed) for seed in range(40)],
}


def main() -> None:
    """The table on standard output."""
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    found, _ = solvers(("orbsoc", "clarabel"))
    sys.stdout.write(f"| family | {' | '.join(f'{each.name}: claims | iterations' for each in found)} |\n")
    sys.stdout.write(f"|{'---|' * (1 + 2 * len(found))}\n")
    for family, problems in FAMILIES.items():
        cells = [family]
        for solver in found:
            answers = [solver.variants[0].solve(problem, TOL) for problem in problems()]
            claims = Counter(answer.claim for answer in answers)
            cells.append(", ".join(f"{number} {claim}" for claim, number in claims.most_common()))
            cells.append(f"{np.mean([answer.iterations for answer in answers]):.1f}")
        sys.stdout.write(f"| {' | '.join(cells)} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
