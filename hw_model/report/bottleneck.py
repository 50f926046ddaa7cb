"""The bottleneck: the cause that takes most of a modelled time, and its name for a designer."""

from __future__ import annotations

from collections.abc import Mapping

from hw_model.vocabulary import Cause

_NAMES: dict[Cause, str] = {
    "ps": "the PS core",
    "issue": "the PL's lanes",
    "dependency": "the latency of dependent operations on the PL",
    "bank": "the banks of the PL's storage",
    "divider": "the PL's dividers",
    "write_port": "the write ports of the PL's storage",
    "fetch": "the fetch of microcode",
    "drain": "starting and draining segments",
    "cache": "cache maintenance",
    "link": "the link between PS and PL",
    "interrupt": "the wait for interrupts",
}


def bottleneck_of(causes: Mapping[Cause, int]) -> tuple[Cause, float, str]:
    """The cause with the largest share of the total, that share, and its name; ("ps", 0, …) of nothing."""
    total = sum(causes.values())
    nothing: Cause = "ps"
    cause = max(causes, key=lambda name: causes[name], default=nothing)
    return cause, causes.get(cause, 0) / total if total else 0.0, _NAMES[cause]
