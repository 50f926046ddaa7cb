"""The exported program on the RTL: the driver's accesses are AXI transactions of the engine in Verilator."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from orbsoc import _core
from orbsoc.hw.schedules import Engine
from orbsoc.ps.registers import Region, Register, Status
from orbsoc.rtl.solve_cases import TIGHT
from orbsoc.rtl.validation import ADDRESS_BITS, problems
from tests.flight.c_library import expected, need
from tests.flight.stand_in import MEMORIES, REGISTERS, Partitioned
from tests.rtl.axi_session import AxiSession, built_behind_axi
from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_verilator

SMALL = problems()["6 variables, cones 3"]
ONE_LANE = Engine(lanes=1, banks=4, address_bits=ADDRESS_BITS)
STORAGE_BYTES = 8 << ADDRESS_BITS
REFUSED, LATE, BUS_ERROR = 256, 257, 22
IDLE_CLOCKS = 10_000
LINE_BYTES = 16


class OverAxi:
    """Accesses of 32 bits as beats of 64 on the memories' port, and as transactions on that of the registers."""

    def __init__(self, session: AxiSession, program: Partitioned) -> None:
        self.session, self.library = session, program.library
        self.tries, self.error_at = 0, -1
        self.accesses = 0
        self._pending: tuple[int, int] | None = None

    def read(self, address: int) -> int:
        self._flush()
        if address < MEMORIES:
            value = self.session.read(address - REGISTERS)
            if address - REGISTERS == Register.STATUS and Status.decode(value).busy:
                self.session.wait(IDLE_CLOCKS)
            return value
        response, word = self.session.ask(f"peek {address - MEMORIES & ~7:x}").split()
        self._answered(response)
        return int(word, 16) >> 32 * (address // 4 % 2) & 0xFFFF_FFFF

    def write(self, address: int, value: int) -> None:
        if address < MEMORIES:
            self._flush()
            self.session.write(address - REGISTERS, value)
            return
        offset = address - MEMORIES
        if self._pending and self._pending[0] == offset - 4 and offset % 8 == 4:
            low, self._pending = self._pending[1], None
            self._poke(offset - 4, value << 32 | low)
        else:
            self._flush()
            self._pending = offset, value

    def _flush(self) -> None:
        """A low half that no high one follows: a piece that the PL drops, or a template beside its neighbour."""
        if self._pending is not None:
            (offset, value), self._pending = self._pending, None
            self._poke(offset & ~7, value << 32 * (offset // 4 % 2))

    def _poke(self, offset: int, word: int) -> None:
        self.accesses += 1
        if self.accesses == self.error_at:
            offset = STORAGE_BYTES  # beyond the engine's storage: the PL answers SLVERR
        self._answered(self.session.ask(f"poke {offset:x} {word:x}"))

    def _answered(self, response: str) -> None:
        if response != "0":
            self.library.pl_bus_error()


@pytest.fixture(scope="module")
def harness() -> Path:
    require_verilator()
    need("gcc")
    return built_behind_axi(RTL, ONE_LANE, "flat", lines=1)


@pytest.fixture(params=["factor_only", "resident"])
def program(request: pytest.FixtureRequest, harness: Path, tmp_path: Path) -> Iterator[Partitioned]:
    with AxiSession(harness) as session:
        made = Partitioned(tmp_path / "c", SMALL, TIGHT, request.param, engine=ONE_LANE)
        made.pl = OverAxi(session, made)  # type: ignore[assignment]
        made.attach(polls=20, patience=40)
        yield made


def test_the_program_solves_on_the_rtl_and_survives_its_troubles(program: Partitioned) -> None:
    """A clean solve, one with an error on the bus, one whose storage is overwritten, and a clean one again."""
    wanted = expected(_core.ExactEngine(SMALL, TIGHT, 64).solve())
    pl = program.pl
    assert isinstance(pl, OverAxi)
    assert program.solve() == wanted
    assert (program.place, program.events) == ("on device", (0, 0))
    assert pl.session.segments()
    pl.accesses = 0
    pl.error_at = 3
    assert program.library.pl_place(program._solver()) == 1
    assert program.library.orbsoc_solve(program._solver()) == 0
    assert (program.place, program.events) == ("second try", (BUS_ERROR, 0))
    pl.error_at = -1
    for offset in range(0, LINE_BYTES * 4096, LINE_BYTES * 7):  # every seventh line of microcode
        pl.session.ask_all(f"poke {Region.MICROCODE + offset + half:x} 0" for half in (0, 8))
    assert program.solve() == wanted
    assert program.place == "second try"
    assert program.events[0] in (REFUSED, LATE, *range(1, 23))
    np.testing.assert_equal(program.solve(), wanted)
    assert (program.place, program.events) == ("on device", (0, 0))
