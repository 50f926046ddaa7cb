"""Objective and terminal conditions as smooth functions of the end state, with first and second derivatives.

Rows of a point: two of the plane, the perigee radius, the perigee direction. Gradients are written in analytic
operations only; second derivatives are complex steps of them, exact to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import cross, in_plane_axes

from ..direct.terminal import LargestOrbit

Vector = NDArray[Any]
"""Real, or complex in a complex step."""

ROWS = 4
PLANE, ACROSS, PERIGEE, DIRECTION = range(ROWS)
STEP = 1e-30
"""Of the complex step: no subtraction, so no cancellation."""


@dataclass(frozen=True, slots=True, eq=False)
class Conditions:
    """∇J (B, 6), the rows' gradients (B, 4, 6) and the rows' values (B, 4) at end states."""

    objective: Vector
    gradients: Vector
    values: Vector


def conditions(target: LargestOrbit, ends: Vector) -> Conditions:
    """Evaluate at end states (B, 6), real or complex."""
    r, v = ends[:, :3], ends[:, 3:]
    rr, vv, rv = _dot(r, r), _dot(v, v), _dot(r, v)
    norm = np.sqrt(rr)[:, None]
    energy_slope = np.concatenate([r / norm**3, v], axis=1)
    rho = target.perigee
    energy = 0.5 * vv - 1.0 / norm[:, 0]
    square = rr * vv - rv**2
    square_slope = 2.0 * np.concatenate(
        [r * vv[:, None] - v * rv[:, None], v * rr[:, None] - r * rv[:, None]], axis=1
    )
    perigee = square / (2.0 * rho**2) - 1.0 / rho - energy
    perigee_slope = square_slope / (2.0 * rho**2)[:, None] - energy_slope

    gradients = np.zeros((len(ends), ROWS, 6), ends.dtype)
    values = np.zeros((len(ends), ROWS), ends.dtype)
    gradients[:, PERIGEE], values[:, PERIGEE] = perigee_slope, perigee
    first, second = in_plane_axes(target.normal)
    gradients[:, PLANE], values[:, PLANE] = _component(first, r, v)
    gradients[:, ACROSS], values[:, ACROSS] = _component(second, r, v)
    if target.perigee_direction is not None:
        q = cross(target.normal, target.perigee_direction)
        qr, qv = _dot(q, r), _dot(q, v)
        values[:, DIRECTION] = vv * qr - rv * qv - qr / norm[:, 0]
        by_r = (vv - 1.0 / norm[:, 0])[:, None] * q - v * qv[:, None] + r * (qr[:, None] / norm**3)
        by_v = 2.0 * v * qr[:, None] - r * qv[:, None] - rv[:, None] * q
        gradients[:, DIRECTION] = np.concatenate([by_r, by_v], axis=1)
    return Conditions(energy_slope, gradients, values)


def curvature(target: LargestOrbit, ends: Array, multipliers: Array) -> Array:
    """∇²(J + Σ ν c) at end states, (B, 6, 6)."""
    point = np.repeat(np.arange(len(ends)), 6)
    nudged = ends[point].astype(np.complex128)
    nudged += 1j * STEP * np.tile(np.eye(6), (len(ends), 1))
    at = conditions(target[point], nudged)
    slope = at.objective.imag + (multipliers[point, None] @ at.gradients.imag)[:, 0]
    return np.asarray(slope.reshape(len(ends), 6, 6).swapaxes(1, 2) / STEP)


def _dot(a: Vector, b: Vector) -> Vector:
    return np.asarray((a * b).sum(axis=1))


def _component(axis: Array, r: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Gradient (B, 6) and value (B,) of axis · (r × v)."""
    return np.concatenate([cross(v, axis), cross(axis, r)], axis=1), _dot(axis, cross(r, v))
