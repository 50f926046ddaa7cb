"""The verdict over many scenarios: short lines, and no word beside VERIFIED that says that what was asked is broken."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.verdict import Question, Word
from orbsoc.missions.phasing import Scenario, load_scenario, plan
from tests.missions.phasing.cases import planned
from tests.missions.verdict_rules import assert_rules


def ahead(angle_deg: float, acceleration_m_s2: float | None = None, **tables: object) -> Scenario:
    """Two bodies on one orbit, the target ahead by an angle."""
    orbit = {
        "sma_km": 6928.137, "ecc": 0.001, "inc_deg": 53.0, "raan_deg": 10.0, "argp_deg": 0.0, "true_anomaly_deg": 0.0,
        "epoch_s": 0.0,
    }  # fmt: skip
    engine = (
        None if acceleration_m_s2 is None else {"acceleration_m_s2": acceleration_m_s2, "exhaust_m_s": 2900.0}
    )
    return Scenario.model_validate(
        {
            "mission": "phasing", "name": "ahead", "forces": ["j2"], "chaser": orbit,
            "target": orbit | {"true_anomaly_deg": angle_deg}, "window": {"revolutions": 12, "latest_h": 20.0},
            "engine": engine, **tables,
        }
    )  # fmt: skip


@pytest.mark.parametrize("name", ["socp", "chance", "design", "timing"])
def test_the_shipped_scenarios_are_verified_in_few_short_lines(name: str) -> None:
    found = planned(name)
    assert found.status is PlanStatus.VERIFIED
    assert_rules(found.verdict, found.status)


def test_an_engine_too_weak_for_the_impulses_is_not_verified_and_says_by_how_much() -> None:
    found = plan(ahead(40.0, 0.05))
    assert found.status is PlanStatus.NOT_VERIFIED
    assert_rules(found.verdict, found.status)
    assert found.verdict.word(Question.ENGINE) is Word.TOO_WEAK
    answer, engine = str(found.verdict.lines[0]), str(found.verdict.lines[-1])
    assert "5 impulses fly as impulses (0.00 m off), not as burns" in answer
    assert "miss by 2.5 km (allowed 1 km)" in engine
    strong = plan(ahead(40.0, 1.0))
    assert strong.status is PlanStatus.VERIFIED
    assert strong.verdict.word(Question.ENGINE) is Word.ENOUGH


def test_burns_without_room_are_too_weak() -> None:
    found = plan(ahead(40.0, 1e-3))
    assert found.status is PlanStatus.NOT_VERIFIED
    assert found.verdict.word(Question.ENGINE) is Word.TOO_WEAK
    assert_rules(found.verdict, found.status)


def test_corrections_that_diverge_from_short_burns_do_not_judge_the_engine() -> None:
    found = planned("design")
    assert found.analysis is not None
    assert found.analysis.finite is not None
    assert found.analysis.finite.diverged
    assert found.verdict.word(Question.ENGINE) is Word.NOT_JUDGED


def test_a_bound_about_the_plan_is_called_a_bound_and_shooting_has_none() -> None:
    assert planned().verdict.word(Question.OPTIMUM) is Word.BOUND
    assert planned("design").verdict.word(Question.OPTIMUM) is None


def test_what_flies_is_verified_with_its_optimality_told_apart() -> None:
    """A descent whose bound is 5e-6 below the plan: a campaign's leg, 4 revolutions, JPL spent 115.2 m/s."""
    found = plan(load_scenario(Path(__file__).parent / "gtoc9_25_20.toml"))
    assert found.status is PlanStatus.VERIFIED
    assert_rules(found.verdict, found.status)
    assert found.programme is not None
    assert found.programme.total_m_s == pytest.approx(111.474, abs=1e-3)
    line = found.verdict.lines[1]
    assert line.word in {Word.BOUND, Word.BEST_FOUND}
    assert line.claim is not None
    assert line.claim.gap is not None
    assert 0.0 <= line.claim.gap < 1e-5


def test_a_chance_that_the_draws_miss_fails() -> None:
    """The scheme of the paper does not see the probability that is asked for."""
    errors = {"probability": 0.999, "distance_km": 20.0, "runs": 500}
    found = plan(planned("design").scenario.with_changes(uncertainty=errors, surprise=None, engine=None))
    assert found.status is PlanStatus.NOT_VERIFIED
    assert found.verdict.word(Question.FLIGHTS) is Word.MISSED
    assert_rules(found.verdict, found.status)
    assert planned("chance").verdict.word(Question.FLIGHTS) is Word.MET


def test_a_cheaper_number_of_revolutions_comes_with_its_command() -> None:
    found = plan(ahead(40.0, window={"revolutions": 6, "latest_h": 30.0, "front": [12]}))
    line = found.verdict.lines[1]
    assert line.word is Word.CHEAPER
    assert line.settings == {"window.revolutions": "12"}
    again = plan(ahead(40.0, window={"revolutions": 12, "latest_h": 30.0}))
    assert again.programme is not None
    assert line.figure.startswith(f"{again.programme.total_m_s:.1f} m/s")


def test_a_plan_without_a_flight_has_an_answer_alone() -> None:
    broken = replace(planned(), status=PlanStatus.FAILED, programme=None, verification=None, analysis=None)
    assert [line.word for line in broken.verdict.lines] == [Word.FAILED]


def drawn(seed: int) -> Scenario:
    """Another distance, engine, number of revolutions, front, probability and scheme."""
    random = np.random.default_rng(seed)
    acceleration = 10.0 ** random.uniform(-3.0, 0.5) if seed % 4 else None
    turns = int(random.integers(6, 20))
    return ahead(
        float(random.uniform(-20.0, 80.0)), acceleration,
        window={"revolutions": turns, "latest_h": 2.0 * turns, "front": [turns + 2] if seed % 3 else []},
        uncertainty={"runs": 200, "probability": random.choice([None, 0.9, 0.99])} if seed % 2 else None,
        scheme="paper" if seed % 5 == 0 else "socp",
        limits={"perigee_height_km": 150.0, "apogee_height_km": 30_000.0},
    )  # fmt: skip


def test_random_phasings_contradict_themselves_nowhere() -> None:
    words: set[Word] = set()
    planned_ones = 0
    for seed in range(24):
        try:
            found = plan(drawn(seed))
        except ScenarioError:  # no phasing orbit meets the target within the limits
            continue
        assert_rules(found.verdict, found.status)
        words |= {line.word for line in found.verdict.lines}
        planned_ones += 1
    assert planned_ones >= 20
    assert words >= {Word.VERIFIED, Word.NOT_VERIFIED, Word.TOO_WEAK, Word.ENOUGH, Word.BOUND, Word.MET}
