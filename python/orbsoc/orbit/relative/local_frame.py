"""The target's frame (R, T, N): from inertial states to relative ones and back, with the frame's rotation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..array import Array
from ..vectors import cross_matrix

LVLH = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
"""Takes (R, T, N) to (x along the motion, y against the angular momentum, z to the nadir); its transpose goes back."""


def local_frame(target: ArrayLike, acceleration: ArrayLike | None = None) -> tuple[Array, Array]:
    """Rows R, T, N of the frame in inertial axes, (3, 3), and its angular velocity in its own axes, (3,), rad/s.

    `target` is the inertial state [r_m, v_m_s]; `acceleration` (3,), m/s², matters where it leaves the orbital plane:
    ω = (r/h) a_N R̂ + (h/r²) N̂. Without it the plane rests. Raises ValueError for a rectilinear state.
    """
    state = np.asarray(target, np.float64)
    r, v = state[:3], state[3:]
    momentum = np.cross(r, v)
    radius, h = float(np.linalg.norm(r)), float(np.linalg.norm(momentum))
    if not h > 0.0:
        raise ValueError("rectilinear motion: r × v = 0 has no orbital plane; r and v must not be parallel")
    outward, normal = r / radius, momentum / h
    axes = np.array([outward, np.cross(normal, outward), normal])
    across = 0.0 if acceleration is None else float(normal @ np.asarray(acceleration, np.float64))
    return axes, np.array([radius / h * across, 0.0, h / radius**2])


def to_relative(target: ArrayLike, acceleration: ArrayLike | None = None) -> Array:
    """Matrix (6, 6) that takes an inertial difference chaser − target to the relative state: ρ = Q Δr,
    ρ̇ = Q Δv − ω × ρ. Exact, for any distance."""
    axes, rate = local_frame(target, acceleration)
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = matrix[3:, 3:] = axes
    matrix[3:, :3] = -cross_matrix(rate) @ axes
    return matrix


def to_inertial(target: ArrayLike, acceleration: ArrayLike | None = None) -> Array:
    """The inverse of `to_relative`, (6, 6): Δv = Qᵀ(ρ̇ + ω × ρ)."""
    axes, rate = local_frame(target, acceleration)
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = matrix[3:, 3:] = axes.T
    matrix[3:, :3] = axes.T @ cross_matrix(rate)
    return matrix


def relative_state(target: ArrayLike, chaser: ArrayLike, acceleration: ArrayLike | None = None) -> Array:
    """State of the chaser relative to the target, (..., 6), frame (R, T, N), from inertial [r_m, v_m_s]; one target (6,)
    and any number of chasers (..., 6). `acceleration` is the target's, as in `local_frame`."""
    difference = np.asarray(chaser, np.float64) - np.asarray(target, np.float64)
    return np.asarray(difference @ to_relative(target, acceleration).T)


def absolute_state(target: ArrayLike, relative: ArrayLike, acceleration: ArrayLike | None = None) -> Array:
    """Inertial states (..., 6) of chasers from their relative states (..., 6); the inverse of `relative_state`."""
    difference = np.asarray(relative, np.float64) @ to_inertial(target, acceleration).T
    return np.asarray(np.asarray(target, np.float64) + difference)
