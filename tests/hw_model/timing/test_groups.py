"""Groups of interleaved problems: what is in one, how often its segments run, and which reports are of one problem."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

from hw_model import HwModelError, load_partition, load_platform, parse_trace, simulate, speedup
from hw_model.area.budget import budget
from hw_model.report.remedies import remedies
from hw_model.report.study import Study
from hw_model.report.throughput import throughputs
from hw_model.timing.actions import actions_of
from hw_model.timing.groups import grouped, in_groups
from hw_model.timing.limits import limits
from hw_model.timing.stage_cycles import Microcode, PlCycles, estimated
from hw_model.timing.trace import Solve, Trace
from tests.hw_model.synthetic import synthetic_trace

METHOD = {
    "startup": [["equilibrate"], ["load_kkt"], ["factorize"], ["rhs"], ["solve_kkt"], ["refine_kkt", "check_solve"]],
    "warm_startup": [["equilibrate"], ["load_kkt"], ["start"]],
    "iteration": [
        ["statistics"], ["nt_scaling"], ["scaling_blocks"], ["factorize"], ["rhs"], ["solve_kkt"],
        ["refine_kkt", "check_solve"], ["direction"], ["step_length"], ["centering"], ["cone_product"], ["corrector_rhs"],
        ["solve_kkt"], ["refine_kkt", "check_solve"], ["direction"], ["step_length"], ["advance"],
    ],
    "closing": [["unscale"]],
    "flags": {"statistics": "stop", "start": "stop", "check_solve": "repeat"},
}  # fmt: skip


def _trace() -> Trace:
    """The synthetic one with its lists, seven modules, and a stage that only a warm start runs."""
    made = synthetic_trace(iterations=3, solves=2)
    stages = made["patterns"][0]["stages"]
    stages["start"] = stages["rhs"]
    stages |= {name: at | {"module": "statistics"} for name, at in stages.items() if at["module"] == "ps"}
    return parse_trace(made | {"method": METHOD})


TRACE = _trace()
RESIDENT, PAPER, ALL_PS = (load_partition(name) for name in ("resident", "paper", "all_ps"))
ZU9EG = load_platform("zu9eg")


def several(copies: int) -> Any:
    return ZU9EG.with_value("pl.interleaved", copies)


def scheduled(trace: Trace, platform: Any, pattern: int, stage: str) -> PlCycles:
    """A thousand cycles and a hundred more for each problem of a segment."""
    cycles = 900 + 100 * platform.pl.interleaved.value
    return PlCycles({"issue": cycles}, 0, "issue", "schedule", Microcode(cycles, 4 * cycles, cycles), 100)


def solves(*patterns: int) -> Trace:
    """Solves of these patterns, told apart by their iterations."""
    one = TRACE.solves[0]
    made = tuple(one.model_copy(update={"pattern": p, "iterations": k}) for k, p in enumerate(patterns))
    return TRACE.model_copy(update={"patterns": TRACE.patterns * (1 + max(patterns)), "solves": made})


def numbers(found: tuple[Solve, ...]) -> list[int]:
    return [solve.iterations for solve in found]


def test_solves_of_a_pattern_follow_one_another() -> None:
    assert numbers(in_groups(solves(0, 1, 0, 1, 1), 2).solves) == [0, 2, 1, 3, 4]
    assert in_groups(TRACE, 1) is TRACE


def test_a_workload_of_fewer_solves_stands_for_as_many_runs_of_it() -> None:
    assert numbers(in_groups(solves(0, 1, 0), 2).solves) == [0, 0, 2, 2, 1, 1]
    assert len(in_groups(TRACE, 8).solves) == 16


def test_a_group_is_of_one_pattern_and_the_last_may_be_smaller() -> None:
    trace = in_groups(solves(0, 1, 0, 1, 1), 2)
    works = list(grouped(actions_of(trace, RESIDENT), trace, 2))
    launched = Counter(work.pattern for work in works if work.kind == "launch")
    assert launched == {0: 2, 1: 3}  # all but the PL's work is once a problem
    starts = Counter(work.pattern for work in works if work.kind == "compute" and work.what == "equilibrate")
    assert starts == {0: 1, 1: 2}


def test_what_closes_an_attempt_runs_once_though_problems_end_at_different_iterations() -> None:
    long = TRACE.solves[0]
    turns = [event for event in long.events if event[1] < 2]
    short = long.model_copy(update={"events": (*turns, ("statistics", 2), ("unscale", 2))})
    pair = TRACE.model_copy(update={"solves": (short, long)})
    together, alone = (
        Counter(work for work in grouped(actions_of(trace, RESIDENT), trace, 2) if work.side == "pl")
        for trace in (pair, TRACE.model_copy(update={"solves": (long,)}))
    )
    computed = {work: times for work, times in together.items() if work.kind in ("compute", "control")}
    assert computed == {work: times for work, times in alone.items() if work.kind in ("compute", "control")}
    closed = [work for work in computed if work.kind == "compute" and work.what == "unscale"]
    assert [computed[work] for work in closed] == [1]


def test_a_solve_that_starts_warm_is_in_no_group() -> None:
    started = TRACE.solves[0].model_copy(update={"events": (("start", 0), *TRACE.solves[0].events)})
    trace = TRACE.model_copy(update={"solves": (TRACE.solves[1], started)})
    with pytest.raises(
        HwModelError, match="solve 1 of the workload starts warm, and interleaved problems start"
    ):
        in_groups(trace, 2)


def test_interleaved_problems_are_more_a_second_where_their_segments_share_cycles() -> None:
    rows = [throughputs(TRACE, several(copies), RESIDENT, ALL_PS, scheduled)[0] for copies in (1, 2, 4)]
    rates = [row.solves_per_s for row in rows]
    assert rates == sorted(set(rates))
    assert [row.interleaved for row in rows] == [1, 2, 4]
    assert [row.buffer_words for row in rows] == [copies * rows[0].buffer_words for copies in (1, 2, 4)]
    assert " 1 of 4 interleaved in flight" in rows[2].words
    assert "interleaved" not in rows[0].words
    assert {row.baseline_per_s for row in rows} == {rows[0].baseline_per_s}


def test_the_ps_alone_interleaves_nothing() -> None:
    one, four = (throughputs(TRACE, several(copies), ALL_PS, ALL_PS, scheduled) for copies in (1, 4))
    assert one == four
    assert budget(TRACE, several(4), ALL_PS) == budget(TRACE, ZU9EG, ALL_PS)


def test_a_budget_has_the_words_of_all_problems_until_they_do_not_fit() -> None:
    found = {copies: budget(TRACE, several(copies), RESIDENT, scheduled) for copies in (1, 2, 8, 64)}
    for copies, each in found.items():
        assert each.storage_words == pytest.approx(copies * found[1].storage_words, abs=copies)
    uses = [each.of("bram36").used for each in found.values()]
    assert uses == sorted(uses)
    assert found[1].fits
    assert not found[64].fits
    assert found[64].tightest.kind == "bram36"
    assert found[2].microcode_words > found[1].microcode_words
    assert remedies(TRACE, several(64), RESIDENT, scheduled) == []


@pytest.mark.parametrize("priced", [throughputs, budget])
def test_the_ps_does_not_run_several_problems_in_one_stream(priced: Callable[..., Any]) -> None:
    base = (ALL_PS,) if priced is throughputs else ()
    with pytest.raises(
        HwModelError,
        match=r"`pl\.interleaved` = 2 under partition 'paper': only the PL's own control .*resident",
    ):
        priced(TRACE, several(2), PAPER, *base, scheduled)


def test_an_estimate_knows_no_interleaved_problems() -> None:
    with pytest.raises(
        HwModelError, match=r"`pl\.interleaved` = 2: the estimate knows no .*ask for schedules"
    ):
        budget(TRACE, several(2), RESIDENT, estimated)


@pytest.mark.parametrize("schedule", ["serial", "overlapped"])
def test_reports_of_one_problem_refuse_several(schedule: str) -> None:
    platform = several(8).with_values({"runtime.schedule": schedule, "runtime.cores_used": 2})
    reports: list[Callable[[], object]] = [
        lambda: simulate(TRACE, platform, RESIDENT, scheduled),
        lambda: speedup(TRACE, platform, RESIDENT, cycles=scheduled),
        lambda: speedup(TRACE, platform, "best", cycles=scheduled),
        lambda: Study(TRACE, scheduled).points(platform, [RESIDENT]),
        lambda: limits(TRACE, platform, RESIDENT, scheduled),
    ]
    for report in reports:
        with pytest.raises(
            HwModelError, match=r"`pl\.interleaved` = 8: this report is of one problem after the"
        ):
            report()
