"""Fly the whole programme, coast, burn, coast, burn, with the integrator that the optimiser does not use, and judge its end."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.orbit import CanonicalUnits
from orbsoc.orbit.array import Array

from ..model.coast import coasted_from
from ..scenario import Scenario
from ..targets.target import Target
from ..verification import SAMPLES, Arcs, CoastArc, EndOfFlight, Flight, flown_burn, judged
from .transfer import Transfer


@dataclass(frozen=True, slots=True, eq=False)
class TransferFlight(Arcs):
    """Two coasts and two burns.

    A burn's `planned` is what was propagated: the optimiser flies by the same law, and only ends are compared.
    """

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
        return float(np.linalg.norm(states[:, :3], axis=1).min()) - self.burns[0].about.earth_radius_m


@dataclass(frozen=True, slots=True, eq=False)
class Verification(EndOfFlight):
    """What the propagation of two burns found; `slew_rad_s` is the slowest turn between the burns that joins their directions."""

    flight: TransferFlight
    slew_rad_s: float


def fly(scenario: Scenario, transfer: Transfer) -> TransferFlight:
    """The programme propagated. Raises `orbsoc.orbit.PropagationError`, and ValueError where it burns the vehicle up."""
    time_s = CanonicalUnits.of(scenario.constants).time_s
    thruster = scenario.vehicle.thruster()
    state = scenario.launch_inertial(scenario.initial)
    coasts: list[CoastArc] = []
    burns: list[Flight] = []
    starts: list[float] = []
    now_s = 0.0
    for coast, duration, controls in zip(transfer.coasts, transfer.durations, transfer.controls, strict=True):
        coast_s, duration_s = float(coast) * time_s, float(duration) * time_s
        times_s = np.linspace(0.0, coast_s, SAMPLES)
        coasts.append(
            CoastArc(
                times_s, coasted_from(scenario, state, times_s, independent=True), about=scenario.constants
            )
        )
        burns.append(
            flown_burn(
                coasts[-1].states[-1], thruster, transfer.grid, controls, duration_s, scenario.constants
            )
        )
        starts += [now_s, now_s + coast_s]
        now_s += coast_s + duration_s
        state = burns[-1].propagated[-1]
        thruster = replace(thruster, mass_kg=thruster.mass_kg - thruster.mass_flow_kg_s * duration_s)
    return TransferFlight(tuple(coasts), tuple(burns), tuple(starts))


def verify(scenario: Scenario, target: Target, transfer: Transfer, planned_end: Array) -> Verification:
    """Fly the transfer and compare the orbit it reaches with the one it promises; `planned_end` (6,) is canonical."""
    flight = fly(scenario, transfer)
    promised = target.promised(planned_end)
    found = judged(scenario, target, planned_end, promised, list(flight.burns), flight.lowest_altitude_m)
    lowest_km = min(each.lowest_altitude_m for each in flight.coasts if each.times_s[-1] > 0.0) / 1e3
    allowed_km = scenario.limits.lowest_altitude_km
    if lowest_km < allowed_km:
        words = f"altitude of a coast is {lowest_km:.3f} km, allowed {allowed_km:g} km or more"
        found["failures"] = (*found["failures"], words)
    return Verification(**found, flight=flight, slew_rad_s=flight.slew_rad_s)
