"""V4: whole solves through the RTL's registers and interrupts, and what happens when the computer is broken."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import orbsoc.rtl.solve as rtl_solve
from orbsoc import solve
from orbsoc.ps.registers import Control, LaunchWhileBusy, LostInterrupt, Register
from orbsoc.rtl.session import RtlPort, RtlSession
from orbsoc.rtl.solve import SolveOutcome, described, solve_on_rtl
from orbsoc.rtl.solve_cases import FOUR_LANES, TIGHT, quick_solves, run_solves
from orbsoc.rtl.validation import RtlError, built, problems
from tests.rtl.verilator import require_verilator
from tests.solving.restart_problems import WEAK, recovered_at_third_attempt

RTL = Path(__file__).parents[2] / "rtl"
SMALL = "6 variables, cones 3"
HIT = 20
"""The launch that goes wrong."""


def small() -> SolveOutcome:
    return solve_on_rtl(RTL, SMALL, problems()[SMALL], TIGHT, engine=FOUR_LANES)


def test_whole_solves_on_the_rtl_are_rusts_bit_for_bit_and_the_models_to_one_percent() -> None:
    require_verilator()
    points = quick_solves(RTL.parent / "scenarios")
    outcomes = list(run_solves(RTL, points))
    assert [described(outcome) for outcome in outcomes] == [[]] * len(points)
    assert all(outcome.good for outcome in outcomes)
    assert all(
        outcome.iterates == outcome.iterations + 2 for outcome in outcomes
    )  # the first; the last, twice
    flat = [outcome for outcome in outcomes if outcome.format == "flat" and outcome.engine.fp == 64]
    assert len({outcome.problem for outcome in flat}) == 3
    assert any("mission" in outcome.problem for outcome in flat)
    assert all(outcome.iterations >= 10 and outcome.status == "SOLVED" for outcome in flat)
    assert {outcome.engine.fp for outcome in outcomes} == {64, 32}


def test_restarts_on_the_rtl_are_those_of_rust() -> None:
    """The second restart has another regularisation, which the PL must be told."""
    require_verilator()
    outcome = solve_on_rtl(RTL, "stalls twice", recovered_at_third_attempt(), WEAK, engine=FOUR_LANES)
    assert described(outcome) == []
    assert outcome.good
    assert outcome.status == "SOLVED"
    assert [launch.stage for launch in outcome.launches].count("identity_blocks") == 3


class Broken(RtlPort):
    """A PL with one defect at one launch."""

    launches = 0

    def write(self, address: int, value: int) -> None:
        start = (address, value) == (Register.CONTROL, Control.START)
        self.launches += start
        if start and self.launches == HIT:
            self.before_start()
        super().write(address, value)
        if start and self.launches == HIT:
            self.after_start()

    def before_start(self) -> None: ...

    def after_start(self) -> None: ...


class StartedAgain(Broken):
    """The PS does not wait for the interrupt."""

    def after_start(self) -> None:
        self.session.write(Register.MODULE, 1)


class InterruptLost(Broken):
    @property
    def interrupt(self) -> bool:
        return super().interrupt and self.launches != HIT


@pytest.mark.parametrize(
    ("defect", "error"), [(StartedAgain, LaunchWhileBusy), (InterruptLost, LostInterrupt)]
)
def test_a_broken_protocol_ends_the_solve_and_names_the_stage(
    monkeypatch: pytest.MonkeyPatch, defect: type[Broken], error: type[Exception]
) -> None:
    require_verilator()
    monkeypatch.setattr(rtl_solve, "RtlPort", defect)
    with pytest.raises(error, match=r"stage '\w+', launch \d+"):
        small()


def test_a_bit_turned_in_the_rtls_storage_is_noticed_at_the_next_crossing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require_verilator()

    class BitTurned(Broken):
        """The last bit of one word of the factor, before the segment that substitutes through it."""

        def before_start(self) -> None:
            word = np.array([ADDRESS], np.uint32)
            self.session.set_words(word, self.session.get_words(word) ^ np.uint64(1))

    program = rtl_solve.pl_program(problems()[SMALL], TIGHT, FOUR_LANES)
    image = rtl_solve._core.program_image(program.core, "flat")
    ADDRESS = int(image.homes["pivot_inverse"][1][0])
    stages = [launch.stage for launch in small().launches]
    monkeypatch.setattr(f"{__name__}.HIT", next(k for k in range(20, 60) if stages[k - 1] == "solve_pair"))
    monkeypatch.setattr(rtl_solve, "RtlPort", BitTurned)
    outcome = small()
    assert not outcome.good
    assert outcome.different_words > 0
    first = outcome.differences[0]
    assert first.buffer in ("pair_refinement", "constant", "step")  # what that segment's results come to
    assert first.iteration == stages[:HIT].count("nt_scaling") - 1
    assert first.rtl != first.rust
    assert "words differ" in described(outcome)[0]


def test_a_schedule_that_promises_other_cycles_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    require_verilator()
    image_of = rtl_solve._core.program_image

    class Promise:
        """A program as it is, but for the cycles of one segment."""

        def __init__(self, *arguments: object) -> None:
            self.image = image_of(*arguments)
            start, cycles = self.image.entries["step_length"]
            self.entries = self.image.entries | {"step_length": (start, cycles + 1)}

        def __getattr__(self, name: str) -> object:
            return getattr(self.image, name)

    monkeypatch.setattr(rtl_solve._core, "program_image", Promise)
    outcome = small()
    runs = sum(launch.stage == "step_length" for launch in outcome.launches)
    assert outcome.busy_error_cycles == runs > 0
    assert not outcome.good


def test_a_solve_that_took_another_way_than_rusts_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    require_verilator()
    loop = rtl_solve._core.ExactEngine
    made: list[object] = []

    def other_tolerance(problem: object, settings: object, fp: int) -> object:
        """The referee's own loop, made first, stops earlier."""
        made.append(settings)
        return loop(problem, settings if len(made) > 1 else rtl_solve.Settings(tol=1e-3), fp)

    monkeypatch.setattr(rtl_solve._core, "ExactEngine", other_tolerance)
    outcome = small()
    assert (outcome.same_stages, outcome.same_solution, outcome.good) == (False, False, False)
    assert outcome.different_words == 0


def test_the_answer_is_that_of_the_public_solver() -> None:
    """The referee's engine keeps no stored zeros in its factor, the public one does: same solution."""
    engine = rtl_solve._core.ExactEngine(problems()[SMALL], TIGHT, 64)
    exact, public = engine.solve(), solve(problems()[SMALL], TIGHT)
    for vector in ("x", "y", "z", "s"):
        assert np.array_equal(getattr(exact, vector), getattr(public, vector))
    assert exact.iterations == public.iterations


def test_a_session_that_ends_says_so() -> None:
    require_verilator()
    with (
        RtlSession(built(RTL, FOUR_LANES, "flat", lines=1)) as session,
        pytest.raises(RtlError, match="no command"),
    ):
        session.ask("jump")


def test_the_words_of_an_engine_are_checked_against_its_buffers() -> None:
    engine = rtl_solve._core.ExactEngine(problems()[SMALL], TIGHT, 64)
    calls: list[Callable[[], object]] = [
        lambda: engine.words("slack", np.array([10**6], np.uint32)),
        lambda: engine.set_words("slack", np.array([10**6], np.uint32), np.zeros(1, np.uint64)),
        lambda: engine.set_words("slack", np.array([0], np.uint32), np.zeros(2, np.uint64)),
    ]
    for call in calls:
        with pytest.raises(ValueError, match="slack"):
            call()
    with pytest.raises(KeyError, match="no buffer"):
        engine.words("nowhere")
    with pytest.raises(ValueError, match="fp"):
        rtl_solve._core.ExactEngine(problems()[SMALL], TIGHT, 16)
