"""Banks with no more rows than the schedules need: the same solves, and what lies behind the last row is refused."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import pytest

from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine, EngineError, PlProgram, pl_program, with_exact_depth
from orbsoc.ps.registers import ENGINE_FIELDS, Region, Wrapper
from orbsoc.rtl.solve import described, solve_on_rtl
from orbsoc.rtl.solve_cases import SINGLE
from orbsoc.rtl.validation import Format, RtlError, problems
from tests.rtl.axi_session import AxiSession, built_behind_axi
from tests.rtl.case_writer import Answer, Case, run_case
from tests.rtl.engine_sources import RTL
from tests.rtl.machine import Machine, Op, Slot, busy_cycles, encode, evaluate, random_program, schedule
from tests.rtl.test_streamed import PROBLEM, STREAMS, Shape, solved
from tests.rtl.verilator import require_verilator


class Solve(NamedTuple):
    """A problem of validation, an engine with a power of two of rows, how it is solved there, and whether the PL has the control."""

    problem: str
    engine: Engine
    form: Format
    settings: Settings
    resident: bool


CASES = {
    "f64, 4 lanes, compressed": Solve(
        "12 variables, cones 4 6", Engine(lanes=4, banks=16, address_bits=12), "compressed", Settings(), True
    ),
    "f32, 2 lanes in 2 clusters, flat": Solve(
        "6 variables, cones 3", Engine(fp=32, lanes=2, banks=8, clusters=2, address_bits=12), "flat", SINGLE, False
    ),
}  # fmt: skip


def program(case: Solve, engine: Engine) -> PlProgram:
    """Of the case's control."""
    streams = STREAMS if case.resident else ()
    return pl_program(problems()[case.problem], case.settings, engine, None, streams)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_the_same_schedules_fit_into_fewer_rows(case: Solve) -> None:
    """In as many cycles. Where words lie is another, and with it what compression makes of them. Too few rows are refused by their key."""
    whole = program(case, case.engine)
    engine = with_exact_depth(whole)
    assert engine.rows is not None
    assert engine.rows < (1 << 12) // engine.banks
    exact = program(case, engine)
    assert exact.storage_words <= engine.rows * engine.banks
    assert {name: found.cycles for name, found in exact.segments.items()} == {
        name: found.cycles for name, found in whole.segments.items()
    }
    few = exact.home_words // engine.banks
    with pytest.raises(EngineError, match=f"`rows`: .* the engine has {few * engine.banks}"):
        program(case, replace(engine, rows=few))


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_solve_takes_the_modelled_cycles_and_has_the_hosts_bits(case: Solve) -> None:
    require_verilator()
    outcome = solve_on_rtl(
        RTL, "small", problems()[case.problem], case.settings,
        engine=case.engine, form=case.form, resident=case.resident, exact_depth=True,
    )  # fmt: skip
    assert described(outcome) == []
    assert (outcome.good, outcome.status) == (True, "SOLVED")
    assert outcome.engine == with_exact_depth(program(case, case.engine))
    assert outcome.words > 500


STREAMED = Engine(fp=32, lanes=4, banks=16, address_bits=12)


@pytest.fixture(scope="module")
def exact() -> Engine:
    return with_exact_depth(pl_program(PROBLEM, SINGLE, STREAMED, None, STREAMS))


def test_so_has_one_with_streamed_microcode_behind_axi(
    exact: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    solved(monkeypatch, Shape(exact, 2, 64, SINGLE), "stream 25 1 2 0")


@pytest.fixture(scope="module")
def session(exact: Engine) -> Iterator[AxiSession]:
    require_verilator()
    with AxiSession(built_behind_axi(RTL, exact, "compressed", lines=1, stream=2)) as opened:
        yield opened


def test_what_lies_behind_the_last_row_is_refused(exact: Engine, session: AxiSession) -> None:
    """By the PL with an error on the bus, and by the driver, which knows how many words there are, before it comes to that."""
    assert exact.rows is not None
    words = exact.rows * exact.banks
    assert ENGINE_FIELDS["fewer_words"].of(session.read(Wrapper.ENGINE)) == 1
    assert session.read(Wrapper.WORDS) == words
    session.ask(f"set {words - 1:x} 77")
    assert session.ask(f"get {words - 1:x}") == "77"
    end = Region.STORAGE + 4 * exact.rows * exact.banks
    assert session.ask(f"poke {end - 8:x} 5a5a5a5a12345678") == "0"
    assert session.ask(f"peek {end - 8:x}") == "0 5a5a5a5a12345678"
    for beyond in (end, Region.STORAGE + (4 << 12) - 8, Region.STORAGE + (4 << 12)):
        assert session.ask(f"peek {beyond:x}") == "2 0"
        assert session.ask(f"poke {beyond:x} 1") == "2"
    assert session.ask(f"peek {end - 8:x}") == "0 5a5a5a5a12345678"


def test_a_program_of_another_depth_is_refused(exact: Engine, session: AxiSession) -> None:
    assert exact.rows is not None
    own = session.read(Wrapper.IDENTITY)
    for rows in (None, exact.rows + 1, exact.rows):
        image = _core.program_image(
            pl_program(PROBLEM, SINGLE, replace(exact, rows=rows), None, STREAMS).core, "compressed", stream=2
        )
        assert (image.identity == own) == (rows == exact.rows)
    other = _core.program_image(pl_program(PROBLEM, SINGLE, replace(exact, rows=exact.rows + 1)).core, "flat")
    with pytest.raises(RtlError, match=f"16 x {exact.rows + 1} words"):
        session.require_engine_of(other)


@pytest.mark.parametrize("rows", [0, (1 << 12) // 16 + 1])
def test_rows_that_no_engine_can_have_are_refused(rows: int) -> None:
    with pytest.raises(EngineError, match=f"`rows` = {rows}: allowed is 1 to what `address_bits` reach"):
        pl_program(PROBLEM, SINGLE, replace(STREAMED, rows=rows))


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Answer]:
    """Random programs on all words of the second engine, and one that reads and one that writes behind the last."""
    require_verilator()
    second = CASES["f32, 2 lanes in 2 clusters, flat"]
    engine = with_exact_depth(program(second, second.engine))
    few = Machine(fp=32, lanes=2, banks=8, clusters=2, address_bits=12, rows=engine.rows or 0)
    case = Case(few)
    for seed in range(6):
        ops, memory = random_program(few, 300, seed, words=few.words if seed % 2 else 96)
        slots = schedule(few, ops)
        words = max(slot.time for slot in slots) + 1
        code = encode(few, slots, words)
        case.add(f"random{seed}", code, busy_cycles(few, slots, words), memory, evaluate(few, ops, memory))
    last = {few.words - 1: 0x3F80_0000}
    for name, op in {
        "at": Op("move", few.words - 2, few.words - 1), "reads": Op("move", 0, few.words),
        "writes": Op("move", few.words, few.words - 1),
    }.items():  # fmt: skip
        case.add(name, encode(few, [Slot(op, 0, 0)], 1), 1, last, {})
    return run_case(case, tmp_path_factory.mktemp("depth"))


def test_random_programs_on_all_words_run_as_they_must(answers: dict[str, Answer]) -> None:
    found = {name: answer for name, answer in answers.items() if name.startswith("random")}
    assert len(found) == 6
    assert {name: answer for name, answer in found.items() if not answer.good} == {}


def test_a_program_that_goes_behind_the_last_row_is_asserted(answers: dict[str, Answer]) -> None:
    assert answers["at"].violated == ()
    assert answers["reads"].violated == ("read_unwritten",)
    assert answers["writes"].violated == ("write_pending",)
