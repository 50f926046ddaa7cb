"""How fast the thrust turns: the rate of a commanded attitude, and its bound as cones of the convex problem.

Commanded is p/|p|, with p(τ) the interpolant of the nodal controls over τ ∈ [−1, 1]. It turns at |p × p'|/|p|² · 2/T, which is
|p'| · 2/T where p is of unit length. |p'| ≤ ωT/2 at a point is one cone of four, (ωT/2, p') ∈ Q⁴, convex with T unknown, too. p' is
a polynomial of degree n = N − 2; on the M + 1 points −cos(kπ/M) it is nowhere longer than cos(nπ/2M)⁻¹ times its longest
there (Ehlich & Zeller 1964), so that points in proportion to N hold it between the nodes as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from orbsoc.conic.builder import ConicBuilder, Term, Variable
from orbsoc.guidance.collocation import (
    LegendreGauss,
    differentiation_matrix,
    interpolation_matrix,
    legendre_gauss,
)
from orbsoc.guidance.powered_flight import BurnVariables, Trajectory
from orbsoc.orbit.array import Array

from .. import tuning

SAMPLES_PER_NODE = 64
STEP = 1e-5
"""Of the central differences, in τ."""


def rates(grid: LegendreGauss, controls: Array, tau: ArrayLike) -> Array:
    """Rates (K,), rad per unit of τ, of the direction that nodal controls (N, 3) command, by central differences of it."""
    at = np.asarray(tau, dtype=np.float64)
    ahead, behind = (_directions(grid, controls, at + step) for step in (STEP, -STEP))
    return np.asarray(np.linalg.norm(ahead - behind, axis=1) / (2.0 * STEP))


def peak_rate(grid: LegendreGauss, controls: Array) -> float:
    """The largest of `rates` over the burn, on 64 points a node that are as dense at the ends as the nodes are."""
    return float(rates(grid, controls, _dense(SAMPLES_PER_NODE * grid.size)).max())


def add_turns(
    builder: ConicBuilder,
    controls: Variable,
    slopes: Array | sparse.coo_array,
    allowed: Array,
    longer: tuple[Variable, Array] | None = None,
) -> None:
    """A cone for each row of `slopes` (M, nodes): |p'| there is at most `allowed` (M,), and M rows times a variable more."""
    pick, head = np.vstack([np.zeros(3), -np.eye(3)]), np.array([[1.0], [0.0], [0.0], [0.0]])
    terms: list[Term] = [(controls, sparse.kron(sparse.coo_array(slopes), pick))]
    if longer is not None:
        terms.append((longer[0], np.kron(-longer[1], head)))
    builder.second_order(terms, np.kron(allowed, head[:, 0]), size=4, name="attitude rate")


@dataclass(frozen=True, slots=True)
class RateBound:
    """The thrust turns at `rate` at most, rad per canonical time.

    The unit ball |u| ≤ 1 lets a fast turn take the short way through its inside. `price` is what thrust that is missing costs, as a
    multiple of what it is worth, −price · w_i T/2 · û_i·u_i with û_i of the reference: the concave 1 − |u|, linearised.
    """

    rate: float
    price: float = 0.0

    def add(
        self, builder: ConicBuilder, variables: BurnVariables, reference: Trajectory, worth: float
    ) -> None:
        """The cones, and the price where `worth` is the cost that a unit of time without thrust adds."""
        grid, slopes = reference.grid, slope_matrix(reference.grid.size)
        half = np.full(len(slopes), 0.5 * self.rate)
        if variables.duration is None:
            add_turns(builder, variables.controls, slopes, half * reference.duration)
        else:
            longer = (variables.duration, half[:, None])
            add_turns(builder, variables.controls, slopes, np.zeros(len(slopes)), longer)
        if self.price > 0.0:
            length = np.linalg.norm(reference.controls, axis=1, keepdims=True)
            weights = 0.5 * self.price * worth * reference.duration * grid.weights
            builder.cost(
                variables.controls, -weights[:, None] * reference.controls / np.maximum(length, 1e-3)
            )


@cache
def slope_matrix(nodes: int) -> Array:
    """From nodal values to the derivative of their interpolant at the bounded points (4N + 1, N)."""
    grid = legendre_gauss(nodes)
    return interpolation_matrix(grid.nodes, _dense(tuning.CONES_PER_NODE * nodes)) @ differentiation_matrix(
        grid.nodes
    )


def _dense(count: int) -> Array:
    return -np.cos(np.pi * np.arange(count + 1) / count)


def _directions(grid: LegendreGauss, controls: Array, tau: Array) -> Array:
    raw = grid.interpolate(controls, tau)
    return np.asarray(raw / np.linalg.norm(raw, axis=1, keepdims=True))
