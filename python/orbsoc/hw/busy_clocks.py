"""For how many clocks of the PL a launch is busy, and for how many it can be: what a limit in the PL is set by."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Literal

from hw_model.timing.control_program import END_CYCLES, FLAG_CYCLES, LAUNCH_CYCLES, RUN_CYCLES
from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.ps.program import BusyClocks, ControlProgram, instruction_clocks
from orbsoc.ps.registers import WORD_MASK
from orbsoc.ps.segments import Method

from .schedules import Engine, pl_program


def busy_clocks(
    problem: Problem,
    settings: Settings,
    engine: Engine | None,
    *,
    form: Literal["flat", "compressed", "in_order"] = "flat",
    streams: Iterable[tuple[str, ...]] = (),
) -> BusyClocks:
    """Clocks for which each launch of a problem's segments is busy on an engine, as the RTL counts them in SPENT. `streams`: the
    segments, where they are not the stages of the six modules.

    Raises `EngineError` for an engine that cannot hold the problem.
    """
    program = pl_program(problem, settings, engine, None, tuple(streams))
    entries = _core.program_image(program.core, form).entries
    names = tuple(streams) or tuple((name,) for name in entries)
    return clocks_of({stages: entries["_".join(stages)][1] for stages in names})


def clocks_of(segments: Mapping[tuple[str, ...], int]) -> BusyClocks:
    """Busy cycles of segments, with those of the operation control."""
    return BusyClocks(segments, LAUNCH_CYCLES, RUN_CYCLES, FLAG_CYCLES, END_CYCLES)


def most_clocks(clocks: BusyClocks, settings: Settings, program: ControlProgram | None = None) -> int:
    """For how many clocks a launch is busy at the most, within a register's 32 bits: the longest segment, or with a control program an
    attempt with all iterations and refinement steps that the settings allow."""
    if program is None:
        return min(max(clocks.segments.values()) + clocks.launch, WORD_MASK)
    longest = 0
    for entry in (program.cold, program.warm):
        one, two = (_attempt(program, entry, clocks, count, settings.refinement_max) for count in (1, 2))
        longest = max(longest, one + (settings.max_iterations - 1) * (two - one))
    return min(longest, WORD_MASK)


def _attempt(program: ControlProgram, at: int, clocks: BusyClocks, iterations: int, refinements: int) -> int:
    """Clocks of an attempt that uses every iteration and refinement step."""
    flags = Method.from_core(_core, resident=True).flags
    total = iteration = refined = 0
    raised = False
    while True:
        instruction = program.instructions[at]
        total += instruction_clocks(instruction, clocks)
        at += 1
        match instruction.op:
            case "end":
                return total
            case "run":
                stage = instruction.stream[-1]
                if stage in flags and flags[stage][0] == "repeat":
                    raised = refined < refinements
                    refined = refined + 1 if raised else 0
                else:
                    iteration += stage == "statistics"
                    raised = stage == "statistics" and iteration > iterations
            case _:
                if raised == (instruction.op == "if"):
                    at = instruction.target
