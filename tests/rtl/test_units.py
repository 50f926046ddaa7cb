"""The floating-point units against the host's IEEE 754 arithmetic, bit for bit (a NaN as the canonical NaN).

A seeded subset by default; `make units` runs a million vectors per operation and format.
"""

from __future__ import annotations

import os
import re
import subprocess

import pytest

from tests.rtl.engine_sources import build, parameters
from tests.rtl.verilator import require_verilator

VECTORS = int(os.environ.get("ORBSOC_UNIT_VECTORS", "40000"))
FORMATS = {"f64": (11, 52), "f32": (8, 23), "(8,15)": (8, 15)}
if VECTORS >= 1_000_000:  # `make units`
    FORMATS |= {"(8,7)": (8, 7), "(5,10)": (5, 10), "(6,9)": (6, 9)}
UNITS = ("ADD", "MUL", "DIV", "DIV_INTERVAL")
LINE = re.compile(
    r"unit (\w+) vectors (\d+) mismatches (\d+) nan (\d+) infinite (\d+) subnormal (\d+) zero (\d+)"
)


def run_units(name: str, vectors: int, seed: int, **wrong: int) -> subprocess.CompletedProcess[str]:
    """The harness on one format; `wrong` overrides a latency that the harness expects."""
    exp, man = FORMATS[name]
    table = parameters()
    if f"{name.upper()}_ADD_CYCLES" in table:
        cycles = {unit: table[f"{name.upper()}_{unit}_CYCLES"] for unit in UNITS}
    else:
        cycles = {"ADD": 7, "MUL": 8, "DIV": (man + 18) // 2, "DIV_INTERVAL": 1 + man % 4}
    options = {f"{unit}_CYCLES": value for unit, value in cycles.items()}
    executable = build("units", EXP=exp, MAN=man, **options)
    expected = {**cycles, **wrong}
    arguments = [exp, man, *(expected[unit] for unit in UNITS), vectors, seed]
    return subprocess.run([executable, *map(str, arguments)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("name", FORMATS)
def test_units_are_ieee_754(name: str) -> None:
    require_verilator()
    done = run_units(name, VECTORS, seed=2025)
    rows = {row[0]: tuple(map(int, row[1:])) for row in LINE.findall(done.stdout)}
    assert done.returncode == 0, done.stdout
    assert set(rows) == {"add", "sub", "mul", "div", "sqrt", "less"}
    for operation, (vectors, mismatches, nan, infinite, subnormal, zero) in rows.items():
        assert (vectors, mismatches) == (VECTORS, 0), operation
        if operation in ("add", "sub", "mul", "div"):
            assert min(nan, infinite, subnormal) > 200, operation  # the vectors reach every corner
            assert zero > 5, operation


@pytest.mark.parametrize(
    ("unit", "operation", "off"),
    [("ADD", "add", 1), ("ADD", "sub", -1), ("MUL", "mul", 1), ("MUL", "mul", -1), ("DIV", "div", -1)],
)
def test_a_result_one_cycle_off_is_a_mismatch(unit: str, operation: str, off: int) -> None:
    require_verilator()
    right = parameters()[f"F32_{unit}_CYCLES"]
    done = run_units("f32", 2_000, seed=1, **{unit: right + off})
    mismatches = {row[0]: int(row[2]) for row in LINE.findall(done.stdout)}
    assert done.returncode == 1
    assert mismatches[operation] > 0
