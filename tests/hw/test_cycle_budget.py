"""The budget of a plan: it prices every subproblem, compares every word, and never prices half a solve."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import hw_model
import orbsoc
import orbsoc.hw.cycle_budget
from orbsoc import Cones, Problem, Settings, Solution, Status
from orbsoc.guidance.outer_loop import OuterLoop, Work
from orbsoc.guidance.scp import Iteration
from orbsoc.hw.cycle_budget import CycleBudget, cycle_budget

PROBLEM = Problem(
    c=[1.0, 1.0], A=[[1.0, -1.0]], b=[0.5], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(l=2)
)


def row(solution: Solution) -> Iteration:
    return Iteration(1, 1e-8, PROBLEM, solution, 0.0, 0.0, {})


def budget(
    *solutions: Solution,
    deadline_ms: float | None = None,
    verified: bool = True,
    scheduled: bool = False,
    device: str = "zu9eg",
    outer_loop: OuterLoop | None = None,
) -> CycleBudget:
    scheduler = None
    if scheduled:
        scheduler = orbsoc.PsScheduler()
        scheduler(PROBLEM, Settings(tol=1e-8))
    return cycle_budget(
        [row(solution) for solution in solutions],
        device=device,
        partition="paper",
        deadline_ms=deadline_ms,
        verified=verified,
        scheduled=scheduler,
        outer_loop=outer_loop,
    )


@pytest.fixture
def solved() -> Solution:
    return orbsoc.solve(PROBLEM, tol=1e-8)


@pytest.mark.parametrize("scheduled", [True, False])
def test_the_same_solve_has_the_same_bits(solved: Solution, scheduled: bool) -> None:
    assert budget(solved, scheduled=scheduled).same_bits


@pytest.mark.parametrize("name", ["x", "y", "s", "z"])
def test_one_different_last_bit_of_any_vector_is_seen(solved: Solution, name: str) -> None:
    changed = getattr(solved, name).copy()
    changed[-1] = np.nextafter(changed[-1], np.inf)
    assert not budget(replace(solved, **{name: changed})).same_bits


def test_another_status_or_iteration_count_is_seen(solved: Solution) -> None:
    assert not budget(replace(solved, iterations=solved.iterations + 1)).same_bits
    assert not budget(replace(solved, status=Status.SOLVED_INACCURATE)).same_bits


def test_a_difference_does_not_keep_the_later_subproblems_out_of_the_price(solved: Solution) -> None:
    other = replace(solved, iterations=99)
    assert len(budget(other, solved, solved).report.solves) == 3


def test_an_interrupted_solve_is_not_priced(solved: Solution, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = replace(solved, status=Status.INTERRUPTED)
    monkeypatch.setattr(orbsoc.PsScheduler, "__call__", lambda *_: stopped)
    with pytest.raises(KeyboardInterrupt):
        budget(solved)


def test_an_interrupted_comparison_is_not_a_difference(
    solved: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        orbsoc.hw.cycle_budget, "solve", lambda *_: replace(solved, status=Status.INTERRUPTED)
    )
    with pytest.raises(KeyboardInterrupt):
        budget(solved, scheduled=True)


@pytest.mark.parametrize(("deadline_ms", "verdict"), [(1e3, "PASS"), (1e-9, "FAIL")])
def test_the_verdict_says_what_it_is_about(solved: Solution, deadline_ms: float, verdict: str) -> None:
    found = budget(solved, deadline_ms=deadline_ms)
    assert found.summary()["verdict"] == verdict
    assert found.headline.startswith("the conic solves of the plan, modelled: paper on zu9eg")
    assert found.deadline_line.startswith(
        f"modelled deadline verdict for the conic solves of the plan, exact PL cycles: {verdict}: "
    )
    assert "the rest of the outer loop is not in it" in found.deadline_line
    assert "the engine fits, " in found.deadline_line
    assert found.summary()["fits"]
    written = found.to_dict()
    assert (written["headline"], written["deadline_line"]) == (found.headline, found.deadline_line)


def test_a_counted_outer_loop_is_in_the_time_and_in_the_words(solved: Solution) -> None:
    works = (Work(10_000, 100, 10), Work(7_000, 50, 5), Work(1_000_000, 0, 0))
    alone = budget(solved, solved, deadline_ms=1e3)
    found = budget(solved, solved, deadline_ms=1e3, outer_loop=OuterLoop(works, "counted here"))
    ps = hw_model.load_platform("zu9eg").ps
    cycles = (
        1_017_000 * ps.cycles_per_instruction.value
        + 150 * ps.div_f64_cycles.value
        + 15 * ps.sqrt_f64_cycles.value
    )
    generation = sum(
        row.cycles_each * row.runs for row in alone.report.stages if row.stage == "(problem data)"
    )
    more_ms = found.report.makespan_ms.nominal - alone.report.makespan_ms.nominal
    assert more_ms == pytest.approx((cycles - generation) / ps.clock_mhz.value / 1e3, rel=1e-4)
    assert found.headline.startswith("the whole plan, modelled: ")
    assert "is not in it" not in found.deadline_line
    assert found.summary()["outer_loop"] == "counted here"
    assert not any("outer loop" in line for line in found.report.not_modelled)


def test_an_outer_loop_of_another_number_of_solves_is_refused(solved: Solution) -> None:
    with pytest.raises(hw_model.TraceError, match=r"outer_loop\.works has 1 entries; 1 solves need"):
        budget(solved, outer_loop=OuterLoop((Work(1, 0, 0),), "too short"))


def test_an_engine_that_the_device_does_not_hold_meets_no_deadline(solved: Solution) -> None:
    found = budget(solved, deadline_ms=1e6, device="xc7z020")
    assert not found.area.fits
    assert found.summary()["verdict"] == "FAIL"
    assert found.to_dict()["deadline"]["verdict"] == "FAIL"
    assert re.search(
        r": FAIL: the engine does NOT FIT: \w+ at \d+ % of its ceiling; if it did, ", found.deadline_line
    )
    assert "PASS" not in found.deadline_line


def test_without_a_verified_plan_no_deadline_is_met(solved: Solution) -> None:
    found = budget(solved, deadline_ms=1e3, verified=False)
    assert found.summary()["verdict"] is None
    assert found.to_dict()["deadline"] is None
    assert found.deadline_line.startswith("no deadline verdict: there is no verified plan")
    assert "PASS" not in found.deadline_line


def test_without_a_deadline_nothing_is_said_of_one(solved: Solution) -> None:
    assert budget(solved).deadline_line == ""
    assert budget(solved, verified=False).summary()["deadline"] is None
