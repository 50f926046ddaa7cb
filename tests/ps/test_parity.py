"""A bit that turned over and was read, in the emulated PL: it stops wherever it is, and a solve ends with the error."""

from __future__ import annotations

import pytest

from orbsoc.ps.driver import Driver
from orbsoc.ps.events import PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import Control, Fault, Module, Parity, Register, Status
from tests.ps.fake_engine import METHOD, FakeEngine
from tests.ps.test_limit import SCALE, frame


def test_it_stops_a_running_segment_before_its_end_is_told() -> None:
    class Upset(FakeEngine):
        def run(self, stage: str) -> int:
            pl.upset()
            return super().run(stage)

    pl = ProgrammableLogic(METHOD, Upset().run)
    frame(pl, Module.PS, 0, 1, Control.PUBLISH)
    frame(pl, SCALE.module, SCALE.number, 2, Control.START)
    pl.tick()
    assert pl.interrupt
    assert Status.decode(pl.read(Register.STATUS)) == Status(fault=Fault.PARITY, sequence=1)
    frame(pl, Module.PS, 0, 1, Control.PUBLISH)
    assert Status.decode(pl.read(Register.STATUS)).fault is Fault.PARITY


def test_a_solve_ends_with_it() -> None:
    engine = FakeEngine()
    ran: list[str] = []

    def run(stage: str) -> int:
        ran.append(stage)
        if len(ran) == 3:
            pl.upset()
        return engine.run(stage)

    pl = ProgrammableLogic(METHOD, run)
    driver = Driver(METHOD, engine, pl, words=dict.fromkeys(METHOD.buffers, 1), record=PsRecord())
    with pytest.raises(Parity, match="the PL reports PARITY"):
        driver.run()
