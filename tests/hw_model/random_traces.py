"""Hypothesis strategies: arbitrary valid traces and computers."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st

from hw_model.platform.platform import Platform, load_platform, platform_names
from hw_model.vocabulary import MODULES, OPCODES

_BUFFERS = ("a", "b", "c", "d", "e")


@st.composite
def stages(draw: st.DrawFn, name: str) -> dict[str, Any]:
    """A stage with any operations, and a chain that no preset makes longer than all of them in a row."""
    names = st.lists(st.sampled_from(_BUFFERS), unique=True, max_size=3)
    codes = draw(st.sets(st.sampled_from(OPCODES), max_size=6))
    operations = {code: draw(st.integers(0, 5000)) if code in codes else 0 for code in OPCODES}
    serial = 6 * sum(operations.values())  # every preset gives each operation 6 cycles or more
    return {
        "module": draw(st.sampled_from(MODULES)),
        "reads": draw(names),
        "writes": draw(names),
        "operations": operations,
        "critical_path": dict.fromkeys(("orbsoc_rtl", "vendor_ip"), draw(st.integers(0, serial))),
    }


@st.composite
def traces(draw: st.DrawFn) -> dict[str, Any]:
    """One or two patterns, one to three solves of up to 12 events."""
    patterns = [
        {
            "n": 1, "p": 0, "m": 2, "cones": {"l": 2, "q": []}, "nnz_kkt": 3, "nnz_l": 2,
            "buffers": {name: draw(st.integers(0, 3000)) for name in _BUFFERS},
            "stages": {name: draw(stages(name)) for name in ("one", "two", "three", "four")},
        }
        for _ in range(draw(st.integers(1, 2)))
    ]  # fmt: skip
    event = st.tuples(st.sampled_from(("one", "two", "three", "four")), st.integers(0, 3))
    solves = [
        {
            "pattern": draw(st.integers(0, len(patterns) - 1)), "status": "SOLVED", "iterations": 3,
            "events": draw(st.lists(event, max_size=12)),
        }
        for _ in range(draw(st.integers(1, 3)))
    ]  # fmt: skip
    return {
        "schema": "orbsoc.trace/2",
        "datapath": draw(st.sampled_from(("f64", "f32"))),
        "patterns": patterns,
        "solves": solves,
    }


@st.composite
def platforms(draw: st.DrawFn) -> Platform:
    """A shipped platform of several cores with other clocks, lanes, dividers and latencies."""
    several = [name for name in platform_names() if load_platform(name).ps.cores.value > 1]
    platform = load_platform(draw(st.sampled_from(several)))
    changes = {
        "ps.clock_mhz": st.floats(1.0, 5000.0),
        "pl.clock_mhz": st.floats(1.0, 1000.0),
        "pl.lanes": st.integers(1, 64),
        "pl.dividers": st.integers(1, 8),
        "pl.overlap_exponent": st.floats(1.0, 64.0),
        "pl.latency_preset": st.sampled_from(("orbsoc_rtl", "vendor_ip")),
    }
    for key, values in changes.items():
        platform = platform.with_value(key, draw(values))
    return platform
