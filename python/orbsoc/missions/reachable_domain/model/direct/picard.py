"""Solve (L ⊗ I − diag(Gᵢ)) X = C for many trajectories, L (N, N) shared: the linearised motion, without factorising it.

L is the twofold differentiation over a burn or its transpose, so L⁻¹ integrates twice, and X ← L⁻¹(C + GX) is the
Picard iteration of a linear differential equation: after k iterations the error is of the order of (T²/r³)ᵏ/(2k)!, ten
iterations to rounding for a burn of a quarter of an orbit. An iteration is one matrix product for all trajectories.
Where it does not converge the equations are factorised. Arrays have trajectories last: C and X are (N, 3, …, B).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array

MAX_ITERATIONS = 40
UNCHECKED_ITERATIONS = 6
"""Iterations before the first convergence check."""
TOLERANCE = 1e-9
"""Change of an iteration, relative to the largest number of X or 1, at which it has converged."""
BLOCK = 768
"""Columns of X in a block, of all its trajectories: what fits in a core's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class GravityGradient:
    """G = qqᵀ − κI at the nodes of B trajectories: q (N, 3, B) = r·√3/|r|^(5/2), κ (N, B) = 1/|r|³."""

    q: Array
    kappa: Array

    @classmethod
    def at(cls, positions: Array) -> GravityGradient:
        """At positions (N, 3, B), canonical."""
        square = np.einsum("ncb,ncb->nb", positions, positions)
        kappa = 1.0 / (square * np.sqrt(square))
        return cls(positions * np.sqrt(3.0 * kappa / square)[:, None], kappa)

    def times(self, x: Array, out: Array | None = None) -> Array:
        """GX for X (N, 3, …, B)."""
        middle = (slice(None), *(None,) * (x.ndim - 3))
        q = [self.q[:, c][middle] for c in range(3)]
        along = q[0] * x[:, 0]
        product = q[1] * x[:, 1]
        along += product
        along += np.multiply(q[2], x[:, 2], out=product)
        kappa = self.kappa[(slice(None), None, *(None,) * (x.ndim - 3))]
        pulled = np.empty_like(x) if out is None else out
        np.multiply(x, -kappa, out=pulled)
        for c in range(3):
            pulled[:, c] += np.multiply(q[c], along, out=product)
        return pulled

    def dense(self) -> Array:
        """G itself, (B, N, 3, 3)."""
        out: Array = np.einsum("ncb,ndb->bncd", self.q, self.q)
        k = np.arange(3)
        out[..., k, k] -= self.kappa.T[:, :, None]
        return out


def solve_picard(
    double_integral: Array, gravity: GravityGradient, constant: Array, guess: Array | None = None
) -> Array:
    """X of L X = C + GX, with `twice` = L⁻¹ (N, N)."""
    n, shape = len(double_integral), constant.shape
    x = guess if guess is not None else (double_integral @ constant.reshape(n, -1)).reshape(shape)
    pulled, moved, old = np.empty(shape), np.empty(shape), np.empty(shape)
    for number in range(MAX_ITERATIONS):
        gravity.times(x, pulled)
        pulled += constant
        np.matmul(double_integral, pulled.reshape(n, -1), out=moved.reshape(n, -1))
        if number >= UNCHECKED_ITERATIONS:
            change = np.subtract(moved, x, out=pulled)
            if not max(change.max(), -change.min()) > TOLERANCE * max(1.0, moved.max()):
                return moved
        x, moved, old = moved, old, moved
    return _factorised(double_integral, gravity, constant)


def blocks(count: int, *, columns: int = 6) -> Iterator[slice]:
    """Blocks of `count` trajectories with `columns` columns of X each."""
    each = max(BLOCK // columns, 1)
    for start in range(0, count, each):
        yield slice(start, start + each)


def _factorised(double_integral: Array, gravity: GravityGradient, constant: Array) -> Array:
    n, count = len(double_integral), constant.shape[-1]
    system = np.broadcast_to(np.kron(np.linalg.inv(double_integral), np.eye(3)), (count, 3 * n, 3 * n)).copy()
    blocks, k = system.reshape(count, n, 3, n, 3), np.arange(n)
    blocks[:, k, :, k, :] -= gravity.dense().transpose(1, 0, 2, 3)
    right = np.moveaxis(constant, -1, 0).reshape(count, 3 * n, -1)
    return np.ascontiguousarray(np.moveaxis(np.linalg.solve(system, right), 0, -1)).reshape(constant.shape)
