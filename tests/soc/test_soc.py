"""The flight code on the core in RTL, alone and with the engine in RTL: the host's bits, and cycles that add up."""

from __future__ import annotations

import importlib.util
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.conic.cones import Cones
from orbsoc.conic.problem import Problem
from orbsoc.hw.schedules import Engine
from orbsoc.soc.counted import Counted
from orbsoc.soc.machine import Machine, SocError
from orbsoc.soc.program import COMPILER, compiled
from orbsoc.soc.runs import FORM, cache_folder, counted
from orbsoc.soc.table import summed
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).parents[2] / "rtl"
ENGINE = Engine(lanes=1, banks=16)
RATIO, LATENCY = 3.5, 20


def _problem() -> Problem:
    """Three second-order cones and five nonnegative rows in four variables."""
    random = np.random.default_rng(3)
    offset = np.r_[np.full(5, 3.0), 1.0, 5.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0, 0.0]
    return Problem(
        c=random.normal(size=4), G=random.normal(size=(14, 4)), h=offset, cones=Cones(l=5, q=[1, 3, 5])
    )


@pytest.fixture(scope="module")
def machine() -> Machine:
    """One computer for all tests: with the engine that `resident` needs. Its tools are required where Verilator is."""
    require_verilator()
    missing = [] if shutil.which(COMPILER) else [COMPILER]
    if importlib.util.find_spec("pythondata_cpu_rocket") is None:
        missing.append("pythondata-cpu-rocket")
    if missing and os.environ.get("ORBSOC_REQUIRE_RTL") == "1":
        pytest.fail(f"ORBSOC_REQUIRE_RTL=1, but missing: {', '.join(missing)}")
    if missing:
        pytest.skip(f"missing: {', '.join(missing)}")
    program = compiled(_problem(), None, RTL, cache_folder(), partition="resident", engine=ENGINE, form=FORM)
    return Machine.built(RTL, program.engine, FORM, program.code_lines)


def _counted(machine: Machine, partition: str | None) -> Counted:
    return counted(
        _problem(),
        RTL,
        partition=partition,
        engine=ENGINE,
        ratio=RATIO,
        latency=LATENCY,
        machine_of=lambda _: machine,
    )


def test_both_halves_have_the_hosts_bits_and_their_cycles_add_up(machine: Machine) -> None:
    split, alone = _counted(machine, "resident"), _counted(machine, None)
    for found in (split, alone):
        assert found.same_bits
        assert len(found.verdicts) == 2  # from cold, and from a point nearby
        assert 0 < summed([found])[-1].core_cycles < found.core_cycles
    attempt = next(part for part in split.stages if part.where == "PL")
    # The core waits for the engine: its clocks, and what launch and polls take.
    assert attempt.pl_cycles * RATIO < attempt.core_cycles < attempt.pl_cycles * RATIO + 3000
    assert all(part.where == "core" for part in alone.stages)
    load = sum(part.core_cycles for part in split.stages if part.name == "load")
    assert split.core_cycles - load < alone.core_cycles


def test_a_program_that_never_ends_is_told(machine: Machine, tmp_path: Path) -> None:
    image = tmp_path / "loop.hex"
    image.write_text("0000006f0000006f\n" * 8)  # j .
    with pytest.raises(SocError, match="its limit of clocks"):
        list(machine.run(image, ratio=1.0, latency=0, limit=20_000))


@pytest.mark.usefixtures("machine")
@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        ("--lanes 64", "`lanes` = 64: allowed is 1 to 16"),
        ("--banks 5", "`banks` = 5: allowed is a power of two from 2 to 64"),
        ("--partition paper_streams", '`streams` = "iteration" has no program in C'),
        ("--partition nonsense", "known: all_ps, factor_only, paper"),
        ("--solves 9", "allowed is first, all, or numbers from 1 to 1"),
    ],
)
def test_what_cannot_run_is_told_in_one_line_before_anything_is_simulated(
    arguments: str, allowed: str, tmp_path: Path
) -> None:
    problem = tmp_path / "small.json"
    _problem().save(problem)
    done = CliRunner().invoke(
        app, ["hw", "soc", str(problem), *arguments.split(), "--out", str(tmp_path / "out")]
    )
    assert done.exit_code == 2
    assert allowed in done.stderr
    assert "simulated" not in done.stderr
