"""Random burns from a millisecond to an hour whose answer is known: flown forward, and the orbit that they end on is the target.

`python -m benchmarks.missions --any-length` plans them, `--ignition-free` with the ignition free. Lengths are log-uniform, and
so is the thrust; the burn is a good part of a revolution where the orbit asks for that.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.made_missions import LOWEST_M, STANDARD_GRAVITY_M_S2, Mission, axes_along
from orbsoc.missions.reachable_insertion import Scenario
from orbsoc.orbit import EARTH, Elements, Thruster, elements_from_state, propagate_burn, state_from_elements

Array = NDArray[np.float64]

KINDS = ("raise", "lower", "plane", "any")
BURN_S = (1e-3, 3600.0)
ACCELERATION_M_S2 = (0.1, 30.0)
LARGEST_DELTA_V_M_S = 3000.0
LONGEST_ARC = 0.35
"""Of the period of the first orbit."""
HIGHEST_ECCENTRICITY = 1.5


def any_length(seed: int, count: int, *, free: bool = False) -> Iterator[Mission]:
    """The first `count` of a seed, kinds by turns; each depends on (seed, number) alone. `free`: the ignition."""
    for number in range(count):
        yield burn_of_any_length(seed, number, free=free)


def burn_of_any_length(seed: int, number: int, *, free: bool = False) -> Mission:
    """Mission `number` of a seed; all but its length is drawn again until it can be flown."""
    random = np.random.default_rng([seed, number, 5])
    burn_s = 10.0 ** random.uniform(*np.log10(BURN_S))
    kind = KINDS[number % len(KINDS)]
    while True:
        found = _constructed(kind, f"any-length-{kind}-{seed}-{number}", burn_s, random, free=free)
        if found is not None:
            return found


def _constructed(
    kind: str, name: str, burn_s: float, random: np.random.Generator, *, free: bool
) -> Mission | None:
    first = _first_orbit(random)
    start = np.concatenate(state_from_elements(first))
    mass_kg = 10.0 ** random.uniform(np.log10(200.0), np.log10(2e5))
    thrust_n = mass_kg * 10.0 ** random.uniform(*np.log10(ACCELERATION_M_S2))
    flow_kg_s = thrust_n / (STANDARD_GRAVITY_M_S2 * random.uniform(220.0, 460.0))
    left = 1.0 - flow_kg_s * burn_s / mass_kg
    longest_s = min(burn_s * 10.0 ** random.uniform(0.1, 4.0), 0.95 * mass_kg / flow_kg_s)
    if left < 0.1 or -np.log(left) * thrust_n / flow_kg_s > LARGEST_DELTA_V_M_S or longest_s < 1.1 * burn_s:
        return None
    if burn_s > LONGEST_ARC * first.period_s():
        return None
    nominal = {
        "raise": np.array([1.0, 0.0, 0.0]),
        "lower": np.array([-1.0, 0.0, 0.0]),
        "plane": np.array([0.3 * random.standard_normal(), 0.0, random.choice([-1.0, 1.0])]),
        "any": random.standard_normal(3),
    }[kind]
    nominal /= np.linalg.norm(nominal)
    wobble = 10.0 ** random.uniform(-2.0, -0.4) * random.standard_normal((3, 3))

    def steering(t_s: float, state: Array) -> Array:
        tau = 2.0 * t_s / burn_s - 1.0
        return np.asarray((nominal + wobble[0] + wobble[1] * tau + wobble[2] * tau**2) @ axes_along(state))

    flown = propagate_burn(
        start, Thruster(mass_kg, thrust_n, flow_kg_s), steering, np.linspace(0.0, burn_s, 33)
    )
    last = elements_from_state(flown[-1, :3], flown[-1, 3:])
    if np.linalg.norm(flown[:, :3], axis=1).min() < EARTH.earth_radius_m + LOWEST_M:
        return None
    if last.ecc > HIGHEST_ECCENTRICITY or last.perigee_radius_m < 1e6:
        return None
    document: dict[str, Any] = {
        "mission": "reachable_insertion", "name": name, "problem": "min_time", "axes": "eci",
        "vehicle": {
            "mass_kg": mass_kg, "dry_mass_kg": mass_kg - flow_kg_s * longest_s, "thrust_n": thrust_n, "mass_flow_kg_s": flow_kg_s,
        },
        "initial": {"position_m": start[:3].tolist(), "velocity_m_s": start[3:].tolist()},
        "target": {"position_m": flown[-1, :3].tolist(), "velocity_m_s": flown[-1, 3:].tolist()},
        "burn": {
            "duration_s": min(0.98 * longest_s, burn_s * random.uniform(0.5, 1.8)), "ignition": "free" if free else "now",
        },
    }  # fmt: skip
    return Mission(kind, Scenario.model_validate(document), burn_s)


def _first_orbit(random: np.random.Generator) -> Elements:
    perigee_m = EARTH.earth_radius_m + 1e3 * 10.0 ** random.uniform(np.log10(180.0), np.log10(2000.0))
    ecc = random.choice([0.0, random.uniform(0.0, 0.1), random.uniform(0.1, 0.75)])
    inc = random.uniform(0.0, np.pi)
    raan, argp, anomaly = random.uniform(0.0, 2.0 * np.pi, 3)
    return Elements(perigee_m / (1.0 - ecc), float(ecc), float(inc), raan, argp, float(anomaly))
