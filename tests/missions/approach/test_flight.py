"""A station's approach in a closed loop: it keeps out and ends on its last point, which as planned it does not."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbsoc.fly.computer import Price
from orbsoc.fly.loop import Flight, Timing, fly
from orbsoc.fly.solver import OnboardSolver
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions import approach as mission
from orbsoc.missions.approach.flight import SOUGHT, SPARE_M, ApproachLoop, allowed, nearest_m, replanned
from orbsoc.missions.approach.model.problem import flown

SCENARIOS = Path(__file__).parents[3] / "scenarios"


class Quick:
    """A computer whose answers are always there: what a flight does with them is looked at here."""

    def price(self, *_: object) -> Price:
        return Price(1e-3, 1)


@pytest.fixture(scope="module")
def solver() -> OnboardSolver:
    return OnboardSolver()


@pytest.fixture(scope="module")
def loop(solver: OnboardSolver) -> ApproachLoop:
    return ApproachLoop.of(mission.load_scenario(SCENARIOS / "station_vbar_dispersed.toml"), solver)


def once(loop: ApproachLoop, solver: OnboardSolver, number: int, computer: Quick | None) -> Flight:
    return fly(loop, computer, solver, Timing(loop.allowance_s), seed=1, number=number)  # type: ignore[arg-type]


def test_replanned_it_ends_nearer_and_stays_out(loop: ApproachLoop, solver: OnboardSolver) -> None:
    for number in (2, 3):  # as planned, the first enters the keep-out
        closed, still = (once(loop, solver, number, each).outcome for each in (Quick(), None))
        assert list(closed) == list(loop.columns)
        assert closed["safe"]
        assert closed["on_target"]
        assert closed["miss_m"] < 0.1 * still["miss_m"]
        assert not still["on_target"]


def test_a_replan_keeps_every_condition_from_where_the_flight_is(
    loop: ApproachLoop, solver: OnboardSolver
) -> None:
    programme, approach = loop.first.programme, loop.approach
    at, left = 3, ImpulseProgramme(loop.first.programme.times_s[3:], loop.first.programme.dv_m_s[3:])
    state = flown(approach, programme)[at - 1]
    state = approach.motion.transition(float(left.times_s[0]), float(programme.times_s[at - 1])) @ state
    state = state + np.array([3.0, -5.0, 1.0, 2e-3, -3e-3, 1e-3])
    found, _ = replanned(approach, left, state, SOUGHT[0], solver)
    assert found is not None
    begun = replace(approach, start=state, times_s=left.times_s)
    after = flown(begun, found)
    for k in range(begun.guarded):
        drift = nearest_m(begun, after[k], float(begun.times_s[k]), begun.horizon_s)
        assert drift >= begun.scenario.keep_out.margin_m - SPARE_M
    end = approach.motion.transition(approach.duration_s, float(found.times_s[-1])) @ after[-1]
    assert np.abs(end[:3] - begun.scenario.points["contact"].position()).max() < 1e-5


def test_a_margin_is_kept_as_far_as_the_state_has_it(loop: ApproachLoop) -> None:
    approach = replace(loop.approach, times_s=loop.approach.times_s[3:])
    close = replace(approach, start=np.array([0.0, -230.0, 0.0, 0.0, 0.0, 0.0]))
    left = allowed(close, SOUGHT[-1]).scenario.keep_out.margin_m
    assert left == pytest.approx(30.0 - SPARE_M)
    assert allowed(close, SOUGHT[0]).scenario.keep_out.margin_m == 45.0


def test_without_errors_there_is_no_loop(solver: OnboardSolver) -> None:
    with pytest.raises(ScenarioError, match="uncertainty"):
        mission.closed_loop(mission.load_scenario(SCENARIOS / "station_vbar.toml"), solver)


def test_after_the_gate_the_first_arc_alone_has_less_margin(loop: ApproachLoop) -> None:
    late = replace(loop.approach, times_s=loop.approach.times_s[20:])
    corridor = loop.scenario.corridor
    assert corridor is not None
    assert not late.guarded
    at = np.array([0.0, -100.0, 17.0, 0.0, 0.0, 0.0])
    begun = allowed(replace(late, start=at), SOUGHT[0])
    margins = begun.corridor_margins(np.array([0, 1, 5]))
    assert margins[0] == pytest.approx(float(corridor.depth(at[:3])) - SPARE_M)
    assert margins[0] < corridor.margin_m
    assert margins[1:].tolist() == [corridor.margin_m] * 2
