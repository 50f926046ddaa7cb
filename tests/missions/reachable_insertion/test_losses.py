"""Thrust is lost in flight: the target where it is in reach, else another orbit, with the evidence, beside brute force."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orbsoc.fly.computer import Computer
from orbsoc.fly.loop import Fate, Flight, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.guidance.verdict import Question, Word
from orbsoc.missions import reachable_insertion as mission
from orbsoc.missions.reachable_insertion.flight.loop import InsertionLoop
from orbsoc.missions.reachable_insertion.flight.warm import Belief
from orbsoc.missions.reachable_insertion.model.highest_perigee import perigee_gradient, perigee_radius
from orbsoc.orbit import EARTH, rotate_state
from orbsoc.orbit.array import Array

SCENARIO = Path(__file__).parents[3] / "scenarios" / "rec1_dry.toml"
AZIMUTHS = 500
IN_REACH, OUT_OF_REACH = (20.0, 0.6), (35.0, 0.25)
"""Losses chosen by brute force: time, and share of the thrust that is kept."""


def loop_of(at_s: float, kept: float) -> InsertionLoop:
    event = {"at_s": at_s, "thrust_kept": kept}
    return InsertionLoop.of(mission.load_scenario(SCENARIO).with_changes(event=event), OnboardSolver())


def flown(loop: InsertionLoop) -> Flight:
    return fly(loop, Computer("zu9eg", "all_ps"), OnboardSolver(), Timing(0.1))


def believed(loop: InsertionLoop) -> Belief:
    assert loop.scenario.event is not None
    vehicle = loop.vehicle(0, 0)
    vehicle.advance(loop.first, loop.scenario.event.known_s)
    return loop._belief(vehicle.sense(np.random.default_rng(0)), loop.first, 0.1)


def perigees(r: Array, v: Array) -> Array:
    """Radii (K,), SI."""
    h = np.cross(r, v)
    laplace = np.cross(v, h) / EARTH.mu_m3_s2 - r / np.linalg.norm(r, axis=1, keepdims=True)
    return (h * h).sum(axis=1) / EARTH.mu_m3_s2 / (1.0 + np.linalg.norm(laplace, axis=1))


def by_brute_force(belief: Belief) -> float:
    """The highest perigee (m) of thrust at constant and turning pitch from 500 azimuths, in orbit and inertially, at any cut-off."""
    azimuths = np.linspace(0.0, 2.0 * np.pi, AZIMUTHS, endpoint=False)
    rates = np.deg2rad([-0.6, -0.3, 0.0, 0.3, 0.6])
    angle, rate = (each.ravel() for each in np.meshgrid(azimuths, rates))
    return max(_highest(belief, angle, rate, fixed=fixed) for fixed in (False, True))


def _highest(belief: Belief, angle: Array, rate: Array, *, fixed: bool, steps: int = 40) -> float:
    r, v = (np.tile(each, (angle.size, 1)) for each in (belief.state[:3], belief.state[3:]))
    step = belief.longest_s / steps

    def axes(r: Array, v: Array) -> tuple[Array, Array]:
        out = r / np.linalg.norm(r, axis=1, keepdims=True)
        h = np.cross(r, v)
        return out, np.cross(h / np.linalg.norm(h, axis=1, keepdims=True), out)

    first = axes(r, v)

    def pull(t: float, r: Array, v: Array) -> Array:
        out, along = first if fixed else axes(r, v)
        turned = (angle + rate * t)[:, None]
        thrust = belief.engine.thrust_n / (belief.mass_kg - belief.engine.flow_kg_s * t)
        radius = np.linalg.norm(r, axis=1, keepdims=True)
        return thrust * (np.cos(turned) * along + np.sin(turned) * out) - EARTH.mu_m3_s2 * r / radius**3

    best = perigees(r, v)
    for k in range(steps):
        t, half = k * step, 0.5 * step
        a = pull(t, r, v)
        b = pull(t + half, r + half * v, v + half * a)
        c = pull(t + half, r + half * (v + half * a), v + half * b)
        d = pull(t + step, r + step * (v + half * b), v + step * c)
        r, v = r + step * v + step**2 / 6.0 * (a + b + c), v + step / 6.0 * (a + 2.0 * (b + c) + d)
        best = np.maximum(best, perigees(r, v))
    return float(best.max())


def test_the_derivative_of_the_perigee_is_that_of_differences() -> None:
    end = np.array([0.5, 0.85, 0.1, 0.8, -0.45, 0.1])
    steps = 1e-6 * np.eye(6)
    wanted = [(perigee_radius(end + h) - perigee_radius(end - h)) / 2e-6 for h in steps]
    assert perigee_gradient(end) == pytest.approx(wanted, abs=1e-8)


def test_a_loss_that_leaves_the_target_in_reach_ends_on_it() -> None:
    loop = loop_of(*IN_REACH)
    flight = flown(loop)
    assert flight.outcome["on_target"] == 1.0
    assert flight.outcome["cutoff_s"] > 1.5 * loop.first.duration_s
    assert next(iter(loop.verdict(flight))).word is Word.MET
    without = fly(loop, None, OnboardSolver(), Timing(0.1))
    assert without.outcome["safe"] == 0.0


def test_a_loss_that_does_not_is_proved_and_a_safe_orbit_is_flown_to() -> None:
    loop = loop_of(*OUT_OF_REACH)
    flight = flown(loop)
    answer, safety = loop.verdict(flight)
    assert (answer.word, safety.word) == (Word.INSTEAD, Word.SAFE)
    assert answer.question is Question.ANSWER
    assert answer.claim is not None
    assert answer.claim.kind.value == "proved"
    assert by_brute_force(believed(loop)) - EARTH.earth_radius_m > 120e3
    assert flight.outcome["perigee_km"] > 120.0


@pytest.mark.parametrize(("at_s", "kept"), [(10.0, 0.4), (20.0, 0.4), (35.0, 0.2)])
def test_the_highest_perigee_is_that_of_brute_force(at_s: float, kept: float) -> None:
    loop = loop_of(at_s, kept)
    belief = believed(loop)
    burn = loop.losses.highest(belief, loop.first, OnboardSolver())
    end, _ = loop.warm.end_of(belief, burn)
    wanted = by_brute_force(belief)
    found = perigee_radius(end) * EARTH.earth_radius_m
    assert found > wanted - 1.5e3
    if wanted - EARTH.earth_radius_m < 125e3:  # where it decides whether an orbit lasts
        assert found > wanted - 50.0


def test_an_engine_that_is_out_leaves_nothing_to_plan_and_says_so() -> None:
    loop = loop_of(20.0, 0.0)
    flight = flown(loop)
    answer, safety = loop.verdict(flight)
    assert (answer.word, safety.word) == (Word.MISSED, Word.NOT_SAFE)
    assert "out of reach, proved" in answer.figure
    assert flight.replans == 4


def test_what_is_proved_out_of_reach_no_search_reaches() -> None:
    for at_s, kept in ((10.0, 0.4), (20.0, 0.35), (35.0, 0.25)):
        loop = loop_of(at_s, kept)
        belief = believed(loop)
        assert loop.losses.proof(belief) is not None
        assert not mission.plan(loop.losses.scenario_of(belief, "target")).verified


def test_a_scenario_told_in_eci_flies_to_the_same_orbit() -> None:
    exact = {"position_m": 0.0, "velocity_m_s": 0.0}
    scenario = mission.load_scenario(SCENARIO).with_changes(guidance=exact)
    turned = {
        key: rotate_state(scenario.eci_rotation, getattr(scenario, key).vector()).tolist()
        for key in ("initial", "target")
    }
    vectors = {key: {"position_m": x[:3], "velocity_m_s": x[3:]} for key, x in turned.items()}
    document = scenario.model_dump() | vectors | {"axes": "eci", "launch_site": None}
    other = checked(mission.Scenario, document, source="in ECI")
    ends = [flown(InsertionLoop.of(each, OnboardSolver())).outcome for each in (scenario, other)]
    assert ends[0]["on_target"] == ends[1]["on_target"] == 1.0
    assert ends[0]["propellant_kg"] == pytest.approx(ends[1]["propellant_kg"], rel=1e-3)
    assert ends[0]["perigee_km"] == pytest.approx(ends[1]["perigee_km"], abs=0.05)


def test_another_order_of_preference_is_kept() -> None:
    event = {"at_s": 35.0, "thrust_kept": 0.25}
    scenario = mission.load_scenario(SCENARIO).with_changes(event=event, guidance={"instead": ["energy"]})
    loop = InsertionLoop.of(scenario, OnboardSolver())
    choice = loop.losses.decide(believed(loop), loop.first, OnboardSolver())
    assert [each.sought for each in choice.decisions][1] == "the largest orbit above the safe perigee"
    assert choice.burn is not None


@pytest.mark.parametrize(("at_s", "out_s"), [(20.0, 5.0), (40.0, 0.6), (20.0, 20.0)])
def test_an_engine_that_burns_again_still_brings_the_vehicle_to_its_target(at_s: float, out_s: float) -> None:
    event = {"at_s": at_s, "thrust_kept": 0.0, "reignite_after_s": out_s}
    loop = InsertionLoop.of(mission.load_scenario(SCENARIO).with_changes(event=event), OnboardSolver())
    flight = flown(loop)
    assert flight.outcome["on_target"] == 1.0
    assert {each.fate for each in flight.cycles} == {Fate.FLOWN}
    [event_cycle] = [each for each in flight.cycles if each.trigger.urgent]
    assert event_cycle.flown_s == pytest.approx(at_s + out_s)
    assert not [each for each in flight.cycles if at_s + 0.2 < each.trigger.at_s < at_s + out_s]
    burnt_s = flight.outcome["cutoff_s"] - out_s
    flow = loop.scenario.vehicle.mass_flow_kg_s
    assert flight.outcome["propellant_kg"] == pytest.approx(flow * burnt_s, rel=0.01)
    assert fly(loop, None, OnboardSolver(), Timing(0.1)).outcome["on_target"] == 0.0


@pytest.mark.parametrize(
    ("event", "words"),
    [
        ({"thrust_kept": 0.5, "reignite_after_s": 5.0}, r"event\.thrust_kept = 0\.5: must be 0"),
        (
            {"thrust_kept": 0.0, "reignite_after_s": 0.05},
            r"must be above detected_after_s = 0\.1, and below 36",
        ),
        ({"thrust_kept": 0.0, "reignite_after_s": 50.0}, "when the burn ends as planned"),
        ({"thrust_kept": 0.0, "reignite_after_s": -1.0}, "above 0"),
    ],
)
def test_an_engine_that_cannot_burn_again_so_is_told(event: dict[str, float], words: str) -> None:
    scenario = mission.load_scenario(SCENARIO)
    with pytest.raises(ScenarioError, match=words):
        InsertionLoop.of(scenario.with_changes(event={"at_s": 20.0} | event), OnboardSolver())
