"""What the hardware model says that a solve on the RTL takes, in clocks of the simulation.

The L2 model knows nothing of the run but its trace: which stages ran, in order. It counts the time of every frame, flag
read, move and interrupt on the harness's platform (rtl/harness/platform.toml), and takes the segments' cycles from
their schedules.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hw_model import load_platform
from hw_model.report.run import simulate
from hw_model.timing.control_program import members
from hw_model.timing.stage_cycles import PlCycles
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import WORD_BYTES
from orbsoc.hw.schedules import Engine

if TYPE_CHECKING:
    from hw_model import Platform, Trace

PLATFORM = Path("harness") / "platform.toml"
_PICOSECONDS_PER_CLOCK = 10_000


def session_platform(rtl: Path, engine: Engine) -> Platform:
    """The platform of a session on `engine`; a word crosses in one clock to the PL, in five to the PS."""
    word_bytes = WORD_BYTES["f64" if engine.fp == 64 else "f32"]
    return load_platform(rtl / PLATFORM).with_values(
        {
            "pl.lanes": engine.lanes,
            "pl.dividers": engine.dividers,
            "pl.banks": engine.banks,
            "pl.clusters": engine.clusters,
            "link.dma_to_pl_bytes_per_pl_cycle": float(word_bytes),
            "link.dma_to_ps_bytes_per_pl_cycle": word_bytes / 5,
        }
    )


def predicted_clocks(
    trace: Mapping[str, Any], cycles: Mapping[str, int], rtl: Path, engine: Engine, partition: str = "paper"
) -> dict[str, int]:
    """Clocks by cause of all solves of `trace`, without the PS's own work; `cycles` of each segment by its name."""
    parsed = parse_trace({**trace, "datapath": "f64" if engine.fp == 64 else "f32"})

    def source(_: Trace, __: Platform, ___: int, stage: str) -> PlCycles:
        return PlCycles({"issue": cycles["_".join(members(stage))]}, 0, "schedule", "schedule")

    timeline = simulate(parsed, session_platform(rtl, engine), partition, source)
    by_cause = {cause: picoseconds for (cause,), picoseconds in timeline.totals("cause").items()}
    del by_cause["ps"]
    return {
        "pl" if cause == "issue" else cause: round(picoseconds / _PICOSECONDS_PER_CLOCK)
        for cause, picoseconds in by_cause.items()
    }
