"""Problems of one pattern in one stream, on the RTL: each leaves the words of its own solve, in the model's cycles."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from orbsoc import _core
from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import KKT_SOLVES, Engine, EngineError, PlProgram, scheduled
from orbsoc.rtl.group import group_on_rtl
from orbsoc.rtl.group_cases import quick_groups, run_groups
from orbsoc.rtl.same_pattern import same_pattern
from orbsoc.rtl.session import RtlSession
from orbsoc.rtl.solve_cases import FOUR_LANES
from orbsoc.rtl.validation import (
    ADDRESS_BITS,
    CLUSTERED,
    MODULES,
    Format,
    Outcome,
    Point,
    case_of,
    compared,
    prepared,
    problems,
    validate,
)
from tests.rtl.verilator import require_verilator
from tests.solving.restart_problems import WEAK, recovered_at_third_attempt

RTL = Path(__file__).parents[2] / "rtl"
SMALL = "6 variables, cones 3"
STATUSES = ("SOLVED", "PRIMAL_INFEASIBLE", "DUAL_INFEASIBLE", "SOLVED")
SINGLE = Engine(fp=32, lanes=2, banks=8, address_bits=ADDRESS_BITS)


def segments(copies: int) -> list[Point]:
    """Every module on one crossbar or in clusters, on harnesses that other tests build, too; of four problems also
    compressed microcode, of two also binary32 and a stream of two modules."""
    of: dict[int, list[tuple[Engine, Format, Sequence[str]]]] = {
        2: [(FOUR_LANES, "flat", MODULES), (SINGLE, "flat", ("factorization",))],
        4: [(CLUSTERED, "flat", MODULES), (FOUR_LANES, "compressed", ("factorization", "line_search"))],
    }
    modules = [
        Point(SMALL, m, engine, form, interleaved=copies) for engine, form, ms in of[copies] for m in ms
    ]
    stream = Point(SMALL, "factorization", FOUR_LANES, stream=KKT_SOLVES, interleaved=2)
    return [*modules, stream] if copies == 2 else modules


@pytest.mark.parametrize("copies", [2, 4])
def test_every_segment_leaves_each_problem_its_words_in_the_models_cycles(copies: int) -> None:
    require_verilator()
    points = segments(copies)
    outcomes = [each for found in validate(RTL, points, problems(), set()) for each in found]
    assert [outcome for outcome in outcomes if not outcome.good] == []
    assert {outcome.point for outcome in outcomes} == set(points)
    assert len(outcomes) == 25 + 2


def interleaved(copies: int, misread: tuple[str, int] | None = None) -> PlProgram:
    return scheduled(problems()[SMALL], Settings(), FOUR_LANES, copies=copies, misread=misread)


def ran(case: str) -> list[Outcome]:
    return compared(prepared(RTL, Point(SMALL, "line_search", FOUR_LANES), case))


def test_a_word_of_any_problem_that_differs_is_reported() -> None:
    """The last bit of the same expected word of each of three problems, turned."""
    require_verilator()
    program = interleaved(3)
    case = case_of(Point(SMALL, "line_search", FOUR_LANES), program, same_pattern(problems()[SMALL], 3)[1:])
    indices, addresses = _core.program_image(program.core, "flat").homes["step"]
    before, expect = case.split("expect ", 1)
    for address in addresses[indices // 3 == 0].tolist():
        expect, turned = re.subn(
            rf"^({address:x} .*)(.)$", lambda m: m[1] + f"{int(m[2], 16) ^ 1:x}", expect, flags=re.MULTILINE
        )
        assert turned == 1
    (outcome,) = ran(f"{before}expect {expect}")
    assert (outcome.different_words, outcome.rtl_cycles) == (3, outcome.model_cycles)


def test_words_of_another_of_the_problems_are_reported() -> None:
    """What is expected of two problems, exchanged between them."""
    require_verilator()
    program, point = interleaved(3), Point(SMALL, "line_search", FOUR_LANES)
    _, second, third = same_pattern(problems()[SMALL], 3)
    right, exchanged = (case_of(point, program, others) for others in ((second, third), (third, second)))
    (outcome,) = ran(right.split("expect ", 1)[0] + "expect " + exchanged.split("expect ", 1)[1])
    assert outcome.different_words > 0
    (outcome,) = ran(right)
    assert outcome.good


def test_a_scheduler_that_misreads_a_latency_is_noticed() -> None:
    require_verilator()
    point = Point(SMALL, "line_search", FOUR_LANES)
    case = case_of(point, interleaved(2, ("add", -1)), same_pattern(problems()[SMALL], 2)[1:])
    (outcome,) = ran(case)
    assert outcome.assertions
    assert not outcome.good


@pytest.mark.parametrize(("number", "copies"), [(0, 2), (1, 4), (2, 3), (2, 4), (3, 4)])
def test_an_attempt_solves_every_problem_as_by_itself(number: int, copies: int) -> None:
    require_verilator()
    at = quick_groups(copies)[number]
    (outcome,) = run_groups(RTL, [at])
    assert outcome.good, outcome
    assert len(set(outcome.iterations)) > 1  # some have ended while others go on
    assert outcome.words > 50 * copies
    assert outcome.rtl_clocks == outcome.model_clocks + 2  # the first instruction's fetch, and the end's
    if at.name == "three ways to end":
        assert outcome.statuses == STATUSES[:copies]
    for wrong in (
        {"uncounted": {"unscale": 1}}, {"different_words": 1}, {"same_solutions": False}, {"assertions": 1},
        {"launches": (*outcome.launches, replace(outcome.launches[0], rtl_cycles=0))},
    ):  # fmt: skip
        assert not replace(outcome, **wrong).good


def test_an_attempt_that_ends_with_the_first_problem_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A control program that reads the flags of one problem, not of all."""
    require_verilator()
    load = RtlSession.load
    monkeypatch.setattr(
        RtlSession, "load", lambda self, image, method, control, _: load(self, image, method, control)
    )
    (outcome,) = run_groups(RTL, quick_groups(4)[:1])
    assert not outcome.good
    assert outcome.uncounted
    assert outcome.different_words > 0
    assert not outcome.same_solutions


def test_a_group_with_a_problem_that_restarts_is_refused() -> None:
    with pytest.raises(ValueError, match="problem 0 of the group restarts: a group makes one attempt"):
        group_on_rtl(RTL, "stalls", [recovered_at_third_attempt()], WEAK, engine=FOUR_LANES)


def test_a_case_takes_as_many_problems_as_the_program_interleaves() -> None:
    program, point = interleaved(3), Point(SMALL, "line_search", FOUR_LANES)
    with pytest.raises(_core.HardwareError, match="`others`: 1 given; a program of 3 interleaved takes 2"):
        case_of(point, program, same_pattern(problems()[SMALL], 2)[1:])
    other = problems()["12 variables, cones 4 6"]
    with pytest.raises(_core.HardwareError, match="but the recorded pattern has"):
        case_of(point, program, [other, other])
    with pytest.raises(EngineError, match="`copies` = 0: allowed is 1 or more"):
        interleaved(0)


def test_others_of_a_pattern_have_it_and_no_number_of_the_first() -> None:
    for problem in problems().values():
        first, *others = same_pattern(problem, 3)
        assert first is problem
        for other in others:
            assert pattern_digest(other) == pattern_digest(problem)
            for name in ("P", "A", "G"):
                assert (getattr(other, name).data != getattr(problem, name).data).all()
            for name in ("c", "b", "h"):
                assert (getattr(other, name) != getattr(problem, name)).all()


def test_a_point_of_several_problems_has_room_for_their_words() -> None:
    point = Point(SMALL, "line_search", FOUR_LANES)
    assert point.with_interleaved(1) is point
    several = [point.with_interleaved(copies) for copies in (2, 3, 4, 8)]
    assert [each.engine.address_bits for each in several] == [16, 17, 17, 18]
    assert [each.interleaved for each in several] == [2, 3, 4, 8]
