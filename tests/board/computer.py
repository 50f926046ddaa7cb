"""The board's computer in Verilator, for all tests of this folder."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from orbsoc.soc.program import COMPILER
from scripts.routing.modules import source_of
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).parents[2] / "rtl"
CLOCKS = 8
"""Of a bit on the serial line: fewer than on the board, for the simulation's sake."""


@cache
def harness() -> Path:
    """The executable. Its tools are required where Verilator is."""
    require_verilator()
    missing = [] if shutil.which(COMPILER) else [COMPILER]
    if importlib.util.find_spec("pythondata_cpu_picorv32") is None:
        missing.append("pythondata-cpu-picorv32 of requirements/route.txt")
    if missing and os.environ.get("ORBSOC_REQUIRE_ROUTE") == "1":
        pytest.fail(f"ORBSOC_REQUIRE_ROUTE=1, but missing: {', '.join(missing)}")
    if missing:
        pytest.skip(f"missing: {', '.join(missing)}")
    done = subprocess.run(
        ["sh", RTL / "build.sh", "board", f"-GCLOCKS={CLOCKS}"],
        env=os.environ | {"ORBSOC_PICORV32": str(source_of("picorv32_axi").folder)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return Path(done.stdout.strip().splitlines()[-1])


def printed(folder: Path, limit: int, runs: int = 1) -> tuple[int, list[str]]:
    """Exit status of the harness, and the lines over the serial line, with the image memory.hex of a folder."""
    done = subprocess.run(
        [harness(), str(limit), str(CLOCKS), str(runs)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout.splitlines()
