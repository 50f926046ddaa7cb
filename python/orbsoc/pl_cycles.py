"""Exact cycles of the PL's stages for the hardware model, in place of its estimate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from orbsoc.pl_program import Engine, Segment, pl_program

if TYPE_CHECKING:
    from hw_model.platform import Platform
    from hw_model.stage_cycles import PlCycles, StageCycles
    from hw_model.trace import Trace
    from hw_model.vocabulary import PlCause
    from orbsoc.problem import Problem

EXACT_PRESET = "orbsoc_rtl"
"""The latency preset that is the RTL's: only for it is there anything to be exact about."""


def scheduled_cycles(problems: Sequence[Problem]) -> StageCycles:
    """Cycles from schedules, where `problems` has one for a trace's pattern; from the estimate elsewhere.

    An engine of other latencies than the RTL's is estimated, too, and so is a trace that came from a file.
    """

    known: dict[tuple[int, Engine], Mapping[str, Segment]] = {}

    def cycles(trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
        from hw_model.stage_cycles import PlCycles, estimated

        if pattern >= len(problems) or platform.pl.latency_preset != EXACT_PRESET:
            return estimated(trace, platform, pattern, stage)
        engine = Engine(
            fp=64 if trace.datapath == "f64" else 32,
            lanes=platform.pl.lanes.value,
            dividers=platform.pl.dividers.value,
            banks=platform.pl.banks.value,
        )
        if (pattern, engine) not in known:
            known[pattern, engine] = pl_program(problems[pattern], None, engine).segments
        segment = known[pattern, engine][stage]
        return PlCycles(causes(segment), segment.lower_bound, segment.bottleneck, "schedule")

    return cycles


def causes(segment: Segment) -> dict[PlCause, int]:
    """A segment's cycles in the hardware model's words; they sum to its cycles."""
    found = segment.causes
    return {
        "issue": found["issue"],
        "dependency": found["dependency"],
        "bank": found["read_port"],
        "divider": found["divider"],
        "write_port": found["write_port"] + found["result"],
        "fetch": found["fetch"],
        "drain": found["startup"] + found["drain"] + found["finish"],
    }
