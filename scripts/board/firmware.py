"""The program in the board's block RAM: the flight code of a problem in binary32, its self-test, and the report around it."""

from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path

import numpy as np

from orbsoc.conic.cones import Cones
from orbsoc.conic.problem import Problem
from orbsoc.flight.export import default_settings, export_c
from orbsoc.flight.selftest import record
from orbsoc.hw.schedules import Engine
from orbsoc.orbit.relative.clohessy_wiltshire import ClohessyWiltshire
from orbsoc.soc.errors import SocError
from orbsoc.soc.program import COMPILER, Target, linked
from scripts.record_synthesis import ROOT

ENGINE = Engine(fp=32, lanes=1, banks=4, address_bits=11)
CODE_BITS = 14
"""Of the engine in rtl/board/board.sv: 2^14 lines of microcode."""
PROGRAM = ROOT / "rtl" / "board" / "program"
PICORV32 = Target(
    (
        "--specs=picolibc.specs", "-O2", "-march=rv32im", "-mabi=ilp32", "-nostartfiles", "-ffp-contract=off", "-fno-math-errno",
        "-ffunction-sections", "-fdata-sections", "-DPICOLIBC_INTEGER_PRINTF_SCANF", "-Wl,--gc-sections", "-Wl,--no-warn-rwx-segments",
    ),
    ("main", "orbsoc_solve", "orbsoc_attach"),
    4,
)  # fmt: skip
"""The core has no floating point: its operations are libgcc's, which round as the standard says."""
_HASH, _PRIME = 2166136261, 16777619
"""FNV-1a of 32 bits."""


def rendezvous() -> Problem:
    """Three impulses that end a drift, an eighth of an orbit apart, and the least sum of their magnitudes.

    In the orbit's plane, Clohessy-Wiltshire: 1 km behind a target, at rest, to the target, at rest. Times are radians of the
    orbit, distances km. Variables (t, Δv_R, Δv_T) of each impulse with ‖Δv‖ ≤ t; 4 equalities, 3 cones of 3.
    """
    motion, plane = ClohessyWiltshire(1.0), np.ix_([0, 1, 3, 4], [0, 1, 3, 4])
    times = np.linspace(0.0, 0.5 * np.pi, 3)
    start = np.array([0.0, -1.0, 0.0, 0.0])
    A, cost = np.zeros((4, 9)), np.zeros(9)
    for k, time in enumerate(times):
        A[:, 3 * k + 1 : 3 * k + 3] = motion.transition(times[-1], time)[plane][:, 2:]
        cost[3 * k] = 1.0
    return Problem(
        c=cost,
        A=A,
        b=-motion.transition(times[-1], 0.0)[plane] @ start,
        G=-np.eye(9),
        h=np.zeros(9),
        cones=Cones(q=[3, 3, 3]),
    )


def firmware(problem: Problem, image: Path) -> None:
    """Write the image of a problem's program as `$readmemh` takes it, 32 bits a line.

    Raises SocError without a compiler, where the program is larger than the block RAM or the microcode's memory, and what
    `export_c` raises.
    """
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "program"
        export_c(problem, folder, fp=ENGINE.fp, partition="resident", engine=ENGINE, form="compressed")
        found = re.search(r"program_microcode, (\d+)u,", (folder / "pl_program.c").read_text())
        assert found
        if int(found[1]) > 1 << CODE_BITS:
            raise SocError(f"the problem takes {found[1]} lines of microcode: allowed is {1 << CODE_BITS}")
        sources = [*folder.glob("*.c"), *folder.glob("*/*.c"), *PROGRAM.glob("*.c"), PROGRAM / "start.S"]
        compile_program(folder, sorted(sources), image, ["-DORBSOC_SHORT_SELFTEST", "-DORBSOC_COLD_SELFTEST"])


def compile_program(folder: Path, sources: list[Path], image: Path, defines: list[str]) -> None:
    """A program for the board from its sources, with headers in `folder`, which takes what is made on the way. Raises SocError."""
    if shutil.which(COMPILER) is None:
        raise SocError(
            f"{COMPILER} is not installed: apt-get install gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf"
        )
    given = [f"-DORBSOC_FP={ENGINE.fp}", *defines]
    linked(folder, sources, PROGRAM / "link.ld", given, image, on_pl=True, target=PICORV32)


def answer_hash(problem: Problem) -> str:
    """Of the host's own answer, as the board prints it: FNV-1a of the bits of x, y, z and s, low bytes first."""
    cold = record(problem, default_settings(ENGINE.fp), ENGINE.fp)[0].solution
    found = _HASH
    for byte in np.concatenate([cold.x, cold.y, cold.z, cold.s]).astype("<f8").tobytes():
        found = (found ^ byte) * _PRIME & 0xFFFFFFFF
    return f"{found:08x}"
