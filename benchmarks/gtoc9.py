"""The legs of JPL's winning GTOC9 campaign, planned by the phasing mission: `python -m benchmarks.gtoc9`.

Debris follow mean elements with secular J2 drift, as the rules of the competition say; the chaser leaves one and meets the
next in osculating J2. Departure and arrival are free within 0.15 days of the listed dates, whose durations are rounded to
0.01 d and add up. Every plan is flown again here, by SciPy's DOP853 on a field of this file. A run adds rows to its CSV file
and leaves out the legs that it has already; `--table` prints what is there.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, degrees, pi, sin, sqrt
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from orbsoc.missions.phasing import Plan, Scenario, plan

Array = NDArray[np.float64]

DATA = Path(__file__).parent / "data"
ROWS = Path(__file__).parents[1] / "docs/measurements/gtoc9.csv"
MU, RADIUS, J2 = 398600.4418e9, 6378137.0, 1.08262668e-3
"""Of the rules, SI."""
DAY_S, FREE_D = 86400.0, 0.15
PERIGEE_KM = 6600.0 - 6378.137
"""Height below which the rules forbid to fly."""
MET_M, MORE_M_S, SHARE, PROCESSOR_S = 100.0, 0.1, 0.8, 20.0
"""What is asked of the legs: re-flown miss, Δv over JPL's on at least a share of the legs, processor time."""
FIELDS = ("leg", "from", "to", "days", "jpl_m_s", "ours_m_s", "status", "impulses", "revolutions", "depart_d", "arrive_d",
          "perigee_km", "reflown_m", "reflown_m_s", "gap", "processor_s")  # fmt: skip


@dataclass(frozen=True, slots=True)
class Leg:
    """From one debris to the next: numbers, dates (MJD2000), JPL's Δv (m/s)."""

    number: int
    mission: int
    begin: int
    end: int
    depart: float
    arrive: float
    dv_m_s: float


def debris() -> dict[int, list[float]]:
    """Epoch (MJD2000), a (m), e, i, Ω, ω, M (rad) of the 123 debris."""
    return {int(row[0]): [float(x) for x in row[1:]] for row in _rows(DATA / "gtoc9_debris.csv")}


def legs() -> list[Leg]:
    """All 113 of the campaign."""
    rows = list(_rows(DATA / "gtoc9_legs.csv"))
    return [Leg(k + 1, *map(int, row[:3]), *map(float, row[3:])) for k, row in enumerate(rows)]


def scenario(leg: Leg, known: dict[int, list[float]]) -> Scenario:
    """Seconds count from the listed departure."""
    length_s = (leg.arrive - leg.depart) * DAY_S
    return Scenario.model_validate(
        {
            "mission": "phasing", "name": f"GTOC9, {leg.begin} to {leg.end}", "forces": ["j2"],
            "chaser": _body(known[leg.begin], leg.depart), "target": _body(known[leg.end], leg.depart),
            "window": {
                "start_s": 0.0, "end_s": length_s, "latest_h": 720.0,
                "dates_h": min(24.0 * FREE_D, 0.49 * length_s / 3600.0),
            },
            "limits": {"perigee_height_km": PERIGEE_KM},
        }
    )  # fmt: skip


def reflown(leg: Leg, found: Plan, known: dict[int, list[float]]) -> tuple[float, float, float]:
    """Distance (m) and speed (m/s) by which the impulses miss, and the lowest osculating perigee height (km) on the way."""
    assert found.programme is not None
    assert found.phasing is not None
    start, end = found.phasing.start_s, found.phasing.end_s
    state, at, lowest = _debris_state(known[leg.begin], leg.depart + start / DAY_S), start, np.inf
    for t, dv in [*zip(found.programme.times_s, found.programme.dv_m_s, strict=True), (end, np.zeros(3))]:
        if t > at:
            run = solve_ivp(_field, (at, t), state, "DOP853", rtol=1e-12, atol=1e-6)
            state, at = run.y[:, -1], t
        outward = state[:3] / np.linalg.norm(state[:3])
        normal = np.cross(state[:3], state[3:])
        normal /= np.linalg.norm(normal)
        state = state.copy()
        state[3:] += np.array([outward, np.cross(normal, outward), normal]).T @ dv
        lowest = min(lowest, _perigee_km(state))
    off = state - _debris_state(known[leg.end], leg.depart + end / DAY_S)
    return float(np.linalg.norm(off[:3])), float(np.linalg.norm(off[3:])), lowest


def measure(leg: Leg, known: dict[int, list[float]]) -> dict[str, object]:
    """A row of the table."""
    task, before = scenario(leg, known), process_time()
    found = plan(task)
    spent = process_time() - before
    row: dict[str, object] = {
        "leg": leg.number, "from": leg.begin, "to": leg.end, "days": f"{leg.arrive - leg.depart:.2f}",
        "jpl_m_s": leg.dv_m_s, "status": found.status.name, "processor_s": f"{spent:.1f}",
    }  # fmt: skip
    if found.programme is None or found.phasing is None:
        return row
    miss_m, miss_m_s, perigee_km = reflown(leg, found, known)
    length_s = (leg.arrive - leg.depart) * DAY_S
    return row | {
        "ours_m_s": f"{found.programme.total_m_s:.2f}", "impulses": len(found.programme),
        "revolutions": found.to_dict()["phasing"]["revolutions"],
        "depart_d": f"{found.phasing.start_s / DAY_S:+.3f}", "arrive_d": f"{(found.phasing.end_s - length_s) / DAY_S:+.3f}",
        "perigee_km": f"{perigee_km:.0f}", "reflown_m": f"{miss_m:.3f}", "reflown_m_s": f"{miss_m_s:.1e}",
        "gap": "" if found.bounded is None else f"{found.bounded.gap:.1e}",
    }  # fmt: skip


def table(rows: list[dict[str, str]]) -> str:
    """What the rows show against what is asked, and all of them, in Markdown."""
    done = [row for row in rows if row["ours_m_s"]]
    more = [float(row["ours_m_s"]) - float(row["jpl_m_s"]) for row in done]
    cheap = sum(each <= MORE_M_S for each in more)
    met = sum(float(row["reflown_m"]) <= MET_M for row in done)
    longest = max(float(row["processor_s"]) for row in rows)
    ours, theirs = (sum(float(row[key]) for row in done) for key in ("ours_m_s", "jpl_m_s"))
    lines = [
        f"- {len(rows)} of {len(legs())} legs run, {len(done)} planned, {sum(row['status'] == 'VERIFIED' for row in rows)} verified; "
        f"{met} re-flown to {MET_M:g} m or less, at most {max(float(row['reflown_m']) for row in done):.3f} m.",
        f"- {cheap} ({100 * cheap / len(rows):.0f} %) at JPL's Δv + {MORE_M_S:g} m/s or less; {SHARE:.0%} are asked for. "
        f"Together {ours:.1f} m/s, JPL's {theirs:.1f} m/s.",
        f"- Processor time a leg: at most {longest:.1f} s, {PROCESSOR_S:g} s are allowed.",
        "",
        "| " + " | ".join(FIELDS) + " |",
        "|" + "---|" * len(FIELDS),
    ]
    return "\n".join(lines + ["| " + " | ".join(row[key] for key in FIELDS) + " |" for row in rows])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROWS, help="rows, one a leg")
    parser.add_argument("--legs", type=int, nargs="*", help="numbers from 1; all by default")
    parser.add_argument("--part", default="1/1", help="2/3: every third leg from the second")
    parser.add_argument("--table", action="store_true", help="plan nothing; print the table")
    arguments = parser.parse_args()
    if not arguments.table:
        part, parts = map(int, arguments.part.split("/"))
        arguments.out.parent.mkdir(parents=True, exist_ok=True)
        known = debris()
        for leg in legs()[part - 1 :: parts]:
            old = {int(row["leg"]) for row in _read(arguments.out)}
            if leg.number not in old and (not arguments.legs or leg.number in arguments.legs):
                row = measure(leg, known)
                with arguments.out.open("a", newline="", encoding="utf-8") as file:
                    csv.DictWriter(file, FIELDS, restval="").writerow(row)
                sys.stdout.write(" ".join(f"{row.get(key, '')}" for key in FIELDS) + "\n")
                sys.stdout.flush()
    rows = _read(arguments.out)
    if rows:
        sys.stdout.write(table(sorted(rows, key=lambda row: int(row["leg"]))) + "\n")


def _rows(path: Path) -> Iterator[list[str]]:
    with path.open(encoding="utf-8") as file:
        yield from (row for row in csv.reader(file) if row[0][0].isdigit())


def _read(path: Path) -> list[dict[str, str]]:
    return [dict(zip(FIELDS, row, strict=True)) for row in _rows(path)] if path.exists() else []


def _body(known: list[float], zero: float) -> dict[str, object]:
    epoch, sma_m, ecc, *angles = known
    keys = ("inc_deg", "raan_deg", "argp_deg", "mean_anomaly_deg")
    turned = {key: degrees(angle) for key, angle in zip(keys, angles, strict=True)}
    return {
        "sma_km": sma_m / 1e3,
        "ecc": ecc,
        **turned,
        "epoch_s": (epoch - zero) * DAY_S,
        "motion": "mean_j2",
    }


def _debris_state(known: list[float], date: float) -> Array:
    """By the rules: Ω and ω drift, M grows with √(μ/a³)."""
    epoch, a, e, inc, node, perigee, anomaly = known
    dt, n = (date - epoch) * DAY_S, sqrt(MU / a**3)
    drift = 1.5 * J2 * (RADIUS / (a * (1.0 - e * e))) ** 2 * n
    node -= drift * cos(inc) * dt
    perigee += 0.5 * drift * (5.0 * cos(inc) ** 2 - 1.0) * dt
    mean = (anomaly + n * dt) % (2.0 * pi)
    eccentric = mean
    for _ in range(50):
        eccentric -= (eccentric - e * sin(eccentric) - mean) / (1.0 - e * cos(eccentric))
    x, y = a * (cos(eccentric) - e), a * sqrt(1.0 - e * e) * sin(eccentric)
    rate = n * a / (1.0 - e * cos(eccentric))
    u, v = -rate * sin(eccentric), rate * sqrt(1.0 - e * e) * cos(eccentric)
    p = np.array([cos(node) * cos(perigee) - sin(node) * sin(perigee) * cos(inc),
                  sin(node) * cos(perigee) + cos(node) * sin(perigee) * cos(inc), sin(perigee) * sin(inc)])  # fmt: skip
    q = np.array([-cos(node) * sin(perigee) - sin(node) * cos(perigee) * cos(inc),
                  -sin(node) * sin(perigee) + cos(node) * cos(perigee) * cos(inc), cos(perigee) * sin(inc)])  # fmt: skip
    return np.concatenate([x * p + y * q, u * p + v * q])


def _field(_: float, state: Array) -> list[float]:
    x, y, z, u, v, w = state.tolist()
    square = x * x + y * y + z * z
    pull = -MU / (square * sqrt(square))
    oblate = 1.5 * J2 * RADIUS * RADIUS / square
    ratio = 5.0 * z * z / square
    across = pull * (1.0 + oblate * (1.0 - ratio))
    return [u, v, w, across * x, across * y, pull * (1.0 + oblate * (3.0 - ratio)) * z]


def _perigee_km(state: Array) -> float:
    r, v = state[:3], state[3:]
    radius = float(np.linalg.norm(r))
    sma = 1.0 / (2.0 / radius - float(v @ v) / MU)
    eccentricity = np.cross(v, np.cross(r, v)) / MU - r / radius
    return (sma * (1.0 - float(np.linalg.norm(eccentricity))) - RADIUS) / 1e3


if __name__ == "__main__":
    main()
