"""A flown insertion as CCSDS messages: an ephemeris of coasts and burns, and its first state with the burns as manoeuvres."""

from __future__ import annotations

import numpy as np
from scipy.integrate import trapezoid

from orbsoc.guidance.ccsds import FRAME, InertialManoeuvre, Subject, oem, opm
from orbsoc.orbit import rotate_state

from ..scenario import Scenario
from ..verification import Arcs, Flight


def messages(scenario: Scenario, arcs: Arcs) -> dict[str, str]:
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
    to_eci, starts_s = scenario.eci_rotation, arcs.starts_s
    times = [start_s + each.times_s for start_s, each in zip(starts_s[::2], arcs.coasts, strict=True)]
    times += [start_s + each.times_s for start_s, each in zip(starts_s[1::2], arcs.burns, strict=True)]
    states = np.concatenate([each.states for each in arcs.coasts] + [each.propagated for each in arcs.burns])
    # microseconds, as the messages have them: an instant that two arcs share is told once
    _, once = np.unique(np.round(np.concatenate(times), 6), return_index=True)
    manoeuvres, mass_kg = [], scenario.vehicle.mass_kg
    for ignition_s, burn in zip(starts_s[1::2], arcs.burns, strict=True):
        manoeuvres.append(_manoeuvre(scenario, ignition_s, burn, mass_kg))
        mass_kg += manoeuvres[-1].delta_mass_kg
    flown = rotate_state(to_eci, states[once])
    comment = "coasts and burns as flown by the check, DOP853"
    start = rotate_state(to_eci, scenario.launch_inertial(initial))
    return {
        "orbit.oem": oem(subject, np.concatenate(times)[once], flown, comment=comment),
        "orbit.opm": opm(subject, 0.0, start, mass_kg=scenario.vehicle.mass_kg, manoeuvres=manoeuvres),
    }


def _manoeuvre(scenario: Scenario, ignition_s: float, burn: Flight, mass_kg: float) -> InertialManoeuvre:
    """The burn with the integral of its thrust over mass."""
    vehicle, times = scenario.vehicle, burn.times_s
    acceleration = vehicle.thrust_n / (mass_kg - vehicle.mass_flow_kg_s * times)[:, None] * burn.direction
    x, y, z = (float(each) for each in scenario.eci_rotation @ trapezoid(acceleration, times, axis=0))
    spent_kg, duration_s = vehicle.mass_flow_kg_s * float(times[-1]), float(times[-1])
    return InertialManoeuvre(ignition_s, (x, y, z), duration_s=duration_s, delta_mass_kg=-spent_kg)
