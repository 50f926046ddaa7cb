"""Verdicts of five reachable domains on random orbits, against burns that are known and burns that are planned directly.

`python -m benchmarks.reach_verdicts --orbits 300 --out out/reach-verdicts.csv` makes orbits of two kinds. Nine in ten are *flown*: a
random attitude programme, cut off at a random time, flown by DOP853; the orbit that it ends on is within reach, and no verdict may say
otherwise. The others are *drawn* next to the edge and next to the largest orbit of a plane; for these the mission
`reachable_insertion` plans the burn onto the very orbit, which knows nothing of the domain's tables. A contradiction is an orbit
called beyond reach by the tables, or solved (`exact`), that a flown burn no longer than the scenario's ends on.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.made_missions import STANDARD_GRAVITY_M_S2
from orbsoc.missions.reachable_domain import Scenario
from orbsoc.missions.reachable_domain.search.continuation.boundary import resolved_boundary
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.query.shortest_burn import shortest_burn
from orbsoc.orbit import (
    EARTH,
    Elements,
    PropagationError,
    elements_from_state,
    propagate_burn,
    state_from_elements,
)
from orbsoc.orbit.planes import inclination_and_node
from orbsoc.reach import ReachableDomain, Verdict

Array = NDArray[np.float64]

PLANES = 7
"""Of the grid along inclination and node, which span the domain."""
FLOWN_SHARE = 0.9
LEAST_BURN = 0.3
"""Of the scenario's burn, that a flown orbit takes."""

STARTS = {
    # name: mass kg, dry kg, thrust N, Isp s, burn s, [a km, e, i, node, argp, true anomaly deg], perigee bounds (first, last, step) km
    "kick stage": (5000.0, 1500.0, 30000.0, 340.0, 250.0, (6678.137, 0.0, 51.6, 30.0, 0.0, 40.0), (150.0, 350.0, 50.0)),
    "apogee engine": (2000.0, 1100.0, 490.0, 321.0, 3000.0, (24500.0, 0.72, 27.0, 10.0, 178.0, 175.0), (500.0, 4500.0, 1000.0)),
    "long burn": (5000.0, 1500.0, 2000.0, 320.0, 3000.0, (6978.137, 0.0, 98.0, 120.0, 0.0, 10.0), (200.0, 600.0, 100.0)),
    "short burn": (10000.0, 5000.0, 50000.0, 310.0, 20.0, (6878.137, 0.001, 63.4, 200.0, 90.0, 30.0), (440.0, 480.0, 10.0)),
}  # fmt: skip
DOMAINS = ("paper", *STARTS)


@dataclass(frozen=True, slots=True)
class Trial:
    """An orbit, what is known of it, and what the domain says. `known_s` is a burn (s) that was flown onto it, NaN for none;
    `exact_s` the burn that the exact answer found. `contradiction` is empty where there is none."""

    domain: str
    number: int
    kind: str
    sma_km: float
    ecc: float
    inc_deg: float
    raan_deg: float
    argp_deg: float
    known_s: float
    tables: str
    tilt_deg: float
    tilt_error_deg: float
    sma_left_km: float
    sma_error_km: float
    exact: str
    exact_s: float
    contradiction: str


def solved(name: str) -> ReachableDomain:
    """A domain with its boundary resolved and a grid that spans it."""
    edge_only = _scenario(name, (0.0, 1.0), (0.0, 1.0))
    boundary = resolved_boundary(Domain.of(edge_only))
    lowest = np.isfinite(boundary["tilt_deg"])
    now = float(np.rad2deg(inclination_and_node(Domain.of(edge_only).frame.normal)[1]))
    inc, raan = (
        boundary["inc_deg"][lowest],
        np.mod(boundary["raan_deg"][lowest] - now + 180.0, 360.0) + now - 180.0,
    )
    scenario = _scenario(name, (inc.min(), inc.max()), (raan.min(), raan.max()))
    ready = Domain.of(scenario)
    return ReachableDomain(scenario, ready.solve_planes(*ready.planes()).columns, boundary)


def trials(
    name: str, domain: ReachableDomain, count: int, *, seed: int = 28, exact_every: int = 25
) -> Iterator[Trial]:
    """The first `count` orbits of a domain; each depends on (seed, domain, number) alone."""
    flown = int(FLOWN_SHARE * count)
    for number in range(count):
        draw = np.random.default_rng([seed, DOMAINS.index(name), number])
        orbit, known_s = (
            _flown(domain.scenario, draw) if number < flown else (_drawn(domain, draw), float("nan"))
        )
        exact = number % exact_every == 0
        yield _judged(name, number, domain, orbit, known_s, exact=exact)


def _judged(
    name: str, number: int, domain: ReachableDomain, orbit: Elements, known_s: float, *, exact: bool
) -> Trial:
    rough = domain.can_reach(orbit)
    kind, allowed_s = ("drawn" if np.isnan(known_s) else "flown"), domain.scenario.burn.duration_s
    if kind == "drawn":
        planned = shortest_burn(domain.scenario, orbit)
        known_s = planned.duration_s if planned.verified else float("nan")
    solved_now = domain.can_reach(orbit, exact=True) if exact else None
    burn = None if solved_now is None else solved_now.burn
    reached = known_s <= allowed_s
    wrong = [
        f"{how}: {margin.words}"
        for how, margin in (("tables", rough), ("exact", solved_now))
        if margin is not None and margin.verdict is Verdict.BEYOND and reached
    ]
    return Trial(
        domain=name,
        number=number,
        kind=kind,
        sma_km=orbit.sma_m / 1e3,
        ecc=orbit.ecc,
        inc_deg=float(np.rad2deg(orbit.inc_rad)),
        raan_deg=float(np.rad2deg(orbit.raan_rad)),
        argp_deg=float(np.rad2deg(orbit.argp_rad)),
        known_s=known_s,
        tables=rough.verdict.value,
        tilt_deg=rough.tilt_deg,
        tilt_error_deg=rough.tilt_error_deg,
        sma_left_km=rough.sma_km,
        sma_error_km=rough.sma_error_km,
        exact="" if solved_now is None else solved_now.verdict.value,
        exact_s=float("nan") if burn is None else burn.duration_s,
        contradiction="; ".join(wrong),
    )


def _flown(scenario: Scenario, draw: np.random.Generator) -> tuple[Elements, float]:
    """The orbit at the end of a random programme: a direction that turns at a constant rate, half of them across the plane."""
    start, thruster = scenario.initial_eci(), scenario.vehicle.thruster()
    lowest, highest = scenario.boundary.perigee_height_km.first, scenario.boundary.perigee_height_km.last
    ahead = start[3:] / np.linalg.norm(start[3:])
    across = np.cross(start[:3], start[3:])
    across /= np.linalg.norm(across)
    for _ in range(2000):
        spread = draw.normal(size=3) * draw.choice([0.2, 0.7, 2.0])
        first = (
            ahead * draw.choice([1.0, 1.0, 0.0, -0.3]) + across * draw.choice([-2.0, 0.0, 0.0, 2.0]) + spread
        )
        first /= np.linalg.norm(first)
        last = first + draw.normal(size=3) * draw.choice([0.05, 0.3, 1.0])
        burn_s = scenario.burn.duration_s * draw.choice([1.0, draw.uniform(LEAST_BURN, 1.0)])

        def steering(time_s: float, _state: Array, ends: tuple[Array, Array] = (first, last)) -> Array:
            share = time_s / scenario.burn.duration_s
            return (1.0 - share) * ends[0] + share * ends[1]

        try:
            end = propagate_burn(start, thruster, steering, [burn_s])[-1]
        except PropagationError:
            continue
        orbit = elements_from_state(end[:3], end[3:])
        height_km = orbit.perigee_height_m() / 1e3
        if orbit.ecc < 0.95 and 0.8 * lowest <= height_km <= 1.1 * highest:
            return orbit, float(burn_s)
    raise RuntimeError(f"{scenario.name}: no random burn ends within the perigee heights")


def _drawn(domain: ReachableDomain, draw: np.random.Generator) -> Elements:
    """An orbit near the edge, or near the largest of a grid's plane."""
    heights = domain.limit.height_km
    height_km = float(draw.uniform(heights[0], heights[-1]))
    reached = np.flatnonzero(domain.points["status"] == "reached")
    if draw.uniform() < 0.5 or not reached.size:
        azimuth = float(draw.uniform(0.0, 360.0))
        tilt = np.deg2rad(domain.limit(azimuth, height_km) * draw.normal(1.0, 0.03))
        inc, raan = inclination_and_node(domain.domain.frame.tilted(np.array([tilt]), np.deg2rad([azimuth])))
        perigee_m = EARTH.earth_radius_m + 1e3 * height_km
        ecc = float(draw.uniform(0.0, 0.1))
        return Elements(
            perigee_m / (1.0 - ecc),
            ecc,
            float(inc[0]),
            float(raan[0]) % (2.0 * np.pi),
            draw.uniform(0.0, 6.28),
            0.0,
        )
    row = int(draw.choice(reached))
    points = domain.points
    perigee_m = EARTH.earth_radius_m + 1e3 * points["perigee_km"][row]
    ecc = float(np.clip(points["ecc"][row] * draw.normal(1.0, 0.02), 0.0, 0.98))
    angles = np.deg2rad(
        [
            points["inc_deg"][row],
            points["raan_deg"][row] % 360.0,
            points["argp_deg"][row] + draw.normal(0.0, 2.0),
        ]
    )
    inc_rad, raan_rad, argp_rad = map(float, angles)
    return Elements(perigee_m / (1.0 - ecc), ecc, inc_rad, raan_rad, argp_rad, 0.0)


def _scenario(name: str, inc_deg: tuple[float, float], raan_deg: tuple[float, float]) -> Scenario:
    if name == "paper":
        document: dict[str, Any] = {
            "vehicle": {
                "mass_kg": 160000.0,
                "dry_mass_kg": 0.0,
                "thrust_n": 270000.0,
                "mass_flow_kg_s": 60.0,
            },
            "initial": {
                "position_m": [-4780421.0, 4388673.2, 1069366.2],
                "velocity_m_s": [-4944.1088, -4692.4264, -3389.3615],
            },
            "burn": {"duration_s": 1200.0},
        }
        heights = (100.0, 500.0, 100.0)
    else:
        mass, dry, thrust, isp_s, burn_s, orbit, heights = STARTS[name]
        elements = Elements(orbit[0] * 1e3, orbit[1], *np.deg2rad(orbit[2:]))
        state = np.concatenate(state_from_elements(elements))
        document = {
            "vehicle": {
                "mass_kg": mass,
                "dry_mass_kg": dry,
                "thrust_n": thrust,
                "mass_flow_kg_s": thrust / isp_s / STANDARD_GRAVITY_M_S2,
            },
            "initial": {"position_m": state[:3].tolist(), "velocity_m_s": state[3:].tolist()},
            "burn": {"duration_s": burn_s},
        }
    bounds = dict(zip(("first", "last", "step"), heights, strict=True))
    spans = {
        key: {"first": low, "last": high, "step": (high - low) / (PLANES - 1)}
        for key, (low, high) in (("inclination_deg", inc_deg), ("raan_deg", raan_deg))
    }
    return Scenario.model_validate(
        {
            "mission": "reachable_domain",
            "name": name,
            "axes": "eci",
            **document,
            "grid": {**spans, "perigee_height_km": bounds},
            "boundary": {"azimuths": 48, "perigee_height_km": bounds},
        }
    )


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orbits", type=int, default=300, help="of each domain")
    parser.add_argument("--seed", type=int, default=28)
    parser.add_argument("--domains", nargs="+", default=list(DOMAINS), choices=DOMAINS)
    parser.add_argument("--out", type=Path, required=True)
    chosen = parser.parse_args(arguments)
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    wrong = 0
    with chosen.out.open("w", newline="", encoding="utf-8") as stream:
        rows = csv.DictWriter(stream, [field.name for field in fields(Trial)])
        rows.writeheader()
        for name in chosen.domains:
            domain, tally = solved(name), Counter[str]()
            for trial in trials(name, domain, chosen.orbits, seed=chosen.seed):
                rows.writerow(asdict(trial))
                stream.flush()
                tally[
                    f"{trial.kind}, {'known' if trial.known_s <= domain.scenario.burn.duration_s else 'no'} burn: {trial.tables}"
                ] += 1
                wrong += bool(trial.contradiction)
                if trial.contradiction:
                    sys.stdout.write(f"{name} {trial.number} ({trial.kind}): {trial.contradiction}\n")
            sys.stdout.write(f"{name}: {dict(sorted(tally.items()))}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{wrong} contradictions\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
