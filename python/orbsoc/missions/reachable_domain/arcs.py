"""Many collocated burns of one vehicle, and the end state as an affine function of their controls.

On N Legendre–Gauss nodes with differentiation matrix [d₀ D] the burn is D R + d₀r₀ = hV, D V + d₀v₀ = h(g(R) + kU),
with h = T/2, gravity g and thrust acceleration k. Velocity is eliminated, then, linearised about a reference, so are
the positions: M R = kU + q with M = (D²/h²) ⊗ I − diag(Gᵢ), Gᵢ = ∂g/∂r at node i. The end state follows from
r_f = r₀ + wᵀ(D R + d₀r₀), v_f = v₀ + hΣwᵢ(gᵢ + kᵢuᵢ): six numbers, affine in the 3N controls. The convex subproblem
needs no other unknowns. The vehicle and its mass are those of `reachable_insertion.model.Burn`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.collocation import LegendreGauss, legendre_gauss
from orbsoc.missions.reachable_insertion.model import Burn

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Arcs:
    """B burns on one grid, canonical: positions (B, N, 3), controls (B, N, 3) and end states (B, 6)."""

    positions: Array
    controls: Array
    ends: Array

    def __len__(self) -> int:
        return len(self.ends)

    def __getitem__(self, which: NDArray[np.intp] | NDArray[np.bool_] | slice) -> Arcs:
        return Arcs(self.positions[which], self.controls[which], self.ends[which])

    def put(self, which: NDArray[np.intp], other: Arcs) -> None:
        """Overwrite some burns, in place."""
        self.positions[which] = other.positions
        self.controls[which] = other.controls
        self.ends[which] = other.ends


@dataclass(frozen=True, slots=True, eq=False)
class EndMap:
    """x_f = `constant` + `by_control` · vec(U), shapes (B, 6) and (B, 6, 3N); `inverse` and `offset` find
    the positions."""

    constant: Array
    by_control: Array
    inverse: Array
    offset: Array

    def ends(self, controls: Array) -> Array:
        """End states (B, 6) of controls (B, N, 3)."""
        moved = np.einsum("bij,bj->bi", self.by_control, controls.reshape(len(controls), -1))
        return np.asarray(self.constant + moved)


@dataclass(frozen=True, slots=True, eq=False)
class Collocation:
    """The constant part of the equations: one vehicle, one start, one burn time, one grid."""

    burn: Burn
    duration: float
    grid: LegendreGauss
    thrust: Array
    second: Array
    drift: Array
    slopes: Array

    @classmethod
    def of(cls, burn: Burn, duration: float, nodes: int) -> Collocation:
        """Collocate a burn of `duration` (canonical) on `nodes` Legendre–Gauss nodes."""
        grid, half = legendre_gauss(nodes), 0.5 * duration
        first, column = grid.differentiation[:, 1:], grid.differentiation[:, 0]
        position, velocity = burn.start[:3], burn.start[3:]
        return cls(
            burn=burn,
            duration=duration,
            grid=grid,
            thrust=burn.thrust_acceleration(half * (grid.nodes + 1.0)),
            second=np.asarray(np.kron(first @ first, np.eye(3)) / half**2),
            drift=np.outer(first @ column, position) / half**2 + np.outer(column, velocity) / half,
            slopes=np.asarray(np.kron(grid.weights @ first, np.eye(3))),
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
        count, n, half = len(about), self.grid.size, 0.5 * self.duration
        gravity, gradient = gravity_gradient(about.positions)
        still = gravity - np.einsum("bnij,bnj->bni", gradient, about.positions)
        system = np.broadcast_to(self.second, (count, 3 * n, 3 * n)).copy()
        blocks = system.reshape(count, n, 3, n, 3)
        k = np.arange(n)
        blocks[:, k, :, k, :] -= gradient.transpose(1, 0, 2, 3)
        inverse: Array = np.asarray(np.linalg.inv(system), np.float64)

        weighted = half * self.grid.weights
        rows = np.empty((count, 6, n, 3))
        rows[:, :3] = self.slopes.reshape(3, n, 3)
        rows[:, 3:] = (weighted[:, None, None] * gradient).transpose(0, 2, 1, 3)
        sensitivity = rows.reshape(count, 6, 3 * n) @ inverse
        offset = (still - self.drift).reshape(count, 3 * n)
        constant = np.einsum("bij,bj->bi", sensitivity, offset)
        column = self.grid.weights @ self.grid.differentiation[:, 0]
        constant[:, :3] += (1.0 + column) * self.burn.start[:3]
        constant[:, 3:] += self.burn.start[3:] + np.einsum("n,bni->bi", weighted, still)
        by_control = sensitivity.reshape(count, 6, n, 3)
        by_control[:, 3:] += weighted[:, None] * np.eye(3)[:, None, :]
        by_control *= self.thrust[:, None]
        return EndMap(constant, by_control.reshape(count, 6, 3 * n), inverse, offset)

    def arcs(self, linear: EndMap, controls: Array) -> Arcs:
        """The linearised arcs that controls (B, N, 3) fly."""
        pushed = (self.thrust[:, None] * controls).reshape(len(controls), -1) + linear.offset
        positions = np.einsum("bij,bj->bi", linear.inverse, pushed)
        return Arcs(positions.reshape(controls.shape), controls, linear.ends(controls))

    def change(self, one: Arcs, other: Arcs) -> Array:
        """Largest change of a node's state or of the end state, (B,)."""
        moved = np.abs(one.positions - other.positions).max(axis=(1, 2))
        turned = np.abs(self.velocities(one.positions) - self.velocities(other.positions)).max(axis=(1, 2))
        ended = np.abs(one.ends - other.ends).max(axis=1)
        return np.asarray(np.maximum(np.maximum(moved, turned), ended))


def gravity_gradient(positions: Array) -> tuple[Array, Array]:
    """−r/|r|³ (…, 3) and its Jacobian 3rrᵀ/|r|⁵ − I/|r|³ (…, 3, 3), canonical."""
    square = np.einsum("...i,...i->...", positions, positions)
    cube = 1.0 / (square * np.sqrt(square))
    pull = -positions * cube[..., None]
    gradient = (-3.0 / square)[..., None, None] * (pull[..., :, None] * positions[..., None, :])
    gradient[..., np.arange(3), np.arange(3)] -= cube[..., None]
    return pull, gradient
