"""Many flights of one scenario: coarse tasks on the executors of `sweep`, each flight with the bits that it has alone.

A shard has a few dozen flights, so that a run that is killed loses little. Every flight is also flown without re-planning, by the same
vehicle with the same errors.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.closed_loop import ClosedLoop
from orbsoc.guidance.scenario_file import BaseScenario
from orbsoc.missions.registry import flyable, made_scenario
from orbsoc.solving.bundle import versions
from orbsoc.sweep.executors import Executor
from orbsoc.sweep.runner import Report, Watcher, run
from orbsoc.sweep.store import Columns, ShardStore, Task

from .computer import Computer
from .loop import Fate, Flight, Timing, fly
from .solver import OnboardSolver

DATASET = "flights"
MOST_ROWS = 50
"""Flights of a shard."""
LEAST_SHARDS = 60
"""Of a run, where it has as many flights: two workers then lose 3.3 % at most."""
WITHOUT = "without_"
"""Prefix of the figures of the same flight without re-planning."""


@dataclass(frozen=True, slots=True)
class Study:
    """What is flown: the scenario as a document, the computer, what time an answer has, how many flights from which seed."""

    scenario: dict[str, Any]
    device: str
    partition: str
    slower: float
    timing: Timing
    runs: int
    seed: int

    def document(self) -> dict[str, Any]:
        """What a results folder belongs to; another version is another study."""
        return {"name": self.scenario["name"], **asdict(self), "versions": versions()}

    def tasks(self) -> list[Task]:
        """Shards of at most `MOST_ROWS` flights, numbered from 1: flight 0 has no error that is drawn once."""
        rows = max(1, min(MOST_ROWS, self.runs // LEAST_SHARDS))
        shared = json.dumps({k: v for k, v in asdict(self).items() if k != "runs"}, sort_keys=True)
        firsts = range(1, self.runs + 1, rows)
        return [
            Task(DATASET, k, count, {"study": shared, "first": first, "count": count})
            for k, first in enumerate(firsts)
            if (count := min(rows, self.runs + 1 - first))
        ]


@lru_cache(maxsize=2)
def _ready(study: str) -> tuple[ClosedLoop, Computer, OnboardSolver, Timing, int]:
    """Of one study, once a process: the plan on the ground, the patterns, the schedules."""
    given = json.loads(study)
    _, scenario = made_scenario(given["scenario"])
    solver = OnboardSolver()
    loop = flyable(scenario).closed_loop(scenario, solver)
    computer = Computer(given["device"], given["partition"], given["slower"])
    return loop, computer, solver, Timing(**given["timing"]), given["seed"]


def fly_shard(payload: dict[str, Any]) -> Columns:
    """The work of a task: flights `first` to `first` + `count` − 1 as columns."""
    loop, computer, solver, timing, seed = _ready(payload["study"])
    rows = []
    for number in range(payload["first"], payload["first"] + payload["count"]):
        flight = fly(loop, computer, solver, timing, seed=seed, number=number)
        still = fly(loop, None, solver, timing, seed=seed, number=number)
        rows.append(_row(flight, still))
    return _columns(rows)


def _row(flight: Flight, still: Flight) -> dict[str, Any]:
    computed = [each for each in flight.cycles if each.solves]
    return {
        "flight": flight.number,
        **flight.outcome,
        **{f"{WITHOUT}{name}": value for name, value in still.outcome.items()},
        "replans": flight.replans,
        "lost": flight.lost,
        "late": sum(each.fate is Fate.LATE for each in flight.cycles),
        "unanswered": sum(each.fate is Fate.NO_ANSWER for each in flight.cycles),
        "counted": sum(each.counted for each in computed),
        "longest_ms": 1e3 * flight.longest_s,
        "at_s": [each.trigger.at_s for each in computed],
        "computed_ms": [each.price.time_ms for each in computed],
        "pl_cycles": [float(each.price.pl_cycles) for each in computed],
    }


def _columns(rows: list[dict[str, Any]]) -> dict[str, NDArray[Any]]:
    found: dict[str, NDArray[Any]] = {}
    for name, value in rows[0].items():
        if isinstance(value, list):
            found[name] = np.empty(len(rows), dtype=object)
            for k, row in enumerate(rows):
                found[name][k] = np.array(row[name])
        else:
            found[name] = np.array([row[name] for row in rows])
    return found


def fly_many(study: Study, folder: Path, executor: Executor, watch: Watcher, *, resume: bool) -> Report:
    """Fly what the folder lacks. Raises what the sweep raises; finished shards stay."""
    store = ShardStore.open(folder, study.document(), resume=resume)
    return run(store, study.tasks(), fly_shard, executor, watch)


def read_flights(folder: Path) -> dict[str, NDArray[Any]]:
    """All finished flights, in order of their numbers."""
    return ShardStore.load(folder).read(DATASET)


def quantiles(values: NDArray[Any]) -> dict[str, float]:
    """Least, median, 99 % and worst, each a value that occurred."""
    ordered = np.sort(np.asarray(values, np.float64))
    at = [0, *(min(ordered.size - 1, int(np.ceil(share * ordered.size)) - 1) for share in (0.5, 0.99)), -1]
    names = ("least", "p50", "p99", "worst")
    return {name: float(ordered[max(k, -1)]) for name, k in zip(names, at, strict=True)}


def by_mission_time(found: Mapping[str, NDArray[Any]]) -> Iterator[tuple[float, NDArray[Any]]]:
    """Computation times (ms) of all flights that began at the same time, ascending; times are told to the tenth of a second."""
    at = np.round(np.concatenate([each for each in found["at_s"] if each is not None]), 1)
    took = np.concatenate([each for each in found["computed_ms"] if each is not None])
    for time_s in np.unique(at):
        yield float(time_s), took[at == time_s]


@dataclass(frozen=True, slots=True)
class DelayRow:
    """What flights cost on average on a computer of some speed: more of what they spend, `spent`, than with answers at once, and how
    many end well."""

    slower: float
    computed_ms: float
    spent: str
    more_spent: float
    on_target: float
    lost: float


SPENT = {"propellant_kg": "propellant (kg)", "delta_v_m_s": "velocity change (m/s)"}
"""What flights spend, by the first of these figures that they end with."""
DELAYS = (0.0, 1.0, 10.0, 100.0, 300.0, 1000.0)
"""Speeds that are compared, as times as slow as the computer."""
COMPARED = 24
"""Flights of each."""


def cost_of_delay(study: Study, heard: Callable[[], None] = lambda: None) -> list[DelayRow]:
    """The first flights again with answers at once and on slower and slower computers; without a window, so that late ones fly late."""
    shared = json.loads(study.tasks()[0].payload["study"])
    loop, computer, solver, given, seed = _ready(json.dumps(shared, sort_keys=True))
    timing = Timing(given.allowance_s, inf)
    rows: list[DelayRow] = []
    spent = next(name for name in SPENT if name in loop.columns)
    least: NDArray[Any] | None = None
    for slower in DELAYS:
        flights = []
        for number in range(1, min(study.runs, COMPARED) + 1):
            heard()
            flights.append(
                fly(loop, computer.at(slower * computer.slower), solver, timing, seed=seed, number=number)
            )
        used = np.array([each.outcome[spent] for each in flights])
        least = used if least is None else least
        times = [1e3 * c.price.time_s for each in flights for c in each.cycles if c.solves]
        rows.append(
            DelayRow(
                slower,
                float(np.median(times)) if times else 0.0,
                SPENT[spent],
                float(np.mean(used - least)),
                float(np.mean([each.outcome["on_target"] for each in flights])),
                float(np.mean([each.lost for each in flights])),
            )
        )
    return rows


def summary(study: Study, scenario: BaseScenario, found: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """Of all flights: how they ended with and without re-planning, and what the computer took."""
    loop_columns = [name for name in found if f"{WITHOUT}{name}" in found]
    took = np.concatenate([each for each in found["computed_ms"] if each is not None])
    return {
        "mission": scenario.mission,
        "name": scenario.name,
        "runs": study.runs,
        "seed": study.seed,
        "device": study.device,
        "partition": study.partition,
        "times_as_slow": study.slower,
        "window_ms": None if study.timing.window_s is None else 1e3 * study.timing.window_s,
        "on_target": int(found["on_target"].sum()),
        "on_target_without_replanning": int(found[f"{WITHOUT}on_target"].sum()),
        "replans": {"fewest": int(found["replans"].min()), "total": int(found["replans"].sum())},
        "lost": int(found["lost"].sum()),
        "unanswered": int(found["unanswered"].sum()),
        "computed": int(took.size),
        "outer_loop_counted": int(found["counted"].sum()),
        "computed_ms": quantiles(took) if took.size else {},
        "ends": {
            name: {"with": _spread(found[name]), "without": _spread(found[f"{WITHOUT}{name}"])}
            for name in loop_columns
            if name != "on_target"
        },
        "scenario": study.scenario,
        "versions": versions(),
    }


def _spread(values: NDArray[Any]) -> dict[str, float]:
    return {
        "mean": float(values.mean()),
        "std": float(values.std()) if np.ptp(values) else 0.0,
        "least": float(values.min()),
        "largest": float(values.max()),
    }
