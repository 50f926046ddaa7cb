"""Random approaches of a station: what is planned, in what time, and whether anything that was claimed is contradicted.

`python -m benchmarks.station_approaches --count 200 --clarabel --flights 10 --out FILE` plans approaches on V-bar and R-bar from
random places and writes a line of JSON of each: the status, the processor time, the cost. With `--errors` the plan knows of the errors that it
is flown with, and leaves a margin for them. It solves every conic problem again with Clarabel, flies drifts of every verified plan, whole and cut at random fractions, and its abort impulses, on a grid twenty times
as dense as the planner's, and flies it with errors. A run that was stopped goes on where its file ends.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.solution import Status
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.interfaces import clarabel
from orbsoc.missions import approach
from orbsoc.missions.approach.model.problem import flown
from orbsoc.missions.approach.verification.aborts import kicked
from orbsoc.missions.approach.verification.closed_loop import fly_corrected

LAPSE_S = 5e4
"""An error of the velocity by which a margin is lost in three orbits, by three standard deviations."""
ERRORS = {"position_m": 0.3, "velocity_m_s": 2e-3, "execution_share": 0.01, "sigmas": 3.0}
"""That a plan with `--errors` knows of."""
ABORTS = 100
"""Drifts of each plan: after random burns, cut at random fractions."""


def scenario(seed: int, **changes: Any) -> Mapping[str, Any]:
    """A random approach, as a document."""
    random = np.random.default_rng([seed, 48])
    radius = float(random.uniform(60.0, 400.0))
    gate = radius * float(random.uniform(1.15, 1.6))
    behind = float(random.uniform(4.0, 15.0)) * radius
    vertical = bool(random.random() < 0.4)
    sign = float(random.choice([-1.0, 1.0]))
    duration = float(random.uniform(3000.0, 9000.0))
    hold, last = float(random.uniform(300.0, 1200.0)), float(random.uniform(0.06, 0.2)) * radius
    rate = 1.1283e-3
    if vertical:  # from below or above, on a circular orbit
        depth = sign * float(random.uniform(2.0, 5.0)) * gate
        start = {"x_m": -sign * behind, "z_m": depth, "vx_m_s": 1.5 * rate * depth}
        points: dict[str, Any] = {
            "gate": {"z_m": sign * gate},
            "dock": {"z_m": sign * last, "vz_m_s": -sign * 0.1},
        }
        axis = "+R-bar" if sign > 0.0 else "-R-bar"
    else:
        start = {"x_m": sign * behind, "y_m": float(random.uniform(-0.3, 0.3)) * radius}
        points = {"gate": {"x_m": sign * gate}, "dock": {"x_m": sign * last, "vx_m_s": -sign * 0.1}}
        axis = "+V-bar" if sign > 0.0 else "-V-bar"
    points["gate"] |= {
        "vx_m_s": 0.0, "arrive_s": duration, "hold_s": hold, "hold_within_m": 0.02 * radius, "impulses": 6,
        "hold_impulses": max(1, int(hold / (40.0 if vertical else 200.0))),
    }  # fmt: skip
    points["dock"] |= {"arrive_s": duration + hold + 9.0 * gate, "impulses": 15}
    return {
        "mission": "approach", "name": f"random {seed}", "target": {"altitude_km": 420.0, "inclination_deg": 51.6},
        "start": start, "points": points,
        "keep_out": {"radius_m": radius, "until": "gate", "margin_m": 0.03 * radius, "body_m": 0.5 * last},
        "corridor": {"axis": axis, "half_angle_deg": float(random.uniform(8.0, 20.0)), "margin_m": 0.01 * last},
        "speed": {"at_target_m_s": 0.1, "by_range_per_s": float(random.uniform(0.002, 0.005))},
        "engine": {"largest_m_s": 3.0}, "safety": {"orbits": float(random.choice([1.0, 2.0]))},
        **changes,
    }  # fmt: skip


def contradicted(plan: approach.Plan, seed: int) -> int:
    """Of random cut drifts of a verified plan, how many come nearer than was said."""
    random, at = np.random.default_rng([seed, 49]), plan.approach
    assert plan.programme is not None
    assert plan.verification is not None
    after, count = flown(at, plan.programme), at.guarded
    grid = np.linspace(0.0, at.horizon_s, int(4800 * at.horizon_s / at.period_s))
    table = np.array([at.motion.transition(float(t), 0.0)[:3] for t in grid])
    said = plan.verification.least_cut_m
    broken = 0
    for _ in range(ABORTS):
        k, fraction = int(random.integers(count)), float(random.random())
        state = after[k].copy()
        state[3:] -= (1.0 - fraction) * plan.programme.dv_m_s[k]
        broken += bool(np.linalg.norm(table @ state, axis=1).min() < said - 2e-3)
    return broken


def judged(seed: int, *, with_errors: bool, with_clarabel: bool, flights: int) -> dict[str, Any]:
    """What is found of one random approach, as a line of the file."""
    found: dict[str, Any] = {"seed": seed}
    known = {"uncertainty": ERRORS} if with_errors else {}
    try:
        asked = checked(approach.Scenario, scenario(seed, **known), source=f"random {seed}")
    except ScenarioError as error:
        return found | {"status": "refused", "message": str(error)}
    ended: list[float] = []
    began = time.process_time()
    plan = approach.plan(asked, callback=lambda _: ended.append(time.process_time()))
    found["whole_s"] = time.process_time() - began
    found["planned_s"] = ended[-1] - began if ended else found["whole_s"]
    found |= {
        "status": plan.status.value,
        "message": plan.verification.failures[0]
        if plan.verification and plan.verification.failures
        else plan.message[:160],
        "cost_m_s": plan.cost,
        "bound_m_s": plan.lower_bound,
        "solves": len(plan.subproblems),
        "patterns": len({pattern_digest(row.problem) for row in plan.subproblems}),
        "starts": {each.side: each.reference.cost for each in plan.attempts if each.found},
    }
    if plan.status is PlanStatus.VERIFIED:
        assert plan.programme is not None
        assert plan.verification is not None
        needed = [each for each in plan.verification.aborts if not each.safe and each.dv_m_s is not None]
        found |= {
            "drifts_contradicted": contradicted(plan, seed),
            "nearest_m": plan.verification.least_cut_m,
            "keep_out_m": plan.verification.keep_out_m,
            "aborts": len(plan.verification.aborts),
            "aborts_needed": len(needed),
            "aborts_missing": len(plan.verification.unsafe_aborts),
            "abort_gap": max((1.0 - each.at_least_m_s / each.size_m_s for each in needed), default=0.0),
            "aborts_contradicted": aborts_contradicted(plan, seed),
        }
        if flights:
            margin = plan.scenario.keep_out.margin_m
            sizes = {"fixed": (0.3, 2e-3), "margin": (margin / 30.0, margin / LAPSE_S)}
            found["flights"] = flights
            for name, (position, velocity) in sizes.items():
                errors = Uncertainty(
                    position_m=position, velocity_m_s=velocity, execution_share=0.01, runs=flights
                )
                flown_with = fly_corrected(
                    plan.approach, plan.programme, plan.verification.arcs, errors=errors, runs=flights
                )
                found[f"entered_{name}"] = flown_with.entered
    if with_clarabel:
        tally: Counter[str] = Counter()
        for row in plan.subproblems:
            theirs = clarabel.solve(row.problem, row.settings)
            both = row.solution.status is Status.SOLVED and theirs.status is Status.SOLVED
            tally["both" if both else f"{row.solution.status.name}, {theirs.status.name}"] += 1
            gap = (row.solution.objective - theirs.objective) / max(abs(theirs.objective), 1e-6)
            tally["dearer by 1e-6"] += both and gap > 1e-6
        found["clarabel"] = dict(tally)
    return found


def aborts_contradicted(plan: approach.Plan, seed: int) -> int:
    """Of random abort impulses of a verified plan, up to ABORTS, how many do not do what was said, on a dense grid."""
    assert plan.verification is not None
    at, random = plan.approach, np.random.default_rng([seed, 51])
    told = [each for each in plan.verification.aborts if each.dv_m_s is not None]
    grid = np.linspace(0.0, at.horizon_s, int(4800 * at.horizon_s / at.period_s))
    table = at.transitions(grid, np.zeros_like(grid))[:, :3]
    broken = 0
    for k in random.choice(len(told), min(ABORTS, len(told)), replace=False).tolist():
        each = told[k]
        assert each.dv_m_s is not None
        ranges = np.linalg.norm(table @ kicked(each.state, each.dv_m_s), axis=1)
        out = np.flatnonzero(ranges >= at.axes_m[0])
        kept = out.size and ranges[out[0] :].min() >= at.axes_m[0] - 0.011
        broken += not (kept and ranges.min() >= plan.scenario.keep_out.body_m - 0.011)
    return broken


def summary(rows: list[dict[str, Any]]) -> str:
    """Sums of all lines of a file, in words."""
    statuses = Counter(row["status"] for row in rows)
    verified = [row for row in rows if row["status"] == "verified"]
    planned = [row for row in rows if "planned_s" in row]
    words = [str(dict(statuses))]
    for name in ("drifts_contradicted", "aborts", "aborts_needed", "aborts_missing", "aborts_contradicted"):
        words.append(f"{name} {sum(row[name] for row in verified)}")
    words.append(f"flights {sum(row.get('flights', 0) for row in verified)}")
    for name in ("entered_fixed", "entered_margin"):
        words.append(f"{name} {sum(row.get(name, 0) for row in verified)}")
    solved: Counter[str] = Counter()
    for row in rows:
        solved.update(row.get("clarabel", {}))
    words.append(f"beside Clarabel {dict(solved)}")
    for name in ("planned_s", "whole_s", "solves", "patterns"):
        values = [row[name] for row in planned]
        words.append(f"{name}: median {np.median(values):.2f}, largest {max(values):.2f}")
    gaps = np.array([1.0 - row["bound_m_s"] / row["cost_m_s"] for row in verified if row["bound_m_s"]])
    words.append(f"above the bound without the keep-out: median {100 * np.median(gaps):.1f} %")
    words.append(f"within 0.5 % of it {int((gaps < 0.005).sum())} of {gaps.size}")
    return "\n".join(words)


def main() -> None:
    """A line of JSON an approach, and the sums; what the file has is not done again."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--errors", action="store_true", help="plan with the errors of the flights")
    parser.add_argument("--clarabel", action="store_true", help="solve every conic problem again")
    parser.add_argument("--flights", type=int, default=0, help="dispersed flights of each verified plan")
    parser.add_argument("--out", type=Path, help="file of lines of JSON; those that it has are kept")
    chosen = parser.parse_args()
    rows: list[dict[str, Any]] = []
    if chosen.out is not None and chosen.out.is_file():
        rows = [json.loads(line) for line in chosen.out.read_text().splitlines()]
    done = {row["seed"] for row in rows}
    for seed in range(chosen.first, chosen.first + chosen.count):
        if seed in done:
            continue
        rows.append(
            judged(seed, with_errors=chosen.errors, with_clarabel=chosen.clarabel, flights=chosen.flights)
        )
        line = json.dumps(rows[-1])
        if chosen.out is not None:
            with chosen.out.open("a") as file:
                file.write(f"{line}\n")
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
    sys.stdout.write(f"{summary(rows)}\n")


if __name__ == "__main__":
    main()
