"""Path: the Rust loop and the PS in Python, launch by launch, give the same solve bit for bit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pytest

from orbsoc import PsScheduler, _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.missions.reachable_insertion import load_scenario, plan
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.segments import Method
from orbsoc.solving.solver import solve
from tests.zoo import ZooCase, cases, rescaled_twins

METHOD = Method.from_core(_core)
ITERATE = ("point", "slack", "homogenizer")
ERRORS = ("kkt_error", "refinement", "pair_error", "pair_refinement", "refinement_active")
"""Of linear solves: the Rust loop leaves out those at which no decision looks, a PL's program computes them all."""
READ = tuple(name for name in METHOD.buffers if name not in ERRORS)
ZOO = [*cases(), *rescaled_twins()]
SETTINGS = Settings()

Contents = dict[str, bytes]


def contents(engine: _core.Engine, names: tuple[str, ...]) -> Contents:
    return {name: engine.buffer(name).tobytes() for name in names}


class Scheduled:
    """A solve on the emulated computer, with all its attempts, that keeps the iterate after every step."""

    def __init__(self, problem: Problem, busy_ticks: int = 1) -> None:
        self.engine = _core.Engine(problem, SETTINGS)
        self.iterates: dict[int, Contents] = {}
        pl = ProgrammableLogic(METHOD, self.engine.run, busy_ticks=busy_ticks)
        driver = Driver(METHOD, self.engine, pl, words=self.engine.buffer_words(), record=PsRecord())
        driver.run(restart=self.engine.begin_again, observe=self.keep)

    def keep(self) -> None:
        self.iterates[self.engine.iteration] = contents(self.engine, ITERATE)


def one_by_one(problem: Problem, events: list[tuple[str, int]]) -> _core.Engine:
    """The stages of `events` in turn, each with every entry that it declares."""
    engine = _core.Engine(problem, SETTINGS)
    for index, (stage, _iteration) in enumerate(events):
        engine.run(stage)
        if stage == "unscale" and index + 1 < len(events):
            assert engine.begin_again()
    return engine


def stop_after(step: int) -> Callable[[dict[str, float]], bool]:
    return lambda progress: progress["iteration"] >= step


@pytest.mark.parametrize("case", ZOO, ids=lambda case: case.name)
def test_status_solution_buffers_and_events_are_the_same(case: ZooCase) -> None:
    rust = _core.Engine(case.problem, SETTINGS)
    whole = rust.solve()
    scheduled = Scheduled(case.problem)
    stepped = scheduled.engine.finish()
    assert scheduled.engine.events() == rust.events()
    assert contents(scheduled.engine, READ) == contents(rust, READ)
    assert contents(scheduled.engine, METHOD.buffers) == contents(
        one_by_one(case.problem, rust.events()), METHOD.buffers
    )
    assert (stepped.status, stepped.message) == (whole.status, whole.message)
    assert (stepped.iterations, stepped.refinements) == (whole.iterations, whole.refinements)
    for name in ("x", "y", "z", "s"):
        assert getattr(stepped, name).tobytes() == getattr(whole, name).tobytes()
    for name in ("objective", "dual_objective", "primal_residual", "dual_residual", "gap", "radius"):
        ours, theirs = getattr(stepped, name), getattr(whole, name)
        assert ours == theirs or (math.isnan(ours) and math.isnan(theirs)), name


@pytest.mark.parametrize("case", ZOO, ids=lambda case: case.name)
def test_every_iterate_on_the_way_is_the_same(case: ZooCase) -> None:
    """The Rust loop is stopped after each number of steps, and its iterate compared with the scheduled one."""
    scheduled = Scheduled(case.problem)
    assert list(scheduled.iterates) == list(range(1, scheduled.engine.finish().iterations + 1))
    for step, iterate in scheduled.iterates.items():
        rust = _core.Engine(case.problem, SETTINGS)
        rust.solve(stop_after(step))
        assert contents(rust, ITERATE) == iterate, f"after {step} steps"


@pytest.mark.parametrize("case", cases()[:5], ids=lambda case: case.name)
def test_the_time_a_segment_takes_changes_no_number(case: ZooCase) -> None:
    quick, slow = Scheduled(case.problem), Scheduled(case.problem, busy_ticks=17)
    assert quick.iterates == slow.iterates
    assert quick.engine.events() == slow.engine.events()


def test_a_mission_has_the_same_plan_on_the_emulated_computer() -> None:
    scenario = load_scenario(Path(__file__).resolve().parents[2] / "scenarios" / "rec1.toml")
    ps = PsScheduler()
    ours, theirs = plan(scenario, solve=ps), plan(scenario, solve=solve)
    assert ours.status is theirs.status
    for field in fields(ours.trajectory):
        a, b = getattr(ours.trajectory, field.name), getattr(theirs.trajectory, field.name)
        assert getattr(a, "tobytes", lambda a=a: a)() == getattr(b, "tobytes", lambda b=b: b)(), field.name
    assert len(ps.trace["solves"]) == len(ours.subproblems)
    assert len(ps.trace["patterns"]) == 1
