"""Fly the plan: propagate what the attitude programme commands, and judge the orbit it reaches.

The commanded direction is the degree N − 1 Lagrange interpolant of the controls at the Legendre–Gauss nodes,
normalised, at constant thrust. Propagating the raw interpolant instead would "verify" the over-promise of a
coarse grid, which quietly throttles above 1 between nodes.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss
from orbsoc.guidance.powered_flight import commanded
from orbsoc.orbit import (
    EARTH,
    CanonicalUnits,
    ConstantsSet,
    Elements,
    Thruster,
    angular_momentum,
    elements_from_state,
    laplace_vector,
    propagate_burn,
    rotate_state,
)
from orbsoc.orbit.array import Array

from .model.attitude_rate import peak_rate, rates
from .model.coast import at_ignition, coasted
from .model.problems import Iterate
from .scenario import Scenario
from .targets.target import Target

THRUST_EXCESS = "max‖u‖ − 1 between nodes"
SAMPLES = 401
"""Points at which the plan is sampled for checking, figures and the attitude file (at least 200)."""
COAST_STEP_S = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """A burn sampled at `times_s` (K,) from its ignition, in the axes of plans.

    `direction` (K, 3) is the commanded unit thrust, `rate_rad_s` (K,) how fast it turns, `peak_rate_rad_s` the fastest turn, by
    differences of it; `raw_norm` (K,) is the length of the interpolant before it was normalised; `planned` and `propagated`
    (K, 6) are [r_m, v_m_s] of the optimiser and of the integrator.
    """

    times_s: Array
    direction: Array
    rate_rad_s: Array
    peak_rate_rad_s: float
    raw_norm: Array
    planned: Array
    propagated: Array
    about: ConstantsSet = field(default=EARTH, kw_only=True)

    @property
    def lowest_altitude_m(self) -> float:
        """Smallest height over the equatorial radius along the propagated arc."""
        return float(np.linalg.norm(self.propagated[:, :3], axis=1).min()) - self.about.earth_radius_m


@dataclass(frozen=True, slots=True, eq=False)
class CoastArc:
    """States (K, 6), SI, in the axes of plans, at times (K,) from the start of the coast; none of a coast that takes no time."""

    times_s: Array
    states: Array
    about: ConstantsSet = field(default=EARTH, kw_only=True)

    @property
    def lowest_altitude_m(self) -> float:
        """Over the equatorial radius; between samples r·v = 0 to second order, where the two-body pull is all that bends a coast."""
        r, v = self.states[:, :3], self.states[:, 3:]
        radius = np.linalg.norm(r, axis=1)
        bend = np.maximum(np.einsum("ki,ki->k", v, v) - self.about.mu_m3_s2 / radius, 1e-9)
        step = 0.5 * self.times_s[1]
        when = np.clip(-np.einsum("ki,ki->k", r, v) / bend, -step, step)
        when[0], when[-1] = max(when[0], 0.0), min(when[-1], 0.0)
        pull = -self.about.mu_m3_s2 * r / radius[:, None] ** 3
        near = r + when[:, None] * v + 0.5 * when[:, None] ** 2 * pull
        return float(np.linalg.norm(near, axis=1).min()) - self.about.earth_radius_m


@dataclass(frozen=True, slots=True, eq=False)
class Arcs:
    """Coasts and burns by turns, each from the end of the one before; `starts_s` (2K,) count from the scenario's state."""

    coasts: tuple[CoastArc, ...]
    burns: tuple[Flight, ...]
    starts_s: tuple[float, ...]

    @classmethod
    def of_one(cls, scenario: Scenario, ignition_s: float, burn: Flight) -> Arcs:
        """The first coast and the one burn."""
        times = np.linspace(0.0, ignition_s, 2 + int(ignition_s / COAST_STEP_S))
        coast = CoastArc(np.empty(0), np.empty((0, 6)))
        if ignition_s:
            coast = CoastArc(times, coasted(scenario, times, independent=True), about=scenario.constants)
        return cls((coast,), (burn,), (0.0, ignition_s))


@dataclass(frozen=True, slots=True, eq=False)
class EndOfFlight:
    """What the propagation of one burn or two found; `failures` names every tolerance that is not met, empty when verified.

    `angular_momentum_rel` = |ΔH|/|H| and `laplace_rel` = |ΔL|/μ against the orbit that was asked for (the planned
    one where the problem leaves it open); `plane_rad` is the angle between the reached and the target plane.
    `thrust_excess` and `thrust_deficit` are max‖u‖ − 1 and min‖u‖ − 1 of the raw interpolant. `peak_rate_rad_s` is the fastest
    turn of the commanded direction over a burn.
    """

    planned_orbit: Elements
    propagated_orbit: Elements
    angular_momentum_rel: float
    laplace_rel: float
    plane_rad: float
    thrust_excess: float
    thrust_deficit: float
    peak_rate_rad_s: float
    failures: tuple[str, ...]

    @property
    def verified(self) -> bool:
        return not self.failures


@dataclass(frozen=True, slots=True, eq=False)
class Verification(EndOfFlight):
    """What the propagation of one burn found."""

    flight: Flight

    @property
    def below_ground(self) -> bool:
        """Whether the flight leads through the Earth."""
        return self.flight.lowest_altitude_m < 0.0


def flown_burn(
    start_si: Array,
    thruster: Thruster,
    grid: LegendreGauss,
    controls: Array,
    duration_s: float,
    about: ConstantsSet = EARTH,
) -> Flight:
    """Propagate nodal controls (N, 3) as they are commanded, from a state (6,), with the independent integrator.

    Raises `orbsoc.orbit.PropagationError`.
    """
    tau = np.linspace(-1.0, 1.0, SAMPLES)
    times_s = 0.5 * duration_s * (tau + 1.0)
    raw = grid.interpolate(controls, tau)
    size = np.linalg.norm(raw, axis=1)
    turns = np.append(rates(grid, controls, tau), peak_rate(grid, controls))
    turns = 2.0 * turns / duration_s if duration_s > 0.0 else np.zeros_like(turns)
    states = propagate_burn(
        start_si, thruster, commanded(grid, controls, duration_s), times_s, constants=about
    )
    return Flight(
        times_s, raw / size[:, None], turns[:-1], float(turns[-1]), size, states, states, about=about
    )


def verify(scenario: Scenario, target: Target, iterate: Iterate, *, ignition_s: float = 0.0) -> Verification:
    """Fly the coast and the burn, and compare the orbit that is reached with the one that is promised."""
    units, arc = CanonicalUnits.of(scenario.constants), iterate.trajectory
    start_si = at_ignition(scenario, ignition_s, independent=True)
    thruster = scenario.vehicle.thruster()
    flight = flown_burn(
        start_si, thruster, arc.grid, arc.controls, arc.duration * units.time_s, scenario.constants
    )
    tau = np.linspace(-1.0, 1.0, SAMPLES)
    planned = arc.grid.interpolate_from_start(units.state_from_si(start_si), arc.states, tau)
    flight = replace(flight, planned=units.state_to_si(planned))
    scales = (iterate.momentum_scale, iterate.laplace_scale)
    promised = target.promised(arc.end, scales)
    return Verification(**judged(scenario, target, arc.end, promised, [flight]), flight=flight)


def judged(
    scenario: Scenario,
    target: Target,
    planned_end: Array,
    promised: tuple[Array, Array],
    burns: list[Flight],
    lowest_altitude_m: float | None = None,
) -> dict[str, Any]:
    """The fields of `EndOfFlight` after the last burn, against a planned end (6,) and the promised H and L, canonical.

    The lowest altitude is that of the burns by default.
    """
    units, end_si = CanonicalUnits.of(scenario.constants), burns[-1].propagated[-1]
    end, size = units.state_from_si(end_si), np.concatenate([each.raw_norm for each in burns])
    h, orbit, (momentum, laplace) = angular_momentum(end[:3], end[3:]), orbit_of(scenario, end_si), promised
    found: dict[str, Any] = {
        "angular_momentum_rel": float(np.linalg.norm(h - momentum) / np.linalg.norm(momentum)),
        "laplace_rel": float(np.linalg.norm(laplace_vector(end[:3], end[3:], 1.0) - laplace)),
        "plane_rad": target.plane_error(h),
        "thrust_excess": float(size.max()) - 1.0,
        "thrust_deficit": float(size.min()) - 1.0,
        "peak_rate_rad_s": max(each.peak_rate_rad_s for each in burns),
    }
    lowest_m = (
        min(each.lowest_altitude_m for each in burns) if lowest_altitude_m is None else lowest_altitude_m
    )
    rules, bound = scenario.verification, scenario.limits.attitude_rate_deg_s
    checks = [
        ("|ΔH|/|H|", found["angular_momentum_rel"], rules.angular_momentum_rel),
        ("|ΔL|/μ", found["laplace_rel"], rules.laplace_rel),
        ("plane error in rad", found["plane_rad"], rules.plane_rad),
        (THRUST_EXCESS, found["thrust_excess"], rules.thrust_excess),
        ("depth below the ground in m", max(0.0, -lowest_m), 0.0),
        *((name, value, getattr(rules, limit)) for name, value, limit in target.errors(orbit)),
    ]
    failures = [
        f"{name} is {value:.2e}, allowed {limit:.0e}" for name, value, limit in checks if not value <= limit
    ]
    peak_deg_s = float(np.rad2deg(found["peak_rate_rad_s"]))
    if bound is not None and peak_deg_s > bound:
        failures.append(f"attitude rate is {peak_deg_s:.6g} °/s, allowed {bound:g} °/s")
    return found | {
        "planned_orbit": orbit_of(scenario, units.state_to_si(planned_end)),
        "propagated_orbit": orbit,
        "failures": tuple(failures),
    }


def orbit_of(scenario: Scenario, state_si: Array) -> Elements:
    """Osculating elements in ECI of a state in the axes of plans."""
    state = rotate_state(scenario.eci_rotation, state_si)
    return elements_from_state(state[:3], state[3:], scenario.constants)


def shape_of(orbit: Elements) -> str:
    """Perigee and apogee heights; of a hyperbola the perigee height, C3 and v∞."""
    if orbit.ecc < 1.0:
        return short_shape(orbit)
    c3 = -orbit.constants.mu_m3_s2 / orbit.sma_m
    perigee = f"{orbit.perigee_height_m() / 1e3:.2f}"
    return f"a hyperbola of C3 {c3 / 1e6:.4f} km²/s² (v∞ {np.sqrt(c3):.1f} m/s), perigee {perigee} km"


def short_shape(orbit: Elements) -> str:
    """Perigee and apogee heights; of a hyperbola C3."""
    if orbit.ecc < 1.0:
        return f"{orbit.perigee_height_m() / 1e3:.2f} × {orbit.apogee_height_m() / 1e3:.2f} km"
    return f"C3 {-orbit.constants.mu_m3_s2 / orbit.sma_m / 1e6:.4f} km²/s²"
