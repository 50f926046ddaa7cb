"""How the sweep scales: two processes against one, two Dask workers against one, beside pure computation done likewise.

`python -m benchmarks.reach_scaling --out out/reach-bench` sweeps part of the paper's grid in equal shards on one and on
two processes, locally and on an embedded Dask cluster, and after each does as many tasks of plain arithmetic the same
way: what two workers gain there is what this machine has to give at that moment, start of the processes included. A
machine shared with others changes from minute to minute, so all is done by turns, and medians over the rounds count.
Writes reach_scaling.json: seconds, gains, and the sweep's gain over the arithmetic's.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.environment import commit, machine_class
from orbsoc.missions.reachable_domain import load_scenario
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.tasks import grid_shards, solve_grid_shard
from orbsoc.sweep import DaskCluster, Executor, Processes, Report, ShardStore, Task, run
from orbsoc.sweep.executors import Work
from orbsoc.sweep.store import Columns

SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "paper004_reach.toml"
EXECUTORS: dict[str, Callable[[int], Executor]] = {
    "processes": Processes,
    "dask": lambda workers: DaskCluster(None, workers=workers),
}


def arithmetic(payload: dict[str, Any]) -> Columns:
    """`turns` turns of a loop that touches almost no memory."""
    value = 0
    for k in range(payload["turns"]):
        value = (value * 1103515245 + k) & 0x7FFFFFFF
    return {"value": np.array([value])}


def turns_for(seconds: float) -> int:
    """Turns of `arithmetic` that take `seconds` of processor time."""
    turns = 2_000_000
    started = time.process_time()
    arithmetic({"turns": turns})
    return int(turns * seconds / (time.process_time() - started))


def elapsed_s(tasks: list[Task], work: Work, executor: Executor) -> float:
    """Wall-clock time of a sweep into a new folder."""

    def unwatched(_report: Report, _task: Task, _columns: Columns) -> None:
        pass

    with tempfile.TemporaryDirectory() as folder:
        store = ShardStore.open(Path(folder) / "out", {"name": "scaling"}, resume=False)
        started = time.perf_counter()
        run(store, tasks, work, executor, unwatched)
        return time.perf_counter() - started


def measure(shards: int, used: int, rounds: int) -> dict[str, Any]:
    """Sweep the first `used` of the equal shards of the paper's grid, by turns with as much arithmetic."""
    scenario = load_scenario(SCENARIO)
    planes = scenario.grid.inclination_deg.count * scenario.grid.raan_deg.count
    scenario = scenario.with_changes(method={"planes_per_shard": -(-planes // shards)})
    found = list(grid_shards(Domain.of(scenario)))[:used]
    sweep = [Task("points", k, rows, payload) for k, (rows, payload) in enumerate(found)]
    started = time.process_time()
    solve_grid_shard(sweep[0].payload)
    shard_s = time.process_time() - started
    turns = turns_for(shard_s)
    plain = [Task("plain", k, 1, {"turns": turns}) for k in range(used)]
    seconds: dict[str, list[float]] = {}
    for number in range(rounds):
        for name, make in EXECUTORS.items():
            for workers in (1, 2):
                for what, tasks, work in (
                    ("sweep", sweep, solve_grid_shard),
                    ("arithmetic", plain, arithmetic),
                ):
                    taken = elapsed_s(tasks, work, make(workers))
                    seconds.setdefault(f"{name} {what} {workers}", []).append(taken)
                    sys.stderr.write(
                        f"round {number + 1}: {name}, {what}, {workers} workers: {taken:.2f} s\n"
                    )
    gains: dict[str, dict[str, float]] = {}
    for name in EXECUTORS:
        both = {
            what: statistics.median(seconds[f"{name} {what} 1"])
            / statistics.median(seconds[f"{name} {what} 2"])
            for what in ("sweep", "arithmetic")
        }
        gains[name] = {**both, "sweep_over_arithmetic": both["sweep"] / both["arithmetic"]}
    return {
        "machine": machine_class(),
        "commit": commit(),
        "shards": used,
        "rows": sum(task.rows for task in sweep),
        "shard_cpu_s": shard_s,
        "rounds": rounds,
        "elapsed_s": seconds,
        "gain_of_two": gains,
    }


def main() -> None:
    """Measure and write reach_scaling.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--shards", type=int, default=8, help="of the whole grid")
    parser.add_argument("--used", type=int, default=4, help="shards that are swept")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path("out/reach-bench"))
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    found = measure(chosen.shards, chosen.used, chosen.rounds)
    text = json.dumps(found, indent=1) + "\n"
    (chosen.out / "reach_scaling.json").write_text(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
