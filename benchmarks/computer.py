"""Every mission's conic solves on the emulated computer, against the cores of the same chip; all modelled, nothing measured.

`python -m benchmarks.computer --out out/computer` plans a scenario of each mission, schedules its solves on a few engines in
two orders of elimination, and takes for each partition the fastest that fits the device, at the device's clock and at
150 MHz. The PS alone is priced by operations and by executed instructions. Writes computer.json and computer.md. What a
scenario gave is kept: a run that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any

from benchmarks.measure import geometric_mean
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.report.speedup import Report, speedup
from hw_model.report.study import Study
from orbsoc.files.json_fields import write_json
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.workload import Workload, load_workload

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
MEMORIES = ("block_ram", "streamed_start")
YARDSTICK_MHZ = 150.0


def main() -> None:
    """Price all, or go on where an earlier run stopped."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/computer"))
    parser.add_argument("--device", default="zu9eg")
    given = parser.parse_args()
    kept = given.out / "computer.json"
    rows: list[dict[str, Any]] = json.loads(kept.read_text()) if kept.exists() else []
    clock = load_platform(given.device).pl.clock_mhz.value
    given.out.mkdir(parents=True, exist_ok=True)
    for name, scenario in WORKLOADS.items():
        for mhz in dict.fromkeys((clock, YARDSTICK_MHZ)):
            if not any(row["mission"] == name and row["pl_clock_mhz"] == mhz for row in rows):
                rows += priced(name, SCENARIOS / scenario, given.device, mhz)
                write_json(rows, kept)
                sys.stderr.write(f"{name}, {mhz:g} MHz\n")
    text = "\n".join(line for mhz in dict.fromkeys((clock, YARDSTICK_MHZ)) for line in table(rows, mhz))
    (given.out / "computer.md").write_text(text)
    sys.stdout.write(text)


def priced(name: str, scenario: Path, device: str, mhz: float) -> Iterator[dict[str, Any]]:
    """A row for each partition: the fastest order, engine, format and memory of those that fit; None where none does."""
    works = {ordering: load_workload(scenario, ordering) for ordering in ORDERINGS}
    for partition in PARTITIONS:
        best = min(
            candidates(works, partition, load_platform(device), mhz), default=None, key=lambda one: one[0]
        )
        work = works["amd"]
        row: dict[str, Any] = {
            "mission": name, "origin": work.origin, "partition": partition, "pl_clock_mhz": mhz, "design": None,
        }  # fmt: skip
        if best is not None:
            _, design, report = best
            row |= {"design": design, "bottleneck": report.bottleneck, "energy_mj": report.energy.nominal_mj}
            for key, price in zip(("operations", "executed"), report.prices, strict=False):
                row[key] = {
                    "ms": price.makespan_ms.nominal, "ps_ms": price.baseline_ms.nominal,
                    "speedup": [price.speedup.low, price.speedup.nominal, price.speedup.high],
                }  # fmt: skip
        yield row


def candidates(
    works: dict[str, Workload], name: str, base: Platform, mhz: float
) -> Iterator[tuple[float, str, Report]]:
    """Nominal time, design in words and report of each that fits."""
    partition = load_partition(name)
    for (ordering, work), (engine, shape) in product(works.items(), ENGINES.items()):
        cycles = exact_cycles(work.problems, (), work.settings)
        study = Study(work.trace, cycles)
        for form, memory in product(FORMATS, MEMORIES):
            more = {"pl.clock_mhz": mhz, "pl.microcode_format": form, "pl.microcode_memory": memory}
            platform = base.with_values(shape | more)
            (point,) = study.points(platform, [partition])
            if point.budget.fits:
                words = f"{engine}, {form}, {memory}, {ordering}"
                yield point.times_ms[0], words, speedup(work.trace, platform, partition, cycles=cycles)


def table(rows: list[dict[str, Any]], mhz: float) -> list[str]:
    """Markdown of one clock, with geometric means."""
    lines = [
        f"PL at {mhz:g} MHz:", "",
        "| mission | partition | design | ms | PS alone, ms by operations | by instructions | × by operations | × by instructions | most time |",
        "|---|---|---|--:|--:|--:|--:|--:|---|",
    ]  # fmt: skip
    chosen = [row for row in rows if row["pl_clock_mhz"] == mhz]
    for row in chosen:
        if row["design"] is None:
            lines.append(f"| {row['mission']} | `{row['partition']}` | none fits | | | | | | |")
            continue
        one, two = row["operations"], row.get("executed", row["operations"])
        lines.append(
            f"| {row['mission']} | `{row['partition']}` | {row['design']} | {one['ms']:.3f} | {one['ps_ms']:.3f}"
            f" | {two['ps_ms']:.3f} | {_ratio(one)} | {_ratio(two)} | {row['bottleneck']} |"
        )
    for partition in PARTITIONS:
        of = [row for row in chosen if row["partition"] == partition and row["design"]]
        means = (
            geometric_mean([row[key]["speedup"][1] for row in of if key in row])
            for key in ("operations", "executed")
        )
        lines.append(
            f"| geometric mean | `{partition}` | | | | | {' | '.join(f'{mean:.2f}' for mean in means)} | |"
        )
    return [*lines, ""]


def _ratio(price: dict[str, Any]) -> str:
    low, nominal, high = price["speedup"]
    return f"{nominal:.2f} ({low:.2f}–{high:.2f})"


if __name__ == "__main__":
    main()
