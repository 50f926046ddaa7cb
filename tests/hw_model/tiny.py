"""A computer with round numbers and a solve of three stages, small enough to be worked out on paper."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hw_model.platform.partition import Partition, parse_partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.synthetic import stage

_PARAMETERS: dict[str, dict[str, float | int | str]] = {
    "ps": {
        "cores": 2, "clock_mhz": 1000.0, "flop_per_cycle": 0.5, "div_f64_cycles": 30, "sqrt_f64_cycles": 20,
        "div_f32_cycles": 15, "sqrt_f32_cycles": 10, "build_flops_per_nonzero": 0.0, "cache_line_bytes": 64,
        "parallel_fraction": 0.5, "fork_join_us": 0.01,
    },
    "pl": {
        "clock_mhz": 100.0, "lanes": 2, "dividers": 1, "banks": 4, "clusters": 1, "microcode_format": "flat",
        "microcode_compression": 1.0, "segment_overhead_cycles": 4, "overlap_exponent": 1.0,
        "storage_memory": "block_ram", "storage_depth": "power_of_two", "microcode_memory": "block_ram",
        "stream_bytes_per_cycle": 8.0, "stream_ports": 1, "stream_start_us": 0.0,
    },
    "link": {
        "register_write_ns": 60.0, "register_read_fixed_ns": 100.0, "register_read_pl_cycles": 10.0,
        "core_write_ns_per_byte": 15.0, "core_write_pl_cycles_per_byte": 0.0,
        "core_read_ns_per_byte": 0.0, "core_read_pl_cycles_per_byte": 5.0,
        "dma_fixed_us": 2.0, "dma_to_pl_bytes_per_pl_cycle": 2.0, "dma_to_ps_bytes_per_pl_cycle": 1.0,
        "port_mb_s": 1000.0, "ddr_efficiency": 0.5, "cache_clean_ns_per_line": 0.0,
        "cache_invalidate_ns_per_line": 0.0, "frame_register_writes": 4,
        "status_register_reads": 1, "flags_per_register": 32, "acknowledge_register_writes": 1,
    },
    "runtime": {
        "completion": "interrupt", "schedule": "serial", "interrupt_entry_us": 1.0, "cores_used": 1,
        "ps_jitter_fraction": 0.5, "link_jitter_fraction": 0.25, "interrupt_jitter_us": 2.0, "jitter_exponent": 1.0,
    },
    "resources": {"lut": 1, "ff": 1, "dsp": 1, "bram36": 1},
}  # fmt: skip
_TEXTS = {
    "ps": 'core = "paper core"',
    "pl": 'latency_preset = "orbsoc_rtl"',
    "link": "",
    "runtime": "",
    "resources": "",
}


def platform_toml(**changes: str) -> str:
    """The round computer as a file; `changes` replace the text of a parameter, e.g. pl_lanes="..."."""
    lines = ['name = "paper_computer"', 'description = "Round numbers"']
    for section, parameters in _PARAMETERS.items():
        lines += [f"[{section}]", _TEXTS[section]]
        for key, value in parameters.items():
            entry = f'{{ value = {json.dumps(value)}, tag = "assumed", source = "round" }}'
            lines.append(f"{key} = {changes.pop(f'{section}_{key}', entry)}")
    assert not changes, changes
    return "\n".join(lines) + "\n"


def tiny_platform(folder: Path, **changes: str) -> Platform:
    """The round computer, loaded."""
    path = folder / "paper_computer.toml"
    path.write_text(platform_toml(**changes), encoding="utf-8")
    return load_platform(path)


def partition_of(*on_pl: str) -> Partition:
    """These modules on the PL, the others on the PS."""
    sides = {module: "pl" if module in on_pl else "ps" for module in PL_MODULES}
    return parse_partition({"name": "+".join(on_pl) or "none", "modules": sides})


def tiny_trace() -> dict[str, Any]:
    """make (PS) → factor (factorization) → check (PS) on a buffer of 100 words and one of 2."""
    stages = {
        "make": stage("ps", "v", "v", 70, mul=10),
        "factor": stage("factorization", "v", "w", 100, mul_sub=9, select=1, div=2),
        "check": stage("ps", "w", "r", 40, compare=3, div=1),
    }
    pattern = {
        "n": 2, "p": 0, "m": 3, "cones": {"l": 0, "q": [3]}, "nnz_kkt": 5, "nnz_l": 4,
        "buffers": {"v": 100, "w": 2, "r": 1}, "stages": stages,
    }  # fmt: skip
    solve = {
        "pattern": 0, "status": "SOLVED", "iterations": 1, "events": [["make", 0], ["factor", 1], ["check", 1]],
    }  # fmt: skip
    return {"schema": "orbsoc.trace/2", "datapath": "f64", "patterns": [pattern], "solves": [solve]}
