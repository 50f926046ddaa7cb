"""The verdict over many scenarios: short lines, and no word beside VERIFIED that says that what was asked is broken."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.verdict import WIDTH, Question, Word
from orbsoc.missions import passive_safety
from tests.missions.passive_safety.cases import CASES

SEEDS = range(24)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_verified_plan_has_no_bad_word_and_an_unsafe_one_is_not_verified(seed: int) -> None:
    random = np.random.default_rng(seed)
    keep_out = float(random.choice([20.0, 50.0, 150.0]))
    depth = keep_out + random.uniform(5.0, 50.0)
    safety = str(random.choice(["cone", "samples"]))
    changes = {
        "keep_out_m": keep_out,
        "start": {"x_m": -float(random.uniform(600.0, 4000.0))},
        "capture": {"x_m": 0.0, "z_m": depth},
        "safety": safety,
        "cost": str(random.choice(["norms", "absolutes"])),
        "impulses": {"count": int(random.integers(3, 7))},
    }
    try:
        found = passive_safety.plan(CASES[seed % len(CASES)].scenario(**changes))
    except ScenarioError:
        pytest.fail("these data contradict nothing")
    verdict = found.verdict
    assert max(map(len, str(verdict).splitlines())) <= WIDTH
    assert verdict.succeeded == (found.status is PlanStatus.VERIFIED)
    if verdict.word(Question.SAFETY) is Word.NOT_SAFE:
        assert verdict.word(Question.ANSWER) is Word.NOT_VERIFIED
    if found.status is PlanStatus.VERIFIED and safety == "cone":
        assert found.nearest_m >= keep_out - 0.01
