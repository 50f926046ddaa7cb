"""Fly the whole programme, coast, burn, coast, burn, with the integrator that the optimiser does not use, and judge its end."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.powered_flight import commanded
from orbsoc.orbit import (
    EARTH,
    CanonicalUnits,
    angular_momentum,
    laplace_vector,
    propagate_burn,
)

from ..model.attitude_rate import peak_rate, rates
from ..model.coast import coasted_from
from ..scenario import Scenario
from ..targets.any_target import AnyTarget
from ..targets.free_target import FreeTarget
from ..verification import (
    SAMPLES,
    EndOfFlight,
    Flight,
    OrbitErrors,
    failures_of,
    orbit_of,
    per_second,
    rate_failures,
)
from .transfer import Transfer

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class CoastArc:
    """States (K, 6), SI, in the axes of plans, at times (K,) from the start of the coast."""

    times_s: Array
    states: Array

    @property
    def lowest_altitude_m(self) -> float:
        """Over the equatorial radius; between samples r·v = 0 to second order, where the two-body pull is all that bends a coast."""
        r, v = self.states[:, :3], self.states[:, 3:]
        radius = np.linalg.norm(r, axis=1)
        bend = np.maximum(np.einsum("ki,ki->k", v, v) - EARTH.mu_m3_s2 / radius, 1e-9)
        step = 0.5 * self.times_s[1]
        when = np.clip(-np.einsum("ki,ki->k", r, v) / bend, -step, step)
        when[0], when[-1] = max(when[0], 0.0), min(when[-1], 0.0)
        pull = -EARTH.mu_m3_s2 * r / radius[:, None] ** 3
        near = r + when[:, None] * v + 0.5 * when[:, None] ** 2 * pull
        return float(np.linalg.norm(near, axis=1).min()) - EARTH.earth_radius_m


@dataclass(frozen=True, slots=True, eq=False)
class TransferFlight:
    """Coasts and burns by turns, each from the end of the one before; `starts_s` (2K,) count from the scenario's state.

    A burn's `planned` is what was propagated: the optimiser flies by the same law, and only ends are compared.
    """

    coasts: tuple[CoastArc, ...]
    burns: tuple[Flight, ...]
    starts_s: tuple[float, ...]

    @property
    def end(self) -> Array:
        return np.asarray(self.burns[-1].propagated[-1])

    @property
    def slew_rad_s(self) -> float:
        """The rate of the great circle from the last direction of the first burn to the first of the second, over the coast."""
        first, last = self.burns[0].direction[-1], self.burns[1].direction[0]
        angle = float(np.arctan2(np.linalg.norm(np.cross(first, last)), first @ last))
        coast_s = float(self.coasts[1].times_s[-1])
        return angle / coast_s if coast_s > 0.0 else float("inf")

    @property
    def lowest_altitude_m(self) -> float:
        """Over the equatorial radius, of coasts and burns."""
        states = np.vstack([each.states for each in self.coasts] + [each.propagated for each in self.burns])
        return float(np.linalg.norm(states[:, :3], axis=1).min()) - EARTH.earth_radius_m


def coast_failures(scenario: Scenario, flight: TransferFlight) -> tuple[str, ...]:
    """In words, where a coast passes lower than the scenario allows."""
    lowest_km = min(each.lowest_altitude_m for each in flight.coasts if each.times_s[-1] > 0.0) / 1e3
    if lowest_km >= scenario.limits.lowest_altitude_km:
        return ()
    return (
        f"altitude of a coast is {lowest_km:.3f} km, allowed {scenario.limits.lowest_altitude_km:g} km or more",
    )


@dataclass(frozen=True, slots=True, eq=False)
class Verification(EndOfFlight):
    """What the propagation of two burns found; `slew_rad_s` is the slowest turn between the burns that joins their directions."""

    flight: TransferFlight
    slew_rad_s: float


def fly(scenario: Scenario, transfer: Transfer) -> TransferFlight:
    """The programme propagated. Raises `orbsoc.orbit.PropagationError`, and ValueError where it burns the vehicle up."""
    time_s = CanonicalUnits.of(EARTH).time_s
    thruster = scenario.vehicle.thruster()
    state = scenario.launch_inertial(scenario.initial)
    tau = np.linspace(-1.0, 1.0, SAMPLES)
    coasts, burns, starts = [], [], []
    now_s = 0.0
    for coast, duration, controls in zip(transfer.coasts, transfer.durations, transfer.controls, strict=True):
        coast_s, duration_s = float(coast) * time_s, float(duration) * time_s
        times_s = np.linspace(0.0, coast_s, SAMPLES)
        coasts.append(CoastArc(times_s, coasted_from(scenario, state, times_s, independent=True)))
        raw = transfer.grid.interpolate(controls, tau)
        size = np.linalg.norm(raw, axis=1)
        times_s = 0.5 * duration_s * (tau + 1.0)
        steering = commanded(transfer.grid, controls, duration_s)
        states = propagate_burn(coasts[-1].states[-1], thruster, steering, times_s)
        turning = per_second(rates(transfer.grid, controls, tau), duration_s)
        burns.append(Flight(times_s, raw / size[:, None], turning, size, states, states))
        starts += [now_s, now_s + coast_s]
        now_s += coast_s + duration_s
        state = states[-1]
        thruster = replace(thruster, mass_kg=thruster.mass_kg - thruster.mass_flow_kg_s * duration_s)
    return TransferFlight(tuple(coasts), tuple(burns), tuple(starts))


def verify(scenario: Scenario, target: AnyTarget, transfer: Transfer, planned_end: Array) -> Verification:
    """Fly the transfer and compare the orbit it reaches with the one it promises; `planned_end` (6,) is canonical."""
    flight = fly(scenario, transfer)
    if isinstance(target, FreeTarget):
        momentum = angular_momentum(planned_end[:3], planned_end[3:])
        laplace = laplace_vector(planned_end[:3], planned_end[3:], 1.0)
    else:
        momentum, laplace = target.momentum * target.normal, target.eccentricity * target.perigee
    errors = OrbitErrors.of(scenario, target, flight.end, momentum, laplace)
    size = np.concatenate([each.raw_norm for each in flight.burns])
    pairs = zip(transfer.controls, flight.burns, strict=True)
    peaks = [per_second(np.array(peak_rate(transfer.grid, u)), float(burn.times_s[-1])) for u, burn in pairs]
    peak_rad_s = float(max(peaks))
    excess, deficit = float(size.max()) - 1.0, float(size.min()) - 1.0
    return Verification(
        flight=flight,
        planned_orbit=orbit_of(scenario, CanonicalUnits.of(EARTH).state_to_si(planned_end)),
        propagated_orbit=errors.orbit,
        angular_momentum_rel=errors.angular_momentum_rel,
        laplace_rel=errors.laplace_rel,
        plane_rad=errors.plane_rad,
        thrust_excess=excess,
        thrust_deficit=deficit,
        peak_rate_rad_s=peak_rad_s,
        slew_rad_s=flight.slew_rad_s,
        failures=failures_of(errors.checks(scenario.verification, target, excess, flight.lowest_altitude_m))
        + rate_failures(scenario, peak_rad_s)
        + coast_failures(scenario, flight),
    )
