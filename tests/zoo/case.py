"""One problem of the zoo with what is known about its answer, and short spellings for building it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import SupportsFloat

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.solution import Status

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ZooCase:
    """A problem and the statuses a solver may return for it.

    `objective` is the known optimal value (None: a second solver gives the reference); `scaled` says that the data are
    badly scaled; `clarabel_fails` why Clarabel cannot verify here (then the known answer alone does).
    """

    name: str
    problem: Problem
    expected: frozenset[Status]
    objective: float | None = None
    scaled: bool = False
    clarabel_fails: str | None = None

    @property
    def solvable(self) -> bool:
        return self.expected == frozenset({Status.SOLVED})


def solvable(
    name: str,
    problem: Problem,
    objective: SupportsFloat | None = None,
    *,
    scaled: bool = False,
    clarabel_fails: str | None = None,
) -> ZooCase:
    """A case with an optimal value, known or not."""
    value = None if objective is None else float(objective)
    return ZooCase(name, problem, frozenset({Status.SOLVED}), value, scaled, clarabel_fails)


def infeasible(name: str, problem: Problem) -> ZooCase:
    """A case without a feasible point."""
    return ZooCase(name, problem, frozenset({Status.PRIMAL_INFEASIBLE}))


def unbounded(name: str, problem: Problem) -> ZooCase:
    """A case whose objective falls without limit."""
    return ZooCase(name, problem, frozenset({Status.DUAL_INFEASIBLE}))


def lp(
    c: ArrayLike,
    G: ArrayLike | None = None,
    h: ArrayLike | None = None,
    A: ArrayLike | None = None,
    b: ArrayLike | None = None,
    P: ArrayLike | None = None,
) -> Problem:
    """A problem whose rows of G are all inequalities Gx ≤ h."""
    rows = 0 if G is None else np.shape(G)[0]
    return Problem(P=P, c=c, A=A, b=b, G=G, h=h, cones=Cones(l=rows))


def socp(
    c: ArrayLike,
    cone_rows: Sequence[tuple[ArrayLike, ArrayLike]],
    inequalities: tuple[ArrayLike, ArrayLike] | None = None,
    A: ArrayLike | None = None,
    b: ArrayLike | None = None,
    P: ArrayLike | None = None,
) -> Problem:
    """A problem with one second-order cone h − Gx ∈ Q per pair (G, h) of `cone_rows`, after inequalities Gx ≤ h."""
    blocks = [*([] if inequalities is None else [inequalities]), *cone_rows]
    sizes = [np.shape(h)[0] for _, h in cone_rows]
    l = 0 if inequalities is None else np.shape(inequalities[1])[0]
    return Problem(
        P=P,
        c=c,
        A=A,
        b=b,
        G=np.vstack([np.asarray(G, dtype=float) for G, _ in blocks]),
        h=np.concatenate([np.asarray(h, dtype=float) for _, h in blocks]),
        cones=Cones(l=l, q=sizes),
    )


def box(n: int, low: float, high: float) -> tuple[Array, Array]:
    """(G, h) of low ≤ x ≤ high."""
    eye = np.eye(n)
    return np.vstack([eye, -eye]), np.concatenate([np.full(n, high), np.full(n, -low)])


def ball(center: ArrayLike, radius: float) -> tuple[Array, Array]:
    """(G, h) of ‖x − center‖ ≤ radius."""
    middle = np.asarray(center, dtype=float)
    n = middle.size
    return np.vstack([np.zeros(n), -np.eye(n)]), np.concatenate([[radius], -middle])
