"""The engine behind AXI: whole solves by the driver in C, bursts at full rate, and what the PL refuses."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import orbsoc.rtl.solve as rtl_solve
from orbsoc import _core
from orbsoc.hw.schedules import Engine
from orbsoc.ps.registers import ENGINE_FIELDS, SIZES_FIELDS, Fault, Module, Region, Register, Status, Wrapper
from orbsoc.rtl.mutations import Mutation
from orbsoc.rtl.session import RtlPort
from orbsoc.rtl.solve import described, solve_on_rtl
from orbsoc.rtl.solve_cases import SINGLE, TIGHT, TWO_LANES_F32
from orbsoc.rtl.validation import ADDRESS_BITS, RtlError, problems
from tests.rtl.axi_session import RTL, AxiSession, CDriver, InterruptedCDriver, built_behind_axi
from tests.rtl.verilator import require_verilator

SMALL = problems()["6 variables, cones 3"]
ONE_LANE = Engine(lanes=1, banks=4, address_bits=ADDRESS_BITS)
CLOCKS_DIFFER = re.compile(r"the model's clocks are off by -?[\d.]+ %")


@pytest.fixture
def session() -> Iterator[AxiSession]:
    require_verilator()
    with AxiSession(built_behind_axi(RTL, ONE_LANE, "flat", lines=1)) as opened:
        yield opened


def test_a_solve_by_the_c_driver_over_axi_is_the_one_of_the_engines_own_harness(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same words, stages and busy cycles; only the clocks of moves and register accesses are AXI's."""
    require_verilator()
    own = solve_on_rtl(RTL, "small", SMALL, TIGHT, engine=ONE_LANE, resident=True)
    assert own.good
    monkeypatch.setattr(rtl_solve, "built", built_behind_axi)
    monkeypatch.setattr(rtl_solve, "RtlSession", AxiSession)
    monkeypatch.setattr(rtl_solve, "Driver", CDriver)
    outcome = solve_on_rtl(RTL, "small", SMALL, TIGHT, engine=ONE_LANE, resident=True)
    assert all(CLOCKS_DIFFER.match(line) for line in described(outcome)), described(outcome)
    assert outcome.launches == own.launches
    assert (outcome.words, outcome.different_words) == (own.words, 0)
    assert (outcome.same_stages, outcome.same_solution, outcome.assertions) == (True, True, 0)
    assert (outcome.status, outcome.iterations) == (own.status, own.iterations) == ("SOLVED", own.iterations)
    assert outcome.rtl_clocks > own.rtl_clocks


def test_so_is_one_in_binary32_from_compressed_microcode_with_interrupts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    require_verilator()
    monkeypatch.setattr(rtl_solve, "built", built_behind_axi)
    monkeypatch.setattr(rtl_solve, "RtlSession", AxiSession)
    monkeypatch.setattr(rtl_solve, "Driver", InterruptedCDriver)
    outcome = solve_on_rtl(
        RTL, "small", SMALL, SINGLE, engine=TWO_LANES_F32, form="compressed", resident=True
    )
    assert all(CLOCKS_DIFFER.match(line) for line in described(outcome)), described(outcome)
    assert (outcome.status, outcome.different_words, outcome.assertions) == ("SOLVED", 0, 0)
    assert outcome.words > 500


@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("seed", [0, 1])
def test_bursts_fill_and_read_the_engines_storage(session: AxiSession, size: int, seed: int) -> None:
    """Each burst is read back right behind its last beat: the wrapper must wait until it has settled."""
    different, _, _ = (int(word, 16) for word in session.ask(f"bursts {seed} {size}").split())
    assert different == 0
