"""Exact schedules for the hardware model: the bridge from `pl_program` to `hw_model.schedules`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hw_model.schedules import Engine, Schedule, scheduled
from hw_model.stage_cycles import PlCycles, StageCycles, estimated

if TYPE_CHECKING:
    from hw_model import Platform, Trace
    from orbsoc.problem import Problem


def exact_cycles(problems: Sequence[Problem]) -> StageCycles:
    """Cycles of the stages of a trace whose patterns are those of `problems`, in its order.

    They equal the RTL's, cycle for cycle. Latencies that are not the RTL's have no schedule: the estimate answers
    for those, and a report says so stage by stage. Raises `pl_program.EngineError` for an engine that cannot exist.
    """

    def source(pattern: int, stage: str, engine: Engine) -> Schedule:
        from orbsoc.pl_program import Engine as Parameters
        from orbsoc.pl_program import pl_program

        parameters = Parameters(
            fp=64 if engine.datapath == "f64" else 32,
            lanes=engine.lanes,
            dividers=engine.dividers,
            banks=engine.banks,
        )
        found = pl_program(problems[pattern], None, parameters).segments[stage]
        return Schedule(found.causes, found.lower_bound, found.bottleneck)

    exact = scheduled(source)

    def choose(trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
        of_the_rtl = platform.pl.latency_preset == "orbsoc_rtl"
        return (exact if of_the_rtl else estimated)(trace, platform, pattern, stage)

    return choose
