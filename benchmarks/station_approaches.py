"""Random approaches of a station: what is planned, in what time, and whether anything that was claimed is contradicted.

`python -m benchmarks.station_approaches --count 200` plans approaches on V-bar and R-bar from random places and prints, of each: the
status, the processor time, the cost; then it solves every conic problem again with Clarabel, and flies every verified plan's drifts,
whole and cut at random fractions, on a grid twenty times as dense as the planner's.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from orbsoc.conic.solution import Status
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.interfaces import clarabel
from orbsoc.missions import approach
from orbsoc.missions.approach.model.problem import flown
from orbsoc.missions.approach.verification.closed_loop import fly_corrected

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


def say(text: str) -> None:
    """A line, at once."""
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main() -> None:
    """Print a line a scenario, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--clarabel", action="store_true", help="solve every conic problem again")
    parser.add_argument("--flights", type=int, default=0, help="dispersed flights of each verified plan")
    chosen = parser.parse_args()
    tally: Counter[str] = Counter()
    seconds = []
    for seed in range(chosen.first, chosen.first + chosen.count):
        try:
            asked = checked(approach.Scenario, scenario(seed), source=f"random {seed}")
        except ScenarioError as error:
            tally["refused"] += 1
            say(f"{seed:4d} refused: {error}")
            continue
        began = time.process_time()
        plan = approach.plan(asked)
        seconds.append(time.process_time() - began)
        words = f"{seed:4d} {plan.status.value:13s} {seconds[-1]:6.2f} s  cost {plan.cost:8.4f}  solves {len(plan.subproblems):3d}"
        tally[plan.status.value] += 1
        if plan.status is PlanStatus.VERIFIED:
            broken = contradicted(plan, seed)
            tally["aborts contradicted"] += broken
            assert plan.verification is not None
            words += f"  nearest {plan.verification.least_cut_m:8.2f} m  no abort {len(plan.verification.unsafe_aborts)}"
            if chosen.flights and plan.programme is not None:
                errors = Uncertainty(
                    position_m=0.3, velocity_m_s=2e-3, execution_share=0.01, runs=chosen.flights
                )
                flights = fly_corrected(
                    plan.approach, plan.programme, plan.verification.arcs, errors=errors, runs=chosen.flights
                )
                tally["flights that enter"] += flights.entered
                tally["flights"] += chosen.flights
        else:
            words += f"  {plan.verification.failures[0] if plan.verification else plan.message[:110]}"
        if chosen.clarabel:
            for row in plan.subproblems:
                theirs = clarabel.solve(row.problem, row.settings)
                both = row.solution.status is Status.SOLVED and theirs.status is Status.SOLVED
                tally["solved by both" if both else f"{row.solution.status.name}, {theirs.status.name}"] += 1
                gap = (row.solution.objective - theirs.objective) / max(abs(theirs.objective), 1e-6)
                tally["dearer than Clarabel by 1e-6"] += both and gap > 1e-6
        say(words)
    say(str(dict(tally)))
    say(f"processor time: median {np.median(seconds):.2f} s, largest {max(seconds):.2f} s")


if __name__ == "__main__":
    main()
