"""Claims of the relative missions against brute force and Clarabel: `python -m benchmarks.claims [--cases N] [--seed S] [--first K]`.

Random small fly-arounds, approaches and rendezvous. A claim is contradicted where a flight or a second solver on grids 20
times finer than the planner's does what the claim rules out. Prints a table of counts as it goes.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from math import pi
from typing import Any

import numpy as np

import orbsoc
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.interfaces import clarabel
from orbsoc.missions import fly_around, passive_safety
from orbsoc.missions.fly_around.model.flight import fly
from orbsoc.missions.fly_around.search.fewest import coast_end
from orbsoc.missions.fly_around.search.times import least_error
from orbsoc.missions.fly_around.search.tube import NoTube, Revolution
from orbsoc.missions.passive_safety.model.approach import Approach
from orbsoc.missions.passive_safety.model.problem import assemble

STARTS = 4
"""Random times from which one pulse fewer is tried, half of them after a coast."""
FINER = 960
"""Times of impulse 2 that are tried, 20 times the planner's."""
DENSE = 481
"""Times of a rendezvous, 20 times the planner's."""


def one_fly_around(random: np.random.Generator) -> Counter[str]:
    """Whether one pulse fewer than the plan's does what is proved not to be."""
    a, b = float(random.uniform(80.0, 250.0)), float(random.uniform(60.0, 200.0))
    period = float(random.uniform(1200.0, 3600.0))
    speed = -b * 2.0 * pi / period * float(random.choice([0.0, 0.5, 1.0, 1.2]))
    data: dict[str, Any] = {
        "mission": "fly_around", "name": "random", "impulses": "fewest",
        "tolerance_m": float(random.uniform(0.06, 0.25)) * min(a, b),
        "target": {"altitude_km": 500.0},
        "ellipse": {"semi_axes_m": [a, b], "angles_deg": random.uniform(-90, 90, 3).tolist(), "period_s": period},
        "start": {"x_m": a, "y_m": 0.0, "z_m": 0.0, "vz_m_s": speed},
    }  # fmt: skip
    scenario = checked(fly_around.Scenario, data, source="random")
    found = fly_around.plan(scenario)
    search = found.search
    said = Counter({"fly-arounds": 1, f"fly-around {found.status.value}": 1})
    if search is None or search.impossible < 1:
        return said + Counter({"fly-around without a proof": 1})
    said["fewest proved"] += search.certified
    flight, start, end_s = scenario.flight, scenario.start_state, scenario.duration_s
    left = coast_end(flight, start, end_s, search.impossible_any_m)
    nearest = np.inf
    for k in range(STARTS):
        first = float(random.uniform(0.0, left)) if k % 2 else 0.0
        inner = np.sort(random.uniform(first + 0.05 * end_s, 0.95 * end_s, search.impossible - 1))
        times = np.unique(np.concatenate([[0.0, first], inner]))
        best = least_error(Revolution(flight, start, end_s, orbsoc.solve, coast=first > 0.0), times)
        if not isinstance(best, NoTube):
            nearest = min(nearest, fly(flight, start, best.programme, end_s, 1000).largest_error_m)
    said["contradicted"] += nearest < search.impossible_any_m - 1e-5
    return said


def one_approach(random: np.random.Generator) -> Counter[str]:
    """Two impulses, the second one's time free, or four at equal times, some of them impossible."""
    timing = str(random.choice(["free", "equal"]))
    data: dict[str, Any] = {
        "mission": "passive_safety", "name": "random", "condition": "short", "keep_out_m": 40.0,
        "duration_s": float(random.uniform(2800.0, 4200.0)),
        "target": {"mean_motion_rad_s": 1e-3},
        "start": {"x_m": -float(random.uniform(300.0, 1500.0))},
        "capture": {"x_m": float(random.uniform(-100.0, 100.0)), "z_m": float(random.uniform(41.0, 120.0))},
        "impulses": {"count": 2 if timing == "free" else int(random.integers(2, 5)), "timing": timing},
    }  # fmt: skip
    try:
        scenario = checked(passive_safety.Scenario, data, source="random")
    except ScenarioError:
        return Counter({"approaches refused": 1})
    found, approach = passive_safety.plan(scenario), Approach.of(scenario)
    said = Counter({"approaches": 1, f"approach {timing} {found.status.value}": 1})
    if timing == "equal":
        assert found.timed is not None
        other = clarabel.solve(found.timed.trials[0].row.problem, orbsoc.Settings(tol=1e-9))
        said["contradicted"] += found.status is PlanStatus.INFEASIBLE and other.status is orbsoc.Status.SOLVED
        return said
    seconds = np.linspace(0.0, min(scenario.duration_s, 1e3 * pi), FINER + 2)[1:-1]
    costs = []
    for second in seconds:
        problem = assemble(approach, np.array([0.0, second])).builder.build()
        other = clarabel.solve(problem, orbsoc.Settings(tol=1e-9))
        if other.status is orbsoc.Status.SOLVED:
            costs.append(other.objective)
    said["contradicted"] += found.status is PlanStatus.INFEASIBLE and bool(costs)
    said["no time of 960 will do"] += not costs
    said["no time of 960 will do, told INFEASIBLE"] += not costs and found.status is PlanStatus.INFEASIBLE
    said["missed by NOT FOUND"] += bool(costs) and found.programme is None
    said["best found dearer by 1e-4"] += bool(costs) and found.cost > min(costs, default=0.0) * (1.0 + 1e-4)
    return said


def one_rendezvous(random: np.random.Generator) -> Counter[str]:
    """Impulses at any times, against Clarabel at 481."""
    place, speed = random.uniform(-2e4, 2e4, 3), random.uniform(-20.0, 20.0, 3)
    keys = ("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s")
    data: dict[str, Any] = {
        "mission": "passive_safety", "name": "random", "condition": "none", "keep_out_m": 0.0,
        "duration_s": float(random.uniform(2000.0, 28000.0)),
        "target": {"mean_motion_rad_s": 1.15e-3},
        "start": dict(zip(keys, [*place.tolist(), *speed.tolist()], strict=True)),
        "capture": dict.fromkeys(keys, 0.0), "impulses": {"timing": "generated"},
    }  # fmt: skip
    scenario = checked(passive_safety.Scenario, data, source="random")
    found = passive_safety.plan(scenario)
    said = Counter({"rendezvous": 1, f"rendezvous {found.status.value}": 1})
    if found.timed is None or found.timed.lower_bound is None or found.timed.primer is None:
        return said
    dense = assemble(Approach.of(scenario), np.linspace(0.0, scenario.duration_s, DENSE))
    other = clarabel.solve(dense.builder.build(), orbsoc.Settings(tol=1e-9))
    said["contradicted"] += (
        other.status is orbsoc.Status.SOLVED and other.objective < found.timed.lower_bound * (1 - 1e-7)
    )
    said["gap above 1e-5"] += found.cost > found.timed.lower_bound * (1.0 + 1e-5)
    said["primer above 1 + 1e-6"] += found.timed.primer[0] > 1.0 + 1e-6
    return said


def main() -> None:
    """Run the campaign and print its counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--seed", type=int, default=51)
    parser.add_argument("--first", type=int, default=0, help="case to begin with, of --cases")
    options = parser.parse_args()
    kinds = (one_fly_around, one_approach, one_rendezvous)
    total: Counter[str] = Counter({"contradicted": 0})
    for number in range(options.first, options.cases):
        before = total["contradicted"]
        total.update(kinds[number % 3](np.random.default_rng([options.seed, number])))
        if total["contradicted"] > before:
            sys.stdout.write(f"case {number}: contradicted\n")
        if number % 20 == 19 or number == options.cases - 1:
            sys.stdout.write(f"{number + 1} {dict(sorted(total.items()))}\n")
            sys.stdout.flush()


if __name__ == "__main__":
    main()
