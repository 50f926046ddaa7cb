"""Energy: counted by hand on a tiny computer, then conserved on random traces like cycles."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw_model import speedup
from hw_model.energy.actions import DYNAMIC, ENERGY_ACTIONS, STANDING, Counts, counts_by_module
from hw_model.energy.joules import counter_of, millijoules, picojoules, total_picojoules
from hw_model.platform.partition import Partition
from hw_model.platform.platform import Platform, load_platform
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.random_traces import platforms, traces
from tests.hw_model.synthetic import synthetic_trace
from tests.hw_model.tiny import partition_of, tiny_platform, tiny_trace


def counted(platform: Platform, partition: Partition, raw: dict[str, object]) -> tuple[Durations, Counts]:
    trace = parse_trace(raw)
    durations = Durations(trace, platform, partition)
    return durations, counter_of(actions_of(trace, partition), partition)(durations)


def test_actions_of_a_factorization_by_hand(tmp_path: Path) -> None:
    _, found = counted(tiny_platform(tmp_path), partition_of("factorization"), tiny_trace())
    # Nine c - a.b, a selection, two divisions: 9*3 + 3 + 2*2 operands and 12 results of 64 bits.
    assert (found["mul_f64"], found["add_f64"], found["div_f64"], found["logic_f64"]) == (9, 9, 2, 1)
    assert (found["bank_read_bit"], found["bank_write_bit"]) == (34 * 64, 12 * 64)
    # 132 cycles of a flat word: 1 + 2 lanes of 4 addresses of 8 bits and 4, a divider of 3 addresses and 2.
    assert found["microcode_bit"] == 132 * (1 + 2 * 36 + 26)
    # 800 and 16 bytes cross; five frames or status reads: 6 + 6 + 4 + 3 + 6 + 1 accesses.
    assert (found["beat"], found["register_access"]) == (102, 26)
    assert found["core_cycle"] == 20 + 36
    makespan = 11_996_000
    assert (found["core_waiting"], found["core_idle"]) == (makespan - 56_000, makespan)
    assert (found["unit_clock"], found["pl_static"]) == (3 * makespan, makespan)


def test_an_idle_pl_still_draws_and_does_nothing(tmp_path: Path) -> None:
    _, found = counted(tiny_platform(tmp_path), partition_of(), tiny_trace())
    assert {action for action in ENERGY_ACTIONS if found[action]} == {
        "core_cycle", "core_idle", "ps_static", "pl_static", "memory_static",
    }  # fmt: skip
    assert found["core_cycle"] == 154


def test_a_milliwatt_for_a_millisecond_is_a_microjoule() -> None:
    table = load_platform("zu9eg").energy
    found = millijoules(Counter({"pl_static": 10**9}), table)
    assert found == pytest.approx(table.pl_static_mw.value * 1e-3, rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(traces(), platforms(), st.sets(st.sampled_from(PL_MODULES)))
def test_modules_and_what_lasts_add_up_to_the_run(
    raw: dict[str, object], platform: Platform, on_pl: set[str]
) -> None:
    partition = partition_of(*on_pl)
    durations, found = counted(platform, partition, raw)
    trace = parse_trace(raw)
    parts = counts_by_module(actions_of(trace, partition), durations, microcode_word_bits=0)
    summed: Counts = sum(parts.values(), Counter())
    assert all(count >= 0 for count in found.values())
    # The number of bits a flat word has is the engine's, not the module's.
    for action in set(DYNAMIC) - {"microcode_bit"}:
        assert summed[action] == found[action], action
    by_action = sum(found[action] * picojoules(platform.energy, action) for action in ENERGY_ACTIONS)
    assert by_action == total_picojoules(found, platform.energy)


def test_a_reports_rows_are_its_total_and_its_band_holds_it() -> None:
    report = speedup(synthetic_trace(), "zu9eg", "paper")
    for use in (report.energy, report.baseline_energy):
        assert sum(row.nominal_mj for row in use.rows) == pytest.approx(use.nominal_mj, rel=1e-12)
        assert sum(row.share for row in use.rows) == pytest.approx(1.0, rel=1e-12)
        assert use.low_mj < use.nominal_mj < use.high_mj
    assert {row.action for row in report.energy.rows} >= set(STANDING)


@pytest.mark.parametrize("action", ["mul_f64", "beat", "pl_static", "core_cycle"])
def test_a_share_is_the_sensitivity_to_its_entry(action: str) -> None:
    platform = load_platform("zu9eg")
    key = f"energy.{action}_{'mw' if action in STANDING else 'pj'}"
    was = getattr(platform.energy, key[7:]).value
    before = speedup(synthetic_trace(), platform, "paper").energy
    after = speedup(synthetic_trace(), platform.with_value(key, 1.01 * was), "paper").energy
    [row] = [row for row in before.rows if row.action == action]
    assert after.nominal_mj / before.nominal_mj - 1.0 == pytest.approx(0.01 * row.share, rel=1e-6)
