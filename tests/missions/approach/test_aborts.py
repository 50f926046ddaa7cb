"""The smallest abort impulse: what is found is safe, and nothing below its bound is."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.approach.model.approach import Approach
from orbsoc.missions.approach.verification.aborts import Judge, kicked
from orbsoc.missions.approach.verification.least_abort import GAP, GAP_M_S, Places, least_abort
from tests.missions.approach.cases import planned, station


@pytest.mark.parametrize("name", ["station_vbar", "station_rbar", "elliptic_servicing"])
def test_no_smaller_impulse_of_a_dense_fan_is_safe(name: str) -> None:
    plan = planned(name)
    assert plan.verification is not None
    needed = [each for each in plan.verification.aborts if not each.safe]
    judge, rng = Judge(plan.approach), np.random.default_rng(2)
    angles = 2.0 * np.pi * np.arange(90) / 90
    for each in (needed[k] for k in rng.choice(len(needed), 3, replace=False)):
        assert each.dv_m_s is not None
        assert each.margin_m >= 0.0
        assert each.at_least_m_s <= each.size_m_s
        for size in each.at_least_m_s * np.array([0.25, 0.5, 0.75, 0.9, 0.97]):
            for angle in angles:
                dv = size * np.array([np.cos(angle), np.sin(angle), 0.0])
                assert judge.judged(each.time_s, kicked(each.state, dv)) < 0.0


def test_the_bound_is_within_a_hundredth_at_most_instants() -> None:
    plan = planned()
    assert plan.verification is not None
    needed = [each for each in plan.verification.aborts if not each.safe]
    gaps = [each.size_m_s - each.at_least_m_s for each in needed]
    assert len(needed) >= 10
    enough = [max(GAP * each.size_m_s, GAP_M_S) * (1.0 + 1e-9) for each in needed]
    assert sum(gap <= most for gap, most in zip(gaps, enough, strict=True)) >= 0.9 * len(needed)


def test_of_a_straight_flight_the_least_impulse_is_known() -> None:
    """Past a sphere without forces: from (−3, 0.5) at unit speed, T outward, at 1 from the target after the impulse."""
    times = np.linspace(0.0, 20.0, 2001)
    transitions = np.zeros((times.size, 3, 6))
    transitions[:, :, :3] = np.eye(3)
    transitions[:, :, 3:] = times[:, None, None] * np.eye(3)
    state = np.array([-3.0, 0.5, 0.0, 1.0, 0.0, 0.0])
    ends = state[:3] + np.array([0.0, 0.0, 0.0])

    def judged(dv: np.ndarray) -> float:
        velocity = state[3:] + dv
        t = np.clip(-(ends @ velocity) / max(float(velocity @ velocity), 1e-30), 0.0, 20.0)
        return float(np.linalg.norm(ends + t * velocity)) - 1.0

    found = least_abort(Places(transitions, state, np.ones(3), 0.1), judged, 2.0)
    # the velocity must leave the cone of tangents: the distance of (1, 0) from its side
    angle = np.arcsin(1.0 / np.hypot(3.0, 0.5)) - np.arctan2(0.5, 3.0)
    assert found.dv_m_s is not None
    assert np.linalg.norm(found.dv_m_s) == pytest.approx(np.sin(angle), rel=0.02)
    assert found.at_least_m_s <= np.sin(angle) + 1e-9
    assert found.at_least_m_s >= 0.97 * np.sin(angle)


def test_where_no_impulse_will_do_it_is_proved() -> None:
    """At rest in the middle, for a second, with a keep-out of a metre."""
    times = np.linspace(0.0, 1.0, 11)
    transitions = np.zeros((times.size, 3, 6))
    transitions[:, :, :3] = np.eye(3)
    transitions[:, :, 3:] = times[:, None, None] * np.eye(3)
    found = least_abort(Places(transitions, np.zeros(6), np.ones(3), 0.0), lambda dv: -1.0, 0.5)
    assert found.dv_m_s is None
    assert found.at_least_m_s == 0.5


def test_a_drift_that_is_outside_for_a_moment_between_samples_is_not_safe() -> None:
    """It leaves the keep-out by less than a centimetre after 3939 s, and is 178 m inside after 6423 s."""
    scenario = station(
        keep_out__radius_m=398.08062543241715, keep_out__margin_m=0.0, points__S2__x_m=-450.0,
        safety__orbits=2.0, speed=None,
    )  # fmt: skip
    at = Approach.of(scenario)
    state = np.array(
        [-40.2129721306995, -139.26158857905688, 0.0, 0.02852714804656467, 0.09826828437220222, 0.0]
    )
    times = np.linspace(3900.0, 3980.0, 8001)
    ranges = np.linalg.norm(at.transitions(times, np.zeros_like(times))[:, :3] @ state, axis=1)
    assert 0.0 < ranges.max() - 398.08062543241715 < 0.02
    assert Judge(at).judged(0.0, state) < -100.0
