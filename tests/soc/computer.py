"""One small problem and one simulated computer for all tests of this folder."""

from __future__ import annotations

import importlib.util
import os
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.conic.cones import Cones
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine
from orbsoc.hw.workload import Posed
from orbsoc.soc.counted import Counted
from orbsoc.soc.machine import Machine
from orbsoc.soc.program import COMPILER, compiled
from orbsoc.soc.runs import FORM, cache_folder, counted
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).parents[2] / "rtl"
ENGINE = Engine(lanes=1, banks=16)
RATIO, LATENCY = 3.5, 20


def small_problem() -> Problem:
    """Three second-order cones and five nonnegative rows in four variables."""
    random = np.random.default_rng(3)
    offset = np.r_[np.full(5, 3.0), 1.0, 5.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0]
    return Problem(
        c=random.normal(size=4), G=random.normal(size=(14, 4)), h=offset, cones=Cones(l=5, q=[1, 3, 5])
    )


@cache
def small_computer() -> Machine:
    """With the engine that `resident` needs. Its tools are required where Verilator is."""
    require_verilator()
    missing = [] if shutil.which(COMPILER) else [COMPILER]
    if importlib.util.find_spec("pythondata_cpu_rocket") is None:
        missing.append("pythondata-cpu-rocket")
    if missing and os.environ.get("ORBSOC_REQUIRE_RTL") == "1":
        pytest.fail(f"ORBSOC_REQUIRE_RTL=1, but missing: {', '.join(missing)}")
    if missing:
        pytest.skip(f"missing: {', '.join(missing)}")
    problem = small_problem()
    program = compiled(
        Posed(problem, Settings()), RTL, cache_folder(), partition="resident", engine=ENGINE, form=FORM
    )
    return Machine.built(RTL, program.engine, FORM, program.code_lines)


def small_counts(partition: str | None, **options: Any) -> Counted:
    """The small problem on it, under one pair of clocks."""
    machine = small_computer()
    return counted(
        Posed(small_problem(), Settings()), RTL, partition=partition, engine=ENGINE, ratio=RATIO, latency=LATENCY,
        machine_of=lambda _: machine, **options,
    )  # fmt: skip
