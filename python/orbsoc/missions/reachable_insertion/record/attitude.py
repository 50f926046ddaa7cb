"""The attitude programme behind `attitude.csv`: what the verification flew, burn by burn, and the slew between burns."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orbsoc.orbit import pitch_yaw
from orbsoc.orbit.array import Array

from ..scenario import Scenario
from ..verification import Arcs

COLUMNS = {
    "launch_inertial": ("t_s", "pitch_deg", "yaw_deg", "ux", "uy", "uz", "rate_deg_s"),
    "eci": ("t_s", "ux_eci", "uy_eci", "uz_eci", "mass_kg", "rate_deg_s"),
    "velocity": (
        "t_s", "pitch_velocity_deg", "yaw_velocity_deg", "u_along_velocity", "u_across_in_plane", "u_along_momentum",
        "mass_kg", "rate_deg_s",
    ),
}  # fmt: skip
"""Of `attitude.csv` by its axes; times count from the first ignition. Of two burns the thrust follows."""
COASTED = 4
"""Every fourth sample of a coast between burns is told."""


def attitude_axes(scenario: Scenario) -> str:
    """The axes that `attitude.csv` is in: "velocity" where the scenario asks for it, else those of the plan."""
    return "velocity" if scenario.axes == "velocity" else scenario.plan_axes


def attitude_table(scenario: Scenario, arcs: Arcs) -> str:
    """A header of `COLUMNS` and one line per time. Over a coast between burns the thrust is 0, and the attitude turns at a
    constant rate from the last direction of one burn to the first of the next."""
    axes, vehicle = attitude_axes(scenario), scenario.vehicle
    several = len(arcs.burns) > 1
    mass_kg, rows = vehicle.mass_kg, [np.empty((0, len(COLUMNS[axes]) + several))]
    for k, burn in enumerate(arcs.burns):
        if k:
            rows.append(_slew(axes, arcs, k, mass_kg))
        if not burn.times_s[-1] > 0.0:
            continue
        mass = mass_kg - vehicle.mass_flow_kg_s * burn.times_s
        times = burn.times_s + (arcs.starts_s[2 * k + 1] - arcs.starts_s[1])
        told = _rows(axes, times, burn.direction, burn.propagated, mass, np.rad2deg(burn.rate_rad_s))
        rows.append(np.column_stack([told, np.full(len(told), vehicle.thrust_n)]) if several else told)
        mass_kg = float(mass[-1])
    return _csv((*COLUMNS[axes], "thrust_n") if several else COLUMNS[axes], np.vstack(rows))


def _slew(axes: str, arcs: Arcs, k: int, mass_kg: float) -> Array:
    """Over the coast before burn k, without its ends, which are the burns'."""
    coast = arcs.coasts[k]
    times, states = coast.times_s[COASTED:-1:COASTED], coast.states[COASTED:-1:COASTED]
    first, last = arcs.burns[k - 1].direction[-1], arcs.burns[k].direction[0]
    still, elapsed_s = np.ones(len(times)), times + (arcs.starts_s[2 * k] - arcs.starts_s[1])
    angle = np.arctan2(np.linalg.norm(np.cross(first, last)), first @ last)
    rate = np.rad2deg(angle / coast.times_s[-1]) if len(times) else 0.0
    u = turned(first, last, times / coast.times_s[-1])
    return np.column_stack([_rows(axes, elapsed_s, u, states, mass_kg * still, rate * still), 0.0 * still])


def turned(first: Array, last: Array, shares: Array) -> Array:
    """Unit vectors (K, 3) on the great circle between two, at shares (K,) of the way; of opposite ones, any."""
    axis = np.cross(first, last)
    if np.linalg.norm(axis) < 1e-9:
        axis = np.cross(first, np.eye(3)[int(np.abs(first).argmin())])
    ahead = np.cross(axis / np.linalg.norm(axis), first)
    angle = shares * np.arctan2(last @ ahead, last @ first)
    return np.asarray(np.outer(np.cos(angle), first) + np.outer(np.sin(angle), ahead))


def _rows(axes: str, times: Array, u: Array, states: Array, mass: Array, rate: Array) -> Array:
    """Rows (K, C) of `COLUMNS` for directions (K, 3) that turn at `rate` (K,), °/s, at states (K, 6).

    In launch-inertial axes pitch and yaw are eq. 21's; about the velocity, pitch is towards the outside of the orbit and yaw
    along the angular momentum.
    """
    if axes == "launch_inertial":
        pitch, yaw = pitch_yaw(u)
        return np.column_stack([times, np.rad2deg(pitch), np.rad2deg(yaw), u, rate])
    if axes == "eci":
        return np.column_stack([times, u, mass, rate])
    normal = np.cross(states[:, :3], states[:, 3:])
    forwards, normal = (x / np.linalg.norm(x, axis=1, keepdims=True) for x in (states[:, 3:], normal))
    along, across, out = (np.einsum("ki,ki->k", u, x) for x in (forwards, np.cross(forwards, normal), normal))
    pitch, yaw = np.arctan2(across, along), np.arcsin(np.clip(out, -1.0, 1.0))
    return np.column_stack([times, np.rad2deg(pitch), np.rad2deg(yaw), along, across, out, mass, rate])


def _csv(header: Sequence[str], rows: Array) -> str:
    lines = [",".join(header), *(",".join(f"{value:.12g}" for value in row) for row in rows)]
    return "\n".join(lines) + "\n"
