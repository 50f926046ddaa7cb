"""What errors make of a flight: linear covariance beside flights with draws, and the margin that a plan leaves for it."""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.guidance.verdict import Question
from orbsoc.missions import approach
from orbsoc.missions.approach.verification.closed_loop import SAMPLES, fly_corrected
from orbsoc.missions.approach.verification.errors import covariances_after, room_m
from tests.missions.approach.cases import planned, station

ERRORS = {
    "position_m": 0.3,
    "velocity_m_s": 2e-3,
    "execution_share": 0.01,
    "execution_fixed_m_s": 1e-3,
    "runs": 0,
}


def test_the_covariance_is_that_of_flights_with_draws() -> None:
    """Standard deviations of places at the ends of arcs, of 300 flights about the Earth: within a fifth, which four times the error of
    an estimate from 300 is."""
    plan = planned()
    assert plan.programme is not None
    assert plan.verification is not None
    errors, arcs = Uncertainty(seed=5, **ERRORS), plan.verification.arcs
    found = covariances_after(plan.approach, plan.programme, arcs, errors)
    flights = fly_corrected(plan.approach, plan.programme, arcs, errors=errors, runs=300)
    ratios = []
    for k, arc in enumerate(arcs):
        coast = plan.approach.motion.transition(float(arc.times_s[-1]), float(arc.times_s[0]))
        told = np.sqrt(np.diag(coast @ found[k] @ coast.T)[:3])
        ratios.append(flights.positions[(k + 1) * SAMPLES - 1].std(axis=0) / told)
    ratios = np.array(ratios)
    assert (np.abs(ratios - 1.0) < 0.2).all(), (ratios.min(), ratios.max())


def test_a_margin_that_is_too_small_for_the_errors_grows() -> None:
    """The nearest of a hundred flights then stays farther out, by a third of what was added or more."""
    tight = {"keep_out__margin_m": 0.5, "safety__orbits": 0.0}
    bare = approach.plan(station(**tight))
    plan = approach.plan(station(**tight, uncertainty=ERRORS | {"sigmas": 4.0}))
    assert plan.status is PlanStatus.VERIFIED
    assert plan.approach.errors_m > 0.0
    assert plan.verification is not None
    assert plan.verification.room_m >= 0.0
    assert bare.programme is not None
    assert bare.verification is not None
    assert plan.programme is not None
    errors = Uncertainty(seed=9, sigmas=4.0, **ERRORS)
    assert room_m(bare.approach, bare.programme, bare.verification.arcs, errors) < 0.0
    nearest = [
        fly_corrected(at, programme, arcs, errors=errors, runs=100).outside_m.min()
        for at, programme, arcs in (
            (bare.approach, bare.programme, bare.verification.arcs),
            (plan.approach, plan.programme, plan.verification.arcs),
        )
    ]
    assert nearest[1] - nearest[0] > plan.approach.errors_m / 3.0
    assert plan.to_dict()["errors"]["margin_added_m"] == plan.approach.errors_m


def test_errors_that_no_margin_holds_leave_the_plan_not_verified() -> None:
    plan = approach.plan(station(uncertainty=ERRORS | {"execution_share": 0.2}))
    assert plan.status is PlanStatus.NOT_VERIFIED
    assert plan.verification is not None
    assert "into the keep-out; more impulses before the gate" in plan.verification.failures[0]


def test_the_safety_line_says_whether_errors_are_in_it() -> None:
    """None without `[uncertainty]`; with it the room that they leave, and that drifts have none."""
    with_errors = approach.plan(station(uncertainty=ERRORS))
    assert with_errors.verification is not None
    room = with_errors.verification.room_m
    for plan, words in (
        (planned(), "no errors in it"),
        (with_errors, f"3 σ of errors leave the flight {room:.1f} m outside, drifts without errors"),
    ):
        (line,) = [each for each in plan.verdict.lines if each.question is Question.SAFETY]
        assert line.evidence.endswith(words)
