"""Probe programs (V1): latency, initiation interval and busy cycles of every operation, measured on the RTL by values.

The table that the model uses is read from the parameter files; here it is measured without using it: a consumer is
moved towards its producer until it no longer gets the new word, and two operations towards each other until one is
wrong.
"""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from tests.rtl.case_writer import Case, run_case
from tests.rtl.machine import DIVIDER_OPS, LANE_OPS, READS_B, READS_C, Machine, Op, Slot, encode, evaluate
from tests.rtl.verilator import require_verilator

MACHINES = {
    "f64": Machine(lanes=2, banks=8, address_bits=10),
    "f32": Machine(fp=32, lanes=1, banks=4, address_bits=10),
}
OPS = [*LANE_OPS[1:], *DIVIDER_OPS[1:]]
FAR = 50  # cycles, more than any operation takes
X, Y, Z, OLD, MOVED, TO, TO_2 = 1, 2, 3, 4, 5, 6, 8
MORE = range(10, 18)  # a divider works on several operations: too close, a later one destroys an earlier one


def words(machine: Machine) -> dict[int, int]:
    """Operands that no operation leaves unchanged, and words that no result equals."""
    code = "<d" if machine.fp == 64 else "<f"
    numbers = {X: -2.25, Y: 3.5, Z: 7.0, OLD: 123.0, MOVED: 55.0, TO: 99.0, TO_2: 98.0}
    numbers |= dict.fromkeys(MORE, 97.0)
    return {at: int.from_bytes(struct.pack(code, value), "little") for at, value in numbers.items()}


def operation(name: str, to: int = TO) -> Op:
    a = Z if name == "sqrt" else X
    return Op(name, to, a, Y if name in READS_B else 0, Z if name in READS_C else 0)


def unit(machine: Machine, name: str) -> int:
    return machine.lanes if name in DIVIDER_OPS else 0


def program(machine: Machine, slots: list[Slot]) -> tuple[list[int], dict[int, int], dict[int, int]]:
    """Microcode, storage before, storage after if every operation takes effect in the order of issue."""
    memory = words(machine)
    ordered = [slot.op for slot in sorted(slots, key=lambda slot: slot.time)]
    length = 1 + max(FAR, *(slot.time for slot in slots))
    return encode(machine, slots, length), memory, evaluate(machine, ordered, memory)


@pytest.fixture(scope="module", params=MACHINES)
def machine(request: pytest.FixtureRequest) -> Machine:
    return MACHINES[request.param]


def test_latency_of_every_operation_is_the_tables(machine: Machine, tmp_path: Path) -> None:
    require_verilator()
    case = Case(machine)
    distances = range(1, FAR)
    for name in OPS:
        for distance in distances:
            # The other lane, if there is one, reads: a lane's result register is no matter here.
            slots = [
                Slot(operation(name), 0, unit(machine, name)),
                Slot(Op("move", MOVED, TO), distance, machine.lanes - 1),
            ]
            case.add(f"{name}.{distance}", *_with_cycles(program(machine, slots)))
    answers = run_case(case, tmp_path)
    for name in OPS:
        right = [d for d in distances if not answers[f"{name}.{d}"].different]
        least = machine.distance(name)
        assert right == list(range(least, FAR)), name
        late = [d for d in distances if "read_pending" in answers[f"{name}.{d}"].violated]
        assert late == list(range(1, least)), name


def test_interval_of_every_operation_is_the_tables(machine: Machine, tmp_path: Path) -> None:
    require_verilator()
    case = Case(machine)
    for name in OPS:
        targets = (TO, TO_2, *MORE) if name in DIVIDER_OPS else (TO, TO_2)
        for interval in range(1, FAR):
            slots = [
                Slot(operation(name, to), i * interval, unit(machine, name)) for i, to in enumerate(targets)
            ]
            case.add(f"{name}.{interval}", *_with_cycles(program(machine, slots)))
    answers = run_case(case, tmp_path)
    for name in OPS:
        least = machine.interval(name)
        right = [i for i in range(1, FAR) if not answers[f"{name}.{i}"].different]
        clean = [i for i in range(1, FAR) if not answers[f"{name}.{i}"].violated]
        assert right == clean == list(range(least, FAR)), name


def test_one_operation_keeps_the_engine_busy_until_its_word_is_stored(
    machine: Machine, tmp_path: Path
) -> None:
    require_verilator()
    case = Case(machine)
    numbers = machine.numbers
    expected = {}
    for name in OPS:
        memory = words(machine)
        code = encode(machine, [Slot(operation(name), 0, unit(machine, name))], 1)
        u = machine.latency(name)
        expected[name] = (
            sum(numbers[f"{part}_CYCLES"] for part in ("STARTUP", "READ", "WRITE", "FINISH")) + u + 1
        )
        case.add(name, code, expected[name], memory, evaluate(machine, [operation(name)], memory))
    answers = run_case(case, tmp_path)
    assert {name: answer.cycles for name, answer in answers.items()} == expected
    assert all(answer.good for answer in answers.values())


def _with_cycles(
    parts: tuple[list[int], dict[int, int], dict[int, int]],
) -> tuple[list[int], int, dict[int, int], dict[int, int]]:
    """With a number of cycles that nothing here compares: the values tell."""
    code, memory, after = parts
    return code, len(code) + FAR, memory, after
