"""The computer on board prices solves as `orbsoc plan` does, exactly, whatever they ran."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest

from orbsoc.fly.computer import Computer
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.outer_loop import OuterLoop
from orbsoc.hw.cycle_budget import cycle_budget
from orbsoc.missions import reachable_insertion as mission

SCENARIOS = Path(__file__).parents[2] / "scenarios"


class ColdSolver(OnboardSolver):
    """Every solve from nothing, as on the ground."""

    def __call__(self, problem, settings=None, /):  # type: ignore[no-untyped-def]
        self._last.clear()
        return super().__call__(problem, settings)


@pytest.fixture(scope="module")
def planned() -> tuple[ColdSolver, object]:
    solver = ColdSolver()
    return solver, mission.plan(mission.load_scenario(SCENARIOS / "rec1.toml"), solve=solver)


def test_a_plan_costs_what_it_costs_on_the_ground(planned) -> None:  # type: ignore[no-untyped-def]
    solver, plan = planned
    found = Computer("zu9eg", "paper").price(solver.ran, solver)
    budget = cycle_budget(
        plan.subproblems, device="zu9eg", partition="paper", deadline_ms=None, verified=True
    )
    assert found.time_ms == pytest.approx(budget.report.makespan_ms.nominal, rel=1e-14)
    assert found.pl_cycles == budget.report.cycles["pl"]


def test_twice_as_slow_takes_twice_the_time_for_the_same_cycles(planned) -> None:  # type: ignore[no-untyped-def]
    solver, _ = planned
    computer = Computer("zu9eg", "paper")
    one, two = (computer.at(slower).price(solver.ran, solver) for slower in (1.0, 2.0))
    assert (two.time_s, two.pl_cycles) == (2.0 * one.time_s, one.pl_cycles)


@pytest.mark.parametrize(
    ("device", "partition"),
    [*product(["zu9eg"], ["paper", "all_ps", "paper_streams", "factor_only", "resident"]), ("rocket_soc", "paper")],
)  # fmt: skip
def test_a_cost_put_together_from_steps_is_that_of_all_actions(device: str, partition: str) -> None:
    solver = OnboardSolver()
    scenario = mission.load_scenario(SCENARIOS / "rec1.toml")
    for mass_kg in (84507.0, 84000.0, 80000.0):  # warm and cold solves, with restarts where they come
        mission.plan(scenario.with_changes(vehicle={"mass_kg": mass_kg}), solve=solver)
    computer = Computer(device, partition)
    for ran, alone in product(set(solver.ran), (False, True)):
        computer._price(ran, alone, solver)
        costs = computer._costs[ran.pattern, alone].costs
        assert costs.of(ran.events) == costs.whole(ran.events)
        twice = (*ran.events, *ran.events)  # another attempt
        assert costs.of(twice) == costs.whole(twice)


def test_an_answer_does_not_depend_on_what_was_solved_before(planned) -> None:  # type: ignore[no-untyped-def]
    _, plan = planned
    problems = [(each.problem, each.settings) for each in plan.subproblems]
    fresh, used = OnboardSolver(), OnboardSolver()
    for each in reversed(problems):
        used(*each)
    used.begin()
    for each in problems:
        one, other = fresh(*each), used(*each)
        assert one.x.tobytes() == other.x.tobytes()
    assert fresh.ran == used.ran


def test_with_its_outer_loop_a_plan_costs_what_it_costs_on_the_ground(planned) -> None:  # type: ignore[no-untyped-def]
    solver, plan = planned
    around = mission.outer_loop(plan.scenario, plan)
    assert around is not None
    found = Computer("zu9eg", "paper").price(solver.ran, solver, around)
    budget = cycle_budget(
        plan.subproblems, device="zu9eg", partition="paper", deadline_ms=None, verified=True, outer_loop=around
    )  # fmt: skip
    assert found.time_ms == pytest.approx(budget.report.makespan_ms.nominal, rel=1e-14)
    assert found.pl_cycles == budget.report.cycles["pl"]


@pytest.mark.parametrize("partition", ["paper", "paper_streams"])
def test_of_an_outer_loop_about_some_solves_the_others_are_generated_as_assumed(
    planned, partition: str
) -> None:  # type: ignore[no-untyped-def]
    solver, plan = planned
    around = mission.outer_loop(plan.scenario, plan)
    assert around is not None
    computer, ran = Computer("zu9eg", partition), solver.ran
    part = OuterLoop(around.works[:2], around.source)
    one = computer.price(ran[:1], solver, part)
    rest = computer.price(ran[1:], solver)
    both = computer.price(ran, solver, part)
    assert both.time_s == pytest.approx(one.time_s + rest.time_s, rel=1e-14)
