"""Legendre–Gauss collocation on [−1, 1] with the initial point τ = −1 as an extra interpolation point.

The state is the degree-N polynomial through τ₀ = −1 and the N Legendre–Gauss nodes; its derivative is matched
to the dynamics at the nodes, and the end point follows by quadrature: x(1) = x(−1) + Σ wᵢ ẋ(τᵢ), which is exact
for it. Controls live at the nodes only (degree N − 1). Source: the Gauss pseudospectral method, Benson 2005.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit.array import Array


@dataclass(frozen=True, slots=True)
class LegendreGauss:
    """The grid of N nodes. `nodes` (N,) in (−1, 1), `weights` (N,) sum to 2.

    `differentiation` (N, N + 1): row i gives dx/dτ at node i from x at [−1, nodes].
    """

    nodes: Array
    weights: Array
    differentiation: Array

    @property
    def size(self) -> int:
        return self.nodes.size

    def interpolate(self, values: ArrayLike, tau: ArrayLike) -> Array:
        """The degree N − 1 polynomial through (N, …) values at the nodes, at the points tau → (K, …)."""
        return np.asarray(interpolation_matrix(self.nodes, tau) @ np.asarray(values, dtype=np.float64))

    def interpolate_from_start(self, start: ArrayLike, values: ArrayLike, tau: ArrayLike) -> Array:
        """The degree N polynomial through `start` (…) at τ = −1 and (N, …) `values` at the nodes."""
        points = np.concatenate([[-1.0], self.nodes])
        stacked = np.concatenate([np.asarray(start)[None], np.asarray(values)])
        return np.asarray(interpolation_matrix(points, tau) @ stacked.astype(np.float64))


@cache
def legendre_gauss(size: int) -> LegendreGauss:
    """The grid of `size` Legendre–Gauss nodes; shared and read-only. Raises ValueError if size < 2.

    >>> grid = legendre_gauss(2)
    >>> bool(np.allclose(grid.nodes, [-3**-0.5, 3**-0.5]))
    True
    """
    if isinstance(size, bool) or int(size) != size or size < 2:
        raise ValueError(f"size = {size!r}: a collocation grid needs an integer of at least 2 nodes")
    nodes, weights = np.polynomial.legendre.leggauss(int(size))
    matrix = differentiation_matrix(np.concatenate([[-1.0], nodes]))[1:]
    for array in (nodes, weights, matrix):
        array.setflags(write=False)
    return LegendreGauss(nodes, weights, matrix)


def barycentric_weights(points: ArrayLike) -> Array:
    """Weights 1/Π_{k≠j}(x_j − x_k) up to a common factor, shape (K,). Source: Berrut & Trefethen 2004, (3.2).

    The factor 2 per difference is the inverse capacity of [−1, 1]: it keeps the products near 1 for any K.
    """
    x = np.asarray(points, dtype=np.float64)
    differences = 2.0 * (x[:, None] - x[None, :])
    np.fill_diagonal(differences, 1.0)
    return np.asarray(1.0 / np.prod(differences, axis=1))


def interpolation_matrix(points: ArrayLike, at: ArrayLike) -> Array:
    """Matrix, shape (len(at), len(points)), from values at `points` to the interpolating polynomial at `at`.

    Second barycentric formula (Berrut & Trefethen 2004, (4.2)); exact where `at` hits a point.
    """
    x, t = np.asarray(points, dtype=np.float64), np.atleast_1d(np.asarray(at, dtype=np.float64))
    gaps = t[:, None] - x[None, :]
    hits = gaps == 0.0
    terms = barycentric_weights(x) / np.where(hits, 1.0, gaps)
    matrix: Array = terms / terms.sum(axis=1, keepdims=True)
    on_point = hits.any(axis=1)
    matrix[on_point] = hits[on_point]
    return matrix


def differentiation_matrix(points: ArrayLike) -> Array:
    """Matrix, shape (K, K), from values at K points to derivatives of their interpolant at the same points.

    D_ij = (w_j/w_i)/(x_i − x_j), rows summing to 0 (Berrut & Trefethen 2004, (9.4)).
    """
    x = np.asarray(points, dtype=np.float64)
    weights = barycentric_weights(x)
    gaps = x[:, None] - x[None, :]
    np.fill_diagonal(gaps, 1.0)
    matrix = (weights[None, :] / weights[:, None]) / gaps
    np.fill_diagonal(matrix, 0.0)
    np.fill_diagonal(matrix, -matrix.sum(axis=1))
    return matrix
