"""Several programs in one memory of microcode: the driver in C on a board that Python plays, and on the RTL."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import pytest

import orbsoc.rtl.solve as rtl_solve
from orbsoc import _core
from orbsoc.conic.problem import Cones, Problem
from orbsoc.hw.schedules import pl_program
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import TABLE, TABLE_ENTRY, Entry, Module, Region
from orbsoc.ps.segments import Method
from orbsoc.rtl.solve import solve_on_rtl
from orbsoc.rtl.solve_cases import TIGHT
from orbsoc.rtl.validation import problems
from tests.ps.fake_engine import METHOD
from tests.rtl.axi_session import AxiSession, CDriver, built_behind_axi
from tests.rtl.c_driver import (
    DRIVER,
    IDENTITY,
    NOT_AT_REST,
    OK,
    OUT_OF_RANGE,
    WRONG_ENGINE,
    WRONG_PROGRAM,
    c_segment,
    library,
)
from tests.rtl.engine_sources import RTL
from tests.rtl.test_axi_solve import ONE_LANE
from tests.rtl.test_driver import LITERALS, EngineBoard, image
from tests.rtl.verilator import require_verilator


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return library(tmp_path_factory.mktemp("driver"))


def lines(count: int, mark: int) -> list[list[int]]:
    """Of microcode, each piece another."""
    return [[mark + 16 * line + piece for piece in range(4)] for line in range(count)]


def starts(board: EngineBoard) -> list[int]:
    """Of the segments in the table, as last written."""
    found = dict(board.tables)
    return [found[TABLE + TABLE_ENTRY * each.number + Entry.START] for each in METHOD.segments]


def test_programs_lie_beside_each_other_and_a_switch_writes_no_microcode(made: Path) -> None:
    board, first, second = EngineBoard(made), image(lines(3, 0x1000)), image(lines(4, 0x2000))
    a, b = ctypes.byref(first), ctypes.byref(second)
    assert board.call("load", a) == OK
    assert board.call("load_beside", b) == OK
    own = [0 if each.module is Module.PS else each.number for each in METHOD.segments]
    moved = [0 if each.module is Module.PS else each.number + 3 for each in METHOD.segments]
    of_stages = [k for k, each in enumerate(METHOD.segments) if each.module is not Module.PS]
    assert [starts(board)[k] for k in of_stages] == [moved[k] for k in of_stages]
    memory = dict(board.memories[Region.MICROCODE])
    assert memory == dict(enumerate([*lines(3, 0x1000), *lines(4, 0x2000)]))
    for which, wanted in ((a, own), (b, moved), (a, own)):
        board.memories[Region.MICROCODE].clear()
        board.memories[Region.STORAGE].clear()
        resets, board.tables = board.resets, []
        assert board.call("switch", which) == OK
        assert board.memories[Region.MICROCODE] == {}
        assert board.words(Region.STORAGE) == LITERALS
        assert board.words(Region.TEMPLATES) == {0: 7, 1: 8, 2: 9}
        assert [starts(board)[k] for k in of_stages] == [wanted[k] for k in of_stages]
        assert board.resets == resets + 1


def test_a_program_that_is_not_there_or_does_not_fit_is_refused(made: Path) -> None:
    board, three, four, two = (
        EngineBoard(made),
        image(lines(3, 0)),
        image(lines(4, 0x100)),
        image(lines(2, 0x200)),
    )
    assert board.call("switch", ctypes.byref(three)) == WRONG_PROGRAM
    assert board.call("load_beside", ctypes.byref(three)) == OK
    assert board.call("load_beside", ctypes.byref(four)) == OK
    assert board.call("load_beside", ctypes.byref(two)) == OUT_OF_RANGE  # of eight lines one is left
    assert board.call("load_beside", ctypes.byref(image(identity=IDENTITY ^ 1))) == WRONG_ENGINE
    assert board.call("switch", ctypes.byref(four)) == OK
    assert board.call("load", ctypes.byref(two)) == OK  # over the first lines of `three`
    assert board.call("switch", ctypes.byref(three)) == WRONG_PROGRAM
    assert board.call("switch", ctypes.byref(four)) == OK
    assert board.call("load", ctypes.byref(image(lines(9, 0)))) == OUT_OF_RANGE
    assert board.call("switch", ctypes.byref(two)) == OK
    assert board.open() == OK  # whatever the memories hold
    assert board.call("switch", ctypes.byref(two)) == WRONG_PROGRAM


def test_a_program_is_loaded_again_in_its_place(made: Path) -> None:
    board, three, four = EngineBoard(made), image(lines(3, 0)), image(lines(4, 0x100))
    for _ in range(3):
        for each in (three, four):
            assert board.call("load_beside", ctypes.byref(each)) == OK
    assert sorted(board.memories[Region.MICROCODE]) == list(range(7))


@pytest.mark.parametrize("region", [Region.MICROCODE, Region.TEMPLATES, Region.STORAGE])
def test_a_bit_lost_on_the_way_to_another_place_is_noticed(made: Path, region: Region) -> None:
    board, first, second = EngineBoard(made), image(lines(3, 0)), image(lines(4, 0x100))
    assert board.call("load", ctypes.byref(first)) == OK
    at = region + {Region.MICROCODE: 16 * 5, Region.TEMPLATES: 4, Region.STORAGE: 8 * 3}[region]
    board.spoil = lambda offset, value: (offset, value ^ (offset == at))
    assert board.call("load_beside", ctypes.byref(second)) == WRONG_PROGRAM
    assert board.call("switch", ctypes.byref(second)) == WRONG_PROGRAM
    switched = board.call("switch", ctypes.byref(first))
    assert switched == (OK if region is Region.MICROCODE else WRONG_PROGRAM)


def test_nothing_moves_while_a_launch_is_out(made: Path) -> None:
    board, first = EngineBoard(made), image()
    assert board.call("load", ctypes.byref(first)) == OK
    segment = next(each for each in METHOD.segments if each.stage == "scale")
    assert board.call("publish", 0, ctypes.byref(c_segment(METHOD.segments[0]))) == OK
    assert board.call("launch", segment.number, ctypes.byref(c_segment(segment))) == OK
    for name in ("load_beside", "switch"):
        assert board.call(name, ctypes.byref(first)) == NOT_AT_REST


TINY = problems()["1 variable, 2 rows"]
OTHER = Problem(c=[1, 2], A=[[1, 1]], b=[1], G=[[-1, 0], [0, -1]], h=[0, 0], cones=Cones(l=2))


MUTATIONS = {
    "starts without the first line": ("if (segment.module != ORBSOC_MODULE_PS) segment.start += pl->first;", ""),
    "lines over another program's": ("const int taken = overlaps(&pl->resident[i], first, image->lines);", "const int taken = 0;"),
    "overwritten programs remembered": ("if (pl->resident[i].image != image && !overlaps(", "if (pl->resident[i].image != image || overlaps("),
    "a digest of lines from 0 on": ("if (first == 0) return image->digest;", "if (first < 1000000u) return image->digest;"),
    "a switch without a reset": ("\n  orbsoc_pl_error found = orbsoc_pl_reset(pl);", "\n  orbsoc_pl_error found = ORBSOC_PL_OK;"),
    "a switch without templates": ("  found = load_templates(pl, image);\n  return found", "  return found"),
    "programs kept over an opening": ("  pl->residents = 0;\n", ""),
    "a switch during a launch": ("  uint32_t at = 0;\n  if (pl->out) return ORBSOC_PL_NOT_AT_REST;\n", "  uint32_t at = 0;\n"),
}  # fmt: skip
CHECKS = (
    test_programs_lie_beside_each_other_and_a_switch_writes_no_microcode,
    test_a_program_that_is_not_there_or_does_not_fit_is_refused,
    test_a_program_is_loaded_again_in_its_place, test_nothing_moves_while_a_launch_is_out,
)  # fmt: skip


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mutation_of_what_keeps_programs_apart_is_caught(name: str, tmp_path: Path) -> None:
    right, wrong = MUTATIONS[name]
    source = (DRIVER / "orbsoc.c").read_text()
    assert source.count(right) == 1
    made = library(tmp_path, source.replace(right, wrong))
    assert any(fails(check, made) for check in CHECKS)


def fails(check: Callable[[Path], None], made: Path) -> bool:
    try:
        check(made)
    except AssertionError:
        return True
    return False


class SharedSession(AxiSession):
    """Another problem's program is there first; the own one is loaded beside it, and switched from and to."""

    clocks_of: ClassVar[dict[str, int]] = {}

    def load(self, image: _core.ProgramImage, method: Method, program: ControlProgram | None = None) -> None:
        assert program is not None
        other = pl_program(OTHER, TIGHT, ONE_LANE, None, program.streams)
        self.give(_core.program_image(other.core, "flat"), method, program)
        self._timed("load other", "beside")
        self.ask("image_next")
        self.give(image, method, program)
        self._timed("load own", "beside")
        self._timed("switch to other", "switch 0")
        self._timed("switch to own", "switch 1")

    def _timed(self, what: str, command: str) -> None:
        before = self.clocks()
        assert self.driver(command) == OK
        self.clocks_of[what] = self.clocks() - before


def test_a_solve_of_a_program_that_was_switched_to_has_every_word(monkeypatch: pytest.MonkeyPatch) -> None:
    require_verilator()
    monkeypatch.setattr(rtl_solve, "built", built_behind_axi)
    monkeypatch.setattr(rtl_solve, "RtlSession", SharedSession)
    monkeypatch.setattr(rtl_solve, "Driver", CDriver)
    outcome = solve_on_rtl(RTL, "tiny", TINY, TIGHT, engine=ONE_LANE, resident=True)
    assert (outcome.status, outcome.different_words, outcome.busy_error_cycles) == ("SOLVED", 0, 0)
    clocks = SharedSession.clocks_of
    assert 10 * clocks["switch to own"] < clocks["load own"], clocks
