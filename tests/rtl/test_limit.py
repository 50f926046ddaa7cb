"""The limit on a launch's clocks, in the RTL behind AXI: it stops what has no end, and counts as the emulated PL does."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import orbsoc.rtl.solve as rtl_solve
from orbsoc.hw.emulation import PsScheduler
from orbsoc.ps.events import Kind
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import INSTRUCTION_FIELDS, CycleLimit, Fault, Op, Register, Status, Wrapper
from orbsoc.ps.segments import Segment
from orbsoc.rtl.solve import solve_on_rtl
from orbsoc.rtl.solve_cases import TIGHT
from tests.rtl.axi_session import AxiSession, CDriver, built_behind_axi
from tests.rtl.c_driver import ERRORS, NOT_AT_REST, OK
from tests.rtl.engine_sources import RTL
from tests.rtl.test_axi_solve import LINES, ONE_LANE, SEGMENT, SMALL, load_idle_segment
from tests.rtl.verilator import require_verilator

RUN, BRANCH, END, LAUNCH = 3, 7, 2, 1
FLAG = 7
_FIELDS = INSTRUCTION_FIELDS
PROGRAM = [
    _FIELDS["op"].put(Op.RUN) | _FIELDS["segment"].put(SEGMENT) | _FIELDS["entry"].put(1),
    _FIELDS["op"].put(Op.UNLESS)
    | _FIELDS["stop"].put(1),  # again, unless the flag or the stop bit says otherwise
    _FIELDS["op"].put(Op.END),
    _FIELDS["op"].put(Op.IF) | _FIELDS["target"].put(4) | _FIELDS["entry"].put(1),
    _FIELDS["op"].put(Op.UNLESS) | _FIELDS["target"].put(4),  # a branch to itself
]
ONE = 0x3FF0 << 48


@pytest.fixture
def session() -> Iterator[AxiSession]:
    require_verilator()
    with AxiSession(built_behind_axi(RTL, ONE_LANE, "flat", lines=1)) as opened:
        load_idle_segment(opened, [f"{word:x} {FLAG}" for word in PROGRAM])
        yield opened


def begun_again(session: AxiSession, flag: int) -> None:
    """After a reset: the image once more, and the flag that the control program reads."""
    session.reset()
    assert session.driver("load") == OK
    assert session.driver("publish 0") == OK
    session.ask(f"set {FLAG} {flag:x}")


@pytest.mark.parametrize("entry", [0, 3], ids=["segments", "branches"])
def test_an_attempt_without_end_is_stopped_within_the_limit(session: AxiSession, entry: int) -> None:
    begun_again(session, 0)
    assert session.driver("limit 5000") == OK
    before = session.clocks()
    assert session.driver(f"attempt {entry} 0 0") == OK
    assert session.driver("interrupt 100000") == Fault.CYCLE_LIMIT
    assert session.clocks() - before < 5000 + 100
    assert session.read(Wrapper.SPENT) == 5001
    assert Status.decode(session.read(Register.STATUS)) == Status(fault=Fault.CYCLE_LIMIT)
    ran = session.segments()
    assert len(ran) == (5001 // (LINES + RUN + BRANCH) + 1 if entry == 0 else 0)  # the last was cut off
    assert session.ask(f"peek {8 * FLAG:x}") == "0 0"  # memories can be read
    assert session.driver("attempt 0 0 0") == NOT_AT_REST
    session.write(Register.MODULE, 1)
    assert Status.decode(session.read(Register.STATUS)) == Status(fault=Fault.CYCLE_LIMIT)
    begun_again(session, ONE)
    assert not session.wait(0)[0]
    assert session.read(Wrapper.LIMIT) == 5000  # a reset leaves it
    assert session.driver("attempt 0 0 0") == OK
    assert session.driver("interrupt 100000") == OK
    assert session.driver("rest") == OK


@pytest.mark.parametrize("attempt", [False, True])
def test_a_launch_may_take_its_limit_and_not_a_clock_more(session: AxiSession, attempt: bool) -> None:
    launch = "attempt 0 0 0" if attempt else f"launch {SEGMENT}"
    begun_again(session, ONE)
    assert session.driver(launch) == OK
    assert session.driver("interrupt 10000") == OK
    [(_, cycles)] = session.segments()
    spent = session.read(Wrapper.SPENT)
    assert spent == cycles + (RUN + BRANCH + END if attempt else LAUNCH)
    for limit, error in ((spent, OK), (spent - 1, Fault.CYCLE_LIMIT), (0, OK)):
        begun_again(session, ONE)
        assert session.driver(f"limit {limit}") == OK
        assert session.driver(launch) == OK
        assert session.driver("interrupt 10000") == error
        assert session.read(Wrapper.SPENT) == spent


def test_reads_while_it_runs_do_not_move_the_limit(session: AxiSession) -> None:
    begun_again(session, 0)
    assert session.driver("limit 2000") == OK
    assert session.driver("attempt 0 0 0") == OK
    while not session.wait(0)[0]:
        session.read(Register.DATA_VALID)
        assert session.read(Wrapper.SPENT) <= 2001
    assert Status.decode(session.read(Register.STATUS)).fault is Fault.CYCLE_LIMIT
    assert session.read(Wrapper.SPENT) == 2001


def test_a_solve_takes_the_clocks_of_the_emulated_pl(monkeypatch: pytest.MonkeyPatch) -> None:
    """The emulated PL solves within as many clocks as the RTL says that it took; both are stopped by one fewer."""
    require_verilator()
    spent: list[int] = []

    class LimitedDriver(CDriver):
        limit = 0

        def _await_attempt(self, attempt: Segment) -> None:
            found = self._session().driver("poll 10000000")
            spent.append(self._session().read(Wrapper.SPENT))
            if found != OK:
                raise ERRORS[found]
            self._record.add(Kind.INTERRUPT, attempt.stage, 0)

        def _launch_attempt(self, program: ControlProgram, warm: bool) -> None:
            assert self._session().driver(f"limit {self.limit}") == OK
            super()._launch_attempt(program, warm)

    monkeypatch.setattr(rtl_solve, "built", built_behind_axi)
    monkeypatch.setattr(rtl_solve, "RtlSession", AxiSession)
    monkeypatch.setattr(rtl_solve, "Driver", LimitedDriver)
    outcome = solve_on_rtl(RTL, "small", SMALL, TIGHT, engine=ONE_LANE, resident=True)
    assert (outcome.status, outcome.different_words) == ("SOLVED", 0)
    for less, ends in ((0, True), (1, False)):
        scheduler = PsScheduler(TIGHT, resident=True, engine=ONE_LANE, limit_clocks=spent[0] - less)
        if ends:
            assert scheduler(SMALL).status.name == "SOLVED"
        else:
            with pytest.raises(CycleLimit, match="the PL reports CYCLE_LIMIT"):
                scheduler(SMALL)
    LimitedDriver.limit = spent[0] - 1
    with pytest.raises(CycleLimit):
        solve_on_rtl(RTL, "small", SMALL, TIGHT, engine=ONE_LANE, resident=True)
    assert spent == [spent[0]] * 2
