"""The condensed subproblem: the controls are the only unknowns, and one sparsity pattern serves every point.

minimise c·u subject to Au = b (the plane), rows u ≤ rhs, ‖uᵢ‖ ≤ 1 at N nodes (N cones of four), and one cone of three
for the perigee; c, A and the last rows are dense in the 3N controls, because the states have been eliminated. See
docs/decisions/0015 for its size and time beside the form that keeps the states.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy import sparse

from orbsoc.conic.problem import Cones, Problem
from orbsoc.orbit.array import Array, Flags, Index

from .arcs import Arcs, Collocation, EndMap
from .terminal import TerminalRows


@dataclass(frozen=True, slots=True)
class Shape:
    """Sizes of a condensed subproblem: nodes, equality rows, bounds, and whether there is a perigee cone."""

    nodes: int
    equal: int
    bounds: int
    cone: bool


@dataclass(frozen=True, slots=True, eq=False)
class CondensedBatch:
    """Data of B subproblems of one `base` in the layout of `solve_batch`: c (B, n), b, h and CSC values of A and G."""

    base: Problem
    c: Array
    A: Array
    b: Array
    G: Array
    h: Array

    def __len__(self) -> int:
        return len(self.c)

    def __getitem__(self, which: Index | Flags) -> CondensedBatch:
        return CondensedBatch(
            self.base, self.c[which], self.A[which], self.b[which], self.G[which], self.h[which]
        )

    def problem(self, k: int) -> Problem:
        """One of them as a problem of its own."""
        A, G = self.base.A, self.base.G
        return Problem(
            c=self.c[k],
            A=sparse.csc_array((self.A[k], A.indices, A.indptr), shape=A.shape),
            b=self.b[k],
            G=sparse.csc_array((self.G[k], G.indices, G.indptr), shape=G.shape),
            h=self.h[k],
            cones=self.base.cones,
        )


PERIGEE_CONE = 3
"""Dimension of the cone that holds the perigee at its bound or above, the last one where there is one."""


@cache
def base_problem(shape: Shape) -> Problem:
    """A problem of the pattern; its values are placeholders, none of them zero."""
    n, l = 3 * shape.nodes, shape.bounds
    G = np.zeros((l + 4 * shape.nodes + 3 * shape.cone, n))
    G[:l] = 1.0
    k = np.arange(n)
    G[l + 4 * (k // 3) + 1 + k % 3, k] = -1.0
    G[l + 4 * shape.nodes :] = 1.0
    h = np.zeros(len(G))
    h[l : l + 4 * shape.nodes : 4] = 1.0
    cones = Cones(l, [4] * shape.nodes + [PERIGEE_CONE] * shape.cone)
    return Problem(c=np.ones(n), A=np.ones((shape.equal, n)), b=np.zeros(shape.equal), G=G, h=h, cones=cones)


def condense(linear: EndMap, end: TerminalRows, *, path: tuple[Array, Array] | None = None) -> CondensedBatch:
    """Write rows on the end state as rows on the controls; `path` (rows (B, l, 3N), rhs (B, l)) adds bounds."""
    count, n = len(linear.constant), linear.by_control.shape[2]
    nodes = n // 3
    bound, bound_rhs = _on_controls(linear, end.bound, end.bound_rhs)
    if path is not None:
        bound = np.concatenate([bound, path[0]], axis=1)
        bound_rhs = np.concatenate([bound_rhs, path[1]], axis=1)
    equal, equal_rhs = _on_controls(linear, end.equal, end.equal_rhs)
    cone, cone_rhs = _on_controls(linear, end.cone, end.cone_rhs)
    l, q = bound.shape[1], cone.shape[1]
    base = base_problem(Shape(nodes, equal.shape[1], l, q == 3))

    h = np.empty((count, l + 4 * nodes + q))
    h[:, :l], h[:, l + 4 * nodes :] = bound_rhs, cone_rhs
    h[:, l : l + 4 * nodes] = np.tile([1.0, 0.0, 0.0, 0.0], nodes)
    G = np.empty((count, n, l + 1 + q))
    G[:, :, :l] = bound.transpose(0, 2, 1)
    G[:, :, l] = -1.0
    G[:, :, l + 1 :] = cone.transpose(0, 2, 1)
    return CondensedBatch(
        base=base,
        c=(end.cost[:, None] @ linear.by_control)[:, 0],
        A=equal.transpose(0, 2, 1).reshape(count, -1),
        b=equal_rhs,
        G=G.reshape(count, -1),
        h=h,
    )


def _on_controls(linear: EndMap, rows: Array, rhs: Array) -> tuple[Array, Array]:
    """rows · x_f ∘ rhs as rows · (∂x_f/∂u) u ∘ rhs − rows · constant."""
    return rows @ linear.by_control, rhs - (rows @ linear.constant[:, :, None])[:, :, 0]


def altitude_rows(
    collocation: Collocation, linear: EndMap, about: Arcs, lowest: Array
) -> tuple[Array, Array]:
    """Rows (B, N, 3N) and right-hand sides (B, N) of −r̂ᵢ·Rᵢ ≤ −ρ for smallest radii (B,), canonical: a bound on the altitude.

    The direction r̂ᵢ is the reference's: a half-space that the sphere of radius ρ lies behind, so what the rows allow is
    allowed by the sphere too: r̂ᵢ·Rᵢ ≥ ρ implies |Rᵢ| ≥ ρ.
    """
    count, n = about.positions.shape[:2]
    outward = about.positions / np.linalg.norm(about.positions, axis=2, keepdims=True)
    inverse = collocation.inverse(about.positions).reshape(count, n, 3, 3 * n)
    rows = -np.einsum("bni,bnij->bnj", outward, inverse)
    rhs = np.einsum("bni,ni->bn", outward, collocation.straight) - lowest[:, None]
    rhs -= np.einsum("bnj,bj->bn", rows, linear.offset.reshape(count, -1))
    return rows * np.repeat(collocation.thrust, 3), rhs
