"""Modelled time of a recorded solve on a computer of one PS and one PL.

`simulate` and `speedup` are pure functions of (trace, platform, partition). Nothing here solves anything,
and no result of it is a measurement. docs/hardware-model.md states the formulas and what they leave out.

    report = hw_model.speedup(trace, "zu9eg", "paper", deadline_ms=50.0)
    print(report.to_markdown())

Names are imported when they are first used, so that `import hw_model` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition, load_partition, partition_names
    from hw_model.platform.platform import Platform, load_platform, platform_names
    from hw_model.report.speedup import Report, speedup
    from hw_model.timing.jitter import Distribution, distribution
    from hw_model.timing.timeline import Segment, Timeline, simulate
    from hw_model.timing.trace import Trace, load_trace, parse_trace

    from .errors import HwModelError, PartitionError, PlatformError, TraceError

_HOME = {
    "HwModelError": "errors",
    "PartitionError": "errors",
    "PlatformError": "errors",
    "TraceError": "errors",
    "Distribution": "timing.jitter",
    "distribution": "timing.jitter",
    "Partition": "platform.partition",
    "load_partition": "platform.partition",
    "partition_names": "platform.partition",
    "Platform": "platform.platform",
    "load_platform": "platform.platform",
    "platform_names": "platform.platform",
    "Report": "report.speedup",
    "speedup": "report.speedup",
    "Segment": "timing.timeline",
    "Timeline": "timing.timeline",
    "simulate": "timing.timeline",
    "Trace": "timing.trace",
    "load_trace": "timing.trace",
    "parse_trace": "timing.trace",
}

__all__ = [
    "Distribution",
    "HwModelError",
    "Partition",
    "PartitionError",
    "Platform",
    "PlatformError",
    "Report",
    "Segment",
    "Timeline",
    "Trace",
    "TraceError",
    "distribution",
    "load_partition",
    "load_platform",
    "load_trace",
    "parse_trace",
    "partition_names",
    "platform_names",
    "simulate",
    "speedup",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'hw_model' has no attribute {name!r}")
    return getattr(import_module(f".{_HOME[name]}", __name__), name)
