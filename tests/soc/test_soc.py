"""The flight code on the core in RTL, alone and with the engine in RTL: the host's bits, and cycles that add up."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.soc.errors import SocError
from orbsoc.soc.machine import Machine
from orbsoc.soc.program import COMPILER, FLAGS
from orbsoc.soc.table import summed
from tests.soc.computer import RATIO, RTL, small_computer, small_counts, small_problem


@pytest.fixture(scope="module")
def machine() -> Machine:
    return small_computer()


def test_both_halves_have_the_hosts_bits_and_their_cycles_add_up() -> None:
    split, alone = small_counts("resident", warm=True), small_counts(None, warm=True)
    for found in (split, alone):
        assert found.same_bits
        assert len(found.verdicts) == 2  # from cold, and from a point nearby
        assert 0 < summed([found])[-1].core_cycles < found.core_cycles
    attempt = next(part for part in split.stages if part.where == "PL")
    assert [place.where for place in split.places] == ["PL", "PL"]
    assert [(part.name, part.runs) for part in split.within] == [("launch", 1), ("interrupt", 1)]
    # The core waits for the engine: its clocks, and what launch and interrupt take.
    assert attempt.pl_cycles * RATIO < attempt.core_cycles < attempt.pl_cycles * RATIO + 3000
    assert all(part.where == "core" for part in alone.stages)
    load = sum(part.core_cycles for part in split.stages if part.name == "load")
    assert split.core_cycles - load < alone.core_cycles


def test_a_stage_on_the_pl_leaves_the_core_its_calls() -> None:
    """Words to and fro and waits lie within a stage of the core, and are counted once."""
    split, alone = small_counts("paper"), small_counts(None)
    there = {part.name: part for part in split.stages if part.where == "PL"}
    of_core = {part.name: part for part in split.stages if part.where == "core"}
    stages_alone = {part.name: part.core_cycles for part in alone.stages}
    assert split.same_bits
    assert {"factorize", "solve_pair"} <= set(there)
    assert (
        0 < of_core["factorize"].core_cycles < min(there["factorize"].core_cycles, stages_alone["factorize"])
    )
    assert 0 < summed([split])[-1].core_cycles < 2 * summed([alone])[-1].core_cycles


@pytest.mark.usefixtures("machine")
@pytest.mark.parametrize("source", ["soc/program/interrupts.c", "driver/orbsoc.c"])
def test_the_handler_of_interrupts_has_no_floating_point(source: str) -> None:
    """So rtl/soc/program/vector.S saves none of its registers."""
    includes = [f"-I{RTL / 'soc' / 'program'}", f"-I{RTL / 'driver'}", f"-I{RTL.parent / 'flight'}"]
    text = subprocess.run(
        [COMPILER, *FLAGS, "-DORBSOC_FP=64", *includes, "-S", "-o", "-", str(RTL / source)],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    instructions = set(re.findall(r"^\t([a-z][a-z0-9.]*)", text, re.MULTILINE))
    assert {"lw", "sw", "ret"} <= instructions
    assert not {name for name in instructions if name.startswith("f") and not name.startswith("fence")}


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
        ("--fault nonsense", "allowed is KIND[:SKIP[:TIMES]]"),
        (
            "--partition none --limit-clocks 9",
            "--limit-clocks = 9: partition 'none' has nothing on the PL to stop",
        ),
        ("--limit-clocks 0", "'--limit-clocks': Input should be greater than or equal to 1"),
        ("--solves 9", "allowed is first, all, or numbers from 1 to 1"),
    ],
)
def test_what_cannot_run_is_told_in_one_line_before_anything_is_simulated(
    arguments: str, allowed: str, tmp_path: Path
) -> None:
    problem = tmp_path / "small.json"
    small_problem().save(problem)
    done = CliRunner().invoke(
        app, ["hw", "soc", str(problem), *arguments.split(), "--out", str(tmp_path / "out")]
    )
    assert done.exit_code == 2
    assert allowed in done.stderr
    assert "simulated" not in done.stderr
