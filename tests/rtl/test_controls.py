"""Controls: the checks of a harness, as validation builds it, assert every rule; and what becomes of one that does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.precision import narrow_settings
from orbsoc.hw.schedules import Engine, scheduled
from orbsoc.rtl.mutations import CHECK_MUTATIONS, ENGINE, Mutation
from orbsoc.rtl.rule_violations import RULES, Bench, control_case, silent_rules
from orbsoc.rtl.validation import ADDRESS_BITS, Format, Point, RtlError, built, problems, validate
from tests.rtl.engine_sources import RTL
from tests.rtl.verilator import require_verilator

SMALL = "6 variables, cones 3"
FOUR = Engine(lanes=4, banks=16, address_bits=ADDRESS_BITS)


def case(engine: Engine, form: Format) -> str:
    """A module's case for an engine."""
    settings = narrow_settings(Settings(), 53 if engine.fp == 64 else 24)
    return scheduled(problems()[SMALL], settings, engine).core.case("line_search", form)


@pytest.mark.parametrize("form", ["flat", "compressed"])
def test_a_control_for_a_static_sequencer_breaks_every_rule(form: Format) -> None:
    assert Bench.of(case(FOUR, form), RTL).rules == set(RULES)


@pytest.mark.parametrize(("engine", "more"), [(FOUR, {"write_conflict"}), (ENGINE, set[str]())])
def test_the_in_order_sequencer_is_given_what_it_cannot_hold_up(engine: Engine, more: set[str]) -> None:
    rules = {"read_conflict", "write_pending", "read_unwritten", "unknown_operation"} | more
    assert Bench.of(case(engine, "in_order"), RTL).rules == rules


def test_a_rule_that_no_line_asserts_is_silent() -> None:
    bench = Bench.of(case(ENGINE, "flat"), RTL)
    asserted = [rule for rule in RULES if rule not in ("read_pending", "divider_busy")]
    answer = "run control cycles 1 expected 64 different 0 asserted 6\n"
    answer += "".join(f"assert {rule} 1\n" for rule in asserted)
    assert silent_rules(bench, answer) == ["read_pending", "divider_busy"]


def test_a_control_is_one_segment_for_the_engine_of_the_case() -> None:
    given = case(ENGINE, "flat")
    control = control_case(Bench.of(given, RTL)).splitlines()
    assert control[:3] == given.splitlines()[:3]
    assert [line for line in control if line.startswith("run ")] == ["run control start 0 words 65 cycles 64"]


@pytest.mark.parametrize(
    ("mutation", "silent"),
    [("checks left out", RULES), ("reads of words on their way not asserted", ("read_pending",))],
)
def test_validation_refuses_a_harness_of_which_a_check_is_silent(
    mutation: str, silent: tuple[str, ...], tmp_path: Path
) -> None:
    """The engine's own schedules break no rule: nothing else would tell."""
    require_verilator()
    wrong = CHECK_MUTATIONS[mutation].apply(RTL, tmp_path)
    named: dict[str, Problem] = {SMALL: problems()[SMALL]}
    with pytest.raises(RtlError, match=f"broken by a control, and not asserted: {', '.join(silent)}$"):
        list(validate(wrong, [Point(SMALL, "line_search", ENGINE)], named, set()))


@pytest.mark.parametrize(
    ("name", "becomes"), [("READ_CYCLES = 4", "READ_CYCLES = 5"), ("FINISH_CYCLES = 1", "FINISH_CYCLES = 2")]
)
def test_a_latency_that_the_engine_does_not_have_stops_the_build(
    name: str, becomes: str, tmp_path: Path
) -> None:
    require_verilator()
    wrong = Mutation("engine.svh", name, becomes).apply(RTL, tmp_path)
    with pytest.raises(RtlError, match="names a latency that this engine does not have"):
        built(wrong, ENGINE, "flat", lines=1)
