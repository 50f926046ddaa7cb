"""Random insertions whose answer is known: an attitude programme is flown forward, and the orbit it ends on is the target.

`python -m benchmarks.missions --count 1000 --out out/missions` plans them and writes missions.csv, one line a mission as
soon as it is done; what the file has is not planned again. The burn of the construction is an upper bound of the shortest
one, so a good planner verifies every mission with a burn at most as long. `unreachable` makes missions that cannot be flown.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks import two_burn_missions as two
from benchmarks.burns_of_any_length import any_length
from benchmarks.made_missions import LOWEST_M, STANDARD_GRAVITY_M_S2, Mission, axes_along
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions.reachable_insertion import Plan, Scenario, TwoBurnPlan, plan
from orbsoc.orbit import (
    EARTH,
    Elements,
    Thruster,
    elements_from_state,
    propagate_burn,
    state_from_elements,
)

Array = NDArray[np.float64]

KINDS = (
    "raise", "lower", "plane", "circularise", "escape", "deorbit", "null", "retrograde", "equatorial", "polar",
)  # fmt: skip
LONGEST_ARC = 0.25
"""Of the period of the first orbit, that a burn may take."""
LARGEST_DELTA_V_M_S = 3000.0
LARGEST_TILT = np.deg2rad(8.0)
ANGLES = ("inc_deg", "raan_deg", "argp_deg")
FREE = (
    ("raan_deg",), ("argp_deg",), ANGLES, ("raan_deg", "argp_deg"), (*ANGLES, "shape"), ("argp_deg", "shape"), ("shape",),
)  # fmt: skip
"""Elements left free, by turns."""
ONE_OF_THE_SHAPE = ("sma_km", "ecc", "perigee_height_km")


def missions(seed: int, count: int) -> Iterator[Mission]:
    """The first `count` missions of a seed, kinds by turns; each depends on (seed, number) alone."""
    for number in range(count):
        yield mission(seed, number)


def mission(seed: int, number: int) -> Mission:
    """Mission `number` of a seed; draws are repeated until one can be flown."""
    random = np.random.default_rng([seed, number])
    kind = KINDS[number % len(KINDS)]
    while True:
        found = _constructed(kind, f"{kind}-{seed}-{number}", random)
        if found is not None:
            return found


def unreachable(seed: int, number: int) -> Mission:
    """A mission whose target is out of reach: a plane that is further away than the propellant turns it at any radius
    that the burn passes, or an energy that it cannot buy."""
    random = np.random.default_rng([seed, number, 1])
    made = mission(seed, 10 * number)
    vehicle = made.scenario.vehicle
    start = made.scenario.initial.vector()
    orbit = elements_from_state(start[:3], start[3:])
    delta_v = vehicle.thrust_n / vehicle.mass_flow_kg_s * np.log(vehicle.mass_kg / vehicle.dry_mass_kg)
    speed = float(np.linalg.norm(start[3:]))
    slowest = (
        speed
        if orbit.ecc > 1.0
        else float(np.sqrt(EARTH.mu_m3_s2 / orbit.sma_m * (1 - orbit.ecc) / (1 + orbit.ecc)))
    )
    # Turning by an angle costs 2 v sin(angle/2) where v is least.
    sine = 1.5 * (delta_v + 500.0) / (2.0 * slowest)
    if number % 2 and sine < 0.7:
        tilt = 2.0 * np.arcsin(sine)
        inc = orbit.inc_rad + (tilt if orbit.inc_rad + tilt < np.pi else -tilt)
        target = Elements(orbit.sma_m, orbit.ecc, inc, orbit.raan_rad, orbit.argp_rad, 0.0)
    else:
        energy = 0.5 * (speed + 2.0 * delta_v + 500.0) ** 2 - EARTH.mu_m3_s2 / np.linalg.norm(start[:3])
        sma = -EARTH.mu_m3_s2 / (2.0 * energy)
        perigee = float(np.linalg.norm(start[:3])) * random.uniform(1.0, 1.2)
        target = Elements(sma, 1.0 - perigee / sma, orbit.inc_rad, orbit.raan_rad, orbit.argp_rad, 0.0)
    r, v = state_from_elements(target)
    changed = made.scenario.with_changes(
        name=f"unreachable-{seed}-{number}", target={"position_m": r.tolist(), "velocity_m_s": v.tolist()}
    )
    return Mission("unreachable", changed, float("inf"))


def freed(made: Mission, free: tuple[str, ...], shape: str) -> Mission:
    """The mission with its target by elements, of which `free` is left out; of a free shape the one number `shape` stays.

    The construction still bounds its burn. Raises ScenarioError for a perigee below the ground as the one number."""
    state = made.scenario.target.vector()
    orbit = elements_from_state(state[:3], state[3:])
    angles = np.rad2deg([orbit.inc_rad, orbit.raan_rad, orbit.argp_rad]).tolist()
    given = {key: angle for key, angle in zip(ANGLES, angles, strict=True) if key not in free}
    sizes = (orbit.sma_m / 1e3, orbit.ecc, (orbit.perigee_radius_m - EARTH.earth_radius_m) / 1e3)
    numbers = dict(zip(ONE_OF_THE_SHAPE, sizes, strict=True))
    kept = (shape,) if "shape" in free else ("sma_km", "ecc")
    target = {"position_m": None, "velocity_m_s": None, "free": list(free)} | given
    return Mission(
        made.kind,
        made.scenario.with_changes(target=target | {key: numbers[key] for key in kept}),
        made.burn_s,
    )


def _with_free_elements(seed: int, count: int) -> Iterator[Mission]:
    for number, made in enumerate(missions(seed, count)):
        try:
            yield freed(made, FREE[number % len(FREE)], ONE_OF_THE_SHAPE[number % len(ONE_OF_THE_SHAPE)])
        except ScenarioError as error:
            sys.stderr.write(f"left out: {error}\n")


def _constructed(kind: str, name: str, random: np.random.Generator) -> Mission | None:
    """One draw; None when its flight dives, takes too long, or does not do what its kind says."""
    first = _first_orbit(kind, random)
    r, v = state_from_elements(first)
    mass_kg = 10.0 ** random.uniform(np.log10(200.0), np.log10(2e5))
    acceleration = 10.0 ** random.uniform(np.log10(0.3), np.log10(30.0))
    exhaust_m_s = STANDARD_GRAVITY_M_S2 * random.uniform(220.0, 460.0)
    thrust_n = mass_kg * acceleration
    flow_kg_s = thrust_n / exhaust_m_s
    period_s = 2.0 * np.pi * np.sqrt(abs(first.sma_m) ** 3 / EARTH.mu_m3_s2)
    delta_v_m_s = _delta_v(kind, r, v, random)
    if delta_v_m_s > LARGEST_DELTA_V_M_S:
        return None
    burn_s = mass_kg / flow_kg_s * (1.0 - np.exp(-delta_v_m_s / exhaust_m_s))
    if not 0.5 < burn_s < LONGEST_ARC * period_s:
        return None
    longest_s = burn_s * random.uniform(1.2, 2.0)
    dry_kg = mass_kg - flow_kg_s * longest_s
    if dry_kg < 0.02 * mass_kg:
        return None
    thruster = Thruster(mass_kg, thrust_n, flow_kg_s)
    if kind == "null":
        burn_s, end = 0.0, np.concatenate([r, v])
    else:
        flown = propagate_burn(
            np.concatenate([r, v]),
            thruster,
            _programme(kind, r, v, burn_s, random),
            np.linspace(0.0, burn_s, 21),
        )
        if np.linalg.norm(flown[:, :3], axis=1).min() < EARTH.earth_radius_m + LOWEST_M:
            return None
        end = flown[-1]
    last = elements_from_state(end[:3], end[3:])
    if not _is_of_kind(kind, first, last, np.concatenate([r, v]), end):
        return None
    target = end
    elsewhere = random.uniform(0.0, 2.0 * np.pi)
    if last.ecc < 1.0 and last.sma_m * (1 - last.ecc**2) / (1 + last.ecc * np.cos(elsewhere)) > 6.4e6:
        target = np.concatenate(state_from_elements(_at(last, elsewhere)))
    scenario = Scenario.model_validate({
        "mission": "reachable_insertion", "name": name, "problem": "min_time", "axes": "eci",
        "vehicle": {"mass_kg": mass_kg, "dry_mass_kg": dry_kg, "thrust_n": thrust_n, "mass_flow_kg_s": flow_kg_s},
        "launch_site": {"geocentric_latitude_deg": 5.2, "azimuth_deg": 90.0, "inertial_longitude_deg": 0.0},
        "initial": {"position_m": r.tolist(), "velocity_m_s": v.tolist()},
        "target": {"position_m": target[:3].tolist(), "velocity_m_s": target[3:].tolist()},
        "burn": {"duration_s": min(0.98 * longest_s, (burn_s or 0.3 * longest_s) * random.uniform(0.5, 1.8))},
    })  # fmt: skip
    return Mission(kind, scenario, burn_s)


def _at(orbit: Elements, anomaly: float) -> Elements:
    return Elements(orbit.sma_m, orbit.ecc, orbit.inc_rad, orbit.raan_rad, orbit.argp_rad, anomaly)


def _first_orbit(kind: str, random: np.random.Generator) -> Elements:
    """A first orbit that suits the kind."""
    perigee_m = EARTH.earth_radius_m + 1e3 * 10.0 ** random.uniform(np.log10(180.0), np.log10(2000.0))
    ecc = random.choice([0.0, random.uniform(0.0, 0.1), random.uniform(0.1, 0.75)])
    inc = random.uniform(0.0, np.pi / 2)
    anomaly = random.uniform(0.0, 2.0 * np.pi)
    if kind == "circularise":
        ecc = random.uniform(0.02, 0.6)
        anomaly = random.choice([0.0, np.pi]) + random.uniform(-0.4, 0.4)
    if kind == "escape":
        ecc, anomaly = random.uniform(0.0, 0.8), random.uniform(-0.7, 0.7)
    if kind == "deorbit":
        ecc = random.uniform(0.0, 0.02)
    if kind == "retrograde":
        inc = random.uniform(np.deg2rad(95.0), np.pi)
    if kind == "equatorial":
        inc = random.choice([0.0, random.uniform(0.0, np.deg2rad(1.0))])
    if kind == "polar":
        inc = random.uniform(np.deg2rad(85.0), np.deg2rad(95.0))
    raan, argp = random.uniform(0.0, 2.0 * np.pi, 2)
    return Elements(perigee_m / (1.0 - ecc), float(ecc), float(inc), raan, argp, float(anomaly))


def _delta_v(kind: str, position: Array, velocity: Array, random: np.random.Generator) -> float:
    """In m/s."""
    speed = float(np.linalg.norm(velocity))
    if kind == "circularise":
        circular = float(np.sqrt(EARTH.mu_m3_s2 / np.linalg.norm(position)))
        return abs(circular - speed) * random.uniform(0.6, 1.1)
    if kind == "plane":
        return speed * random.uniform(0.1, 1.0) * LARGEST_TILT
    if kind == "deorbit":
        return float(random.uniform(40.0, 400.0))
    if kind == "escape":
        return float(random.uniform(500.0, LARGEST_DELTA_V_M_S))
    return float(10.0 ** random.uniform(np.log10(10.0), np.log10(LARGEST_DELTA_V_M_S)))


def _programme(
    kind: str, r: Array, v: Array, burn_s: float, random: np.random.Generator
) -> Callable[[float, Array], Array]:
    """A nominal direction that suits the kind, in axes along and across the motion, and a random smooth turn."""
    sign = {"lower": -1.0, "deorbit": -1.0}.get(kind, 1.0)
    if kind == "circularise":
        sign = -1.0 if float(np.linalg.norm(r)) * float(v @ v) > EARTH.mu_m3_s2 else 1.0
    nominal = np.array([sign, 0.0, 0.0])
    if kind == "plane":
        nominal = np.array([random.uniform(-0.3, 0.3), 0.0, random.choice([-1.0, 1.0])])
    if kind in ("retrograde", "equatorial", "polar"):
        nominal = random.standard_normal(3)
        nominal /= np.linalg.norm(nominal)
    size = 10.0 ** random.uniform(-2.0, -0.25)
    wobble = size * random.standard_normal((3, 3)) / np.array([[1.0], [1.0], [2.0]])
    fixed = bool(random.integers(2))
    axes = axes_along(np.concatenate([r, v]))

    def steering(t_s: float, state: Array) -> Array:
        tau = 2.0 * t_s / burn_s - 1.0
        turned = nominal + wobble[0] + wobble[1] * tau + wobble[2] * tau**2
        return turned @ (axes if fixed else axes_along(state))

    return steering


def _is_of_kind(kind: str, first: Elements, last: Elements, start: Array, end: Array) -> bool:
    before, after = (np.cross(x[:3], x[3:]) for x in (start, end))
    tilt = np.arccos(np.clip(before @ after / np.linalg.norm(before) / np.linalg.norm(after), -1.0, 1.0))
    energy = [-0.5 / orbit.sma_m for orbit in (first, last)]
    rules = {
        "raise": energy[1] > energy[0],
        "lower": energy[1] < energy[0],
        "circularise": last.ecc < 0.5 * first.ecc,
        "escape": last.ecc > 1.0,
        "deorbit": last.perigee_height_m() < 100e3,
    }
    return bool(tilt <= LARGEST_TILT and rules.get(kind, True)) and last.perigee_radius_m > 1e6


@dataclass(frozen=True, slots=True)
class Answer:
    """What the planner says of a mission; `ratio`: its burn over the construction's."""

    name: str
    kind: str
    status: str
    burn_s: float
    construction_s: float
    ratio: float
    stages: int
    subproblems: int
    cpu_s: float
    message: str


def answer(made: Mission) -> Answer:
    """Plan one; an exception is an answer of status "traceback"."""
    started = time.process_time()
    try:
        found: Plan | TwoBurnPlan | None = plan(made.scenario)
        words = ""
    except Exception as error:  # counted as what it is
        found, words = None, f"{type(error).__name__}: {error}"
    cpu_s = time.process_time() - started
    if found is None:
        return Answer(
            made.scenario.name,
            made.kind,
            "traceback",
            float("nan"),
            made.burn_s,
            float("nan"),
            0,
            0,
            cpu_s,
            words,
        )
    burn_s = found.time_of_flight_s
    ratio = burn_s / made.burn_s if made.burn_s else 1.0 + burn_s
    return Answer(
        made.scenario.name, made.kind, found.status.value, burn_s, made.burn_s, ratio,
        len(found.attempts), len(found.subproblems), cpu_s, found.message,
    )  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """Plan what the file lacks, and print the tally."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else None)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--unreachable", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--free", action="store_true", help="targets with elements left free")
    kind.add_argument("--two-burns", action="store_true", help="transfers made of two burns")
    kind.add_argument("--any-length", action="store_true", help="burns from a millisecond to an hour")
    parser.add_argument("--ignition-free", action="store_true", help="of any length")
    parser.add_argument("--oblate", action="store_true", help="of two burns: coasts with J2")
    parser.add_argument("--bounded", action="store_true", help="of two burns: a bound on the attitude rate")
    parser.add_argument("--out", type=Path, default=Path("out/missions"))
    chosen = parser.parse_args(arguments)
    chosen.out.mkdir(parents=True, exist_ok=True)
    path = (
        chosen.out
        / f"missions-{chosen.seed}{'-free' * chosen.free}{'-two-burns' * chosen.two_burns}{'-oblate' * chosen.oblate}{'-bounded' * chosen.bounded}{'-any-length' * chosen.any_length}{'-ignition-free' * chosen.ignition_free}.csv"
    )
    done = {row.name: row for row in _read(path)}
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [each.name for each in fields(Answer)])
        if not done:
            writer.writeheader()
        asked = _asked(chosen)
        for number, made in enumerate(asked):
            if made.scenario.name in done:
                continue
            found = answer(made)
            done[found.name] = found
            writer.writerow(asdict(found))
            file.flush()
            if (number + 1) % 20 == 0:
                sys.stderr.write(f"{number + 1}: {tally(done.values())}\n")
    sys.stdout.write(f"{tally(done.values())}\n")
    return 0


def _asked(chosen: argparse.Namespace) -> Iterator[Mission]:
    seed, count = chosen.seed, chosen.count
    if chosen.two_burns:
        yield from two.transfers(seed, count, oblate=chosen.oblate, bounded=chosen.bounded)
    elif chosen.any_length:
        yield from any_length(seed, count, free=chosen.ignition_free)
    else:
        yield from _with_free_elements(seed, count) if chosen.free else missions(seed, count)
    for number in range(chosen.unreachable):
        if chosen.two_burns:
            yield two.unreachable_transfer(seed, number, oblate=chosen.oblate)
        else:
            yield unreachable(seed, number)


def tally(answers: object) -> str:
    """Statuses by count, and how many verified burns are longer than the construction's."""
    rows = list(answers)  # type: ignore[call-overload]
    statuses = Counter(f"{'unreachable ' * (row.kind == 'unreachable')}{row.status}" for row in rows)
    longer = sum(row.status == "verified" and row.ratio > 1.001 for row in rows)
    cpu = sum(row.cpu_s for row in rows)
    counted = ", ".join(f"{count} {status}" for status, count in sorted(statuses.items()))
    return f"{counted}; {longer} longer than 1.001 x the construction; {cpu:.0f} s of processor time"


def _read(path: Path) -> Iterator[Answer]:
    if not path.exists():
        return
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            values = {
                each.name: {"float": float, "int": int}.get(str(each.type), str)(row[each.name])
                for each in fields(Answer)
            }
            yield Answer(**values)  # type: ignore[arg-type]


if __name__ == "__main__":
    sys.exit(main())
