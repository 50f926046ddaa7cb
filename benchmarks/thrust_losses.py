"""Random thrust losses of three vehicles, flown in the closed loop, each verdict beside brute force.

`python -m benchmarks.thrust_losses ROWS.jsonl --count N` flies what the file lacks; `--table ROWS.jsonl` sums it up. A verdict is wrong where a
target that is proved out of reach is reached by the search on the ground, or where a flight with thrust ends with a perigee below the
safe one though thrust at constant and turning pitch from 500 azimuths would have brought the vehicle, as it really was, above it.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Flight, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.missions import reachable_insertion as mission
from orbsoc.missions.reachable_insertion.flight.loop import InsertionLoop
from orbsoc.missions.reachable_insertion.flight.losses import Losses
from orbsoc.missions.reachable_insertion.flight.verdict import OUT_OF_REACH
from orbsoc.missions.reachable_insertion.flight.warm import Belief
from orbsoc.orbit import EARTH
from tests.missions.reachable_insertion.test_losses import by_brute_force

SCENARIOS = Path(__file__).parents[1] / "scenarios"
SEED = 77
TIMING = Timing(0.1)
CHECKED = 5
"""One proof in this number is held against the search on the ground."""


def vehicles() -> list[mission.Scenario]:
    """rec1, rec2 and the rounded data of the paper, each with a dry mass and a latest end of burn."""

    def load(name: str, dry_kg: float, latest_s: float) -> mission.Scenario:
        found = mission.load_scenario(SCENARIOS / f"{name}.toml")
        cycle = {"latest_end_s": latest_s, "period_s": 10.0}
        return found.with_changes(
            problem="min_time", vehicle={"dry_mass_kg": dry_kg}, guidance=cycle, event=None
        )

    return [
        load("rec1_dry", 79500.0, 110.0),
        load("rec2", 79500.0, 110.0),
        load("paper004_insertion_zf196", 76500.0, 150.0),
    ]


def flown(base: InsertionLoop, number: int, computer: Computer, solver: OnboardSolver) -> dict[str, Any]:
    """One loss: time and share are drawn by its number; of one in ten the engine is out."""
    random = np.random.default_rng([SEED, number])
    at_s = float(random.uniform(0.5, 0.9 * base.first.duration_s))
    kept = float(random.uniform(0.0, 1.0)) if number % 10 else 0.0
    scenario = base.scenario.with_changes(event={"at_s": at_s, "thrust_kept": kept})
    loop = replace(base, scenario=scenario, losses=Losses(scenario, base.warm))
    flight = fly(loop, computer, solver, TIMING, seed=5, number=number)
    [event] = [each for each in flight.cycles if each.trigger.urgent]
    decisions = () if event.answer is None else event.answer.decisions
    row = {
        "number": number, "at_s": at_s, "kept": kept, "word": loop.verdict(flight)[0].word.text,
        "computed_ms": event.price.time_ms, "decisions": [[each.sought, each.word] for each in decisions], **flight.outcome,
    }  # fmt: skip
    if kept and not flight.outcome["safe"]:
        highest_m = by_brute_force(as_it_was(loop, flight, event.trigger.at_s))
        row["reachable_perigee_km"] = (highest_m - EARTH.earth_radius_m) / 1e3
    if kept and decisions and decisions[0].word == OUT_OF_REACH and number % CHECKED == 0:
        belief = as_it_was(loop, flight, event.trigger.at_s)
        row["reached_anyway"] = mission.plan(loop.losses.scenario_of(belief, "target")).verified
    return row


def as_it_was(loop: InsertionLoop, flight: Flight, until_s: float) -> Belief:
    """The true vehicle of a flight when its fault was detected."""
    vehicle = loop.vehicle(flight.seed, flight.number)
    starts = [at_s for at_s, _ in flight.programmes]
    for (at_s, programme), end_s in zip(flight.programmes, [*starts[1:], np.inf], strict=True):
        if at_s < until_s:
            vehicle.advance(programme, min(end_s, until_s))
    engine, scenario = vehicle.engine_now(), loop.scenario
    latest_s = scenario.guidance.latest_end_s
    assert latest_s is not None
    left_s = (vehicle.mass_kg - vehicle.dry_kg) / engine.flow_kg_s
    return Belief(until_s, vehicle.state, vehicle.mass_kg, engine, min(left_s, latest_s - until_s))


def summed(rows: list[dict[str, Any]], safe_km: float) -> str:
    """The counts, and every wrong verdict."""
    wrong = [
        row for row in rows if row.get("reached_anyway") or row.get("reachable_perigee_km", 0.0) >= safe_km
    ]
    words = Counter((row["word"], "safe" if row["safe"] else "not safe") for row in rows)
    lines = [f"{len(rows)} losses; wrong: {len(wrong)} {[row['number'] for row in wrong]}"]
    lines += [f"{word}, {safe}: {count}" for (word, safe), count in sorted(words.items())]
    lines.append(f"proofs held against the search: {sum('reached_anyway' in row for row in rows)}")
    times = sorted(row["computed_ms"] for row in rows if row["computed_ms"])
    if times:
        lines.append(f"decision, modelled: p50 {times[len(times) // 2]:.1f}, worst {times[-1]:.1f} ms")
    return "\n".join(lines)


def main() -> None:
    """Fly, or sum up."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("rows", type=Path, nargs="+")
    parser.add_argument("--count", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="with --step, numbers first, first + step, …")
    parser.add_argument("--step", type=int, default=1)
    given = parser.parse_args()
    if given.count:
        [path] = given.rows
        done = (
            {json.loads(line)["number"] for line in path.read_text().splitlines()} if path.exists() else set()
        )
        solver, computer = OnboardSolver(), Computer("zu9eg", "paper")
        loops = [InsertionLoop.of(each, solver) for each in vehicles()]
        with path.open("a") as file:
            for number in range(given.first, given.count, given.step):
                if number not in done:
                    row = flown(loops[number % len(loops)], number, computer, solver)
                    file.write(json.dumps(row) + "\n")
                    file.flush()
    rows = [json.loads(line) for path in given.rows for line in path.read_text().splitlines()]
    sys.stdout.write(summed(rows, 120.0) + "\n")


if __name__ == "__main__":
    main()
