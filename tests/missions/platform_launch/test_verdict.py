"""The verdict over many launches: short lines, and no word beside VERIFIED that says that what was asked is broken."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.verdict import Question, Word
from orbsoc.missions.platform_launch import Scenario, load_scenario, plan
from tests.missions.platform_launch.data import SCENARIOS, launched
from tests.missions.verdict_rules import assert_rules


@pytest.mark.parametrize("name", ["", "_dispersed", "_norms", "_printed"])
def test_the_shipped_scenarios_are_verified_in_few_short_lines(name: str) -> None:
    found = plan(load_scenario(SCENARIOS / f"paper002{name}.toml"))
    assert found.status is PlanStatus.VERIFIED
    assert_rules(found.verdict, found.status)
    assert found.verdict.word(Question.SAFETY) is Word.NOT_ASKED
    assert (found.verdict.word(Question.FLIGHTS) is Word.SAMPLED) == (name == "_dispersed")


def test_the_cheaper_phase_comes_with_its_command_and_costs_what_it_says() -> None:
    found = plan(launched(500.0))
    (line,) = (each for each in found.verdict.lines if each.question is Question.OPTION)
    assert line.word is Word.CHEAPER
    ((key, value),) = line.settings.items()
    again = plan(launched(500.0, **{key: float(value)}))
    assert again.meeting is not None
    assert f"add up to {again.meeting.value:.4f} m²/s²" in line.figure


def test_what_is_known_of_the_optimum_depends_on_what_was_asked() -> None:
    words = {
        case: plan(launched(rendezvous=table)).verdict.word(Question.OPTIMUM)
        for case, table in (
            ("free", {"duration_s": "free"}),
            ("given", {"duration_s": 1500.0}),
            ("generated", {"impulses": "generated", "cost": "norms", "longest_orbits": 0.5}),
        )
    }
    assert words == {"free": Word.BEST_FOUND, "given": Word.PROVED, "generated": Word.BOUND}


def drawn(seed: int) -> Scenario:
    """Another push, orbit, place, cost, number of impulses and time."""
    random = np.random.default_rng(seed)
    cost = str(random.choice(["squares", "norms"]))
    generated = cost == "norms" and seed % 2 == 0
    return launched(
        float(10.0 ** random.uniform(2.0, 3.3)),
        orbit={
            "altitude_km": float(random.uniform(300.0, 30_000.0)),
            "semi_minor_m": float(10.0 ** random.uniform(2.0, 4.0)),
            "constants": "wgs84",
        },
        phase_deg=float(random.uniform(0.0, 360.0)),
        yaw_bias_deg=float(random.uniform(-60.0, 60.0)),
        rendezvous={
            "cost": cost,
            "impulses": "generated" if generated else 2,
            "longest_orbits": float(random.uniform(0.3, 2.0)),
            "duration_s": "free" if seed % 3 else 1500.0,
        },
        uncertainty={"runs": 20} if seed % 4 == 0 else None,
    )


def test_random_launches_contradict_themselves_nowhere() -> None:
    words: set[Word] = set()
    planned = 0
    for seed in range(24):
        try:
            found = plan(drawn(seed))
        except ScenarioError:
            continue
        assert_rules(found.verdict, found.status)
        words |= {line.word for line in found.verdict.lines}
        planned += 1
    assert planned >= 18
    assert words >= {Word.VERIFIED, Word.CHEAPER, Word.PROVED, Word.BOUND, Word.BEST_FOUND, Word.SAMPLED}
