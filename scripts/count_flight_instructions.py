"""Count the instructions of each stage of the library in C on aarch64, over data sets of one pattern, under QEMU.

    python scripts/count_flight_instructions.py [--sets 50]

The pattern is that of rec1's subproblems. Prints, for each stage, its runs and the least and most instructions of one.
Needs gcc, gcc-aarch64-linux-gnu and qemu-user.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from benchmarks.recorded import first_insertions
from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.flight.selftest import given_data
from tests.flight.c_library import FLIGHT, ROOT, STRICT, sources, write_pattern

AFTER = 1000
"""The mark after a stage, as in tests/flight/count_stages.c."""


def counted(folder: Path, sets: int) -> dict[str, list[int]]:
    """Instructions of each run of each stage."""
    problems = first_insertions(12, sets)
    tables = write_pattern(folder, problems[0], Settings(), 64)
    with (folder / "data").open("wb") as file:
        for problem in problems:
            for name in "pagcbh":
                file.write(given_data(problem)[name].tobytes())
    macros = ["-DORBSOC_FP=64", f"-DORBSOC_INDEX_BITS={tables.index_bits}"]
    own = [str(folder / "pattern.c"), str(ROOT / "tests" / "flight" / "count_stages.c")]
    options = [*STRICT[1:], "-O2", "-static", *macros, f"-I{FLIGHT}", f"-I{folder}"]
    program, plugin, marks = folder / "program", folder / "count.so", folder / "marks"
    subprocess.run(
        ["aarch64-linux-gnu-gcc", *options, *own, *map(str, sources()), "-lm", "-o", str(program)], check=True
    )
    source = str(ROOT / "scripts" / "count_instructions.c")
    subprocess.run(["gcc", "-shared", "-fPIC", "-O2", source, "-o", str(plugin)], check=True)
    subprocess.run(["qemu-aarch64", "-plugin", f"{plugin},out={marks}", program, folder / "data"], check=True)
    names, found, begun = list(_core.stages()), defaultdict(list), (0, 0)
    for line in marks.read_text().splitlines():
        kind, number, executed = line.split()[:3]
        if kind != "mark":
            continue
        if int(number) == AFTER:
            found[names[begun[0]]].append(int(executed) - begun[1])
        else:
            begun = int(number), int(executed)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sets", type=int, default=50)
    with tempfile.TemporaryDirectory() as folder:
        found = counted(Path(folder), parser.parse_args().sets)
    sys.stdout.write("| stage | runs | least | most | spread |\n|---|---|---|---|---|\n")
    for stage, runs in found.items():
        least, most = min(runs), max(runs)
        sys.stdout.write(
            f"| {stage} | {len(runs)} | {least} | {most} | {100 * (most - least) / most:.2f} % |\n"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
