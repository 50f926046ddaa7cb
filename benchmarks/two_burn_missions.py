"""Random transfers whose answer is known: coast, burn, coast, burn is flown forward, and the orbit it ends on is the target.

`python -m benchmarks.missions --two-burns` plans them. The burns of the construction bound the shortest ones; half of the missions
ignite now, half when it suits. `unreachable_transfer` makes targets that no number of burns reaches. With `oblate` the coasts are
flown with J2 by DOP853, and the first lasts up to `REVOLUTIONS`. With `bounded`
the thrust of the construction turns at a constant rate, slower than the orbit, and that rate is the mission's bound.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.made_missions import LOWEST_M, STANDARD_GRAVITY_M_S2, Mission, axes_along
from orbsoc.missions.reachable_insertion import Scenario
from orbsoc.orbit import EARTH, Elements, Thruster, elements_from_state, propagate_burn, state_from_elements
from orbsoc.orbit.perturbations import J2, PointMass, coast
from orbsoc.orbit.propagate import Steering

Array = NDArray[np.float64]

KINDS = ("raise", "lower", "plane", "any")
LONGEST_ARC = 0.25
"""Of the period of the first orbit, that one burn may take."""
DELTA_V_M_S = (20.0, 2000.0)
"""Of one burn."""
COASTS = (0.05, 0.9)
"""Between the burns, in periods of the first orbit."""
HIGHEST_ECCENTRICITY = 1.5
REVOLUTIONS = 4.0
"""Of the first orbit, that a coast with J2 before the first burn may take."""
SLOW = (0.01, 0.7)
"""Turns of the thrust of a bounded construction, in turns of the first orbit."""
OFF = Thruster(1.0, 0.0, 0.0)


def transfers(seed: int, count: int, *, oblate: bool = False, bounded: bool = False) -> Iterator[Mission]:
    """The first `count` of a seed, kinds by turns; each depends on (seed, number) alone."""
    for number in range(count):
        yield transfer(seed, number, oblate=oblate, bounded=bounded)


def transfer(seed: int, number: int, *, oblate: bool = False, bounded: bool = False) -> Mission:
    """Mission `number` of a seed; draws are repeated until one can be flown."""
    random = np.random.default_rng([seed, number, 4 if oblate else 2])
    kind = KINDS[number % len(KINDS)]
    while True:
        name = f"two-burns-{'oblate-' * oblate}{'bounded-' * bounded}{kind}-{seed}-{number}"
        found = _constructed(kind, name, random, oblate=oblate, bounded=bounded)
        if found is not None:
            return found


def unreachable_transfer(seed: int, number: int, *, oblate: bool = False) -> Mission:
    """A target out of reach by turns: an energy that the vehicle cannot buy even at the ground, or the first orbit flown the
    other way round, which costs more than 0.8 of its speed however it is done, by a vehicle that has 0.3 of it at most."""
    random = np.random.default_rng([seed, number, 3])
    while True:
        made = transfer(seed, int(random.integers(1_000_000)), oblate=oblate)
        vehicle, start = made.scenario.vehicle, made.scenario.initial.vector()
        exhaust = vehicle.thrust_n / vehicle.mass_flow_kg_s
        delta_v = exhaust * np.log(vehicle.mass_kg / vehicle.dry_mass_kg)
        orbit = elements_from_state(start[:3], start[3:])
        if number % 2 == 0:
            at_ground = np.sqrt(2.0 * EARTH.mu_m3_s2 * (1.0 / EARTH.earth_radius_m - 0.5 / orbit.sma_m))
            energy = 0.5 * (at_ground + delta_v + 200.0) ** 2 - EARTH.mu_m3_s2 / EARTH.earth_radius_m
            sma = -0.5 * EARTH.mu_m3_s2 / energy
            ecc = abs(1.0 - orbit.perigee_radius_m / sma)
            target = Elements(sma, ecc, orbit.inc_rad, orbit.raan_rad, orbit.argp_rad, 0.0)
            state = np.concatenate(state_from_elements(target))
        elif orbit.ecc < 0.02 and delta_v < 0.3 * float(np.linalg.norm(start[3:])):
            state = np.concatenate([start[:3], -start[3:]])
        else:
            continue
        changed = made.scenario.with_changes(
            name=f"unreachable-transfer-{seed}-{number}",
            target={"position_m": state[:3].tolist(), "velocity_m_s": state[3:].tolist()},
        )
        return Mission("unreachable", changed, float("inf"))


def _constructed(
    kind: str, name: str, random: np.random.Generator, *, oblate: bool, bounded: bool
) -> Mission | None:
    """One draw; None when its flight dives, takes too long, or ends on an orbit that is not wanted."""
    first = _first_orbit(random)
    start = np.concatenate(state_from_elements(first))
    period_s = first.period_s()
    mass_kg = 10.0 ** random.uniform(np.log10(200.0), np.log10(2e5))
    thrust_n = mass_kg * 10.0 ** random.uniform(np.log10(0.3), np.log10(30.0))
    exhaust_m_s = STANDARD_GRAVITY_M_S2 * random.uniform(220.0, 460.0)
    flow_kg_s = thrust_n / exhaust_m_s
    delta_v = 10.0 ** random.uniform(*np.log10(DELTA_V_M_S), 2)
    masses = mass_kg * np.exp(-np.cumsum(delta_v) / exhaust_m_s)
    burns_s = np.array([mass_kg - masses[0], masses[0] - masses[1]]) / flow_kg_s
    longest_s = float(burns_s.sum()) * random.uniform(1.1, 1.6)
    dry_kg = mass_kg - flow_kg_s * longest_s
    if burns_s.max() > LONGEST_ARC * period_s or dry_kg < 0.02 * mass_kg:
        return None
    free = bool(random.integers(2))
    latest_s = REVOLUTIONS * period_s if oblate else period_s
    coasts_s = (random.uniform(0.0, latest_s) if free else 0.0, random.uniform(*COASTS) * period_s)
    slowest, fastest = np.log10(SLOW)
    rate_rad_s = 2.0 * np.pi / period_s * 10.0 ** random.uniform(slowest, fastest) if bounded else 0.0
    state, lowest = start, np.inf
    for k, (coast_s, burn_s) in enumerate(zip(coasts_s, burns_s, strict=True)):
        nominal = _nominal(kind, random)
        if bounded:
            axis = random.standard_normal(3)
        else:
            steering = _programme(nominal, burn_s, random)
        way = _coast(state, coast_s, oblate=oblate)
        if bounded:
            steering = _turning(nominal @ axes_along(way[-1]), axis, rate_rad_s)
        thruster = Thruster((mass_kg, *masses)[k], thrust_n, flow_kg_s)
        arc = propagate_burn(way[-1], thruster, steering, np.linspace(0.0, burn_s, 65))
        radii = np.linalg.norm(np.vstack([way, arc])[:, :3], axis=1)
        lowest, state = min(lowest, float(radii.min())), arc[-1]
    last = elements_from_state(state[:3], state[3:])
    if lowest < EARTH.earth_radius_m + LOWEST_M or last.ecc > HIGHEST_ECCENTRICITY:
        return None
    if last.perigee_radius_m < EARTH.earth_radius_m + LOWEST_M:
        return None
    waiting = {"coast_j2": True, **({"latest_ignition_s": latest_s} if free else {})} if oblate else {}
    limits = {"limits": {"attitude_rate_deg_s": float(np.rad2deg(rate_rad_s))}} if bounded else {}
    scenario = Scenario.model_validate({
        "mission": "reachable_insertion", "name": name, "problem": "min_time", "axes": "eci",
        "vehicle": {"mass_kg": mass_kg, "dry_mass_kg": dry_kg, "thrust_n": thrust_n, "mass_flow_kg_s": flow_kg_s},
        "initial": {"position_m": start[:3].tolist(), "velocity_m_s": start[3:].tolist()},
        "target": {"position_m": state[:3].tolist(), "velocity_m_s": state[3:].tolist()},
        "burn": {"count": 2, "ignition": "free" if free else "now", **waiting},
        **limits,
    })  # fmt: skip
    return Mission(kind, scenario, float(burns_s.sum()))


def _first_orbit(random: np.random.Generator) -> Elements:
    perigee_m = EARTH.earth_radius_m + 1e3 * 10.0 ** random.uniform(np.log10(200.0), np.log10(2000.0))
    ecc = random.choice([0.0, random.uniform(0.0, 0.1), random.uniform(0.1, 0.6)])
    inc = random.uniform(0.0, np.pi)
    raan, argp, anomaly = random.uniform(0.0, 2.0 * np.pi, 3)
    return Elements(perigee_m / (1.0 - ecc), float(ecc), float(inc), raan, argp, float(anomaly))


def _coast(start: Array, time_s: float, *, oblate: bool) -> Array:
    """States (K, 6) on the way of a coast."""
    times = np.linspace(0.0, time_s, 65)
    if oblate and time_s > 0.0:
        return coast(start[None], times, (PointMass(), J2()))[:, 0]
    return propagate_burn(start, OFF, lambda _t, x: x[3:], times)


def _nominal(kind: str, random: np.random.Generator) -> Array:
    """A direction that suits the kind, in axes along and across the motion."""
    nominal = {
        "raise": np.array([1.0, 0.0, 0.0]),
        "lower": np.array([-1.0, 0.0, 0.0]),
        "plane": np.array([random.uniform(-0.5, 0.5), 0.0, random.choice([-1.0, 1.0])]),
        "any": random.standard_normal(3),
    }[kind]
    return np.asarray(nominal / np.linalg.norm(nominal))


def _programme(nominal: Array, burn_s: float, random: np.random.Generator) -> Steering:
    """A nominal direction, in axes along and across the motion, and a random smooth turn."""
    wobble = 10.0 ** random.uniform(-2.0, -0.4) * random.standard_normal((3, 3))

    def steering(t_s: float, state: Array) -> Array:
        tau = 2.0 * t_s / burn_s - 1.0
        return np.asarray((nominal + wobble[0] + wobble[1] * tau + wobble[2] * tau**2) @ axes_along(state))

    return steering


def _turning(first: Array, axis: Array, rate_rad_s: float) -> Steering:
    """An inertial direction that turns at a constant rate about an axis across it."""
    across = np.cross(axis, first)
    across /= np.linalg.norm(across)

    def steering(t_s: float, _state: Array) -> Array:
        return np.asarray(np.cos(rate_rad_s * t_s) * first + np.sin(rate_rad_s * t_s) * across)

    return steering
