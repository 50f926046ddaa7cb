"""The schedules of real problems on the RTL: equal cycles, equal words, on every sequencer."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine, Stream, scheduled
from orbsoc.rtl import validation as rtl_validation
from orbsoc.rtl.validation import (
    MODULES,
    Point,
    RtlError,
    built,
    problems,
    quick_points,
    run,
    summary,
    validate,
)
from tests.rtl.verilator import require_verilator

RTL = Path(__file__).parents[2] / "rtl"
SMALL = "6 variables, cones 3"


def test_the_quick_points_cover_every_module_lane_and_bank_count() -> None:
    points = quick_points(tuple(problems()))
    flat = [point for point in points if point.format == "flat"]
    assert {point.module for point in flat} == set(MODULES)
    assert {point.engine.lanes for point in flat} == {1, 2, 4}
    assert {point.engine.banks for point in flat} == {4, 8, 16}
    assert {point.engine.fp for point in points} == {64, 32}
    assert {point.format for point in points} == {"flat", "compressed", "in_order"}


@pytest.mark.parametrize(("lanes", "engines"), [((1, 2, 4), 8), ((2,), 2)], ids=["all", "two lanes"])
def test_the_rtl_runs_the_quick_points_in_the_models_cycles(lanes: tuple[int, ...], engines: int) -> None:
    require_verilator()
    named = problems()
    watched: set[Path] = set()
    points = [point for point in quick_points(tuple(named)) if point.engine.lanes in lanes]
    outcomes = [o for found in validate(RTL, points, named, watched) for o in found]
    assert [outcome for outcome in outcomes if not outcome.good] == []
    assert summary(outcomes)["flat"]["largest_cycle_error"] == 0.0
    assert len(watched) == engines  # with their sequencers


def test_a_word_that_differs_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """One bit of the expected words, turned; and a cycle, miscounted."""
    require_verilator()
    engine = Engine(lanes=1, banks=4, address_bits=15)
    program = scheduled(problems()[SMALL], Settings(), engine)
    point = Point(SMALL, "line_search", engine)
    good = program.core.case("line_search", "flat")
    before, expect = good.split("expect ", 1)
    lines = expect.splitlines()
    lines[1] = lines[1][:-1] + ("0" if lines[1][-1] != "0" else "1")
    cycles = f"cycles {program.segments['step_length'].cycles}"
    wrong = (before + "expect " + "\n".join(lines) + "\n").replace(cycles, f"{cycles}1")

    class Wrong:
        def case(self, *_: object, **__: object) -> str:
            return wrong

    monkeypatch.setattr(type(program), "core", Wrong(), raising=False)
    (outcome,) = run(RTL, point, program)
    assert not outcome.good
    assert outcome.different_words == 1
    assert outcome.model_cycles != outcome.rtl_cycles


@pytest.mark.parametrize(
    ("rest", "code", "signals"),
    [
        ("counter 0 where busy was up for 9\n", 1, ("counter 0 where busy was up for 9",)),
        ("assert read_conflict 0\nstatus 01010000 interrupt 1 after the segment, not 01010002 1\n", 1,
         ("status 01010000 interrupt 1 after the segment, not 01010002 1",)),
        ("", 0, ()),
        ("", 1, None),
        ("counter 0 where busy was up for 9\n", 0, None),
    ],
)  # fmt: skip
def test_what_counter_status_and_exit_say_counts(
    rest: str, code: int, signals: tuple[str, ...] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A harness that says all is equal, but for these lines and this exit status; None: they contradict each other."""
    program = scheduled(problems()[SMALL], Settings(), Engine(lanes=1, banks=4, address_bits=15))
    point = Point(SMALL, "line_search", program.engine)
    answer = f"run step_length cycles 9 expected 9 different 0 asserted 0\n{rest}"

    def harness(command: list[object], **_: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, code, answer, "")

    monkeypatch.setattr(rtl_validation, "built", lambda *_, **__: Path("/harness"))
    monkeypatch.setattr(rtl_validation.subprocess, "run", harness)
    if signals is None:
        with pytest.raises(RtlError, match=f"exits with {code}, but says"):
            run(RTL, point, program)
        return
    (outcome,) = run(RTL, point, program)
    assert (outcome.signals, outcome.good) == (signals, not signals)


@pytest.mark.parametrize("level", [-1, 256])
def test_a_level_at_which_fetch_never_delivers_is_refused(level: int) -> None:
    with pytest.raises(ValueError, match=rf"`level` = {level}: allowed is 0 to 255"):
        Point(SMALL, "line_search", Engine(), "in_order", level)


def test_a_stream_of_another_modules_first_stage_is_refused_by_name() -> None:
    """Its segment would not be the module's, and the case without any."""
    stream = Stream(("factorize", "solve_pair"))
    with pytest.raises(
        ValueError, match=r"'linear_solve': the stream begins with stage 'factorize'.*'factorization'"
    ):
        Point("any", "linear_solve", Engine(), stream=stream)
    Point("any", "factorization", Engine(), stream=stream)


@pytest.mark.parametrize(("gaps", "said"), [({"seed": 0}, "seed"), ({"level": 256}, "level")])
def test_a_case_in_which_fetch_never_delivers_is_not_made(gaps: dict[str, int], said: str) -> None:
    program = scheduled(problems()[SMALL], Settings(), Engine(lanes=1, banks=4, address_bits=15))
    with pytest.raises(_core.HardwareError, match=f"`{said}` = {gaps[said]}: allowed is"):
        program.core.case("line_search", "in_order", **gaps)


@pytest.mark.parametrize(("lines", "bits"), [(1, 17), (1 << 17, 17), ((1 << 17) + 1, 18), (1 << 20, 20)])
def test_microcode_memory_grows_with_the_program(
    lines: int, bits: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[list[object]] = []

    def build(command: list[object], **_: object) -> subprocess.CompletedProcess[str]:
        asked.append(command)
        return subprocess.CompletedProcess(command, 0, "/harness\n", "")

    monkeypatch.setattr(rtl_validation.subprocess, "run", build)
    assert built(RTL, Engine(address_bits=15), "flat", lines=lines) == Path("/harness")
    assert f"-GCODE_BITS={bits}" in asked[0]
