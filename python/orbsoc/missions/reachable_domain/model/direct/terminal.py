"""Terminal conditions and objectives, linearised about a reference end state: rows on x_f for B points at once.

Two targets share them. `LargestOrbit`: the most energy on a given plane. `LargestTilt`: the plane tilted furthest from
the current one at a given azimuth; its optimum is the boundary of the reachable domain. Both bound the perigee radius
from below by ρ: ‖(a₁·L, a₂·L)‖ ≤ (n·H)²/ρ − 1, one three-dimensional cone, well defined on a circular orbit; the
square is linearised. With the perigee direction fixed the cone becomes a row q·L = 0 and two bounds on l·L.
Source: Li et al. 2025, eqs. 6–9, with its terminal rows replaced as docs/decisions/0015 says.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from orbsoc.orbit.array import Array, Flags, Index
from orbsoc.orbit.planes import TiltFrame, cross, in_plane_axes

Mask = Flags | Index


@dataclass(frozen=True, slots=True, eq=False)
class TerminalRows:
    """Rows on the end state x of B points: minimise cost·x s.t. equal·x = equal_rhs, bound·x ≤ bound_rhs,
    cone_rhs − cone·x ∈ Q³.

    Shapes: cost (B, 6), equal (B, p, 6), bound (B, l, 6), cone (B, 3, 6) or (B, 0, 6), right-hand sides without the 6.
    """

    cost: Array
    equal: Array
    equal_rhs: Array
    bound: Array
    bound_rhs: Array
    cone: Array
    cone_rhs: Array


class Target(Protocol):
    """The targets of B points; `rows` linearises them about end states (B, 6)."""

    def __len__(self) -> int: ...

    def __getitem__(self, which: Mask) -> Target: ...

    @property
    def perigee(self) -> Array: ...

    def rows(self, ends: Array) -> TerminalRows: ...


@dataclass(frozen=True, slots=True, eq=False)
class LargestOrbit:
    """Most energy on the planes of `normal` (B, 3) with perigee radius ≥ `perigee` (B,), canonical.

    `perigee_direction` (B, 3), unit and in the plane, fixes where the perigee lies; None leaves it free. With `perigee_at_bound`
    the perigee is at its radius, not above it; with a direction given as well, that is left to Newton (`continuation.perigee_at_bound`).
    """

    normal: Array
    perigee: Array
    perigee_direction: Array | None = None
    perigee_at_bound: bool = False

    def __len__(self) -> int:
        return len(self.normal)

    def __getitem__(self, which: Mask) -> LargestOrbit:
        fixed = self.perigee_direction
        direction = None if fixed is None else fixed[which]
        return LargestOrbit(self.normal[which], self.perigee[which], direction, self.perigee_at_bound)

    def moved(self, normal: Array, perigee: Array) -> LargestOrbit:
        """The same on planes of other unit normals (B, 3), with other perigee radii (B,)."""
        fixed = self.perigee_direction
        if fixed is not None:
            fixed = fixed - (fixed * normal).sum(axis=1, keepdims=True) * normal
            fixed = fixed / np.linalg.norm(fixed, axis=1, keepdims=True)
        return LargestOrbit(normal, perigee, fixed, self.perigee_at_bound)

    def rows(self, ends: Array) -> TerminalRows:
        linear = linear_vectors(ends)
        first, second = in_plane_axes(self.normal)
        axes = np.stack([first, second], axis=1)
        equal, equal_rhs = axes @ linear.momentum_slope, -_apply(axes, linear.momentum)
        r, v = ends[:, :3], ends[:, 3:]
        cost = -np.hstack([r / np.linalg.norm(r, axis=1, keepdims=True) ** 3, v])
        if self.perigee_direction is None:
            cone, cone_rhs = _perigee_cone(linear, self.normal, axes, self.perigee)
            if self.perigee_at_bound:
                touching, touching_rhs = _touching(linear, axes, cone, cone_rhs)
                equal = np.concatenate([equal, touching], axis=1)
                equal_rhs = np.concatenate([equal_rhs, touching_rhs], axis=1)
                return TerminalRows(cost, equal, equal_rhs, *_none(len(ends)), *_none(len(ends)))
            return TerminalRows(cost, equal, equal_rhs, *_none(len(ends)), cone, cone_rhs)
        ahead = cross(self.normal, self.perigee_direction)
        straight = np.stack([ahead, self.perigee_direction], axis=1)
        cone, cone_rhs = _perigee_cone(linear, self.normal, straight, self.perigee)
        # q·L = 0, l·L ≥ 0 and l·L ≤ (n·H)²/ρ − 1: rows 1 and 2 of the cone are −q·L and −l·L.
        return TerminalRows(
            cost,
            np.concatenate([equal, -cone[:, 1:2]], axis=1),
            np.concatenate([equal_rhs, -cone_rhs[:, 1:2]], axis=1),
            np.stack([cone[:, 2], cone[:, 0] - cone[:, 2]], axis=1),
            np.stack([cone_rhs[:, 2], cone_rhs[:, 0] - cone_rhs[:, 2]], axis=1),
            *_none(len(ends)),
        )


@dataclass(frozen=True, slots=True, eq=False)
class LargestTilt:
    """The largest tilt of the orbital plane at azimuths (B,) about `frame`, with perigee radius ≥ `perigee` (B,).

    With t the direction of the azimuth and s = n₀ × t, planes at this azimuth have s·H = 0, and the tilt is
    atan2(t·H, n₀·H): its derivative about tilt δ is (t cos δ − n₀ sin δ)·H, which is the objective.
    """

    frame: TiltFrame
    azimuth: Array
    perigee: Array

    def __len__(self) -> int:
        return len(self.azimuth)

    def __getitem__(self, which: Mask) -> LargestTilt:
        return LargestTilt(self.frame, self.azimuth[which], self.perigee[which])

    def tilts(self, ends: Array) -> Array:
        """Tilt (B,) of the planes of end states, projected on the azimuth."""
        momentum = cross(ends[:, :3], ends[:, 3:])
        towards = self.frame.directions(self.azimuth)
        return np.asarray(np.arctan2((momentum * towards).sum(axis=1), momentum @ self.frame.normal))

    def rows(self, ends: Array) -> TerminalRows:
        linear = linear_vectors(ends)
        towards = self.frame.directions(self.azimuth)
        hinge = cross(self.frame.normal, towards)
        tilt = self.tilts(ends)
        normal = self.frame.tilted(tilt, self.azimuth)
        uphill = cross(hinge, normal)  # ∂n/∂δ
        axes = np.stack([hinge, uphill], axis=1)
        momentum = cross(ends[:, :3], ends[:, 3:])
        size = (momentum * normal).sum(axis=1)[:, None, None]
        cost = -(uphill[:, None] @ linear.momentum_slope / size)[:, 0]
        equal, equal_rhs = hinge[:, None] @ linear.momentum_slope, -_apply(hinge[:, None], linear.momentum)
        cone, cone_rhs = _perigee_cone(linear, normal, axes, self.perigee)
        return TerminalRows(cost, equal, equal_rhs, *_none(len(ends)), cone, cone_rhs)


@dataclass(frozen=True, slots=True, eq=False)
class LinearVectors:
    """H ≈ momentum + momentum_slope · x and L likewise, μ = 1: shapes (B, 3) and (B, 3, 6); Ĥ and L̂ at the reference."""

    momentum: Array
    momentum_slope: Array
    laplace: Array
    laplace_slope: Array
    exact_momentum: Array
    exact_laplace: Array


def linear_vectors(ends: Array) -> LinearVectors:
    """H = r × v and L = v × H − r/|r| to first order about end states (B, 6); see `orbsoc.orbit.vectors`."""
    r, v = ends[:, :3], ends[:, 3:]
    count = len(ends)
    norm = np.linalg.norm(r, axis=1)
    vv, rv = (v * v).sum(axis=1), (r * v).sum(axis=1)
    h = cross(r, v)
    by_h = np.concatenate([-_cross_matrices(v), _cross_matrices(r)], axis=2)
    laplace = vv[:, None] * r - rv[:, None] * v - r / norm[:, None]
    by_l = np.empty((count, 3, 6))
    by_l[:, :, :3] = (r / norm[:, None] ** 3)[:, :, None] * r[:, None, :] - v[:, :, None] * v[:, None, :]
    by_l[:, :, 3:] = 2.0 * r[:, :, None] * v[:, None, :] - v[:, :, None] * r[:, None, :]
    k = np.arange(3)
    by_l[:, k, k] += (vv - 1.0 / norm)[:, None]
    by_l[:, k, k + 3] -= rv[:, None]
    return LinearVectors(h - _apply(by_h, ends), by_h, laplace - _apply(by_l, ends), by_l, h, laplace)


def _perigee_cone(linear: LinearVectors, normal: Array, axes: Array, perigee: Array) -> tuple[Array, Array]:
    """Rows and right-hand side of ((n·H)²/ρ − 1, a₁·L, a₂·L) ∈ Q³, with axes (B, 2, 3); linear about the reference.

    With n·H ≈ m + g·x and m̂ its value at the reference, (n·H)² ≈ 2m̂(m + g·x) − m̂².
    """
    slope = (normal[:, None] @ linear.momentum_slope)[:, 0]
    value = (normal * linear.momentum).sum(axis=1)
    at = (normal * linear.exact_momentum).sum(axis=1)
    rows = np.concatenate(
        [-(2.0 * at / perigee)[:, None, None] * slope[:, None], -(axes @ linear.laplace_slope)], axis=1
    )
    head = (2.0 * at * value - at**2) / perigee - 1.0
    return rows, np.concatenate([head[:, None], _apply(axes, linear.laplace)], axis=1)


def _touching(linear: LinearVectors, axes: Array, cone: Array, cone_rhs: Array) -> tuple[Array, Array]:
    """The cone's slack on its surface, (n·H)²/ρ − 1 = |L|: |L| to first order is l·L with l along the reference's L."""
    along = _apply(axes, linear.exact_laplace)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    by = np.concatenate([np.ones((len(along), 1)), -along], axis=1)
    return by[:, None] @ cone, (by * cone_rhs).sum(axis=1, keepdims=True)


def _apply(matrices: Array, vectors: Array) -> Array:
    """(B, m, k) · (B, k) → (B, m)."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])


def _none(count: int) -> tuple[Array, Array]:
    """No rows."""
    return np.empty((count, 0, 6)), np.empty((count, 0))


def _cross_matrices(vectors: Array) -> Array:
    """[a]ₓ of vectors (B, 3), (B, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
