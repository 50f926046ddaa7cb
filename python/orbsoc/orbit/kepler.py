"""Two-body coasts of many states at once, in closed form: f and g by universal variables, in units where μ = 1.

Kepler's equation t(χ) = σ χ² C + (1 − α r₀) χ³ S + r₀ χ, with σ = r₀·v₀, α = 2/r₀ − v₀² and Stumpff's C and S of αχ², is solved
by Laguerre's iteration, which converges from anywhere (Conway 1986). Whole revolutions of an ellipse are left out.
"""

from __future__ import annotations

import numpy as np

from .array import Array

ITERATIONS = 60
DEGREE = 5
"""Of the polynomial that Laguerre's iteration takes the equation for; Conway's choice."""
SERIES = 1e-3
"""|αχ²| below which Stumpff's functions are summed."""


def coasted_in_closed_form(states: Array, times: Array) -> Array:
    """States (B, 6) after times (B,), which may be negative."""
    r, v = states[:, :3], states[:, 3:]
    radius = np.linalg.norm(r, axis=1)
    sigma = np.einsum("bi,bi->b", r, v)
    alpha = 2.0 / radius - np.einsum("bi,bi->b", v, v)
    time = _within_a_revolution(times, alpha)
    chi = time / radius
    for _ in range(ITERATIONS):
        square, cube = _stumpff(alpha * chi**2)
        psi = alpha * chi**2
        excess = sigma * chi**2 * square + (1.0 - alpha * radius) * chi**3 * cube + radius * chi - time
        slope = sigma * chi * (1.0 - psi * cube) + (1.0 - alpha * radius) * chi**2 * square + radius
        bend = sigma * (1.0 - psi * square) + (1.0 - alpha * radius) * chi * (1.0 - psi * cube)
        root = np.sqrt(np.abs((DEGREE - 1) ** 2 * slope**2 - DEGREE * (DEGREE - 1) * excess * bend))
        step = DEGREE * excess / (slope + root)
        chi = chi - step
        if not np.abs(step).max() > 1e-15 * max(1.0, np.abs(chi).max()):
            break
    square, cube = _stumpff(alpha * chi**2)
    psi = alpha * chi**2
    f, g = 1.0 - chi**2 * square / radius, time - chi**3 * cube
    position = f[:, None] * r + g[:, None] * v
    end = np.linalg.norm(position, axis=1)
    f_rate, g_rate = chi * (psi * cube - 1.0) / (end * radius), 1.0 - chi**2 * square / end
    return np.hstack([position, f_rate[:, None] * r + g_rate[:, None] * v])


def _within_a_revolution(times: Array, alpha: Array) -> Array:
    """Times less whole revolutions of the ellipses among the orbits, the nearest to 0."""
    closed = alpha > 1e-9
    period = 2.0 * np.pi / np.where(closed, alpha, 1.0) ** 1.5
    return np.where(closed, times - period * np.round(times / period), times)


def _stumpff(psi: Array) -> tuple[Array, Array]:
    """C = (1 − cos √ψ)/ψ and S = (√ψ − sin √ψ)/√ψ³, continued to ψ ≤ 0."""
    small = np.abs(psi) < SERIES
    root = np.sqrt(np.where(small, 1.0, np.abs(psi)))
    ahead = psi > 0.0
    angle = np.where(ahead, root, 0.0)
    lag = np.where(ahead, 0.0, np.minimum(root, 300.0))
    square = np.where(ahead, 2.0 * np.sin(0.5 * angle) ** 2, 2.0 * np.sinh(0.5 * lag) ** 2) / root**2
    cube = np.where(ahead, angle - np.sin(angle), np.sinh(lag) - lag) / root**3
    return (
        np.where(small, 1 / 2 - psi / 24 + psi**2 / 720 - psi**3 / 40320, square),
        np.where(small, 1 / 6 - psi / 120 + psi**2 / 5040 - psi**3 / 362880, cube),
    )
