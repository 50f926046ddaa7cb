"""Exact schedules replace the estimate everywhere, and are asked for once."""

from __future__ import annotations

from collections import Counter

import pytest

from hw_model.area.budget import budget
from hw_model.errors import HwModelError
from hw_model.platform.partition import load_partition
from hw_model.platform.platform import load_platform
from hw_model.report.run import simulate
from hw_model.report.speedup import speedup
from hw_model.report.study import Study
from hw_model.timing.schedules import CAUSE_OF, Engine, Schedule, scheduled
from hw_model.timing.stage_cycles import Microcode
from hw_model.timing.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace

TRACE = parse_trace(synthetic_trace(iterations=2))
CODE = Microcode(words=1890, flat_bits=600_000, bits=90_000)


def source(pattern: int, stage: str, engine: Engine) -> Schedule:
    """Every cause 100 cycles, issue less with more lanes."""
    return Schedule(dict.fromkeys(CAUSE_OF, 100) | {"issue": 8000 // engine.lanes}, 500, "issue", CODE)


def test_a_schedule_is_where_all_reports_take_their_cycles() -> None:
    platform = load_platform("zu9eg").with_value("pl.lanes", 8)
    cycles = scheduled(source)
    report = speedup(TRACE, platform, "paper", cycles=cycles)
    rows = [row for row in report.stages if row.side == "pl"]
    assert {row.cycles_each for row in rows} == {1000 + 9 * 100}
    assert {row.origin for row in rows} == {"schedule"}
    assert all(row.causes_each["write_port"] == 200 and row.causes_each["drain"] == 300 for row in rows)
    assert not any("estimate" in line for line in report.not_modelled)
    used = {row.key for row in report.assumptions if row.used}
    assert "pl.banks" in used
    assert "pl.overlap_exponent" not in used
    assert simulate(TRACE, platform, "paper", cycles).makespan_picoseconds == report.makespan_picoseconds
    [point] = Study(TRACE, cycles).points(platform, [load_partition("paper")])
    assert point.time_ms == report.makespan_ms
    segments = {name for name, stage in TRACE.patterns[0].stages.items() if stage.module != "ps"}
    taken = budget(TRACE, platform, load_partition("paper"), cycles)
    assert (taken.microcode_words, taken.microcode_bits) == (1890 * len(segments), 90_000 * len(segments))
    assert taken.microcode_origin == "schedule"


def test_a_schedule_is_asked_for_once_an_engine() -> None:
    asked: Counter[tuple[int, str, Engine]] = Counter()

    def counted(pattern: int, stage: str, engine: Engine) -> Schedule:
        asked[pattern, stage, engine] += 1
        return source(pattern, stage, engine)

    cycles = scheduled(counted)
    for lanes in (2, 4, 2):
        simulate(TRACE, load_platform("zu9eg").with_value("pl.lanes", lanes), "paper", cycles)
    assert set(asked.values()) == {1}
    assert {key[2].lanes for key in asked} == {2, 4}


@pytest.mark.parametrize(
    ("bad", "says"),
    [
        (
            Schedule({"luck": 3}, 0, "issue", CODE),
            "cause 'luck' is not known; allowed: issue, dependency, read_port",
        ),
        (Schedule({"issue": -3}, 0, "issue", CODE), "issue = -3 cycles: must be 0 or more"),
        (Schedule({"issue": 3}, 4, "issue", CODE), "3 cycles are fewer than the bound 4 allows"),
    ],
)
def test_an_impossible_schedule_is_refused(bad: Schedule, says: str) -> None:
    with pytest.raises(HwModelError, match=says):
        simulate(TRACE, load_platform("zu9eg"), "paper", scheduled(lambda *_: bad))


def test_another_familys_latencies_have_no_schedule() -> None:
    with pytest.raises(HwModelError, match=r"`pl\.latency_preset` = 'vendor_ip': schedules are made with"):
        simulate(
            TRACE,
            load_platform("zu9eg").with_value("pl.latency_preset", "vendor_ip"),
            "paper",
            scheduled(source),
        )
