"""What a programme of coasts and burns does over time: heights, mass, and where its Δv goes."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from orbsoc.guidance.figure_style import labels_in_line
from orbsoc.orbit import EARTH, ConstantsSet, Thruster, elements_from_state
from orbsoc.orbit.array import Array

from ..verification import Arcs, Flight
from .orbit import AFTER, BEFORE, BURN

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, eq=False)
class History:
    """Along a flight, each (K,), SI. `delta_v_m_s` = `speed_change_m_s` + `gravity_m_s` + `steering_m_s`.

    d|v|/dt = a u·v̂ + g·v̂. Of a burn that speeds up, gravity takes −∫ g·v̂ dt and turning ∫ a (1 − u·v̂) dt; of one that `brakes`,
    the change is the speed that is shed, and v̂ is replaced by −v̂.
    """

    brakes: bool
    times_s: Array
    altitude_m: Array
    perigee_height_m: Array
    apogee_height_m: Array
    mass_kg: Array
    delta_v_m_s: Array
    speed_change_m_s: Array
    gravity_m_s: Array
    steering_m_s: Array

    @classmethod
    def of(cls, thruster: Thruster, flight: Flight) -> History:
        """From the samples of a burn that was flown."""
        times, states = flight.times_s, flight.propagated
        r, v = states[:, :3], states[:, 3:]
        radius, speed = (np.linalg.norm(each, axis=1) for each in (r, v))
        along = v / speed[:, None]
        acceleration = thruster.acceleration_m_s2(times)
        pull = -flight.about.mu_m3_s2 * r / radius[:, None] ** 3
        forwards = np.einsum("ki,ki->k", flight.direction, along)
        brakes = bool(_integrated(acceleration * forwards, times)[-1] < 0.0)
        sign = -1.0 if brakes else 1.0
        mass = thruster.mass_kg - thruster.mass_flow_kg_s * times
        return replace(
            cls.of_coast(times, states, thruster.mass_kg, flight.about),
            brakes=brakes,
            mass_kg=mass,
            delta_v_m_s=thruster.thrust_n / thruster.mass_flow_kg_s * np.log(thruster.mass_kg / mass),
            speed_change_m_s=sign * (speed - speed[0]),
            gravity_m_s=_integrated(-sign * np.einsum("ki,ki->k", pull, along), times),
            steering_m_s=_integrated(acceleration * (1.0 - sign * forwards), times),
        )

    @classmethod
    def of_coast(cls, times: Array, states: Array, mass_kg: float, about: ConstantsSet = EARTH) -> History:
        """Of states (K, 6) without thrust."""
        orbits = [elements_from_state(x[:3], x[3:], about) for x in states]
        still = np.zeros(len(times))
        return cls(
            False,
            times,
            np.linalg.norm(states[:, :3], axis=1) - about.earth_radius_m,
            np.array([orbit.perigee_height_m() for orbit in orbits]),
            np.array([orbit.apogee_height_m() for orbit in orbits]),
            still + mass_kg,
            *(still,) * 4,
        )

    @classmethod
    def of_arcs(cls, thruster: Thruster, arcs: Arcs) -> History:
        """Of coasts and burns one after the other, the first ignition at their time; what a burn's Δv goes to counts from its start."""
        parts, spent = [], 0.0
        for k, (coast, burn) in enumerate(zip(arcs.coasts, arcs.burns, strict=True)):
            for at, part in enumerate((
                cls.of_coast(coast.times_s, coast.states, thruster.mass_kg, burn.about),
                cls.of(thruster, burn),
            )):  # fmt: skip
                times = part.times_s + arcs.starts_s[2 * k + at]
                parts.append(replace(part, times_s=times, delta_v_m_s=part.delta_v_m_s + spent))
            spent = float(parts[-1].delta_v_m_s[-1])
            thruster = replace(thruster, mass_kg=float(parts[-1].mass_kg[-1]))
        names = [each.name for each in fields(cls)][1:]
        joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
        return cls(parts[-1].brakes, **joined)


def _integrated(rate: Array, times: Array) -> Array:
    from scipy.integrate import cumulative_simpson  # pyright: ignore[reportUnknownVariableType]

    return np.asarray(cumulative_simpson(rate, x=times, initial=0.0), dtype=np.float64)


def history_figure(title: str, thruster: Thruster, arcs: Arcs) -> Figure:
    """Altitude, perigee and apogee, mass and Δv: of one burn from its ignition, and where its Δv is lost; of several from the
    first state on, burns shaded."""
    from matplotlib.figure import Figure

    one = len(arcs.burns) == 1
    history = History.of(thruster, arcs.burns[0]) if one else History.of_arcs(thruster, arcs)
    time, apogee = history.times_s, history.apogee_height_m
    figure = Figure(figsize=(7.2, 8.0))
    place = {"left": 0.12, "right": 0.97, "bottom": 0.07, "top": 0.94, "hspace": 0.22}
    grid = {"height_ratios": (1.0, 1.2, 0.8, 1.6 if one else 1.0), **place}
    panels = list(figure.subplots(4, 1, sharex=True, gridspec_kw=grid))
    panels[0].plot(time, history.altitude_m / 1e3, color=BURN if one else "#222222")
    panels[1].plot(time, history.perigee_height_m / 1e3, color=BEFORE, label="perigee height")
    closed = np.where(np.isfinite(apogee), apogee, np.nan) / 1e3
    if np.isfinite(closed).any():
        panels[1].plot(time, closed, color=AFTER, label="apogee height")
        if np.nanmax(closed) > 20.0 * max(float(np.nanmin(closed)), 1.0):
            panels[1].set_yscale("symlog", linthresh=100.0)
    panels[2].plot(time, history.mass_kg, color="#444444")
    panels[3].plot(time, history.delta_v_m_s, color="#222222", linewidth=3.0, alpha=0.6, label="spent Δv")
    if one:
        change = f"speed {'shed' if history.brakes else 'gained'}"
        panels[3].plot(time, history.speed_change_m_s, color=AFTER, label=change)
        panels[3].plot(time, history.gravity_m_s, color=BEFORE, label="taken by gravity")
        panels[3].plot(time, history.steering_m_s, color=BURN, label="spent on turning")
    for start_s, burn in zip(arcs.starts_s[1::2], arcs.burns, strict=True):
        for panel in () if one else panels:
            end_s = start_s + float(burn.times_s[-1])
            panel.axvspan(start_s, end_s, color=BURN, alpha=0.25, linewidth=0.0)
    for panel, label in zip(panels, ("altitude (km)", "osculating (km)", "mass (kg)", "m/s"), strict=True):
        panel.set_ylabel(label)
    panels[3].set_xlabel("time since ignition (s)" if one else "time from the first state (s)")
    panels[3].set_xlim(time[0], time[-1])
    for panel in (panels[1], panels[3]):
        panel.legend(
            loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, handlelength=1.5
        )
    labels_in_line(panels)
    figure.suptitle(title, x=0.01, ha="left", fontweight="bold")
    return figure
