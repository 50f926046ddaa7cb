"""A flown insertion as CCSDS messages: an ephemeris of coasts and burns, and its first state with the burns as manoeuvres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from orbsoc.guidance.ccsds import FRAME, InertialManoeuvre, Subject, oem, opm
from orbsoc.orbit import rotate_state

from ..model.coast import coasted
from ..scenario import Scenario
from ..verification import Flight

Array = NDArray[np.float64]
COAST_STEP_S = 60.0


class FlownBurn(NamedTuple):
    """When it begins, counted from the scenario's state, and its flight."""

    ignition_s: float
    flight: Flight


class FlownArc(NamedTuple):
    """A coast: times (K,) from the scenario's state, and states (K, 6) in the axes of plans."""

    times_s: Array
    states: Array


def first_coast(scenario: Scenario, ignition_s: float) -> FlownArc:
    """From the scenario's state to the first ignition."""
    times = np.linspace(0.0, ignition_s, 2 + int(ignition_s / COAST_STEP_S))
    return (
        FlownArc(times, coasted(scenario, times, independent=True))
        if ignition_s
        else FlownArc(np.empty(0), np.empty((0, 6)))
    )


def messages(scenario: Scenario, coasts: Sequence[FlownArc], burns: Sequence[FlownBurn]) -> dict[str, str]:
    """`orbit.oem` and `orbit.opm`, in the frame of `[initial]`, or in the scenario's ECI where it names none."""
    initial = scenario.initial
    subject = Subject(
        scenario.name,
        "the direction from which the scenario counts nodes",
        "the scenario's state",
        **({} if initial.epoch is None else {"epoch": initial.epoch}),
        frame=initial.axes_name or FRAME,
        center=scenario.constants.center,
    )
    to_eci = scenario.eci_rotation
    arcs = [
        *coasts,
        *(FlownArc(each.ignition_s + each.flight.times_s, each.flight.propagated) for each in burns),
    ]
    times = np.concatenate([each.times_s for each in arcs])
    states = np.concatenate([each.states for each in arcs])
    # microseconds, as the messages have them: an instant that two arcs share is told once
    _, once = np.unique(np.round(times, 6), return_index=True)
    manoeuvres, mass_kg = [], scenario.vehicle.mass_kg
    for burn in burns:
        manoeuvre = _manoeuvre(scenario, burn, mass_kg)
        manoeuvres.append(manoeuvre)
        mass_kg += manoeuvre.delta_mass_kg
    flown = rotate_state(to_eci, states[once])
    comment = "coasts and burns as flown by the check, DOP853"
    start = rotate_state(to_eci, scenario.launch_inertial(initial))
    return {
        "orbit.oem": oem(subject, times[once], flown, comment=comment),
        "orbit.opm": opm(subject, 0.0, start, mass_kg=scenario.vehicle.mass_kg, manoeuvres=manoeuvres),
    }


def _manoeuvre(scenario: Scenario, burn: FlownBurn, mass_kg: float) -> InertialManoeuvre:
    """The burn with the integral of its thrust over mass."""
    vehicle, times = scenario.vehicle, burn.flight.times_s
    mass = mass_kg - vehicle.mass_flow_kg_s * times
    acceleration = vehicle.thrust_n / mass[:, None] * burn.flight.direction
    x, y, z = (float(each) for each in scenario.eci_rotation @ trapezoid(acceleration, times, axis=0))
    duration_s = float(times[-1])
    return InertialManoeuvre(
        burn.ignition_s, (x, y, z), duration_s=duration_s, delta_mass_kg=-vehicle.mass_flow_kg_s * duration_s
    )
