"""Fly the plan: propagate what the attitude programme commands, and judge the orbit it reaches.

The commanded direction is the degree N − 1 Lagrange interpolant of the controls at the Legendre–Gauss nodes,
normalised, at constant thrust. Propagating the raw interpolant instead would "verify" the over-promise of a
coarse grid, which quietly throttles above 1 between nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.powered_flight import Trajectory, commanded
from orbsoc.orbit import (
    EARTH,
    CanonicalUnits,
    Elements,
    angular_momentum,
    elements_from_state,
    laplace_vector,
    propagate_burn,
    rotate_state,
)

from .model.attitude_rate import peak_rate, rates
from .model.coast import at_ignition
from .model.problems import Iterate
from .scenario import Scenario
from .scenario import Verification as VerificationRules
from .targets.any_target import AnyTarget
from .targets.free_target import FreeTarget

Array = NDArray[np.float64]

SAMPLES = 401
"""Points at which the plan is sampled for checking, figures and the attitude file (at least 200)."""


@dataclass(frozen=True, slots=True, eq=False)
class Flight:
    """The plan sampled at `times_s` (K,), launch-inertial axes.

    `direction` (K, 3) is the commanded unit thrust, `rate_rad_s` (K,) how fast it turns, `raw_norm` (K,) the length of the interpolant before it was
    normalised; `planned` and `propagated` (K, 6) are [r_m, v_m_s] of collocation and of the integrator.
    """

    times_s: Array
    direction: Array
    rate_rad_s: Array
    raw_norm: Array
    planned: Array
    propagated: Array

    @property
    def lowest_altitude_m(self) -> float:
        """Smallest height over the equatorial radius along the propagated arc."""
        return float(np.linalg.norm(self.propagated[:, :3], axis=1).min()) - EARTH.earth_radius_m


@dataclass(frozen=True, slots=True, eq=False)
class EndOfFlight:
    """What the propagation of one burn or two found; `failures` names every tolerance that is not met, empty when verified.

    `angular_momentum_rel` = |ΔH|/|H| and `laplace_rel` = |ΔL|/μ against the orbit that was asked for (the planned
    one where the problem leaves it open); `plane_rad` is the angle between the reached and the target plane.
    `thrust_excess` and `thrust_deficit` are max‖u‖ − 1 and min‖u‖ − 1 of the raw interpolant. `peak_rate_rad_s` is the fastest
    turn of the commanded direction over a burn, by differences of it.
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
    """What the propagation of one burn found.

    `perigee_error_m` is reached − required perigee radius, NaN when the problem requires none.
    """

    flight: Flight
    perigee_error_m: float

    @property
    def below_ground(self) -> bool:
        """Whether the flight leads through the Earth."""
        return self.flight.lowest_altitude_m < 0.0


def fly(
    scenario: Scenario, trajectory: Trajectory, *, ignition_s: float = 0.0, samples: int = SAMPLES
) -> Flight:
    """Propagate the coast of `ignition_s` and the commanded burn with the independent integrator; `samples` uniform times
    of the burn, both ends included.

    Raises `orbsoc.orbit.PropagationError`.
    """
    units = CanonicalUnits.of(EARTH)
    duration_s = trajectory.duration * units.time_s
    tau = np.linspace(-1.0, 1.0, samples)
    times_s = 0.5 * duration_s * (tau + 1.0)
    raw = trajectory.grid.interpolate(trajectory.controls, tau)
    raw_norm = np.linalg.norm(raw, axis=1)
    start_si = at_ignition(scenario, ignition_s, independent=True)
    planned = trajectory.grid.interpolate_from_start(units.state_from_si(start_si), trajectory.states, tau)
    return Flight(
        times_s=times_s,
        direction=raw / raw_norm[:, None],
        rate_rad_s=per_second(rates(trajectory.grid, trajectory.controls, tau), duration_s),
        raw_norm=raw_norm,
        planned=units.state_to_si(planned),
        propagated=propagate_burn(
            start_si,
            scenario.vehicle.thruster(),
            commanded(trajectory.grid, trajectory.controls, duration_s),
            times_s,
        ),
    )


def verify(
    scenario: Scenario, target: AnyTarget, iterate: Iterate, *, ignition_s: float = 0.0
) -> Verification:
    """Fly the plan and compare the orbit it reaches with the one it promises."""
    units = CanonicalUnits.of(EARTH)
    trajectory = iterate.trajectory
    flight = fly(scenario, trajectory, ignition_s=ignition_s)
    momentum, laplace = _promised(scenario, target, iterate)
    errors = OrbitErrors.of(scenario, target, flight.propagated[-1], momentum, laplace)
    perigee_error = float("nan")
    if scenario.problem == "max_energy" and scenario.target.perigee_height_km is not None:
        perigee_error = errors.orbit.perigee_height_m() - 1e3 * scenario.target.perigee_height_km
    excess, deficit = float(flight.raw_norm.max()) - 1.0, float(flight.raw_norm.min()) - 1.0

    rules = scenario.verification
    checks = errors.checks(rules, target, excess, flight.lowest_altitude_m)
    if scenario.problem == "max_energy":
        free = scenario.target.perigee_direction == "free"
        shortfall = max(0.0, -perigee_error) if free else abs(perigee_error)
        checks.append(("perigee error in m", shortfall, rules.perigee_m))
    peak = peak_rate(trajectory.grid, trajectory.controls)
    peak_rad_s = float(per_second(np.array(peak), trajectory.duration * units.time_s))
    return Verification(
        flight=flight,
        planned_orbit=orbit_of(scenario, units.state_to_si(trajectory.end)),
        propagated_orbit=errors.orbit,
        angular_momentum_rel=errors.angular_momentum_rel,
        laplace_rel=errors.laplace_rel,
        plane_rad=errors.plane_rad,
        perigee_error_m=perigee_error,
        thrust_excess=excess,
        thrust_deficit=deficit,
        peak_rate_rad_s=peak_rad_s,
        failures=failures_of(checks) + rate_failures(scenario, peak_rad_s),
    )


Check = tuple[str, float, float]
"""What is checked, what it is, and what is allowed."""


@dataclass(frozen=True, slots=True)
class OrbitErrors:
    """How far a flight ends from the orbit that was promised; see `Verification`. `orbit` is the one reached, ECI."""

    orbit: Elements
    angular_momentum_rel: float
    laplace_rel: float
    plane_rad: float

    @classmethod
    def of(
        cls, scenario: Scenario, target: AnyTarget, reached_si: Array, momentum: Array, laplace: Array
    ) -> OrbitErrors:
        """Of an end state (6,), SI, against the canonical H and L that were promised."""
        reached = CanonicalUnits.of(EARTH).state_from_si(reached_si)
        h = angular_momentum(reached[:3], reached[3:])
        return cls(
            orbit_of(scenario, reached_si),
            float(np.linalg.norm(h - momentum) / np.linalg.norm(momentum)),
            float(np.linalg.norm(laplace_vector(reached[:3], reached[3:], 1.0) - laplace)),
            target.plane_error(h),
        )

    def checks(
        self, rules: VerificationRules, target: AnyTarget, thrust_excess: float, lowest_altitude_m: float
    ) -> list[Check]:
        """Everything that a flight has to keep to, beside its limit."""
        found = [
            ("|ΔH|/|H|", self.angular_momentum_rel, rules.angular_momentum_rel),
            ("|ΔL|/μ", self.laplace_rel, rules.laplace_rel),
            ("plane error in rad", self.plane_rad, rules.plane_rad),
            ("max‖u‖ − 1 between nodes", thrust_excess, rules.thrust_excess),
            ("depth below the ground in m", max(0.0, -lowest_altitude_m), 0.0),
        ]
        return found + [
            (name, value, float(getattr(rules, limit))) for name, value, limit in target.errors(self.orbit)
        ]


def failures_of(checks: list[Check]) -> tuple[str, ...]:
    """Each check that is not met, in words."""
    return tuple(
        f"{name} is {value:.2e}, allowed {limit:.0e}" for name, value, limit in checks if not value <= limit
    )


def rate_failures(scenario: Scenario, peak_rad_s: float) -> tuple[str, ...]:
    """In words, where the thrust turns faster than the scenario allows."""
    bound, peak_deg_s = scenario.limits.attitude_rate_deg_s, np.rad2deg(peak_rad_s)
    if bound is None or peak_deg_s <= bound:
        return ()
    return (f"attitude rate is {peak_deg_s:.6g} °/s, allowed {bound:g} °/s",)


def per_second(per_tau: Array, duration_s: float) -> Array:
    """Rates over τ ∈ [−1, 1] as rates over the burn; a burn of 0 s turns nothing."""
    return 2.0 * per_tau / duration_s if duration_s > 0.0 else np.zeros_like(per_tau)


def orbit_of(scenario: Scenario, state_si: Array) -> Elements:
    """Osculating elements in ECI of a launch-inertial state."""
    state = rotate_state(scenario.eci_rotation, state_si)
    return elements_from_state(state[:3], state[3:])


def shape_of(orbit: Elements) -> str:
    """Perigee and apogee heights; of a hyperbola the perigee height, C3 and v∞."""
    if orbit.ecc < 1.0:
        return short_shape(orbit)
    c3 = -EARTH.mu_m3_s2 / orbit.sma_m
    perigee = f"{orbit.perigee_height_m() / 1e3:.2f}"
    return f"a hyperbola of C3 {c3 / 1e6:.4f} km²/s² (v∞ {np.sqrt(c3):.1f} m/s), perigee {perigee} km"


def short_shape(orbit: Elements) -> str:
    """Perigee and apogee heights; of a hyperbola C3."""
    if orbit.ecc < 1.0:
        return f"{orbit.perigee_height_m() / 1e3:.2f} × {orbit.apogee_height_m() / 1e3:.2f} km"
    return f"C3 {-EARTH.mu_m3_s2 / orbit.sma_m / 1e6:.4f} km²/s²"


def _promised(scenario: Scenario, target: AnyTarget, iterate: Iterate) -> tuple[Array, Array]:
    """Canonical H and L that the burn has to end with."""
    perigee_free = scenario.problem == "max_energy" and scenario.target.perigee_direction == "free"
    if perigee_free or isinstance(target, FreeTarget):
        end = iterate.trajectory.end
        return angular_momentum(end[:3], end[3:]), laplace_vector(end[:3], end[3:], 1.0)
    return (
        iterate.momentum_scale * target.momentum * target.normal,
        iterate.laplace_scale * target.eccentricity * target.perigee,
    )
