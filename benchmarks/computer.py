"""Every mission's conic solves on the emulated computer, against the cores of the same chip; all modelled, nothing measured.

`python -m benchmarks.computer --out out/computer` plans a scenario of each mission, schedules its solves on a few engines in
two orders of elimination, and takes for each partition the fastest that fits the device, at the device's clock and at
150 MHz. The PS alone is priced by operations and by executed instructions, in the order that it is fastest in. Writes
computer-DEVICE.json and .md. What a scenario gave is kept: a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.measure import geometric_mean
from hw_model.area.budget import budget
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.report.bands import band_of
from hw_model.report.run import durations_of
from hw_model.report.study import Study
from hw_model.timing.actions import actions_of
from hw_model.timing.ps import PRICES
from hw_model.timing.timeline import lay_out, makespan_picoseconds, tally_of
from hw_model.vocabulary import PICOSECONDS_PER_MS
from orbsoc.files.json_fields import write_json
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.workload import load_workload

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"
WORKLOADS = {
    "passive safety": "paper000_1.toml",
    "fly-around": "paper001_fewest.toml",
    "platform launch": "paper002.toml",
    "phasing": "paper003_socp.toml",
    "insertion": "rec1.toml",
    "insertion, two burns": "raise_two_burns.toml",
    "reachable domain, a point": "paper004_reach.toml",
    "rendezvous, 40 steps": "rendezvous_40.json",
}
ORDERINGS = ("amd", "nested_dissection")
ENGINES = {
    "4 lanes": {"pl.lanes": 4, "pl.dividers": 2, "pl.banks": 16},
    "8 lanes": {"pl.lanes": 8, "pl.dividers": 2, "pl.banks": 32},
    "16 lanes, 8 clusters": {"pl.lanes": 16, "pl.dividers": 4, "pl.banks": 32, "pl.clusters": 8},
}
PARTITIONS = ("paper", "resident")
FORMATS = ("compressed", "flat")
MEMORIES = {
    "block RAM": {},
    "start streamed": {"pl.microcode_memory": "streamed_start"},
    "start streamed, exact depth": {"pl.microcode_memory": "streamed_start", "pl.storage_depth": "exact"},
    "streamed, exact depth": {"pl.microcode_memory": "streamed", "pl.storage_depth": "exact"},
    "streamed by {ports} ports, exact depth": {
        "pl.microcode_memory": "streamed",
        "pl.storage_depth": "exact",
    },
}
"""A start that is streamed and exact depth are priced without RTL. `ports`: as many as a line of the engine has words of 64 bits, 4 at most."""
YARDSTICK_MHZ = 150.0


def main() -> None:
    """Price all, or go on where an earlier run stopped."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/computer"))
    parser.add_argument("--device", default="zu9eg")
    parser.add_argument("--clock-mhz", type=float, nargs="*", help="of the PL; the device's and 150")
    given = parser.parse_args()
    kept = given.out / f"computer-{given.device}.json"
    rows: list[dict[str, Any]] = json.loads(kept.read_text())["rows"] if kept.exists() else []
    base = load_platform(given.device)
    clocks = dict.fromkeys(given.clock_mhz or (base.pl.clock_mhz.value, YARDSTICK_MHZ))
    given.out.mkdir(parents=True, exist_ok=True)
    for name, scenario in WORKLOADS.items():
        done = {row["pl_clock_mhz"] for row in rows if row["mission"] == name}
        if missing := [mhz for mhz in clocks if mhz not in done]:
            rows += priced(name, SCENARIOS / scenario, base, missing)
            write_json({"provenance": "modelled", "rows": rows}, kept)
            sys.stderr.write(f"{name}, {time.process_time():.0f} s of processor time\n")
    text = "\n".join(line for mhz in clocks for line in table(rows, mhz))
    (given.out / f"computer-{given.device}.md").write_text(text)
    sys.stdout.write(text)


class Ordered:
    """A workload solved in one order of elimination; its schedules are made once for all clocks and partitions."""

    def __init__(self, scenario: Path, ordering: str) -> None:
        self.ordering = ordering
        self.work = load_workload(scenario, ordering)
        self.cycles = exact_cycles(self.work.problems, (), self.work.settings)
        self.study = Study(self.work.trace, self.cycles)
        self.partitions = {name: load_partition(name) for name in PARTITIONS}
        self.actions = {name: actions_of(self.work.trace, self.partitions[name]) for name in PARTITIONS}
        self.tallies = {name: tally_of(actions) for name, actions in self.actions.items()}

    def ms(self, platform: Platform, name: str) -> float:
        """Nominal time of a partition; infinite if its engine does not fit."""
        trace, split = self.work.trace, self.partitions[name]
        if not budget(trace, platform, split, self.cycles).fits:
            return math.inf
        durations = durations_of(trace, platform, split, self.cycles)
        return (
            makespan_picoseconds(self.actions[name], durations, tally=self.tallies[name]) / PICOSECONDS_PER_MS
        )

    def bound(self, platform: Platform, name: str) -> str:
        """The two causes that take most of the time."""
        durations = durations_of(self.work.trace, platform, self.partitions[name], self.cycles)
        causes = {
            cause: ps for (cause,), ps in lay_out(self.actions[name], durations, name).totals("cause").items()
        }
        (first, second) = sorted(causes, key=lambda cause: -causes[cause])[:2]
        total = sum(causes.values())
        return ", ".join(f"{cause} {100 * causes[cause] / total:.0f} %" for cause in (first, second))


def priced(name: str, scenario: Path, base: Platform, clocks: Sequence[float]) -> Iterator[dict[str, Any]]:
    """A row for each partition: the fastest order, engine, format and memory of those that fit; None where none does."""
    works = [Ordered(scenario, ordering) for ordering in ORDERINGS]
    for mhz, partition in product(clocks, PARTITIONS):
        designs = [
            (work.ms(platform, partition), f"{words}, {work.ordering}", work, platform)
            for work in works
            for words, platform in engines(base, mhz)
        ]
        best_ms, design, work, platform = min(designs, key=lambda one: one[0])
        solves = work.work.trace.solves
        row: dict[str, Any] = {
            "mission": name, "partition": partition, "pl_clock_mhz": mhz, "design": None,
            "solves": len(solves), "iterations": sum(solve.iterations for solve in solves),
        }  # fmt: skip
        if math.isfinite(best_ms):
            row |= {"design": design, "bound": work.bound(platform, partition)}
            for price in PRICES:
                row[price] = compared(works, work, platform.with_value("ps.price", price), partition)
        yield row


def engines(base: Platform, mhz: float) -> Iterator[tuple[str, Platform]]:
    """Each engine with each place for its microcode, in words."""
    for (engine, shape), form, (memory, places) in product(ENGINES.items(), FORMATS, MEMORIES.items()):
        clock = {} if mhz == base.pl.clock_mhz.value else {"pl.clock_mhz": mhz}  # the device's own has a band
        ports = min(4, shape["pl.lanes"] // 2)
        several = {"pl.stream_ports": ports} if "{ports}" in memory else {}
        settings = shape | places | clock | several | {"pl.microcode_format": form}
        yield f"{engine}, {form}, {memory.format(ports=ports)}", base.with_values(settings)


def compared(works: Sequence[Ordered], work: Ordered, platform: Platform, name: str) -> dict[str, Any]:
    """Times at one price of the PS's work, and the PS alone in the order in which that is fastest."""
    (point,) = work.study.points(platform, [work.partitions[name]])
    alone = min(
        (each.study.points(platform, [load_partition("all_ps")])[0].times_ms for each in works),
        key=lambda times: times[0],
    )
    ratio = band_of([slow / fast for slow, fast in zip(alone, point.times_ms, strict=True)])
    return {
        "ms": point.times_ms[0], "ps_ms": alone[0], "speedup": [ratio.low, ratio.nominal, ratio.high],
        "energy_mj": point.energy.nominal_mj,
    }  # fmt: skip


def table(rows: list[dict[str, Any]], mhz: float) -> list[str]:
    """Markdown of one clock, with geometric means."""
    lines = [
        f"PL at {mhz:g} MHz:", "",
        "| mission | solves | iterations | partition | design | ms | PS alone, ms, by operations | by instructions | × by operations | × by instructions | most time |",
        "|---|--:|--:|---|---|--:|--:|--:|--:|--:|---|",
    ]  # fmt: skip
    chosen = [row for row in rows if row["pl_clock_mhz"] == mhz]
    for row in chosen:
        start = f"| {row['mission']} | {row['solves']} | {row['iterations']} | `{row['partition']}` |"
        if row["design"] is None:
            lines.append(f"{start} none fits | | | | | | |")
            continue
        one, two = (row[price] for price in PRICES)
        lines.append(
            f"{start} {row['design']} | {one['ms']:.3f} | {one['ps_ms']:.3f} | {two['ps_ms']:.3f}"
            f" | {_ratio(one)} | {_ratio(two)} | {row['bound']} |"
        )
    for partition in PARTITIONS:
        of = [row for row in chosen if row["partition"] == partition and row["design"]]
        means = (geometric_mean([row[price]["speedup"][1] for row in of]) for price in PRICES)
        lines.append(
            f"| geometric mean of {len(of)} | | | `{partition}` | | | | | {' | '.join(f'{mean:.2f}' for mean in means)} | |"
        )
    return [*lines, ""]


def _ratio(price: dict[str, Any]) -> str:
    low, nominal, high = price["speedup"]
    return f"{nominal:.2f} ({low:.2f}–{high:.2f})"


if __name__ == "__main__":
    main()
