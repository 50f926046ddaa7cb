"""The engine in Verilator against the contract: random programs, static and in order, and the rules it asserts."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.rtl.case_writer import Case, run_case
from tests.rtl.compressed import Compressor
from tests.rtl.machine import (
    Machine,
    busy_cycles,
    encode,
    evaluate,
    full_words,
    in_order,
    random_program,
    schedule,
)
from tests.rtl.verilator import require_verilator

SMALL = Machine(lanes=2, banks=8, address_bits=10)
SINGLE = Machine(fp=32, lanes=1, banks=4, address_bits=10)
WIDE = Machine(lanes=4, dividers=2, banks=16, address_bits=10)
LONG = Machine(fp=32, lanes=1, dividers=2, banks=4, address_bits=15)
FULL = Machine(lanes=4, banks=16, address_bits=14)
TWO_CLUSTERS = Machine(fp=32, lanes=4, banks=8, clusters=2, address_bits=10)
FOUR_CLUSTERS = Machine(lanes=8, dividers=3, banks=16, clusters=4, address_bits=10)
MACHINES = {
    "2 lanes, 8 banks": SMALL,
    "1 lane, 4 banks, f32": SINGLE,
    "4 lanes, 2 dividers, 16 banks": WIDE,
    "2 clusters": TWO_CLUSTERS,
    "4 clusters of 2 lanes": FOUR_CLUSTERS,
}
ONE = 0x3FF0_0000_0000_0000


@pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)
def test_static_programs_run_in_the_scheduled_cycles_and_give_the_same_words(
    machine: Machine, tmp_path: Path
) -> None:
    require_verilator()
    case = Case(machine)
    for seed in range(12):
        ops, memory = random_program(machine, 400, seed)
        slots = schedule(machine, ops)
        words = max(slot.time for slot in slots) + 1
        code = encode(machine, slots, words)
        case.add(
            f"random{seed}", code, busy_cycles(machine, slots, words), memory, evaluate(machine, ops, memory)
        )
    answers = run_case(case, tmp_path)
    assert {name: answer for name, answer in answers.items() if not answer.good} == {}


@pytest.mark.parametrize("machine", [SMALL, SINGLE], ids=["2 lanes", "1 lane, f32"])
def test_in_order_programs_with_gaps_take_the_modelled_cycles(machine: Machine, tmp_path: Path) -> None:
    require_verilator()
    case = Case(machine, "in_order")
    for seed, level in enumerate((0, 0, 32, 64, 128, 200)):
        ops, memory = random_program(machine, 400, seed)
        packed, cycles = in_order(machine, schedule(machine, ops), seed=seed + 1, level=level)
        code = encode(machine, packed, max(slot.time for slot in packed) + 1)
        case.add(
            f"level{level}.{seed}", code, cycles, memory, evaluate(machine, ops, memory), (seed + 1, level)
        )
    answers = run_case(case, tmp_path)
    assert {name: answer for name, answer in answers.items() if not answer.good} == {}


@pytest.mark.parametrize(
    "machine",
    [SINGLE, LONG, WIDE, TWO_CLUSTERS],
    ids=["1 lane", "1 lane, 64-bit lines", "4 lanes, 2 dividers", "2 clusters"],
)
def test_compressed_programs_take_the_frozen_cycles_of_their_fetch(machine: Machine, tmp_path: Path) -> None:
    require_verilator()
    case = Case(machine, "compressed")
    compressor = Compressor(machine, random.Random(1))
    for seed in range(8):
        # Half of the programs on few words of storage, where addresses repeat and steps are short.
        ops, memory = random_program(machine, 400, seed, words=96 if seed % 2 else 16)
        slots = schedule(machine, ops)
        words = max(slot.time for slot in slots) + 1
        lines, frozen = compressor.segment(slots, words)
        cycles = busy_cycles(machine, slots, words) + machine.numbers["DECODE_CYCLES"] + frozen
        case.add(f"random{seed}", lines, cycles, memory, evaluate(machine, ops, memory))
    case.templates = compressor.templates
    answers = run_case(case, tmp_path)
    assert {name: answer for name, answer in answers.items() if not answer.good} == {}


def test_words_longer_than_a_line_freeze_the_datapath(tmp_path: Path) -> None:
    require_verilator()
    case = Case(FULL, "compressed")
    compressor = Compressor(FULL, random.Random(1))
    for seed in range(3):
        slots, memory = full_words(FULL, seed)
        words = max(slot.time for slot in slots) + 1
        lines, frozen = compressor.segment(slots, words)
        assert frozen > 0
        cycles = busy_cycles(FULL, slots, words) + FULL.numbers["DECODE_CYCLES"] + frozen
        case.add(f"full{seed}", lines, cycles, memory, evaluate(FULL, [slot.op for slot in slots], memory))
    case.templates = compressor.templates
    answers = run_case(case, tmp_path)
    assert {name: answer for name, answer in answers.items() if not answer.good} == {}
