"""Least distances of drifts against dense sampling and closed forms; cut impulses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety import (
    audit_cut_burns,
    drift_clearance,
    sampled_clearance,
    states_after,
)
from orbsoc.guidance.safety_bound import STILL_M
from orbsoc.orbit.relative import ClohessyWiltshire, DriftEllipse

N = 1e-3
PERIOD = 2 * np.pi / N
MOTION = ClohessyWiltshire(N)
NUMBERS = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(np.array)
SCALE = np.array([200.0, 1000.0, 100.0, 0.2, 0.2, 0.1])


@settings(max_examples=60)
@given(NUMBERS, st.floats(0.3, 6.0))
def test_the_least_distance_over_a_horizon_is_that_of_dense_samples(state: np.ndarray, orbits: float) -> None:
    start, horizon = SCALE * state, orbits * PERIOD
    found = drift_clearance(start, N, horizon)
    dense = sampled_clearance(MOTION, start, 0.0, np.linspace(0.0, horizon, 6001))
    assert found.distance_m[0] <= dense.distance_m[0] + 1e-3
    there = MOTION.transition(found.at_s[0], 0.0) @ start
    assert 0.0 <= found.at_s[0] <= horizon + PERIOD / 1440
    still = abs(DriftEllipse.of(start, N).drift_per_orbit_m) < STILL_M
    assert np.linalg.norm(there[:3]) == pytest.approx(found.distance_m[0], abs=0.02 if still else 1e-6)
    assert found.distance_m[0] > dense.distance_m[0] - 0.5  # between samples it moves by less


@settings(max_examples=60)
@given(NUMBERS)
def test_for_all_time_is_below_any_horizon_and_above_the_radial_bound(state: np.ndarray) -> None:
    start = SCALE * state
    ever, soon = drift_clearance(start, N), drift_clearance(start, N, 50 * PERIOD)
    assert ever.distance_m[0] <= soon.distance_m[0] + 1e-6
    ellipse = DriftEllipse.of(start, N)
    nearest_r = max(0.0, ellipse.lowest_r_m, -ellipse.highest_r_m)
    assert ever.distance_m[0] >= nearest_r - 1e-9


def test_a_closed_ellipse_about_the_target_has_its_known_distance() -> None:
    """2b − p with p ≥ 1.5 b, else b √(1 − p²/3b²)."""
    b = 100.0
    for p, distance in ((0.0, b), (100.0, b * np.sqrt(1 - 1 / 3)), (160.0, 40.0)):
        state = np.array([b, p, 0.0, 0.0, -2 * N * b, 0.0])
        assert drift_clearance(state, N).distance_m[0] == pytest.approx(distance, abs=1e-6)


def test_many_states_are_as_each_alone() -> None:
    states = SCALE * np.random.default_rng(3).uniform(-1, 1, (7, 6))
    together = drift_clearance(states, N)
    alone = [drift_clearance(state, N).distance_m[0] for state in states]
    assert together.distance_m == pytest.approx(alone, abs=1e-9)


def test_a_cut_impulse_is_followed_by_the_drift_of_its_fraction() -> None:
    start = np.array([0.0, -500.0, 0.0, 0.0, 0.0, 0.0])
    programme = ImpulseProgramme([0.0, 1500.0], [[-0.1, 0.0, 0.0], [0.02, -0.03, 0.0]])
    cuts = audit_cut_burns(programme, start, MOTION, 40.0, mean_motion_rad_s=N)
    assert [cut.number for cut in cuts] == [1, 2]
    assert cuts[0].missed_m == pytest.approx(500.0)
    after = states_after(programme, start, MOTION)
    for cut, whole, dv in zip(cuts, after, programme.dv_m_s, strict=True):
        state = whole.copy()
        state[3:] -= (1.0 - cut.fraction) * dv
        assert drift_clearance(state, N).distance_m[0] == pytest.approx(cut.distance_m, abs=1e-6)
        assert cut.distance_m <= min(cut.half_m, cut.completed_m, cut.missed_m) + 1e-6
        assert drift_clearance(whole, N).distance_m[0] == pytest.approx(cut.completed_m, abs=1e-6)
    assert cuts[0].unsafe_share == 0.0
    assert cuts[1].unsafe_share > 0.1
    assert cuts[0].to_dict()["number"] == 1
    sampled = audit_cut_burns(programme, start, MOTION, 40.0, mean_motion_rad_s=N, circular=False, orbits=1.0)
    exact = audit_cut_burns(programme, start, MOTION, 40.0, mean_motion_rad_s=N, orbits=1.0)
    for one, other in zip(sampled, exact, strict=True):
        assert one.distance_m == pytest.approx(other.distance_m, abs=0.5)
