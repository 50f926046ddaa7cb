"""A target orbit of which only some elements are given: a terminal row for each of these, and none for the rest.

Rows are functions f(r, v) = 0 of the end state, written in analytic operations, so that a complex step of 1e-30 gives their
Jacobian to rounding (Squire & Trapp 1998). With N = ẑ × H/|ẑ × H| the ascending node, A = Ĥ × N and p = cos ω N + sin ω A:

| given | row |
|---|---|
| inclination and node | two leans of Ĥ |
| inclination | sin(i(H) − i) |
| argument of perigee | L·(Ĥ × p), and L·p in place of the length of L below |
| both of the shape | H/h − 1 and L − e; on a circular orbit H/h − 1, H²/r − 1 and H (r·v)/r |
| energy; eccentricity | v²/2 − 1/r − ε; L − e |
| perigee; apogee | H²/r_p − (1 + L); H²/r_a − (1 − L) |
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit import EARTH, CanonicalUnits, ConstantsSet, Elements, angular_momentum, laplace_vector
from orbsoc.orbit.array import Array

from .rows import PLANE_ROWS, Row
from .table import TargetTable
from .target_orbit import CIRCULAR

STEP = 1e-30
NEWTON = 12
"""Steps to the nearest velocity that meets the rows at a position."""
POLAR = 1e-9
"""Sine of the inclination below which an orbit has no node."""


@dataclass(frozen=True, slots=True, eq=False)
class FreeTarget:
    """What is given of an orbit, canonical and in rad; None is free. `to_eci` (3, 3) turns the axes of plans to ECI.

    `momentum` is known where two numbers of the shape are; then `energy` and `eccentricity` are, too.
    """

    to_eci: Array
    momentum: float | None = None
    energy: float | None = None
    eccentricity: float | None = None
    perigee_radius: float | None = None
    apogee_radius: float | None = None
    inc: float | None = None
    raan: float | None = None
    argp: float | None = None
    constants: ConstantsSet = field(default=EARTH, kw_only=True)

    @classmethod
    def of(cls, target: TargetTable, to_eci: Array, constants: ConstantsSet = EARTH) -> FreeTarget:
        """What the table gives."""
        length = constants.earth_radius_m
        angles: dict[str, Any] = {
            name: None if value is None else float(np.deg2rad(value))
            for name, value in (("inc", target.inc_deg), ("raan", target.raan_deg), ("argp", target.argp_deg))
        }
        if "shape" not in target.free:
            sma, ecc = target.shape()
            sma /= length
            return cls(
                to_eci, float(np.sqrt(sma * (1.0 - ecc**2))), -0.5 / sma, ecc, **angles, constants=constants
            )
        sma_m = target.semi_major_axis_m()
        heights: dict[str, Any] = {
            name: None if height is None else 1.0 + 1e3 * height / length
            for name, height in (
                ("perigee_radius", target.perigee_height_km),
                ("apogee_radius", target.apogee_height_km),
            )
        }
        energy = None if sma_m is None else -0.5 * length / sma_m
        return cls(to_eci, energy=energy, eccentricity=target.ecc, **heights, **angles, constants=constants)

    @property
    def normal(self) -> Array | None:
        """Unit normal in ECI (3,) of a plane that is given whole."""
        if self.inc is None:
            return None
        if np.sin(self.inc) < POLAR:
            return np.array([0.0, 0.0, np.cos(self.inc)])
        if self.raan is None:
            return None
        sine = np.sin(self.inc)
        return np.array([sine * np.sin(self.raan), -sine * np.cos(self.raan), np.cos(self.inc)])

    @property
    def rows(self) -> tuple[Row, ...]:
        return tuple(row for row, _ in self._evaluated(np.array([[1.0, 0.1, 0.2, 0.1, 0.9, 0.3]])))

    def conditions(self, ends: NDArray[np.inexact]) -> Array:
        return np.asarray(np.column_stack([value for _, value in self._evaluated(np.asarray(ends))]))

    def linear_rows(self, end: Array) -> tuple[Array, Array]:
        block = self.jacobians(end[None])[0]
        return block, block @ end - self.conditions(end[None])[0]

    def jacobians(self, ends: Array) -> Array:
        """(B, K, 6) of states (B, 6)."""
        moved = (ends[:, None, :] + 1j * STEP * np.eye(6)).reshape(-1, 6)
        found = np.imag(self.conditions(moved)) / STEP
        return np.asarray(found.reshape(len(ends), 6, -1).swapaxes(1, 2))

    def misses(self, end: Array) -> tuple[tuple[Row, float], ...]:
        return tuple(zip(self.rows, self.conditions(end[None])[0].tolist(), strict=True))

    def words(self, row: Row, value: float, _end: Array, _scales: tuple[float, float] = (1.0, 1.0)) -> str:
        if row is Row.INCLINATION:
            return f"the inclination too {'low' if value < 0 else 'high'} by {abs(np.rad2deg(value)):.4f}°"
        if row in PLANE_ROWS:
            return f"the orbit plane tilted by {abs(np.rad2deg(value)):.4f}°"
        if row is Row.ENERGY:
            km2_s2 = abs(value) * CanonicalUnits.of(self.constants).speed_m_s ** 2 / 1e6
            return f"v²/2 − μ/r too {'small' if value < 0 else 'large'} by {km2_s2:.4f} km²/s²"
        if row is Row.PERIGEE_DIRECTION:
            return f"the eccentricity vector off the perigee direction by {abs(value):.2e}"
        return f"the {row.value} off by {abs(value):.2e} of itself"

    def promised(self, end: Array, _scales: tuple[float, float] = (1.0, 1.0)) -> tuple[Array, Array]:
        return angular_momentum(end[:3], end[3:]), laplace_vector(end[:3], end[3:], 1.0)

    def impulse(self, state: Array) -> Array:
        return np.asarray(self.there(state[None])[1][0] - state[3:])

    def there(self, states: Array) -> tuple[Array, Array]:
        """Positions and velocities (K, 3) nearest to states (K, 6); a position that no velocity saves is moved by what is missed."""
        position, start = states[:, :3], states[:, 3:]
        now = states.copy()
        for _ in range(NEWTON):
            rows, jacobians = self.conditions(now), self.jacobians(now)[:, :, 3:]
            step = -np.einsum("bij,bj->bi", np.linalg.pinv(jacobians, rcond=1e-6), rows)
            size = np.linalg.norm(step, axis=1, keepdims=True)
            now[:, 3:] += step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-12))
        left = np.linalg.norm(self.conditions(now), axis=1, keepdims=True)
        wild = ~np.isfinite(now).all(axis=1)
        now[wild, 3:] = start[wild]
        outwards = position / np.linalg.norm(position, axis=1, keepdims=True)
        return position + np.nan_to_num(left, nan=1.0) * outwards, now[:, 3:]

    def plane_error(self, momentum: Array) -> float:
        if self.inc is None:
            return 0.0
        h = self.to_eci @ momentum
        normal = self.normal
        if normal is not None:
            return float(np.arctan2(np.linalg.norm(np.cross(h, normal)), h @ normal))
        return abs(float(np.arctan2(np.hypot(h[0], h[1]), h[2])) - self.inc)

    def momentum_gap(self, momentum: Array) -> float:
        h = self.to_eci @ momentum
        size = self.momentum
        if self.inc is None:
            return 0.0 if size is None else abs(float(np.linalg.norm(h)) - size)
        normal = self.normal
        if normal is None:  # the node is free: turned about the pole until it fits
            normal, h = (
                np.array([np.sin(self.inc), 0.0, np.cos(self.inc)]),
                np.array([np.hypot(h[0], h[1]), 0.0, h[2]]),
            )
        along = max(0.0, float(h @ normal)) if size is None else size
        return float(np.linalg.norm(along * normal - h))

    def errors(self, orbit: Elements) -> list[tuple[str, float, str]]:
        length = self.constants.earth_radius_m
        found: list[tuple[str, float, str]] = []
        if self.energy is not None:
            energy = -0.5 * length / orbit.sma_m
            found.append(("energy error, canonical,", abs(energy - self.energy), "angular_momentum_rel"))
        if self.eccentricity is not None:
            found.append(("eccentricity error", abs(orbit.ecc - self.eccentricity), "laplace_rel"))
        for name, radius, given in (
            ("perigee radius error, relative,", orbit.perigee_radius_m, self.perigee_radius),
            ("apogee radius error, relative,", orbit.apogee_radius_m, self.apogee_radius),
        ):
            if given is not None:
                found.append((name, abs(radius / length / given - 1.0), "angular_momentum_rel"))
        if self.argp is not None and (self.eccentricity is None or self.eccentricity >= CIRCULAR):
            turned = abs((orbit.argp_rad - self.argp + np.pi) % (2.0 * np.pi) - np.pi)
            found.append(
                ("perigee direction error in rad, by the eccentricity,", orbit.ecc * turned, "plane_rad")
            )
        return found

    def _evaluated(self, ends: NDArray[np.inexact]) -> list[tuple[Row, NDArray[np.inexact]]]:
        r, v = ends[:, :3] @ self.to_eci.T, ends[:, 3:] @ self.to_eci.T
        h = np.cross(r, v)
        radius, size = _length(r), _length(h)
        laplace = np.cross(v, h) - r / radius[:, None]
        rows: list[tuple[Row, NDArray[np.inexact]]] = []
        normal = self.normal
        along = size
        if normal is not None:
            first = np.array([np.cos(self.raan or 0.0), np.sin(self.raan or 0.0), 0.0])
            rows += [
                (Row.LEAN_TO_PERIGEE, h @ first / size),
                (Row.LEAN_ACROSS, h @ np.cross(normal, first) / size),
            ]
            along = h @ normal
        elif self.inc is not None:
            flat = _length(h[:, :2])
            rows.append((Row.INCLINATION, (flat * np.cos(self.inc) - h[:, 2] * np.sin(self.inc)) / size))
        eccentricity = _length(laplace)
        if self.argp is not None and (self.eccentricity is None or self.eccentricity >= CIRCULAR):
            ahead, eccentricity = self._about_perigee(h, size, laplace)
            rows.append((Row.PERIGEE_DIRECTION, ahead))
        return rows + self._shape_rows(ends, along, radius, eccentricity)

    def _about_perigee(
        self, h: NDArray[np.inexact], size: NDArray[np.inexact], laplace: NDArray[np.inexact]
    ) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
        """L ahead of the perigee direction that is given, and along it."""
        assert self.argp is not None
        if self.raan is None:
            flat = _length(h[:, :2])
            node = np.column_stack([-h[:, 1] / flat, h[:, 0] / flat, np.zeros_like(flat)])
        else:
            node = np.tile([np.cos(self.raan), np.sin(self.raan), 0.0], (len(h), 1))
        along_node = _dot(laplace, node)
        across = _dot(laplace, np.cross(h / size[:, None], node))
        cosine, sine = np.cos(self.argp), np.sin(self.argp)
        return cosine * across - sine * along_node, cosine * along_node + sine * across

    def _shape_rows(
        self,
        ends: NDArray[np.inexact],
        along: NDArray[np.inexact],
        radius: NDArray[np.inexact],
        eccentricity: NDArray[np.inexact],
    ) -> list[tuple[Row, NDArray[np.inexact]]]:
        rows: list[tuple[Row, NDArray[np.inexact]]] = []
        r, v = ends[:, :3], ends[:, 3:]
        if self.momentum is not None:
            rows.append((Row.MOMENTUM, along / self.momentum - 1.0))
        if self.eccentricity is not None and self.eccentricity < CIRCULAR:
            rows += [
                (Row.ECCENTRICITY, along**2 / radius - 1.0),
                (Row.RADIAL_VELOCITY, along * _dot(r, v) / radius),
            ]
        elif self.eccentricity is not None:
            rows.append((Row.ECCENTRICITY, eccentricity - self.eccentricity))
        elif self.energy is not None:
            rows.append((Row.ENERGY, 0.5 * _dot(v, v) - 1.0 / radius - self.energy))
        elif self.perigee_radius is not None:
            rows.append((Row.PERIGEE_RADIUS, along**2 / self.perigee_radius - 1.0 - eccentricity))
        elif self.apogee_radius is not None:
            rows.append((Row.APOGEE_RADIUS, along**2 / self.apogee_radius - 1.0 + eccentricity))
        return rows


def _dot(a: NDArray[np.inexact], b: NDArray[np.inexact]) -> NDArray[np.inexact]:
    return np.asarray((a * b).sum(axis=1))


def _length(a: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """Without absolute values, which are not analytic; 1e-12 of a zero vector, whose slope is then 0."""
    return np.asarray(np.sqrt(_dot(a, a) + 1e-24))
