"""Faults of the PL while the core runs the flight code: the right answer in time, and a place that says where from."""

from __future__ import annotations

from pathlib import Path

import pytest

from orbsoc.soc import program
from orbsoc.soc.errors import SocError
from orbsoc.soc.faults import Fault
from tests.soc.computer import RATIO, RTL, small_computer, small_counts

PATIENCE = 100
ROUND_CLOCKS = 5000
"""More than a look at a launch takes."""
EVENTS = {
    "registers:300": "bus error",
    "memories:700": "bus error",
    "interrupt": "lost interrupt",
    "reset:37": "bus error",
    "endless": "no end within the patience",
    "clock": "bus error",
}


@pytest.mark.parametrize(("fault", "event"), EVENTS.items())
def test_the_core_alone_has_the_answer_in_time_where_a_fault_stays(fault: str, event: str) -> None:
    found = small_counts("resident", fault=Fault.parsed(fault), patience=PATIENCE)
    assert found.same_bits
    (place,) = found.places
    assert place.where == "core, after two tries on the PL"
    assert place.events == (event, event)
    clean = small_counts("resident", warm=True)
    tries = 2 * (clean.core_cycles + PATIENCE * ROUND_CLOCKS)
    assert found.core_cycles < tries + small_counts(None, warm=True).core_cycles


def test_a_launch_without_end_is_stopped_by_the_limit_in_the_pl() -> None:
    """Long before the patience, by the engine's own clock; then the core alone has the answer."""
    limit = 30_000
    found = small_counts("resident", fault=Fault.parsed("endless"), limit_clocks=limit)
    assert found.same_bits
    (place,) = found.places
    assert (place.where, place.events) == ("core, after two tries on the PL", ("cycle limit", "cycle limit"))
    tries = 2 * (small_counts("resident", warm=True).core_cycles + limit * RATIO)
    assert found.core_cycles < tries + small_counts(None, warm=True).core_cycles


@pytest.mark.parametrize(
    ("fault", "event"),
    [("memories:700:1", "bus error"), ("reset:37:1", "bus error"), ("clock:0:1", "bus error")],
)
def test_a_second_try_succeeds_where_a_fault_goes_away(fault: str, event: str) -> None:
    found = small_counts("resident", fault=Fault.parsed(fault), patience=PATIENCE)
    assert found.same_bits
    (place,) = found.places
    assert (place.where, place.events) == ("PL, second try", (event, "none"))


@pytest.mark.parametrize("on_pl", [False, True], ids=["core alone", "with a PL"])
def test_a_trap_that_is_no_interrupt_is_told_and_ends_the_program(on_pl: bool, tmp_path: Path) -> None:
    machine = small_computer()
    main = tmp_path / "main.c"
    board, driver = RTL / "soc" / "program", RTL / "driver"
    names = ["start.S", "traps.c", "console.c"]
    begin = ""
    if on_pl:
        names += ["vector.S", "interrupts.c"]
        begin = "interrupts_begin(0);"
    main.write_text(
        f'#include "interrupts.h"\nint main(void) {{ {begin} return *(volatile int *)0x4000; }}\n'  # nothing is there
    )
    sources = [main, *(board / name for name in names), *([driver / "orbsoc.c"] if on_pl else [])]
    includes = [f"-I{folder}" for folder in (board, driver, RTL.parent / "flight")]
    flags = ["-DORBSOC_FP=64", *includes]
    program.linked(tmp_path, sources, board / "link.ld", flags, tmp_path / "trap.hex", on_pl=on_pl)
    with pytest.raises(SocError, match=r"code 101; its last line: trap: cause 5 at 0x8.*, value 0x4000"):
        list(machine.run(tmp_path / "trap.hex", ratio=1.0, latency=0, limit=200_000))


@pytest.mark.parametrize("text", ["nonsense", "reset:x", "reset:1:2:3", "reset:-1", "reset:70000", ""])
def test_a_fault_that_is_none_names_what_is_allowed(text: str) -> None:
    with pytest.raises(SocError, match=r"allowed is KIND\[:SKIP\[:TIMES\]\]"):
        Fault.parsed(text)
