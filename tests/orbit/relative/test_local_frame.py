"""Inertial and relative states: round trips, and the rotation of the frame."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbsoc.orbit import EARTH, Elements, state_from_elements
from orbsoc.orbit.relative import absolute_state, local_frame, relative_state

ELEMENTS = st.builds(
    Elements,
    sma_m=st.floats(6.6e6, 4.3e7),
    ecc=st.floats(0.0, 0.7),
    inc_rad=st.floats(0.0, np.pi),
    raan_rad=st.floats(0.0, 6.28),
    argp_rad=st.floats(0.0, 6.28),
    true_anomaly_rad=st.floats(0.0, 6.28),
)
VECTORS = st.lists(st.floats(-1e4, 1e4), min_size=6, max_size=6).map(np.array)


def state_of(elements: Elements) -> np.ndarray:
    return np.concatenate(state_from_elements(elements))


@given(ELEMENTS, VECTORS)
def test_there_and_back(elements: Elements, relative: np.ndarray) -> None:
    target = state_of(elements)
    chaser = absolute_state(target, relative)
    assert np.abs(relative_state(target, chaser) - relative).max() < 1e-7
    many = absolute_state(target, np.stack([relative, -relative]))
    assert np.allclose(many[0], chaser)


@given(ELEMENTS)
def test_axes_are_orthonormal_and_turn_with_the_target(elements: Elements) -> None:
    target = state_of(elements)
    axes, rate = local_frame(target)
    assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-14)
    assert np.allclose(axes[2], np.cross(axes[0], axes[1]))
    speed = axes @ target[3:]  # ṙ = radial speed R̂ + ω × r
    assert speed[1] == pytest.approx(rate[2] * np.linalg.norm(target[:3]), rel=1e-12)


def test_rates_are_the_time_derivatives_of_positions() -> None:
    """ρ̇ counts the rotation of the frame, also out of the plane under a force that has a normal part."""
    target = state_of(Elements(7.2e6, 0.1, 0.9, 0.3, 0.5, 0.7))
    chaser = target + np.array([900.0, -300.0, 500.0, 0.3, 0.8, -0.4])
    pull = np.array([1e-4, -2e-4, 8e-3])

    def accelerations(state: np.ndarray) -> np.ndarray:
        return -EARTH.mu_m3_s2 * state[:3] / np.linalg.norm(state[:3]) ** 3 + pull

    def later(state: np.ndarray, dt: float) -> np.ndarray:
        a = accelerations(state)
        return np.concatenate([state[:3] + state[3:] * dt + 0.5 * a * dt**2, state[3:] + a * dt])

    dt = 1e-2
    ends = [relative_state(later(target, side * dt), later(chaser, side * dt))[:3] for side in (-1, 1)]
    numeric = (ends[1] - ends[0]) / (2 * dt)
    found = relative_state(target, chaser, accelerations(target))
    assert np.abs(found[3:] - numeric).max() < 1e-6
    without = relative_state(target, chaser)
    assert np.abs(without[3:] - numeric).max() > 1e-4  # the normal force turns the plane


def test_a_chaser_at_rest_in_the_frame_moves_with_it() -> None:
    target = state_of(Elements(7.0e6, 0.0, 1.0, 0.0, 0.0, 0.0))
    axes, rate = local_frame(target)
    chaser = absolute_state(target, [0.0, 1000.0, 0.0, 0.0, 0.0, 0.0])
    speed = axes @ (chaser - target)[3:]
    assert speed == pytest.approx([-1000.0 * rate[2], 0.0, 0.0], abs=1e-9)


def test_no_plane_is_told() -> None:
    with pytest.raises(ValueError, match="r × v = 0"):
        local_frame([7e6, 0, 0, 1e3, 0, 0])
