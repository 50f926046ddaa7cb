"""Flight of a burn as it is, with an integrator that no plan uses: point mass, oblateness, air, thrust that may be off.

Runge and Kutta's method of order 4 on plain numbers, in steps of `STEP_S` at most: within 1e-7 m of DOP853
over the burn of rec1, and 1 cm over two minutes in which the thrust swings as no plan's does.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, exp, sqrt

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss
from orbsoc.orbit import ConstantsSet
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations.atmosphere import LAYERS
from orbsoc.orbit.perturbations.forces import EARTH_RATE_RAD_S, FLATTENING

from ..targets.target_orbit import TargetOrbit

STEP_S = 1.0
Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Burn:
    """An attitude programme by nodal thrusts (N, 3), from `start_s` on, planned for an engine of a thrust."""

    start_s: float
    duration_s: float
    grid: LegendreGauss
    controls: Array
    thrust_n: float
    goal: str = "target"
    """What it ends on: the scenario's target, or what was chosen instead."""
    target: TargetOrbit | None = None
    """The orbit that was chosen instead, where it is one that can be planned to again."""

    @property
    def end_s(self) -> float:
        return self.start_s + self.duration_s

    def vectors(self, times_s: Array) -> Array:
        """The interpolant (K, 3) at times from the scenario's state; before and after the burn that of its ends."""
        tau = 2.0 * (times_s - self.start_s) / max(self.duration_s, 1e-9) - 1.0
        return self.grid.interpolate(self.controls, np.clip(tau, -1.0, 1.0))


@dataclass(frozen=True, slots=True)
class Field:
    """What pulls: μ, J2 about a pole (a unit vector in the axes of plans), and air where `drag_area_m2` is not 0."""

    mu_m3_s2: float
    radius_m: float
    j2: float
    pole: Vector
    drag_area_m2: float = 0.0

    @classmethod
    def of(cls, constants: ConstantsSet, pole: Array, drag_area_m2: float) -> Field:
        """As it is."""
        x, y, z = (float(each) for each in pole)
        return cls(constants.mu_m3_s2, constants.earth_radius_m, constants.j2, (x, y, z), drag_area_m2)

    @classmethod
    def as_planned(cls, constants: ConstantsSet) -> Field:
        """The point mass that plans know."""
        return cls(constants.mu_m3_s2, constants.earth_radius_m, 0.0, (0.0, 0.0, 1.0))

    def drag(self, state: Sequence[float], mass_kg: float) -> Vector:
        """−½ ρ C_D·A/m |u| u with u the velocity through air that turns with the body."""
        x, y, z, vx, vy, vz = state
        px, py, pz = self.pole
        rate = EARTH_RATE_RAD_S
        ux, uy, uz = (
            vx - rate * (py * z - pz * y),
            vy - rate * (pz * x - px * z),
            vz - rate * (px * y - py * x),
        )
        radius = sqrt(x * x + y * y + z * z)
        sine = (x * px + y * py + z * pz) / radius
        height_km = 1e-3 * (radius - self.radius_m * (1.0 - FLATTENING * sine * sine))
        base, density, scale = _LAYERS[max(bisect_right(_BASES, height_km) - 1, 0)]
        size = density * exp((base - height_km) / scale) * sqrt(ux * ux + uy * uy + uz * uz)
        factor = -0.5 * size * self.drag_area_m2 / mass_kg
        return factor * ux, factor * uy, factor * uz


_LAYERS: list[list[float]] = LAYERS.tolist()
_BASES = [each[0] for each in _LAYERS]


@dataclass(frozen=True, slots=True)
class Engine:
    """Thrust and flow as they are."""

    thrust_n: float
    flow_kg_s: float


def flown(
    state: Sequence[float],
    mass_kg: float,
    times_s: Sequence[float],
    directions: Sequence[Sequence[float]],
    engine: Engine,
    field: Field,
) -> list[tuple[float, ...]]:
    """States [r_m, v_m_s] at K + 1 increasing times, one step from each to the next, from the first.

    `directions` are 2K + 1 vectors of thrust, at the times and in the middle of each step; their length does not matter.
    """
    mu, radius2 = field.mu_m3_s2, field.radius_m**2
    oblate, (px, py, pz) = 1.5 * field.mu_m3_s2 * field.j2 * radius2, field.pole
    air = field.drag_area_m2 != 0.0
    thrust, flow = engine.thrust_n, engine.flow_kg_s

    def pull(s: Sequence[float], size: float, u: Sequence[float], mass: float) -> Vector:
        x, y, z = s[0], s[1], s[2]
        r2 = x * x + y * y + z * z
        r = sqrt(r2)
        down = -mu / (r2 * r)
        ax, ay, az = size * u[0] + down * x, size * u[1] + down * y, size * u[2] + down * z
        if oblate:
            along = x * px + y * py + z * pz
            k = oblate / (r2 * r2 * r)
            out, down = k * (5.0 * along * along / r2 - 1.0), 2.0 * k * along
            ax, ay, az = ax + out * x - down * px, ay + out * y - down * py, az + out * z - down * pz
        if air:
            dx, dy, dz = field.drag(s, mass)
            ax, ay, az = ax + dx, ay + dy, az + dz
        return ax, ay, az

    states = [tuple(state)]
    x, y, z, vx, vy, vz = state
    begun = times_s[0]
    sizes = [1.0 / sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]) for u in directions]
    for k in range(len(times_s) - 1):
        h = times_s[k + 1] - times_s[k]
        half = 0.5 * h
        m0 = mass_kg - flow * (times_s[k] - begun)
        m1, m2 = m0 - flow * half, m0 - flow * h
        u0, u1, u2 = directions[2 * k], directions[2 * k + 1], directions[2 * k + 2]
        k0, k1, k2 = (
            thrust / m0 * sizes[2 * k],
            thrust / m1 * sizes[2 * k + 1],
            thrust / m2 * sizes[2 * k + 2],
        )
        ax, ay, az = pull((x, y, z, vx, vy, vz), k0, u0, m0)
        bvx, bvy, bvz = vx + half * ax, vy + half * ay, vz + half * az
        bx, by, bz = pull((x + half * vx, y + half * vy, z + half * vz, bvx, bvy, bvz), k1, u1, m1)
        cvx, cvy, cvz = vx + half * bx, vy + half * by, vz + half * bz
        cx, cy, cz = pull((x + half * bvx, y + half * bvy, z + half * bvz, cvx, cvy, cvz), k1, u1, m1)
        dvx, dvy, dvz = vx + h * cx, vy + h * cy, vz + h * cz
        dx, dy, dz = pull((x + h * cvx, y + h * cvy, z + h * cvz, dvx, dvy, dvz), k2, u2, m2)
        sixth = h / 6.0
        x += sixth * (vx + 2.0 * (bvx + cvx) + dvx)
        y += sixth * (vy + 2.0 * (bvy + cvy) + dvy)
        z += sixth * (vz + 2.0 * (bvz + cvz) + dvz)
        vx += sixth * (ax + 2.0 * (bx + cx) + dx)
        vy += sixth * (ay + 2.0 * (by + cy) + dy)
        vz += sixth * (az + 2.0 * (bz + cz) + dz)
        states.append((x, y, z, vx, vy, vz))
    return states


def steps_to(start_s: float, end_s: float, longest_s: float = STEP_S) -> tuple[list[float], Array]:
    """Times of equal steps, and those with the middles of the steps between."""
    count = max(1, ceil((end_s - start_s) / longest_s - 1e-9))
    all_times = np.linspace(start_s, end_s, 2 * count + 1)
    return all_times[::2].tolist(), all_times
