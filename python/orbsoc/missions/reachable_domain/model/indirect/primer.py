"""Extremals of constant-thrust flight, many at once: the motion under primer steering, and its sensitivity.

Pontryagin's principle for a burn of given thrust and duration: the thrust points along the primer p (the costate of
velocity), and r̈ = g(r) + k p/|p|, p̈ = G(r) p with G = ∂g/∂r; the costate of position is −ṗ. Neither right-hand side
depends on a velocity, so both are integrated together by `orbsoc.orbit.gauss`. Source: Lawden, Optimal Trajectories
for Space Navigation, 1963, chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.collocation import interpolation_matrix, legendre_gauss
from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.gauss import GaussSteps, extrapolation, gauss_steps, integrate

FIRST_ITERATIONS, ITERATIONS = 4, 1
"""Fixed-point iterations of the sensitivity equations in the first step, and in the others, which start from the one before:
they only shape Newton's step."""
FLIGHT_BLOCK, BLOCK = 512, 64
"""Extremals in a block of flights, and of sensitivities: what fits in a core's cache."""
LENGTHS_AT = np.linspace(-1.0, 1.0, 201)
"""Times, on [−1, 1], at which a programme's length is sampled."""


@dataclass(frozen=True, slots=True, eq=False)
class Extremals:
    """B extremals: ends (B, 12) = [r, v, p, ṗ], and nodes (K, 6, B) = [r, p] at the scheme's times."""

    scheme: GaussSteps
    ends: Array
    nodes: Array

    def __getitem__(self, which: Index) -> Extremals:
        return Extremals(self.scheme, self.ends[which], self.nodes[:, :, which])

    def put(self, which: Index, other: Extremals) -> None:
        """Overwrite some extremals, in place."""
        self.ends[which] = other.ends
        self.nodes[:, :, which] = other.nodes


def extremals(burn: Burn, duration: float, primers: Array, *, steps: int) -> Extremals:
    """Fly the extremals of initial primers (B, 6) = [p₀, ṗ₀]; columns that cannot be integrated are NaN."""
    scheme = gauss_steps(duration, steps)
    thrust = burn.thrust_acceleration(scheme.times)[:, None]

    def force(window: slice, at: Array) -> Array:
        r, p = at[:, :3], at[:, 3:]
        products = at * at
        square = products[:, 0] + products[:, 1]
        square += products[:, 2]
        size = products[:, 3] + products[:, 4]
        size += products[:, 5]
        along = np.multiply(r, p, out=products[:, :3])
        lean = along[:, 0] + along[:, 1]
        lean += along[:, 2]
        lean *= 3.0
        lean /= square
        square *= np.sqrt(square)
        cube = np.divide(1.0, square, out=square)[:, None]
        out = np.empty_like(at)
        np.multiply(p, (thrust[window] / np.sqrt(size))[:, None], out=out[:, :3])
        out[:, :3] -= np.multiply(r, cube, out=products[:, :3])
        bent = np.multiply(r, lean[:, None], out=products[:, 3:])
        bent -= p
        np.multiply(bent, cube, out=out[:, 3:])
        return out

    ends, nodes = np.empty((len(primers), 12)), np.empty((len(scheme.times), 6, len(primers)))
    with np.errstate(all="ignore"):
        for first in range(0, len(primers), FLIGHT_BLOCK):
            part = slice(first, first + FLIGHT_BLOCK)
            at = primers[part].T
            start = np.repeat(burn.start[:, None], at.shape[1], axis=1)
            position, velocity = np.concatenate([start[:3], at[:3]]), np.concatenate([start[3:], at[3:]])
            arc = integrate(scheme, position, velocity, force)
            r, p = arc.end_position[:3], arc.end_position[3:]
            v, rate = arc.end_velocity[:3], arc.end_velocity[3:]
            ends[part], nodes[:, :, part] = np.concatenate([r, v, p, rate]).T, arc.positions
    return Extremals(scheme, ends, nodes)


def primer_programmes(flown: Extremals, nodes: int) -> Array:
    """Attitude programmes (B, N, 3) of extremals: primers at N Legendre–Gauss nodes, the largest on the way of length 1.

    The primer is smooth where its direction swings, so a few nodes hold it.
    """
    scheme = flown.scheme
    at = 0.5 * scheme.duration * (legendre_gauss(nodes).nodes + 1.0)
    step = np.minimum((at / scheme.length).astype(np.intp), scheme.steps - 1)
    primers = flown.nodes[:, 3:].reshape(scheme.steps, scheme.stages, 3, -1)
    vectors = np.empty((primers.shape[3], nodes, 3))
    for k in range(nodes):
        start = step[k] * scheme.length
        row = interpolation_matrix(scheme.offsets, [at[k] - start])[0]
        vectors[:, k] = np.einsum("s,sdb->bd", row, primers[step[k]])
    between = interpolation_matrix(legendre_gauss(nodes).nodes, LENGTHS_AT) @ vectors
    largest = np.sqrt(np.einsum("bkd,bkd->bk", between, between).max(axis=1))
    return np.asarray(vectors / largest[:, None, None])


def sensitivity(burn: Burn, flown: Extremals) -> Array:
    """∂[r, v, p, ṗ](t_f)/∂[p₀, ṗ₀], shape (B, 12, 6), along flown extremals, to a few digits (see ITERATIONS)."""
    out = np.empty((len(flown.ends), 12, 6))
    thrust = burn.thrust_acceleration(flown.scheme.times)
    with np.errstate(all="ignore"):
        for first in range(0, len(out), BLOCK):
            part = slice(first, first + BLOCK)
            out[part] = _integrated(flown.scheme, _variational_matrices(thrust, flown.nodes[:, :, part]))
    return out


def _integrated(scheme: GaussSteps, field: Array) -> Array:
    """Ends (B, 12, 6) of the six motions δÿ = K δy that start with a unit in p₀ or ṗ₀; `field` is K, (nodes, B, 6, 6)."""
    stages, count = scheme.stages, field.shape[1]
    y, rate = np.zeros((count, 6, 6)), np.zeros((count, 6, 6))
    y[:, 3:, :3] = rate[:, 3:, 3:] = np.eye(3)
    ahead = extrapolation(scheme)
    push = np.zeros((stages, y.size))
    for step in range(scheme.steps):
        here = field[step * stages : (step + 1) * stages]
        drift = y + scheme.offsets[:, None, None, None] * rate
        nodes = drift + (ahead @ push).reshape(drift.shape)
        push = (here @ nodes).reshape(stages, -1)
        for _ in range(ITERATIONS if step else FIRST_ITERATIONS):
            nodes = drift + (scheme.double @ push).reshape(drift.shape)
            push = (here @ nodes).reshape(stages, -1)
        y = y + scheme.length * rate + (scheme.lever @ push).reshape(y.shape)
        rate = rate + (scheme.weights @ push).reshape(y.shape)
    return np.concatenate([y[:, :3], rate[:, :3], y[:, 3:], rate[:, 3:]], axis=1)


def _variational_matrices(thrust: Array, nodes: Array) -> Array:
    """K of the motion next to an extremal, δÿ = K(t) δy with y = (r, p), (nodes, B, 6, 6): [[G, k(I − p̂p̂ᵀ)/|p|], [∂(Gp)/∂r, G]].

    `nodes` (nodes, 6, B) are [r, p] of B extremals and `thrust` (nodes,) the accelerations k. G = 3rrᵀ/|r|⁵ − I/|r|³ and
    ∂(Gp)/∂r = 3(rpᵀ + prᵀ + (r·p)I)/|r|⁵ − 15(r·p)rrᵀ/|r|⁷.
    """
    r, p = nodes[:, :3].transpose(1, 0, 2), nodes[:, 3:].transpose(1, 0, 2)
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    along = (r[0] * p[0] + r[1] * p[1] + r[2] * p[2]) / square
    size = np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    kappa = 1.0 / (square * np.sqrt(square))
    steer, five = thrust[:, None] / size, 3.0 * kappa / square
    unit, scaled, leant = p / size, five * r, p - (5.0 * along) * r
    out = np.empty((6, 6, *square.shape))
    for i in range(3):
        for j in range(i, 3):
            gravity = scaled[i] * r[j]
            turn = -steer * unit[i] * unit[j]
            bend = scaled[i] * leant[j] + five * p[i] * r[j]
            if i == j:
                gravity -= kappa
                turn += steer
                bend += 3.0 * kappa * along
            out[i, j] = out[j, i] = out[3 + i, 3 + j] = out[3 + j, 3 + i] = gravity
            out[i, 3 + j] = out[j, 3 + i] = turn
            out[3 + i, j] = out[3 + j, i] = bend
    return np.ascontiguousarray(out.transpose(2, 3, 0, 1))
