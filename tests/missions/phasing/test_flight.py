"""The approach of hours in a closed loop: tracked anew, it comes nearer to a target that is not where it was."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orbsoc.fly.computer import Price
from orbsoc.fly.loop import Fate, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions import phasing as mission
from orbsoc.missions.phasing.flight import Burns, PhasingLoop

SCENARIOS = Path(__file__).parents[3] / "scenarios"


class Quick:
    """A computer whose answers are always there: what a flight does with them is looked at here."""

    def price(self, *_: object) -> Price:
        return Price(1e-3, 1)


@pytest.fixture(scope="module")
def loop() -> PhasingLoop:
    return PhasingLoop.of(mission.load_scenario(SCENARIOS / "paper003_socp.toml"), OnboardSolver())


def test_tracked_anew_it_comes_nearer(loop: PhasingLoop) -> None:
    solver, timing = OnboardSolver(), Timing(loop.allowance_s)
    for number in (1, 2, 3):
        closed = fly(loop, Quick(), solver, timing, seed=1, number=number)  # type: ignore[arg-type]
        still = fly(loop, None, solver, timing, seed=1, number=number)
        assert [each.fate for each in closed.cycles] == [Fate.FLOWN] * 4
        assert closed.outcome["miss_km"] < 0.5 * still.outcome["miss_km"]
        assert closed.outcome["delta_v_m_s"] < 1.01 * still.outcome["delta_v_m_s"]


def test_without_errors_the_plan_meets_the_target(loop: PhasingLoop) -> None:
    pursuer = loop.vehicle(0, 0)
    pursuer.errors = pursuer.errors.model_copy(update={"execution_share": 0.0, "execution_deg": 0.0})
    for until_s in np.linspace(0.0, loop.first.end_s, 4)[1:]:
        pursuer.advance(loop.first, float(until_s))
    assert loop.outcome(pursuer, loop.first)["miss_km"] < 1e-3


def test_an_impulse_is_fired_once(loop: PhasingLoop) -> None:
    burns = Burns(
        np.array([0.0, 100.0, 200.0]), np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    )
    pursuer = loop.vehicle(0, 0)
    for until_s in (100.0, 100.0, 150.0, 200.0):
        pursuer.advance(burns, until_s)
    assert pursuer.spent_m_s == pytest.approx(3.0, rel=0.01)


@pytest.mark.parametrize(
    ("name", "changes", "key"),
    [
        ("paper003_socp", {"uncertainty": None}, "uncertainty"),
        ("paper003_socp", {"scheme": "paper"}, "scheme"),
    ],
)
def test_what_cannot_be_flown_is_told(name: str, changes: dict[str, object], key: str) -> None:
    scenario = mission.load_scenario(SCENARIOS / f"{name}.toml").with_changes(**changes)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match=key):
        mission.closed_loop(scenario, OnboardSolver())
