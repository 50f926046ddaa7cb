"""Mutants drawn from the syntax tree of the RTL (scripts/mutate_rtl.py): every file has them, and off they change nothing."""

from __future__ import annotations

import os
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from scripts.mutation.campaign import ELABORATED, files
from scripts.mutation.places import Mutant, mutants_of
from scripts.mutation.schemata import VARIABLE, drawn, with_all, write_alone, write_schemata
from tests.rtl.engine_sources import RTL, build, parameters
from tests.rtl.verilator import require_verilator

VECTORS = "1500"
SIZES = (8, 23)
"""Exponent and fraction of binary32."""


@pytest.fixture(scope="module")
def mutants() -> dict[str, list[Mutant]]:
    return mutants_of(RTL, files())


def test_every_file_of_the_rtl_has_places_for_three_mutants(mutants: dict[str, list[Mutant]]) -> None:
    places = {file: {(mutant.start, mutant.end) for mutant in own} for file, own in mutants.items()}
    assert {file: len(own) for file, own in places.items() if len(own) < 3} == {}


def test_a_draw_has_three_places_of_every_file_and_none_twice(mutants: dict[str, list[Mutant]]) -> None:
    draw = drawn(mutants, seed=5, count=200)
    assert len(draw) == len({(mutant.file, mutant.start, mutant.end) for mutant in draw}) == 200
    assert min(Counter(mutant.file for mutant in draw).values()) == 3
    assert {mutant.file for mutant in draw} == set(mutants)
    assert drawn(mutants, seed=5, count=200) == draw
    assert drawn(mutants, seed=6, count=200) != draw


def test_mutants_within_each_other_are_one_text_with_its_lines_in_place() -> None:
    text = b"assign x = a +\n  (b & c);\n"
    outer = Mutant("", 1, 11, 24, "", "", "a - b")
    inner = Mutant("", 2, 18, 23, "", "", "b | c")
    assert with_all(text, [(1, outer), (2, inner)]).decode() == (
        "assign x = (contract::mutant == 1 ? (a - b) : (a +\n  ((contract::mutant == 2 ? (b | c) : (b & c)))));\n"
    )


def test_a_mutant_of_what_elaboration_reads_is_alone_in_its_copy(
    mutants: dict[str, list[Mutant]], tmp_path: Path
) -> None:
    for file in sorted(ELABORATED):
        mutant = drawn({file: mutants[file]}, seed=1, count=1)[0]
        write_alone(RTL, tmp_path / Path(file).stem, mutant)
        text = (tmp_path / Path(file).stem / file).read_text()
        assert text != (RTL / file).read_text()
        assert mutant.instead in text


def run_units(harness: Path, number: int) -> subprocess.CompletedProcess[str]:
    table = parameters()
    cycles = [str(table[f"F32_{unit}_CYCLES"]) for unit in ("ADD", "MUL", "DIV", "DIV_INTERVAL")]
    command = [harness, *map(str, SIZES), *cycles, VECTORS, "1"]
    return subprocess.run(
        command,
        env=os.environ | {VARIABLE: str(number)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def build_units(rtl: Path) -> Path:
    table = parameters()
    options = {
        f"{unit}_CYCLES": table[f"F32_{unit}_CYCLES"] for unit in ("ADD", "MUL", "DIV", "DIV_INTERVAL")
    }
    return build("units", rtl=rtl, EXP=SIZES[0], MAN=SIZES[1], **options)


def test_off_they_change_no_bit_and_each_that_is_on_is_caught(
    mutants: dict[str, list[Mutant]], tmp_path: Path
) -> None:
    require_verilator()
    units = {file: own for file, own in mutants.items() if file.startswith("fpu/")}
    chosen = dict(enumerate(drawn(units, seed=1, count=0), start=1))
    write_schemata(RTL, tmp_path / "rtl", chosen)
    harness = build_units(tmp_path / "rtl")
    right = run_units(build_units(RTL), 0)
    off = run_units(harness, 0)
    assert (off.returncode, off.stdout) == (right.returncode, right.stdout) == (0, right.stdout)
    caught = {number for number in chosen if run_units(harness, number).returncode == 1}
    assert len(caught) > len(chosen) / 2  # of the rest many change nothing at all
