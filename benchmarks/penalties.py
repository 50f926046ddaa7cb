"""Exact penalties: equalities softened at a cost of M a unit, beside the problems whose equalities are kept.

`python -m benchmarks.penalties` softens the equalities of random LPs and of the guidance families (virtual control): Ax + u
− v = b with u, v ≥ 0 at a cost of M·Σ(u + v). Once M exceeds every multiplier of Ax = b, u and v vanish and the optimal
value is that of the problem itself, which SciPy's HiGHS (LPs) or Clarabel (cones) say. Prints how many are solved, in how
many iterations, and how far the objectives are off: for orbsoc and Clarabel, by M over the largest other cost.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import sparse as _sparse
from scipy.optimize import linprog

from benchmarks.answer import Solver
from benchmarks.families import instances
from benchmarks.peers import solvers
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.verify import objectives

sparse: Any = _sparse  # published without types

GUIDANCE = ("mission004", "orbit_insertion", "powered_descent", "rendezvous", "quadrotor", "six_dof")
EVERY = 6
"""Of the guidance families' problems every sixth is softened."""
LPS = 40
DECADES = (2, 4, 6, 7, 8, 9, 10)
TOL = 1e-8
WRONG = 1e-5
"""Error of the objective, relative to one and its value, from which it counts as wrong."""


@dataclass(frozen=True, slots=True, eq=False)
class Kept:
    """A problem with its equalities kept, its optimal value and the largest multiplier of an equality."""

    problem: Problem
    value: float
    multiplier: float

    def penalty(self, decade: int) -> float:
        """M."""
        return float(10.0**decade * np.abs(self.problem.c).max())


def softened(problem: Problem, penalty: float) -> Problem:
    """The problem with Ax + u − v = b, u, v ≥ 0 and `penalty`·Σ(u + v) in the cost; u and v after x, their rows first."""
    p, n = len(problem.b), len(problem.c)
    eye, signs = sparse.eye_array(p), sparse.eye_array(2 * p)
    return Problem(
        P=sparse.block_diag([problem.P, sparse.csc_array((2 * p, 2 * p))]).tocsc(),
        c=np.concatenate([problem.c, np.full(2 * p, penalty)]),
        A=sparse.hstack([problem.A, eye, -eye]).tocsc(),
        b=problem.b,
        G=sparse.vstack(
            [
                sparse.hstack([sparse.csc_array((2 * p, n)), -signs]),
                sparse.hstack([problem.G, sparse.csc_array((len(problem.h), 2 * p))]),
            ]
        ).tocsc(),
        h=np.concatenate([np.zeros(2 * p), problem.h]),
        cones=Cones(l=2 * p + problem.cones.l, q=problem.cones.q),
    )


def linear(seed: int) -> Kept:
    """min cᵀx, Ax = b, x ≥ 0 with 5 to 39 unknowns and half as many rows, 0 ≤ c ≤ 1, feasible by construction."""
    random = np.random.default_rng([seed, 77])
    n = int(random.integers(5, 40))
    A, x = random.normal(size=(n // 2, n)), random.random(n)
    c = random.random(n)
    known = linprog(c, A_eq=A, b_eq=A @ x, method="highs")
    problem = Problem(c=c, A=A, b=A @ x, G=-np.eye(n), h=np.zeros(n), cones=Cones(l=n))
    return Kept(problem, float(known.fun), float(np.abs(known.eqlin.marginals).max()))


def lps() -> Iterator[Kept]:
    """Random LPs."""
    return map(linear, range(LPS))


def guidance() -> Iterator[Kept]:
    """Subproblems of the guidance families."""
    (clarabel,), _ = solvers(("clarabel",))
    every = [instance.problem for family in GUIDANCE for instance in instances((family,))]
    for problem in every[::EVERY]:
        known = clarabel.variants[0].solve(problem, TOL)
        yield Kept(problem, objectives(problem, known)[0], float(np.abs(known.y).max()))


def row(kept: list[Kept], decade: int, found: list[Solver]) -> str:
    """A line of the table; only problems whose multipliers M exceeds have their own value."""
    cells = [f"1e{decade}"]
    exact = [k for k in kept if k.penalty(decade) > k.multiplier]
    for solver in found:
        claims, iterations, errors = 0, 0, [0.0]
        for k in exact:
            soft = softened(k.problem, k.penalty(decade))
            answer = solver.variants[0].solve(soft, TOL)
            iterations += answer.iterations
            if answer.claim == "SOLVED":
                claims += 1
                errors.append(abs(objectives(soft, answer)[0] - k.value) / (1.0 + abs(k.value)))
        wrong = sum(error > WRONG for error in errors)
        cells.append(
            f"{claims} of {len(exact)} | {iterations / len(exact):.1f} | {wrong} | {max(errors):.0e}"
        )
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """The tables on standard output."""
    argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    ).parse_args()
    kinds: dict[str, Callable[[], Iterator[Kept]]] = {"LPs": lps, "guidance": guidance}
    found, _ = solvers(("orbsoc", "clarabel"))
    heading = f"| M over ‖c‖ | {' | '.join(['solved | iterations | wrong | worst error'] * len(found))} |"
    for kind, generate in kinds.items():
        kept = list(generate())
        _say(
            f"\n{kind}, {' and '.join(solver.name for solver in found)}:\n\n{heading}\n|{'---|' * (1 + 4 * len(found))}"
        )
        for decade in DECADES:
            _say(row(kept, decade, found))


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
