"""Osculating Keplerian elements from a state, and back. SI and radians."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from .array import Array
from .constants import EARTH, ConstantsSet
from .vectors import angular_momentum, laplace_vector, specific_energy

_CIRCULAR = 1e-11
"""Eccentricity, or sine of the inclination, below which double precision leaves the angle undefined."""


@dataclass(frozen=True, slots=True)
class Elements:
    """Osculating elements: semi-major axis (m), eccentricity, and four angles (rad, in [0, 2π) or [0, π]), about a body.

    `sma_m` is negative on a hyperbola. Where an angle is undefined it is 0 and the next one takes over its
    meaning, so that `state_from_elements` always returns the original state: on an equatorial orbit raan is 0
    and argp is counted from the x axis; on a circular one argp is 0 and the true anomaly is counted from the
    node.
    """

    sma_m: float
    ecc: float
    inc_rad: float
    raan_rad: float
    argp_rad: float
    true_anomaly_rad: float
    constants: ConstantsSet = field(default=EARTH, kw_only=True)

    @property
    def semilatus_rectum_m(self) -> float:
        return self.sma_m * (1.0 - self.ecc**2)

    @property
    def perigee_radius_m(self) -> float:
        return self.sma_m * (1.0 - self.ecc)

    @property
    def apogee_radius_m(self) -> float:
        """Infinite on a parabola or hyperbola."""
        return self.sma_m * (1.0 + self.ecc) if self.ecc < 1.0 else float("inf")

    def period_s(self) -> float:
        """Of an ellipse."""
        return float(2.0 * np.pi * np.sqrt(self.sma_m**3 / self.constants.mu_m3_s2))

    def perigee_height_m(self) -> float:
        """Height of the perigee over the equatorial radius."""
        return self.perigee_radius_m - self.constants.earth_radius_m

    def apogee_height_m(self) -> float:
        """Height of the apogee over the equatorial radius."""
        return self.apogee_radius_m - self.constants.earth_radius_m


def elements_from_state(
    position_m: ArrayLike, velocity_m_s: ArrayLike, constants: ConstantsSet = EARTH
) -> Elements:
    """Osculating elements of a state given in an inertial frame whose z axis is the pole.

    Source: the vector relations of Vallado, Fundamentals of Astrodynamics, algorithm 9; angles by atan2 of
    components in the orbital basis, so that no arccosine loses digits near 0 and π.
    Raises ValueError for a rectilinear state (r × v = 0), which has no orbital plane, and for a parabolic
    one, whose semi-major axis is infinite.
    """
    r, v = np.asarray(position_m, dtype=np.float64), np.asarray(velocity_m_s, dtype=np.float64)
    mu = constants.mu_m3_s2
    momentum = angular_momentum(r, v)
    size = float(np.linalg.norm(momentum))
    if not size > 1e-12 * float(np.linalg.norm(r) * np.linalg.norm(v)):
        raise ValueError("rectilinear motion: r × v = 0 has no orbital plane; r and v must not be parallel")
    energy = specific_energy(r, v, mu)
    if energy == 0.0:
        raise ValueError("parabolic motion: v² = 2μ/|r| has no finite semi-major axis")
    normal = momentum / size
    eccentricity_vector = laplace_vector(r, v, mu) / mu
    ecc = float(np.linalg.norm(eccentricity_vector))

    inc = float(np.arctan2(np.hypot(normal[0], normal[1]), normal[2]))
    equatorial = np.hypot(normal[0], normal[1]) < _CIRCULAR
    raan = 0.0 if equatorial else _wrap(float(np.arctan2(normal[0], -normal[1])))
    node = np.array([np.cos(raan), np.sin(raan), 0.0])
    across = np.cross(normal, node)
    latitude_argument = float(np.arctan2(r @ across, r @ node))
    argp = 0.0
    if ecc >= _CIRCULAR:
        argp = _wrap(float(np.arctan2(eccentricity_vector @ across, eccentricity_vector @ node)))
    return Elements(
        sma_m=-mu / (2.0 * energy),
        ecc=ecc,
        inc_rad=inc,
        raan_rad=raan,
        argp_rad=argp,
        true_anomaly_rad=_wrap(latitude_argument - argp),
        constants=constants,
    )


def state_from_elements(elements: Elements) -> tuple[Array, Array]:
    """Position (m) and velocity (m/s), shapes (3,), in the frame of the elements.

    Raises ValueError when a(1 − e²) ≤ 0 or when the true anomaly lies beyond the asymptote.
    """
    p = elements.semilatus_rectum_m
    if not (p > 0.0 and np.isfinite(p)):
        raise ValueError(f"a(1 − e²) = {p!r} m must be positive (a < 0 goes with e > 1)")
    cos_nu, sin_nu = np.cos(elements.true_anomaly_rad), np.sin(elements.true_anomaly_rad)
    if 1.0 + elements.ecc * cos_nu <= 0.0:
        raise ValueError(
            f"true anomaly {elements.true_anomaly_rad!r} rad is beyond the asymptote: 1 + e cos ν must be > 0"
        )
    radius = p / (1.0 + elements.ecc * cos_nu)
    speed = np.sqrt(elements.constants.mu_m3_s2 / p)
    basis = _perifocal_basis(elements)
    return (
        radius * (basis @ np.array([cos_nu, sin_nu])),
        speed * (basis @ np.array([-sin_nu, elements.ecc + cos_nu])),
    )


def at_true_anomaly(elements: Elements, true_anomaly_rad: float) -> Elements:
    """The same orbit at another true anomaly."""
    return replace(elements, true_anomaly_rad=true_anomaly_rad)


def _perifocal_basis(elements: Elements) -> Array:
    """Perigee direction and the in-plane direction 90° ahead of it, as columns, shape (3, 2)."""
    cos_o, sin_o = np.cos(elements.raan_rad), np.sin(elements.raan_rad)
    cos_i, sin_i = np.cos(elements.inc_rad), np.sin(elements.inc_rad)
    cos_w, sin_w = np.cos(elements.argp_rad), np.sin(elements.argp_rad)
    node = np.array([cos_o, sin_o, 0.0])
    across = np.array([-sin_o * cos_i, cos_o * cos_i, sin_i])
    return np.column_stack([cos_w * node + sin_w * across, -sin_w * node + cos_w * across])


def _wrap(angle: float) -> float:
    """The angle in [0, 2π)."""
    wrapped = angle % (2.0 * np.pi)
    return 0.0 if wrapped >= 2.0 * np.pi else wrapped
