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
    from hw_model.report.run import simulate
    from hw_model.report.speedup import Report, speedup
    from hw_model.timing.jitter import Distribution, distribution
    from hw_model.timing.timeline import Segment, Timeline
    from hw_model.timing.trace import Trace, load_trace, parse_trace

    from .errors import HwModelError, PartitionError, PlatformError, TraceError

_NAMES = {
    "errors": ("HwModelError", "PartitionError", "PlatformError", "TraceError"),
    "timing.jitter": ("Distribution", "distribution"),
    "platform.partition": ("Partition", "load_partition", "partition_names"),
    "platform.platform": ("Platform", "load_platform", "platform_names"),
    "report.run": ("simulate",),
    "report.speedup": ("Report", "speedup"),
    "timing.timeline": ("Segment", "Timeline"),
    "timing.trace": ("Trace", "load_trace", "parse_trace"),
}
_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names}

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
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'hw_model' has no attribute {name!r}")
    return getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
