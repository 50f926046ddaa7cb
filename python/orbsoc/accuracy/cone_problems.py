"""Optima that are known in closed form, or printed: quadratic programmes of Hock and Schittkowski, and sums of norms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.conic.builder import ConicBuilder
from orbsoc.solving.solver import solve

from .number import Number

QP = "Maros & Mészáros 1999, after Hock & Schittkowski 1981"
TOL = 1e-11
Rows = list[tuple[list[float], float]]
Squares = list[tuple[list[float], float]]
"""(row · x − target)² each."""


@dataclass(frozen=True, slots=True)
class Quadratic:
    """½ xᵀPx + cᵀx + constant; rows that are equal to a value, rows that are at least one, and bounds; the optimum as printed."""

    name: str
    optimum: str
    cost: tuple[ArrayLike, ArrayLike, float]
    equal: Rows
    least: Rows
    bounds: tuple[ArrayLike, ArrayLike]

    @property
    def number(self) -> Number:
        p, c, constant = self.cost
        n = np.size(c)
        builder = ConicBuilder()
        x = builder.variable("x", n)
        builder.quadratic_cost(x, np.asarray(p, float))
        builder.cost(x, c)
        for row, value in self.equal:
            builder.equality([(x, np.array([row]))], value)
        for row, value in self.least:
            builder.nonnegative([(x, -np.array([row]))], -value)
        low, high = (np.broadcast_to(np.asarray(bound, float), n) for bound in self.bounds)
        if np.isfinite([*low, *high]).any():
            builder.bounds(x, low, high)
        ours = solve(builder.build(), tol=TOL).objective + constant
        digits = len(self.optimum.partition(".")[2])
        return Number(f"{self.name}: optimum", QP, self.optimum, ours, 0.5 * 10.0**-digits + 1e-9)


def _squares(squares: Squares) -> tuple[ArrayLike, ArrayLike, float]:
    rows, targets = np.array([row for row, _ in squares]), np.array([target for _, target in squares])
    return 2.0 * rows.T @ rows, -2.0 * rows.T @ targets, float(targets @ targets)


_TAIL: Squares = [([0, 1, 1, 0, 0], 2), ([0, 0, 0, 1, 0], 1), ([0, 0, 0, 0, 1], 1)]
_LINKS: Rows = [([0, 0, 1, 1, -2], 0), ([0, 1, 0, 0, -1], 0)]
QUADRATIC = (
    Quadratic("HS21", "-99.960000", (np.diag([0.02, 2]), [0, 0], -100), [], [([10, -1], 10)], ([2, -50], [50, 50])),
    Quadratic("HS35", "0.11111111", ([[4, 2, 2], [2, 4, 0], [2, 0, 2]], [-8, -6, -4], 9), [], [([-1, -1, -2], -3)], (0, inf)),
    Quadratic("HS51", "0.00000000", _squares([([1, -1, 0, 0, 0], 0), *_TAIL]), [([1, 3, 0, 0, 0], 4), *_LINKS], [], (-inf, inf)),
    Quadratic("HS52", "5.32664756", _squares([([4, -1, 0, 0, 0], 0), *_TAIL]), [([1, 3, 0, 0, 0], 0), *_LINKS], [], (-inf, inf)),
    Quadratic("HS53", "4.09302326", _squares([([1, -1, 0, 0, 0], 0), *_TAIL]), [([1, 3, 0, 0, 0], 0), *_LINKS], [], (-10, 10)),
    Quadratic("HS76", "-4.68181818", ([[2, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 2, 1], [0, 0, 1, 1]], [-1, -3, 1, -1], 0), [],
              [([-1, -2, -1, -1], -5), ([-3, -1, -2, 1], -4), ([0, 1, 4, 0], 1.5)], (0, inf)),
    Quadratic("TAME", "0.00000000", _squares([([1, -1], 0)]), [([1, 1], 1)], [], (0, inf)),
)  # fmt: skip


def numbers() -> Iterator[Number]:
    """Objectives at the optimum."""
    yield from (each.number for each in QUADRATIC)
    yield Number("triangle 3, 4, 5: least sum of distances to its corners", "Torricelli's point, closed form",
                 f"{sqrt(25.0 + 12.0 * sqrt(3.0)):.12f}", _fermat(), 1e-9)  # fmt: skip
    yield Number(
        "regular hexagon of radius 1: smallest circle about it",
        "closed form",
        "1.000000000000",
        _smallest_circle(6),
        1e-9,
    )
    yield Number("distance of (−1; 3, 4) from the second-order cone", "projection, closed form: 6/√2",
                 f"{sqrt(18.0):.12f}", _to_the_cone(), 1e-9)  # fmt: skip


def _fermat() -> float:
    """The least sum of distances to the corners of a triangle."""
    builder = ConicBuilder()
    x, distance = builder.variable("x", 2), builder.variable("distance", 3)
    builder.cost(distance, 1.0)
    for k, corner in enumerate(((0.0, 0.0), (4.0, 0.0), (0.0, 3.0))):
        builder.norm([(x, np.eye(2))], [-corner[0], -corner[1]], bound=distance.index[k : k + 1])
    return solve(builder.build(), tol=TOL).objective


def _smallest_circle(count: int) -> float:
    """The radius of the smallest circle about the corners of a regular polygon of radius 1, moved by (2, −1)."""
    builder = ConicBuilder()
    x, radius = builder.variable("x", 2), builder.variable("radius", 1)
    builder.cost(radius, 1.0)
    for k in range(count):
        corner = 2.0 + np.cos(2.0 * pi * k / count), -1.0 + np.sin(2.0 * pi * k / count)
        builder.norm([(x, np.eye(2))], [-corner[0], -corner[1]], bound=radius)
    return solve(builder.build(), tol=TOL).objective


def _to_the_cone() -> float:
    """The distance of (−1; 3, 4) from {(t, u): ‖u‖ ≤ t}: (5 + 1)/√2."""
    builder = ConicBuilder()
    point, distance = builder.variable("point", 3), builder.variable("distance", 1)
    builder.cost(distance, 1.0)
    builder.second_order([(point, -np.eye(3))], np.zeros(3))
    builder.norm([(point, np.eye(3))], [1.0, -3.0, -4.0], bound=distance)
    return solve(builder.build(), tol=TOL).objective
