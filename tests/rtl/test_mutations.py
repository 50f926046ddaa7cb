"""Engines and models that are wrong in one place (V5): each must be caught by the programs that the right one passes.

A mutation of the RTL is a changed line in a copy of its sources; one of the model is a schedule made under a rule that is not
the engine's. Here the programs are the random ones of test_engine.py; `orbsoc hw validate --mutations` shows the
same mutations of the RTL, and mutations of the product's own scheduler, to the schedules of a problem.
"""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path

import pytest

from orbsoc.hw.schedules import Engine
from orbsoc.rtl.mutations import FREEZING, MUTATIONS
from tests.rtl.case_writer import Answer, Case, run_case
from tests.rtl.compressed import Compressor
from tests.rtl.engine_sources import RTL
from tests.rtl.machine import (
    DIVIDER_OPS,
    MIXTURE,
    Machine,
    Op,
    Reservations,
    Slot,
    busy_cycles,
    encode,
    evaluate,
    full_words,
    in_order,
    random_program,
    schedule,
)
from tests.rtl.verilator import require_verilator


@cache
def programs(form: str, engine: Engine) -> Case:
    """Random programs for one engine and sequencer; it and its mutants run the same."""
    machine = Machine(
        engine.fp, engine.lanes, engine.dividers, engine.banks, engine.clusters, engine.address_bits or 10
    )
    case = Case(machine, form)
    compressor = Compressor(machine, random.Random(1))
    made: list[tuple[list[Slot], dict[int, int]]] = []
    for seed, names in enumerate([MIXTURE, MIXTURE, DIVIDER_OPS[1:], DIVIDER_OPS[1:]]):
        ops, memory = random_program(machine, 300, seed, names=names)
        made.append((schedule(machine, ops), memory))
    if engine == FREEZING:
        made.append(full_words(machine))
    for seed, (slots, memory) in enumerate(made):
        ops = [slot.op for slot in sorted(slots, key=lambda slot: slot.time)]
        words = 1 + max(slot.time for slot in slots)
        cycles = busy_cycles(machine, slots, words)
        if form == "in_order":
            slots, cycles = in_order(machine, slots, seed=1, level=0)
            words = 1 + max(slot.time for slot in slots)
        if form == "compressed":
            code, frozen = compressor.segment(slots, words)
            cycles += machine.numbers["DECODE_CYCLES"] + frozen
        else:
            code = encode(machine, slots, words)
        gaps = (1, 0) if form == "in_order" else None
        case.add(f"random{seed}", code, cycles, memory, evaluate(machine, ops, memory), gaps)
    case.templates = compressor.templates
    return case


def test_each_mutations_line_is_in_the_rtl_once(tmp_path: Path) -> None:
    """Where it is not, `apply` refuses; most mutants themselves are left to the long tests."""
    for k, mutation in enumerate(MUTATIONS.values()):
        changed = mutation.apply(RTL, tmp_path / str(k)) / mutation.file
        assert mutation.becomes in changed.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", MUTATIONS)
def test_a_mutation_of_the_rtl_is_caught(name: str, tmp_path: Path) -> None:
    require_verilator()
    mutation = MUTATIONS[name]
    program = programs(mutation.form, mutation.engine)
    answers = run_case(program, tmp_path, mutation.apply(RTL, tmp_path))
    assert not all(answer.good for answer in answers.values())


@pytest.mark.parametrize(
    ("form", "engine"), dict.fromkeys((mutation.form, mutation.engine) for mutation in MUTATIONS.values())
)
def test_the_engine_as_it_is_passes_the_programs_that_catch_mutations(
    form: str, engine: Engine, tmp_path: Path
) -> None:
    require_verilator()
    answers = run_case(programs(form, engine), tmp_path)
    assert all(answer.good for answer in answers.values()), answers


class WithoutReadPorts(Reservations):
    """A scheduler that lets two operands of one replica meet at a bank."""

    def place(self, op: Op) -> Slot:
        self.rows.clear()
        return super().place(op)


class WithoutWritePorts(Reservations):
    """A scheduler that lets two results meet at a bank."""

    def place(self, op: Op) -> Slot:
        self.writes.clear()
        return super().place(op)


class WithoutResults(Reservations):
    """A scheduler that lets two results of a lane meet."""

    def place(self, op: Op) -> Slot:
        self.results.clear()
        return super().place(op)


class WithoutOverwriting(Reservations):
    """A scheduler that forgets who still reads a word before it is overwritten."""

    def place(self, op: Op) -> Slot:
        self.read_last.clear()
        return super().place(op)


WRONG_SCHEDULERS = {
    WithoutReadPorts: {"read_conflict"},
    WithoutWritePorts: {"write_conflict"},
    WithoutResults: {"result_conflict"},
    WithoutOverwriting: set[str](),  # no rule sees a word overwritten too early: the words do
}


def scheduled_by(kind: type[Reservations]) -> Case:
    """Random programs on two lanes, with the reservations that `kind` makes."""
    machine = Machine(lanes=2, banks=8, address_bits=10)
    case = Case(machine)
    for seed in range(4):
        ops, memory = random_program(machine, 300, seed)
        taken = kind(machine)
        slots = [taken.place(op) for op in ops]
        words = 1 + max(slot.time for slot in slots)
        code = encode(machine, slots, words)
        case.add(
            f"random{seed}", code, busy_cycles(machine, slots, words), memory, evaluate(machine, ops, memory)
        )
    return case


def test_the_scheduler_as_it_is_passes_the_programs_that_catch_wrong_ones(tmp_path: Path) -> None:
    require_verilator()
    answers = run_case(scheduled_by(Reservations), tmp_path)
    assert all(answer.good for answer in answers.values()), answers


@pytest.mark.parametrize("wrong", WRONG_SCHEDULERS, ids=lambda wrong: wrong.__name__)
def test_a_wrong_reservation_of_the_scheduler_is_caught(wrong: type[Reservations], tmp_path: Path) -> None:
    require_verilator()
    answers: dict[str, Answer] = run_case(scheduled_by(wrong), tmp_path)
    assert not any(answer.good for answer in answers.values())
    for answer in answers.values():
        assert WRONG_SCHEDULERS[wrong] <= set(answer.violated)
