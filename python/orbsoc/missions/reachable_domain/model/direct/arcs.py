"""Many collocated burns of one vehicle, and the end state as an affine function of their controls.

On N Legendre–Gauss nodes with differentiation matrix [d₀ D] the burn is D R + d₀r₀ = hV, D V + d₀v₀ = h(g(R) + kU),
with h = T/2, gravity g and thrust acceleration k. Velocity is eliminated, and the straight line R₀ = r₀ + tv₀, which D²
takes to zero, is split off; then, linearised about a reference R̂, so are the positions: M(R − R₀) = kU + q with
M = (D²/h²) ⊗ I − diag(Gᵢ), q = g + G(R₀ − R̂), Gᵢ = ∂g/∂r at node i. The end state follows from
r_f = r₀ + wᵀ(D R + d₀r₀), v_f = v₀ + hΣwᵢ(gᵢ + kᵢuᵢ): six numbers, affine in the 3N controls. The convex subproblem
needs no other unknowns. The vehicle and its mass are those of `guidance.powered_flight.Burn`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss, legendre_gauss
from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array

from ..batch import Batch
from .picard import GravityGradient, blocks, solve_picard

MOST_EQUALITIES = 3
"""Equality rows of a subproblem: two of the plane, one of the perigee direction."""


@dataclass(frozen=True, slots=True, eq=False)
class Arcs(Batch):
    """B burns on one grid, canonical: positions (B, N, 3), controls (B, N, 3) and end states (B, 6).

    `multipliers` (B, 6) are those of the subproblem that a burn solves: up to three of the end's equalities, then three
    of the perigee cone, or of two perigee bounds and a number to ignore. NaN, the default, where there is no such one.
    """

    positions: Array
    controls: Array
    ends: Array
    multipliers: Array = field(default_factory=lambda: np.empty((0, 2 * MOST_EQUALITIES)))

    def __post_init__(self) -> None:
        if len(self.multipliers) != len(self.ends):
            object.__setattr__(self, "multipliers", np.full((len(self.ends), 2 * MOST_EQUALITIES), np.nan))

    def __len__(self) -> int:
        return len(self.ends)


@dataclass(frozen=True, slots=True, eq=False)
class EndMap:
    """x_f = `constant` + `by_control` · vec(U), shapes (B, 6) and (B, 6, 3N); `about` (B, N, 3) are the positions of the
    reference and `offset` (B, N, 3) the q of M(R − R₀) = kU + q."""

    constant: Array
    by_control: Array
    about: Array
    offset: Array

    def ends(self, controls: Array) -> Array:
        """End states (B, 6) of controls (B, N, 3)."""
        moved = self.by_control @ controls.reshape(len(controls), -1, 1)
        return np.asarray(self.constant + moved[:, :, 0])


@dataclass(frozen=True, slots=True, eq=False)
class Collocation:
    """The constant part of the equations: one vehicle, one start, one burn time, one grid."""

    burn: Burn
    duration: float
    grid: LegendreGauss
    thrust: Array
    double_integral: Array
    straight: Array
    slope: Array

    @classmethod
    def of(cls, burn: Burn, duration: float, nodes: int) -> Collocation:
        """Collocate a burn of `duration` (canonical) on `nodes` Legendre–Gauss nodes."""
        grid, half = legendre_gauss(nodes), 0.5 * duration
        first, times = grid.differentiation[:, 1:], half * (grid.nodes + 1.0)
        return cls(
            burn=burn,
            duration=duration,
            grid=grid,
            thrust=burn.thrust_acceleration(times),
            double_integral=np.asarray(np.linalg.inv(first @ first) * half**2),
            straight=burn.start[:3] + np.outer(times, burn.start[3:]),
            slope=np.asarray(grid.weights @ first),
        )

    @property
    def size(self) -> int:
        """Number of controls, 3N."""
        return 3 * self.grid.size

    def velocities(self, positions: Array) -> Array:
        """V = (D R + d₀r₀)/h at the nodes, (B, N, 3)."""
        first, column = self.grid.differentiation[:, 1:], self.grid.differentiation[:, 0]
        return np.asarray((first @ positions + np.outer(column, self.burn.start[:3])) / (0.5 * self.duration))

    def end_map(self, about: Arcs) -> EndMap:
        """Linearise about reference arcs."""
        count, n, weights = len(about), self.grid.size, 0.5 * self.duration * self.grid.weights
        sensitivity, offset = np.empty((count, 6, n, 3)), np.empty((count, n, 3))
        for part in blocks(count):
            positions = np.ascontiguousarray(about.positions[part].transpose(1, 2, 0))
            gravity = GravityGradient.at(positions)
            sensitivity[part] = self._adjoint(gravity).transpose(3, 2, 0, 1)
            # g + G(R₀ − R̂); for a point mass g − G R̂ is −3 R̂/|R̂|³.
            still = gravity.times(np.broadcast_to(self.straight[:, :, None], positions.shape))
            still -= 3.0 * positions * gravity.kappa[:, None]
            offset[part] = still.transpose(2, 0, 1)
        sensitivity[:, 3:] += weights[:, None] * np.eye(3)[:, None]
        start = self.burn.start
        constant = np.concatenate([start[:3] + self.duration * start[3:], start[3:]])
        constant = constant + np.einsum("binc,bnc->bi", sensitivity, offset)
        sensitivity *= self.thrust[:, None]
        return EndMap(constant, sensitivity.reshape(count, 6, 3 * n), about.positions, offset)

    def _adjoint(self, gravity: GravityGradient) -> Array:
        """How the end state's six numbers answer accelerations at the nodes, (N, 3, 6, B), but for what acts at once:
        S M = [slope ⊗ I; h w G], transposed."""
        n, count = gravity.kappa.shape
        weighted = 0.5 * self.duration * self.grid.weights[:, None, None]
        rows = np.zeros((n, 3, 6, count))
        for c in range(3):
            rows[:, c, c] = self.slope[:, None]
            rows[:, c, 3:] = (weighted * gravity.q[:, c, None]) * gravity.q
            rows[:, c, 3 + c] -= weighted[:, 0] * gravity.kappa
        return solve_picard(np.ascontiguousarray(self.double_integral.T), gravity, rows)

    def arcs(self, linear: EndMap, controls: Array) -> Arcs:
        """The linearised arcs that controls (B, N, 3) fly."""
        positions = np.empty_like(controls)
        for part in blocks(len(controls), columns=1):
            about, pushed = linear.about[part], self.thrust[:, None] * controls[part] + linear.offset[part]
            about, pushed = (np.ascontiguousarray(x.transpose(1, 2, 0)) for x in (about, pushed))
            straight = self.straight[:, :, None]
            found = solve_picard(self.double_integral, GravityGradient.at(about), pushed, about - straight)
            positions[part] = (found + straight).transpose(2, 0, 1)
        return Arcs(positions, controls, linear.ends(controls))

    def inverse(self, about: Array) -> Array:
        """M⁻¹ (B, 3N, 3N) about positions (B, N, 3)."""
        count, size = len(about), self.size
        gravity = GravityGradient.at(np.ascontiguousarray(about.transpose(1, 2, 0)))
        unit = np.eye(size).reshape(self.grid.size, 3, size, 1).repeat(count, axis=3)
        return solve_picard(self.double_integral, gravity, unit).reshape(size, size, count).transpose(2, 0, 1)

    def change(self, one: Arcs, other: Arcs) -> Array:
        """Largest change of a node's state or of the end state, (B,)."""
        moved = np.abs(one.positions - other.positions).max(axis=(1, 2))
        turned = np.abs(self.velocities(one.positions) - self.velocities(other.positions)).max(axis=(1, 2))
        ended = np.abs(one.ends - other.ends).max(axis=1)
        return np.asarray(np.maximum(np.maximum(moved, turned), ended))
