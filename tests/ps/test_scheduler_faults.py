"""A PL with one defect, behind `PsScheduler`: the fault is found, typed, named by stage, and leaves no trace behind."""

from __future__ import annotations

import pytest

import orbsoc
import orbsoc.ps.scheduler as scheduler
from orbsoc import Cones, Problem, PsScheduler
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import (
    Control,
    LaunchWhileBusy,
    LostInterrupt,
    ProtocolError,
    ReadBeforeValid,
    Register,
    WrongSegment,
)

PROBLEM = Problem(
    c=[1.0, 2.0], A=[[1.0, 1.0]], b=[1.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0, 0], cones=Cones(l=2)
)
HIT = 5
"""The launch that goes wrong."""


class Defective(ProgrammableLogic):
    """Counts its launches."""

    launches = 0

    def write(self, address: int, value: int) -> None:
        self.launches += (address, value) == (Register.CONTROL, Control.START)
        super().write(address, value)

    @property
    def hit(self) -> bool:
        return self.launches == HIT


class InterruptNeverComes(Defective):
    @property
    def interrupt(self) -> bool:
        return super().interrupt and not self.hit


class InterruptComesEarly(Defective):
    """And STATUS hides that the segment still runs, so that the PS goes on."""

    @property
    def interrupt(self) -> bool:
        return super().interrupt or self.hit

    def read(self, address: int) -> int:
        word = super().read(address)
        if self.hit and address == Register.STATUS:
            launch, segment = self._frame[Register.SEQUENCE], self._frame[Register.SEGMENT]
            return word & ~0x1 & 0xFFFF | segment << 16 | (launch & 0xFF) << 24
        return word if not self.hit or address < Register.DATA_VALID else 0xFFFFFFFF


class FlagsStayDown(Defective):
    def read(self, address: int) -> int:
        return 0 if self.hit and address >= Register.DATA_VALID else super().read(address)


class AnotherSegmentRan(Defective):
    def read(self, address: int) -> int:
        word = super().read(address)
        return word ^ 1 << 16 if self.hit and address == Register.STATUS else word


@pytest.mark.parametrize(
    ("defect", "error"),
    [
        (InterruptNeverComes, LostInterrupt),
        (InterruptComesEarly, LaunchWhileBusy),
        (FlagsStayDown, ReadBeforeValid),
        (AnotherSegmentRan, WrongSegment),
    ],
)
def test_a_defect_of_the_pl_is_found_and_the_next_solve_is_whole(
    defect: type[Defective], error: type[ProtocolError], monkeypatch: pytest.MonkeyPatch
) -> None:
    ps = PsScheduler()
    with monkeypatch.context() as broken:
        broken.setattr(scheduler, "ProgrammableLogic", defect)
        with pytest.raises(error, match="stage '") as found:
            ps(PROBLEM)
    assert type(found.value) is error
    assert ps.trace["solves"] == []
    assert ps(PROBLEM).x.tobytes() == orbsoc.solve(PROBLEM).x.tobytes()
    assert len(ps.trace["solves"]) == 1
