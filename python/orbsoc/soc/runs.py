"""Counted runs: a problem on the simulated computer, kept under what it was made from, so that a run is simulated once."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path

from orbsoc import _core
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.ps.segments import Method
from orbsoc.rtl.validation import Format

from .counted import Counted, parsed
from .faults import PATIENCE_ROUNDS, Fault
from .machine import Machine
from .program import Program, compiled

FORM: Format = "compressed"
"""Of microcode: its lines are a power of two of words, so the DMA moves them in one run."""


def cache_folder() -> Path:
    """Images and the consoles of finished runs; beside the models of rtl/build.sh."""
    home = Path(os.environ.get("XDG_CACHE_HOME", "") or Path.home() / ".cache")
    return Path(os.environ.get("ORBSOC_RTL_CACHE", "") or home / "orbsoc" / "rtl") / "soc-runs"


def stage_names() -> tuple[str, ...]:
    """Of the method, by their numbers in the flight code."""
    return tuple(segment.stage for segment in Method.from_core(_core).segments)[1:]


def counted(
    posed: Posed,
    rtl: Path,
    *,
    partition: str | None,
    engine: Engine,
    ratio: float,
    latency: int,
    fault: Fault | None = None,
    patience: int = PATIENCE_ROUNDS,
    limit_clocks: int | None = None,
    warm: bool = False,
    order: int = 0,
    tell: Callable[[str], None] = lambda line: None,
    machine_of: Callable[[Program], Machine] | None = None,
) -> Counted:
    """The solve from cold by its flight code, counted; then, with `warm`, one from a point nearby.

    `partition`: None for the core alone. `patience`: rounds of a launch where there is a `fault`.
    `limit_clocks`: of the PL, after which it stops a launch; the program's own by default. `order`: of the program's files (`compiled`). `tell` is called with a line on each step. `machine_of`: another way to a machine than
    `Machine.built`, for a run of the core alone on one that has an engine. Raises SocError, and what exporting raises.
    """
    cache = cache_folder()
    tell("compile the program")
    program = compiled(
        posed, rtl, cache, partition=partition, engine=engine, form=FORM,
        patience=patience if fault else None, limit_clocks=limit_clocks, warm=warm, order=order,
    )  # fmt: skip
    tell("build the computer, minutes the first time")
    machine = (
        machine_of(program) if machine_of else Machine.built(rtl, program.engine, FORM, program.code_lines)
    )
    conditions = f"{ratio:g}-{latency}" + (f"-{str(fault).replace(':', '-')}" if fault else "")
    console = cache / f"run-{program.key}-{machine.harness.name}-{conditions}.txt"
    if console.exists():
        tell("this run was simulated before")
        return parsed(console.read_text().splitlines(), stage_names())
    lines = lines_of(machine.run(program.image, ratio=ratio, latency=latency, fault=fault), tell)
    found = parsed(lines, stage_names())
    temporary = console.with_suffix(f".{os.getpid()}")
    temporary.write_text("\n".join(lines) + "\n")
    temporary.replace(console)
    return found


def lines_of(console: Iterable[str], tell: Callable[[str], None]) -> list[str]:
    """What the program and the harness print, but for the lines on how far the run is, which are told."""
    lines = []
    for line in console:
        if line.startswith("@"):
            tell(f"simulated {int(line[1:]) / 1e6:.1f} million clocks of the core")
        else:
            lines.append(line)
    return lines
