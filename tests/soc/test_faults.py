"""Faults of the PL while the core runs the flight code: the right answer in time, and a place that says where from."""

from __future__ import annotations

import pytest

from orbsoc.soc.faults import Fault
from orbsoc.soc.machine import SocError
from tests.soc.computer import small_counts

PATIENCE = 100
ROUND_CLOCKS = 5000
"""More than a look at a launch takes."""
EVENTS = {
    "registers:300": "bus error",
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


@pytest.mark.parametrize(
    ("fault", "event"),
    [("memories:700:1", "bus error"), ("reset:37:1", "bus error"), ("clock:0:1", "bus error")],
)
def test_a_second_try_succeeds_where_a_fault_goes_away(fault: str, event: str) -> None:
    found = small_counts("resident", fault=Fault.parsed(fault), patience=PATIENCE)
    assert found.same_bits
    (place,) = found.places
    assert (place.where, place.events) == ("PL, second try", (event, "none"))


@pytest.mark.parametrize("text", ["nonsense", "reset:x", "reset:1:2:3", "reset:-1", "reset:70000", ""])
def test_a_fault_that_is_none_names_what_is_allowed(text: str) -> None:
    with pytest.raises(SocError, match=r"allowed is KIND\[:SKIP\[:TIMES\]\]"):
        Fault.parsed(text)
