"""Angular momentum and Laplace vectors of an orbit, and their Jacobians.

H = r × v is normal to the orbit and L = v × H − μ r/|r| points to the perigee with |L| = μe. Five of their
six components are independent (H·L = 0). Source: Li et al. 2025, eqs. 6–7.

Every function is written in analytic operations only, so it accepts complex arrays (complex-step tests).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Vector = NDArray[Any]


def cross_matrix(a: ArrayLike) -> Vector:
    """The matrix [a]ₓ, shape (3, 3), with [a]ₓ b = a × b."""
    x, y, z = np.asarray(a)
    zero = x * 0.0
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]])


def angular_momentum(position: ArrayLike, velocity: ArrayLike) -> Vector:
    """H = r × v, shape (3,); units of position × velocity."""
    (x, y, z), (u, v, w) = np.asarray(position), np.asarray(velocity)
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def laplace_vector(position: ArrayLike, velocity: ArrayLike, mu: float) -> Vector:
    """L = v × (r × v) − μ r/|r|, shape (3,), units of μ; the eccentricity vector is L/μ.

    Raises ValueError when the position is the origin.
    """
    r, v = np.asarray(position), np.asarray(velocity)
    return np.asarray(_dot(v, v) * r - _dot(r, v) * v - mu * r / _norm(r))


def angular_momentum_jacobian(position: ArrayLike, velocity: ArrayLike) -> Vector:
    """∂H/∂(r, v), shape (3, 6): [−[v]ₓ, [r]ₓ]."""
    return np.hstack([-cross_matrix(velocity), cross_matrix(position)])


def laplace_jacobian(position: ArrayLike, velocity: ArrayLike, mu: float) -> Vector:
    """∂L/∂(r, v), shape (3, 6).

    From L = (v·v) r − (r·v) v − μ r/|r|:
    ∂L/∂r = (v·v) I − v vᵀ − μ (I/|r| − r rᵀ/|r|³),  ∂L/∂v = 2 r vᵀ − v rᵀ − (r·v) I.
    Raises ValueError when the position is the origin.
    """
    r, v = np.asarray(position), np.asarray(velocity)
    norm, identity = _norm(r), np.eye(3)
    cube = norm * norm * norm
    by_position = _dot(v, v) * identity - np.outer(v, v) - mu * (identity / norm - np.outer(r, r) / cube)
    by_velocity = 2.0 * np.outer(r, v) - np.outer(v, r) - _dot(r, v) * identity
    return np.hstack([by_position, by_velocity])


def specific_energy(position: ArrayLike, velocity: ArrayLike, mu: float) -> float:
    """v²/2 − μ/|r|; −μ/(2a) on an ellipse. Raises ValueError when the position is the origin."""
    r, v = np.asarray(position), np.asarray(velocity)
    return float(0.5 * (v @ v) - mu / _norm(r))


def _dot(a: Vector, b: Vector) -> Any:
    """In an order that every machine rounds the same."""
    return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2])


def _norm(r: Vector) -> Any:
    square = _dot(r, r)
    if square == 0.0:
        raise ValueError("position = [0, 0, 0]: must not be the centre of attraction")
    return np.sqrt(square)
