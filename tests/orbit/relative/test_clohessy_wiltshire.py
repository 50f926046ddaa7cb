"""Clohessy–Wiltshire against its differential equation, the paper's matrix and its own laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from orbsoc.orbit.relative import LVLH, ClohessyWiltshire, DriftEllipse

RATES = st.floats(1e-4, 2e-3)
TIMES = st.floats(-2e4, 2e4)
STATES = st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6).map(np.array)


@given(RATES, TIMES, TIMES, TIMES)
def test_transitions_compose(rate: float, a: float, b: float, c: float) -> None:
    motion = ClohessyWiltshire(rate)
    scale = np.diag([1.0, 1.0, 1.0, rate, rate, rate])  # lengths and speeds in one unit
    whole, parts = motion.transition(c, a), motion.transition(c, b) @ motion.transition(b, a)
    difference = np.linalg.inv(scale) @ (whole - parts) @ scale
    assert np.abs(difference).max() < 1e-11 * (1.0 + rate * (abs(a) + abs(b) + abs(c))) ** 2


@given(RATES, TIMES)
def test_volume_is_kept(rate: float, t: float) -> None:
    assert np.linalg.det(ClohessyWiltshire(rate).transition(t, 0.0)) == pytest.approx(1.0, abs=1e-8)


def test_solves_the_differential_equation() -> None:
    n = 1.1e-3
    matrix = np.zeros((6, 6))
    matrix[:3, 3:] = np.eye(3)
    matrix[3, [0, 4]], matrix[4, 3], matrix[5, 2] = (3 * n**2, 2 * n), -2 * n, -(n**2)
    start = np.array([100.0, -500.0, 30.0, 0.2, -0.1, 0.05])
    flown = solve_ivp(lambda _, x: matrix @ x, (0.0, 9000.0), start, method="DOP853", rtol=1e-12, atol=1e-12)
    found = ClohessyWiltshire(n).transition(9000.0, 0.0) @ start
    assert np.abs(found - flown.y[:, -1]).max() < 1e-7


def test_gives_the_digits_of_a_published_example() -> None:
    """Vallado's HILLSR as Tudat's unit test has it: 1800 s about a circle of 6778.137 km."""
    motion = ClohessyWiltshire(np.sqrt(3.986004418e14 / 6.778137e6**3))
    found = motion.transition(1800.0, 0.0) @ [45.0, 37.0, 12.0, 0.08, 0.03, 0.01]
    published = [
        3.806450080201250e2, -5.437424675454679e2, 2.509547637285142,
        1.541620605755606e-1, -7.294751390499470e-1, -1.662099488431618e-2,
    ]  # fmt: skip
    assert found == pytest.approx(published, rel=1e-12)


def test_is_the_papers_matrix_in_its_axes() -> None:
    """Xu & Meng's Φ: x along the velocity, z to the nadir."""
    w, t = 1e-3, 1234.0
    tau, s, c = w * t, np.sin(w * t), np.cos(w * t)
    printed = np.array(
        [
            [1, 6 * (tau - s), 4 * s / w - 3 * t, 2 * (1 - c) / w],
            [0, 4 - 3 * c, 2 * (c - 1) / w, s / w],
            [0, 6 * w * (1 - c), 4 * c - 3, 2 * s],
            [0, 3 * w * s, -2 * s, c],
        ]
    )
    both = np.kron(np.eye(2), LVLH)
    turned = both @ ClohessyWiltshire(w).transition(t, 0.0) @ both.T
    assert np.allclose(turned[np.ix_([0, 2, 3, 5], [0, 2, 3, 5])], printed, rtol=1e-14, atol=1e-13)


@given(STATES, RATES, st.floats(0.0, 2e4))
def test_the_drift_ellipse_is_the_free_motion(state: np.ndarray, rate: float, t: float) -> None:
    state = state * np.array([100.0, 100.0, 100.0, *[100.0 * rate] * 3])
    there = ClohessyWiltshire(rate).transition(t, 0.0) @ state
    ellipse = DriftEllipse.of(state, rate)
    assert np.allclose(ellipse.positions(t), there[:2], atol=1e-8)
    assert ellipse.lowest_r_m - 1e-9 <= there[0] <= ellipse.highest_r_m + 1e-9
    assert abs(there[2]) <= ellipse.normal_m + 1e-9


@pytest.mark.parametrize("rate", [0.0, -1e-3, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_refused(rate: float) -> None:
    with pytest.raises(ValueError, match=r"mean_motion_rad_s = .*: must be positive and finite"):
        ClohessyWiltshire(rate)


def test_the_rate_of_an_altitude() -> None:
    assert ClohessyWiltshire.at_altitude(593.5e3).mean_motion_rad_s == pytest.approx(1.0846e-3, abs=5e-8)
