"""Throughput of the fly-around's bounds, small conic problems of one pattern, on the emulated computer; all modelled.

`python -m benchmarks.throughput` records the solves of `paper001_fewest.toml`, keeps those of its most frequent pattern, and
prices them with some copies interleaved in each stream under resident control, against the cores of the chip at the price
by executed instructions, a problem on each. Both come from a platform with `pl.interleaved`, as for any command.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from itertools import cycle, islice

from hw_model.area.budget import budget
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import load_platform
from hw_model.report.throughput import IN_FLIGHT, throughputs
from hw_model.timing.trace import Trace
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.workload import Workload, load_workload

SCENARIO = "scenarios/paper001_fewest.toml"
SOLVES = 213
"""That the certificate of the paper's case takes."""
ENGINES = {
    "8 lanes, 2 dividers": {"pl.lanes": 8, "pl.dividers": 2, "pl.banks": 32},
    "16 lanes, 2 dividers, 8 clusters": {"pl.lanes": 16, "pl.dividers": 2, "pl.banks": 32, "pl.clusters": 8},
    "16 lanes, 4 dividers, 8 clusters": {"pl.lanes": 16, "pl.dividers": 4, "pl.banks": 32, "pl.clusters": 8},
}
COPIES = (1, 2, 4, 8, 16)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--device", default="zu9eg")
    parser.add_argument("--clock-mhz", type=float, default=150.0)
    given = parser.parse_args()
    work = load_workload(SCENARIO)
    trace, pattern = most_frequent(work)
    base = load_platform(given.device)
    resident, alone = load_partition("resident"), load_partition("all_ps")
    sys.stdout.write(
        f"{SOLVES} solves, PL at {given.clock_mhz:g} MHz, {base.pl.microcode_format.value} microcode\n\n"
        "| engine | copies | solves/s with "
        + " | ".join(f"{count} in flight" for count in IN_FLIGHT)
        + " | at most | bound by | cores alone | ratio | fits |\n|---|"
        + "--:|" * (len(IN_FLIGHT) + 2)
        + "---|--:|--:|---|\n"
    )
    for name, shape in ENGINES.items():
        more = {"pl.clock_mhz": given.clock_mhz, "ps.price": "executed_instructions"}
        for copies in COPIES:
            platform = base.with_values(shape | more | {"pl.interleaved": copies})
            cycles = exact_cycles(work.problems[pattern : pattern + 1], (), work.settings[pattern:])
            found = throughputs(trace, platform, resident, alone, cycles)
            area = budget(trace, platform, resident, cycles)
            most = max(area.uses, key=lambda use: use.used / use.available if use.available else 0.0)
            last = found[-1]
            rates = " | ".join(f"{each.solves_per_s:.0f}" for each in found)
            sys.stdout.write(
                f"| {name} | {copies} | {rates} | {last.most_per_s:.0f} | {last.busiest.upper()}"
                f" | {last.baseline_per_s:.0f} | {last.gain:.2f} | {'yes' if area.fits else 'no'}: {most.kind} {100 * most.used / most.available:.0f} % |\n"
            )
            sys.stdout.flush()


def most_frequent(work: Workload) -> tuple[Trace, int]:
    """The solves of the pattern that most of them have, repeated up to `SOLVES`, and its number."""
    ((pattern, _),) = Counter(solve.pattern for solve in work.trace.solves).most_common(1)
    of_it = (solve for solve in work.trace.solves if solve.pattern == pattern)
    solves = tuple(solve.model_copy(update={"pattern": 0}) for solve in of_it)
    kept = {"patterns": (work.trace.patterns[pattern],), "solves": tuple(islice(cycle(solves), SOLVES))}
    return work.trace.model_copy(update=kept), pattern


if __name__ == "__main__":
    main()
