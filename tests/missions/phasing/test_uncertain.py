"""Covariance of the meeting against draws of true flights, the chance constraint, and finite burns."""

import numpy as np
import pytest

from orbsoc.guidance.claims import Kind
from orbsoc.guidance.mission import PlanStatus
from orbsoc.missions.phasing import plan, samples
from orbsoc.missions.phasing.model.uncertain import Chance, impulse_covariance, meeting
from orbsoc.missions.phasing.scenario import Engine, Errors
from orbsoc.missions.phasing.verification.finite import finite_burns
from orbsoc.orbit import PropagationError
from orbsoc.orbit.relative import local_frame

from .cases import SCENARIOS, planned, scenario


def test_the_covariance_is_that_of_true_flights() -> None:
    """Execution errors a tenth of the assumed ones, so that the motion about the plan is linear."""
    found = planned().descended
    assert found is not None
    errors = Errors(
        position_m=(0.0, 0.0, 0.0), velocity_m_s=(0.0, 0.0, 0.0), ballistic_m2_kg=0.0,
        execution_share=1e-4, execution_deg=0.029, runs=0,
    )  # fmt: skip
    expected = meeting(found.approach, found.roll, errors).sigmas_m
    random = np.random.default_rng(1)
    axes = local_frame(found.approach.goal)[0]
    active = np.flatnonzero(np.any(found.roll.dv_m_s, axis=1))
    roots = {k: np.linalg.cholesky(impulse_covariance(found.roll.dv_m_s[k], errors)) for k in active}
    misses = []
    for _ in range(200):
        dv = found.roll.dv_m_s.copy()
        for k in active:
            dv[k] += roots[k] @ random.standard_normal(3)
        misses.append(axes @ found.approach.roll(dv).miss[:3])
    assert np.std(misses, axis=0) == pytest.approx(expected, rel=0.2)


def test_the_least_distance_has_the_known_percentiles() -> None:
    """Of the target's errors alone, which no plan changes: 3, 38 and 111 km."""
    found = planned().descended
    assert found is not None
    errors = Errors(execution_share=0.0, execution_deg=0.0, runs=20_000)
    drawn = meeting(found.approach, found.roll, errors)
    assert drawn.least_m / 1e3 == pytest.approx([3.0, 38.0, 111.0], abs=1.0)


def test_a_chance_constraint_holds_at_its_limit_and_costs() -> None:
    asked = scenario().with_changes(
        uncertainty={"probability": 0.995, "runs": 20_000}, window={"front": ()}, surprise=None
    )
    found = plan(asked)
    assert found.status is PlanStatus.VERIFIED
    assert found.descended is not None
    assert found.analysis is not None
    chance = Chance.of(found.descended.approach)
    assert chance is not None
    assert chance.sigma_m(found.descended.approach, found.descended.roll) == pytest.approx(
        chance.limit_m, rel=1e-5
    )
    plain = planned().descended
    assert plain is not None
    assert plain.roll.cost_m_s + 0.01 < found.descended.roll.cost_m_s < plain.roll.cost_m_s + 1.0
    assert found.descended.last.lower_bound == pytest.approx(found.descended.roll.cost_m_s, rel=1e-6)
    assert found.analysis.meeting is not None
    assert found.analysis.meeting.within >= 0.995 - 0.0015


def test_a_chance_that_the_target_alone_forbids_is_infeasible_by_name() -> None:
    asked = scenario().with_changes(uncertainty={"probability": 0.9999, "distance_km": 150.0})
    found = plan(asked)
    assert found.status is PlanStatus.INFEASIBLE
    assert "chance of the meeting" in found.message
    claim = found.verdict.lines[0].claim
    assert claim is not None
    assert claim.kind is Kind.PROVED
    assert claim.gap is not None
    assert claim.gap > 0.0


@pytest.mark.parametrize(
    ("distance_km", "status"),
    [(218.9, "INFEASIBLE"), (219.5, "NOT_FOUND"), (220.0, "NOT_VERIFIED"), (222.0, "VERIFIED")],
)
def test_a_chance_that_some_flight_cannot_keep_is_no_proof(distance_km: float, status: str) -> None:
    """Near the target's own σ of 56.3 km: beyond it a proof, short of it what was tried, and no bound above the plan."""
    errors = {"probability": 0.9999, "distance_km": distance_km, "runs": 100}
    found = plan(scenario().with_changes(uncertainty=errors, window={"front": ()}, surprise=None))
    assert found.status.name == status
    assert found.bounded is None or found.bounded.lower_bound <= found.programme.total_m_s * (1.0 + 1e-6)
    if found.status is PlanStatus.NOT_FOUND:
        assert "flights tried" in str(found.verdict.lines[0])


def test_finite_burns_meet_after_corrections() -> None:
    found = planned().descended
    assert found is not None
    engine = Engine(acceleration_m_s2=1.0687, exhaust_m_s=3090.0)
    misses = [finite_burns(found.approach, found.roll, engine, corrections=k) for k in (0, 1, 2)]
    assert misses[0].miss_m > misses[1].miss_m > misses[2].miss_m
    assert misses[2].miss_m < 500.0
    assert abs(misses[2].dv_m_s - found.roll.cost_m_s) < 0.2
    assert all(burn.duration_s > 0.0 for burn in misses[2].burns)


@pytest.mark.parametrize("acceleration_m_s2", [1e-6, 1e-3, 0.01, 0.05])
def test_burns_without_room_between_each_other_are_refused_before_they_are_flown(
    acceleration_m_s2: float,
) -> None:
    found = planned().descended
    assert found is not None
    with pytest.raises(PropagationError, match="has no room before its impulse's time"):
        finite_burns(
            found.approach, found.roll, Engine(acceleration_m_s2=acceleration_m_s2, exhaust_m_s=3090.0)
        )


def test_what_is_drawn_is_told_beside_other_draws() -> None:
    rows = [row for draw in samples(SCENARIOS).values() for row in draw()]
    assert [row.verdict for row in rows] == ["inferred", "not reproduced"]
