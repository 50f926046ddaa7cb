"""Each rule of a schedule, broken by a program of two or three operations, is asserted by the RTL under its name."""

from __future__ import annotations

import pytest

from tests.rtl.case_writer import Answer, Case, run_case
from tests.rtl.machine import Machine, Op, Slot, encode
from tests.rtl.verilator import require_verilator

MACHINE = Machine(lanes=2, banks=8, address_bits=10)
MEMORY = {at: 0x3FF0_0000_0000_0000 + at for at in range(32)}
LANE_0, LANE_1, DIVIDER = 0, 1, 2
TOGETHER = MACHINE.latency("mul") - MACHINE.latency(
    "move"
)  # a move that begins so late ends with the product
READABLE = MACHINE.distance("mul")
AGAIN = MACHINE.interval("div")

# Addresses differ by 8 where one bank is meant, and are of different banks else.
BROKEN = {
    "read_conflict": [Slot(Op("move", 1, 16), 0, LANE_0), Slot(Op("move", 2, 24), 0, LANE_1)],
    "read_pending": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 2, 1), READABLE - 1, LANE_0)],
    "write_pending": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 1, 18), TOGETHER + 2, LANE_1)],
    "result_conflict": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 2, 18), TOGETHER, LANE_0)],
    "write_conflict": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 9, 18), TOGETHER, LANE_1)],
    "divider_busy": [Slot(Op("div", 1, 16, 17), 0, DIVIDER), Slot(Op("sqrt", 2, 18), AGAIN - 1, DIVIDER)],
    "read_unwritten": [Slot(Op("move", 1, 40), 0, LANE_0)],
}
# The same programs, one step away from the fault.
SOUND = {
    "a broadcast": [Slot(Op("move", 1, 16), 0, LANE_0), Slot(Op("move", 2, 16), 0, LANE_1)],
    "other replicas": [Slot(Op("mul", 1, 16, 24), 0, LANE_0), Slot(Op("move", 2, 17), 0, LANE_1)],
    "read in time": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 2, 1), READABLE, LANE_0)],
    "written in time": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 1, 18), READABLE, LANE_1)],
    "results apart": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 2, 18), TOGETHER - 1, LANE_0)],
    "other bank": [Slot(Op("mul", 1, 16, 17), 0, LANE_0), Slot(Op("move", 2, 18), TOGETHER, LANE_1)],
    "overwritten as it is read": [Slot(Op("move", 1, 16), 0, LANE_0), Slot(Op("move", 16, 17), 0, LANE_1)],
}

# The low bit of an address names the cluster; lanes 0 and 1 lie in the first. All banks differ, so that only the network clashes.
CLUSTERED = Machine(lanes=4, banks=8, clusters=2, address_bits=10)
LANE_2 = 2
BROKEN_BETWEEN = {
    "read_conflict": [Slot(Op("move", 2, 17), 0, LANE_0), Slot(Op("move", 4, 19), 0, LANE_1)],
    "write_conflict": [Slot(Op("move", 1, 16), 0, LANE_0), Slot(Op("move", 3, 18), 0, LANE_1)],
}
SOUND_BETWEEN = {
    "one word for two lanes": [Slot(Op("move", 2, 17), 0, LANE_0), Slot(Op("move", 4, 17), 0, LANE_1)],
    "a word from each": [Slot(Op("move", 2, 17), 0, LANE_0), Slot(Op("move", 3, 18), 0, LANE_2)],
    "a result to each": [Slot(Op("move", 1, 16), 0, LANE_0), Slot(Op("move", 2, 19), 0, LANE_2)],
}


@pytest.fixture(scope="module")
def between(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Answer]:
    require_verilator()
    case = Case(CLUSTERED)
    for name, slots in {**BROKEN_BETWEEN, **SOUND_BETWEEN}.items():
        case.add(name.replace(" ", "_"), encode(CLUSTERED, slots, 1), 1, MEMORY, {})
    return run_case(case, tmp_path_factory.mktemp("between"))


@pytest.mark.parametrize("rule", BROKEN_BETWEEN)
def test_two_words_that_meet_between_clusters_are_asserted(rule: str, between: dict[str, Answer]) -> None:
    assert rule in between[rule].violated


@pytest.mark.parametrize("program", SOUND_BETWEEN)
def test_what_the_network_between_clusters_carries_breaks_no_rule(
    program: str, between: dict[str, Answer]
) -> None:
    assert between[program.replace(" ", "_")].violated == ()


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Answer]:
    require_verilator()
    case = Case(MACHINE)
    for name, slots in {**BROKEN, **SOUND}.items():
        case.add(
            name.replace(" ", "_"), encode(MACHINE, slots, 1 + max(s.time for s in slots)), 1, MEMORY, {}
        )
    unknown = [15 << (1 + 4 * MACHINE.address_bits) | 1, 3 << (1 + 2 * 44 + 30) | 1]
    for i, word in enumerate(unknown):
        case.add(f"unknown{i}", [word], 1, MEMORY, {})
    return run_case(case, tmp_path_factory.mktemp("rules"))


@pytest.mark.parametrize("rule", BROKEN)
def test_a_broken_rule_is_asserted_under_its_name(rule: str, answers: dict[str, Answer]) -> None:
    assert rule in answers[rule].violated


@pytest.mark.parametrize("program", SOUND)
def test_the_neighbouring_program_breaks_no_rule(program: str, answers: dict[str, Answer]) -> None:
    assert answers[program.replace(" ", "_")].violated == ()


@pytest.mark.parametrize("program", ["unknown0", "unknown1"])
def test_an_unknown_operation_is_asserted(program: str, answers: dict[str, Answer]) -> None:
    assert "unknown_operation" in answers[program].violated
