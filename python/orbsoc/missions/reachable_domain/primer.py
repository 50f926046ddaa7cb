"""Extremals of constant-thrust flight, many at once: the motion under primer steering, and its sensitivity.

Pontryagin's principle for a burn of given thrust and duration: the thrust points along the primer p (the costate of
velocity), and r̈ = g(r) + k p/|p|, p̈ = G(r) p with G = ∂g/∂r; the costate of position is −ṗ. Neither right-hand side
depends on a velocity, so both are integrated together by `orbsoc.orbit.gauss`. Source: Lawden, Optimal Trajectories
for Space Navigation, 1963, chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.missions.reachable_insertion.model import Burn
from orbsoc.orbit.gauss import GaussSteps, gauss_steps, integrate

Array = NDArray[np.float64]

SENSITIVITY_SWEEPS = 7
"""Fixed-point sweeps of the linear sensitivity equations per step; they only shape Newton's step."""


@dataclass(frozen=True, slots=True, eq=False)
class Extremals:
    """B extremals: ends (B, 12) = [r, v, p, ṗ], and nodes (K, 6, B) = [r, p] at the scheme's times."""

    scheme: GaussSteps
    ends: Array
    nodes: Array

    def __getitem__(self, which: NDArray[np.intp]) -> Extremals:
        return Extremals(self.scheme, self.ends[which], self.nodes[:, :, which])

    def put(self, which: NDArray[np.intp], other: Extremals) -> None:
        """Overwrite some extremals, in place."""
        self.ends[which] = other.ends
        self.nodes[:, :, which] = other.nodes

    @property
    def lowest_radius(self) -> Array:
        """Smallest |r| on the way, (B,)."""
        radius = np.sqrt((self.nodes[:, :3] ** 2).sum(axis=1)).min(axis=0)
        return np.asarray(np.minimum(radius, np.linalg.norm(self.ends[:, :3], axis=1)))


def extremals(burn: Burn, duration: float, primers: Array, *, steps: int) -> Extremals:
    """Fly the extremals of initial primers (B, 6) = [p₀, ṗ₀]; columns that cannot be integrated are NaN."""
    scheme = gauss_steps(duration, steps)
    thrust = burn.thrust_acceleration(scheme.times)[:, None]

    def force(window: slice, at: Array) -> Array:
        r, p = at[:, :3], at[:, 3:]
        square = np.einsum("sdb,sdb->sb", r, r)
        cube = 1.0 / (square * np.sqrt(square))
        out = np.empty_like(at)
        out[:, :3] = p * (thrust[window] / np.sqrt(np.einsum("sdb,sdb->sb", p, p)))[:, None]
        out[:, :3] -= r * cube[:, None]
        lean = 3.0 * np.einsum("sdb,sdb->sb", r, p) / square
        out[:, 3:] = (r * lean[:, None] - p) * cube[:, None]
        return out

    count = len(primers)
    start = np.repeat(burn.start[:, None], count, axis=1)
    with np.errstate(all="ignore"):
        arc = integrate(
            scheme,
            np.concatenate([start[:3], primers[:, :3].T]),
            np.concatenate([start[3:], primers[:, 3:].T]),
            force,
        )
    r, p = arc.end_position[:3], arc.end_position[3:]
    v, rate = arc.end_velocity[:3], arc.end_velocity[3:]
    return Extremals(scheme, np.concatenate([r, v, p, rate]).T, arc.positions)


def sensitivity(burn: Burn, flown: Extremals) -> Array:
    """∂[r, v, p, ṗ](t_f)/∂[p₀, ṗ₀], shape (B, 12, 6), along flown extremals.

    δÿ = K(t) δy with y = (r, p) and K = [[G, k(I − p̂p̂ᵀ)/|p|], [∂(Gp)/∂r, G]].
    """
    scheme = flown.scheme
    stages, count = scheme.stages, len(flown.ends)
    field = _field(burn.thrust_acceleration(scheme.times), flown.nodes)
    y, rate = np.zeros((count, 6, 6)), np.zeros((count, 6, 6))
    y[:, 3:, :3] = np.eye(3)
    rate[:, 3:, 3:] = np.eye(3)
    for step in range(scheme.steps):
        kernel = field[step * stages : (step + 1) * stages]
        drift = y + scheme.offsets[:, None, None, None] * rate
        nodes = drift
        for _ in range(SENSITIVITY_SWEEPS):
            pushed = (scheme.double @ (kernel @ nodes).reshape(stages, -1)).reshape(drift.shape)
            nodes = drift + pushed
        push = (kernel @ nodes).reshape(stages, -1)
        y = y + scheme.length * rate + (scheme.lever @ push).reshape(y.shape)
        rate = rate + (scheme.weights @ push).reshape(y.shape)
    return np.concatenate([y[:, :3], rate[:, :3], y[:, 3:], rate[:, 3:]], axis=1)


def _field(thrust: Array, nodes: Array) -> Array:
    """K at every node, (K, B, 6, 6)."""
    r, p = nodes[:, :3].transpose(0, 2, 1), nodes[:, 3:].transpose(0, 2, 1)
    square = (r * r).sum(axis=-1)
    five = 3.0 / (square**2 * np.sqrt(square))
    size = np.sqrt((p * p).sum(axis=-1))
    rr = r[..., :, None] * r[..., None, :]
    rp = r[..., :, None] * p[..., None, :]
    along = (r * p).sum(axis=-1)
    k = np.arange(3)
    out = np.empty((*square.shape, 6, 6))
    gradient = five[..., None, None] * rr
    gradient[..., k, k] -= (five * square / 3.0)[..., None]
    out[..., :3, :3] = out[..., 3:, 3:] = gradient
    steer = -(p[..., :, None] * p[..., None, :]) / (size**2)[..., None, None]
    steer[..., k, k] += 1.0
    out[..., :3, 3:] = steer * (thrust[:, None] / size)[..., None, None]
    # ∂(Gp)/∂r = 3(rpᵀ + prᵀ + (r·p)I)/|r|⁵ − 15(r·p)rrᵀ/|r|⁷
    bend = rp + rp.swapaxes(-1, -2) - (5.0 * along / square)[..., None, None] * rr
    bend[..., k, k] += along[..., None]
    out[..., 3:, :3] = five[..., None, None] * bend
    return out
