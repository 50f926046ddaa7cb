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
    from .errors import HwModelError, PartitionError, PlatformError, TraceError
    from .jitter import Distribution, distribution
    from .partition import Partition, load_partition, partition_names
    from .platform import Platform, load_platform, platform_names
    from .report import Report, speedup
    from .timeline import Segment, Timeline, simulate
    from .trace import Trace, load_trace, parse_trace

_HOME = {
    "HwModelError": "errors",
    "PartitionError": "errors",
    "PlatformError": "errors",
    "TraceError": "errors",
    "Distribution": "jitter",
    "distribution": "jitter",
    "Partition": "partition",
    "load_partition": "partition",
    "partition_names": "partition",
    "Platform": "platform",
    "load_platform": "platform",
    "platform_names": "platform",
    "Report": "report",
    "speedup": "report",
    "Segment": "timeline",
    "Timeline": "timeline",
    "simulate": "timeline",
    "Trace": "trace",
    "load_trace": "trace",
    "parse_trace": "trace",
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
