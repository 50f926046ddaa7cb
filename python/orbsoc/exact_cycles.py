"""Exact schedules for the hardware model: the bridge from `pl_program` to `hw_model.schedules` and its unit tracks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hw_model.schedules import Engine, Schedule, engine_of, scheduled
from hw_model.stage_cycles import Microcode, StageCycles
from hw_model.unit_schedules import UnitSchedule, UnitSchedules

if TYPE_CHECKING:
    from hw_model import Platform, Trace
    from orbsoc.pl_program import PlProgram
    from orbsoc.problem import Problem


def exact_cycles(problems: Sequence[Problem]) -> StageCycles:
    """Cycles of the stages of a trace whose patterns are those of `problems`, in its order.

    They equal the RTL's, cycle for cycle, in the microcode's format that the platform names. Raises
    `hw_model.HwModelError` for latencies that are not the RTL's, for which there is no schedule, and
    `pl_program.EngineError` for an engine that cannot exist.
    """

    def source(pattern: int, stage: str, engine: Engine) -> Schedule:
        found = _program(problems[pattern], engine).segments[stage]
        causes, bits = found.causes, found.flat_bits
        if engine.compressed:
            causes, bits = found.compressed_causes, found.compressed_bits
        return Schedule(
            causes, found.lower_bound, found.bottleneck, Microcode(found.words, found.flat_bits, bits)
        )

    return scheduled(source)


def exact_units(problems: Sequence[Problem]) -> UnitSchedules:
    """What every lane and divider executes in the same segments. Raises as `exact_cycles` does."""

    def look_up(trace: Trace, platform: Platform, pattern: int, stage: str) -> UnitSchedule:
        engine = engine_of(platform, trace.datapath)
        program = _program(problems[pattern], engine)
        began, units, operations = program.core.issues(stage, "compressed" if engine.compressed else "flat")
        startup = program.segments[stage].causes["startup"]
        return UnitSchedule(
            engine.lanes,
            began.astype(int) + startup,
            units,
            operations,
            tuple(program.core.operation_names()),
        )

    return look_up


def _program(problem: Problem, engine: Engine) -> PlProgram:
    from orbsoc.pl_program import Engine as Parameters
    from orbsoc.pl_program import pl_program

    parameters = Parameters(
        fp=64 if engine.datapath == "f64" else 32,
        lanes=engine.lanes,
        dividers=engine.dividers,
        banks=engine.banks,
    )
    return pl_program(problem, None, parameters)
