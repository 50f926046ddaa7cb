"""The insertion in a closed loop: the motion against other integrators, the problem's bits, and what re-planning is worth."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import orbsoc
from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Flight, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import commanded
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions import reachable_insertion as mission
from orbsoc.missions.reachable_insertion.flight.loop import InsertionLoop
from orbsoc.missions.reachable_insertion.flight.motion import Burn, Engine, Field, flown, steps_to
from orbsoc.missions.reachable_insertion.flight.vehicle import FlyingVehicle
from orbsoc.missions.reachable_insertion.model.problem_data import ProblemData
from orbsoc.missions.reachable_insertion.outer_loop import outer_loop, replan_loop
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.targets.target_orbit import TargetOrbit
from orbsoc.orbit import EARTH, Thruster, propagate_burn
from orbsoc.orbit.perturbations import J2, Drag, PointMass, coast

SCENARIOS = Path(__file__).parents[3] / "scenarios"
TIMING = Timing(0.1)


@pytest.fixture(scope="module")
def scenario() -> mission.Scenario:
    return mission.load_scenario(SCENARIOS / "rec1.toml")


@pytest.fixture(scope="module")
def solver() -> OnboardSolver:
    return OnboardSolver()


@pytest.fixture(scope="module")
def loop(scenario: mission.Scenario, solver: OnboardSolver) -> InsertionLoop:
    return InsertionLoop.of(scenario, solver)


@pytest.fixture(scope="module")
def computer() -> Computer:
    return Computer("zu9eg", "paper")


def test_a_burn_is_flown_as_by_dop853() -> None:
    random = np.random.default_rng(4)
    grid = legendre_gauss(7)
    start = np.array([3.0355505e6, 5.8294409e6, 1.611191e5, 6678.4965, -3601.7676, 607.0052])
    for _ in range(5):
        controls = random.standard_normal((7, 3)) * 0.2 + [1.0, 0.3, -0.2]
        burn, engine = Burn(0.0, 120.0, grid, controls, 2.7e5), Engine(2.7e5, 61.0)
        times, all_times = steps_to(0.0, 120.0)
        states = flown(
            start.tolist(), 84507.0, times, burn.vectors(all_times).tolist(), engine, Field.as_planned(EARTH)
        )
        wanted = propagate_burn(
            start, Thruster(84507.0, 2.7e5, 61.0), commanded(grid, controls, 120.0), times
        )
        assert np.abs(np.array(states) - wanted)[:, :3].max() < 2e-2
        assert np.abs(np.array(states) - wanted)[:, 3:].max() < 5e-4


def test_the_planned_burn_is_flown_as_its_verification_flies_it(scenario: mission.Scenario) -> None:
    plan = mission.plan(scenario)
    arc, vehicle = plan.trajectory, scenario.vehicle
    burn = Burn(0.0, plan.time_of_flight_s, arc.grid, arc.controls, vehicle.thrust_n)
    times, all_times = steps_to(0.0, burn.end_s)
    start, engine = plan.setup.start_si.tolist(), Engine(vehicle.thrust_n, vehicle.mass_flow_kg_s)
    vectors, field = burn.vectors(all_times).tolist(), Field.as_planned(EARTH)
    states = flown(start, vehicle.mass_kg, times, vectors, engine, field)
    assert np.abs(np.array(states[-1]) - plan.verification.flight.propagated[-1]).max() < 1e-6


def test_oblateness_and_air_are_those_of_coasts() -> None:
    state = np.array([4.0e6, 3.9e6, 3.4e6, -5.0e3, 5.5e3, 1.2e3])
    field = Field.of(EARTH, np.array([0.0, 0.0, 1.0]), drag_area_m2=30.0)
    times, all_times = steps_to(0.0, 300.0)
    still = [[1.0, 0.0, 0.0]] * len(all_times)
    found = flown(state.tolist(), 5000.0, times, still, Engine(0.0, 0.0), field)
    forces = [PointMass(), J2(), Drag(30.0 / 5000.0)]
    wanted = coast(state[None], np.array([0.0, 300.0]), forces)[-1, 0]
    assert np.abs(np.array(found[-1]) - wanted)[:3].max() < 1e-2
    assert np.abs(np.array(found[-1]) - wanted)[3:].max() < 1e-4


def test_numbers_written_into_the_pattern_have_the_bits_of_the_built_problem(
    scenario: mission.Scenario,
) -> None:
    setup = InsertionSetup.of(scenario)
    assert isinstance(setup.target, TargetOrbit)
    build, iterate = setup.subproblem(soft=False), setup.cold_start()
    data = ProblemData.of(build(iterate).problem, 12, scenario.method.slack_weight)
    for _ in range(3):
        wanted, found = build(iterate), data.about(setup.burn, setup.target, iterate)
        for name in ("c", "b", "h"):
            assert getattr(wanted.problem, name).tobytes() == getattr(found.problem, name).tobytes()
        for name in ("A", "G"):
            one, other = getattr(wanted.problem, name), getattr(found.problem, name)
            assert one.data.tobytes() == other.data.tobytes()
            assert np.array_equal(one.indices, other.indices)
        solution = orbsoc.solve(wanted.problem)
        step, ours = wanted.read(solution), found.read(solution)
        assert step.change == ours.change
        assert step.slack == pytest.approx(ours.slack, rel=1e-12)
        iterate = step.iterate


def test_a_flight_is_the_same_whatever_was_flown_before(loop: InsertionLoop, computer: Computer) -> None:
    one, other = OnboardSolver(), OnboardSolver()
    fly(loop, computer, other, TIMING, seed=3, number=5)
    flights = [fly(loop, computer, each, TIMING, seed=3, number=2) for each in (one, other)]
    assert flights[0].outcome == flights[1].outcome
    assert [c.price for c in flights[0].cycles] == [c.price for c in flights[1].cycles]


def test_replanning_makes_the_end_less_dispersed(
    loop: InsertionLoop, computer: Computer, solver: OnboardSolver
) -> None:
    def off(flights: list[Flight], name: str) -> float:
        return float(np.std([each.outcome[name] for each in flights]))

    closed = [fly(loop, computer, solver, TIMING, seed=1, number=n) for n in range(1, 25)]
    still = [fly(loop, None, solver, TIMING, seed=1, number=n) for n in range(1, 25)]
    for name in ("perigee_off_km", "apogee_off_km"):
        assert off(closed, name) < 0.35 * off(still, name)
    assert all(each.outcome["on_target"] for each in closed)
    assert not all(each.outcome["on_target"] for each in still)
    assert min(each.replans for each in closed) >= 8


def test_the_engine_stops_without_propellant(scenario: mission.Scenario, loop: InsertionLoop) -> None:
    propellant = {"dry_mass_kg": 84507.0 - 61.0 * 20.0}
    dry = scenario.with_changes(vehicle=propellant, burn={"duration_s": 19.0})
    vehicle = FlyingVehicle.of(dry, dry)
    vehicle.advance(loop.first, 40.0)
    assert vehicle.mass_kg == pytest.approx(dry.vehicle.dry_mass_kg)
    assert vehicle.cutoff_s == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"event": {"at_s": 57.0, "thrust_kept": 0.5}}, "event.at_s"),
        ({"event": {"at_s": 5.0, "thrust_kept": 0.5, "flow_kept": 0.0}}, "event.flow_kept"),
        ({"guidance": {"latest_end_s": 50.0}}, "guidance.latest_end_s"),
        ({"problem": "max_energy"}, "problem"),
    ],
)
def test_what_contradicts_the_flight_is_refused_with_its_key(
    scenario: mission.Scenario, changes: dict[str, object], key: str
) -> None:
    with pytest.raises(ScenarioError) as raised:
        mission.closed_loop(scenario.with_changes(**changes), orbsoc.solve)
    assert str(raised.value.complaints[0]).startswith(key)


def test_every_warm_answer_has_its_outer_loop(loop: InsertionLoop, computer: Computer) -> None:
    flight = fly(loop, computer, OnboardSolver(), TIMING, seed=3, number=2)
    data, steps = [], []
    for cycle in flight.cycles:
        assert cycle.counted
        assert cycle.answer is not None
        assert cycle.answer.around is not None
        works = cycle.answer.around.works
        assert len(works) == cycle.solves + 1
        data += [work.instructions for work in works[1:-1]]
        steps.append((cycle.answer.figures["left_s"], works[-1].instructions))
    assert set(data) == {outer_loop(loop.scenario, mission.plan(loop.scenario)).works[1].instructions}  # type: ignore[union-attr]
    assert steps == sorted(steps, reverse=True)  # the judging flight is as long as the burn that is left


def test_the_guidance_loop_executes_what_its_flights_have() -> None:
    short, long = (replan_loop(12, 500, 3, 1, judged).works for judged in (20, 40))
    assert short[:-1] == long[:-1]
    assert long[-1].instructions == pytest.approx(2.0 * short[-1].instructions, rel=0.02)
    [alone] = replan_loop(12, 500, 0, 1, 0).works
    assert alone.instructions == short[0].instructions - short[1].instructions
