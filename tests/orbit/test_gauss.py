"""The batch integrator: against SciPy's DOP853, its order, and what it does with motions it cannot follow."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.orbit import propagate_burn
from orbsoc.orbit.gauss import gauss_steps, integrate
from tests.orbit.steered_burns import DURATION_S, START_SI, UNITS, VEHICLE, direction, push


def gauss_ends(steps: int) -> np.ndarray:
    scheme = gauss_steps(DURATION_S / UNITS.time_s, steps)
    times_s = scheme.times * UNITS.time_s
    thrust = push(times_s)

    def force(window: slice, r: np.ndarray) -> np.ndarray:
        return thrust[window] - r / np.linalg.norm(r, axis=1, keepdims=True) ** 3

    start = np.repeat(UNITS.state_from_si(START_SI)[:, None], 6, axis=1)
    arc = integrate(scheme, start[:3], start[3:], force)
    return np.concatenate([arc.end_position, arc.end_velocity])


def test_a_batch_of_burns_agrees_with_dop853_to_1e_12() -> None:
    ends = gauss_ends(8)
    for k in range(6):
        end = propagate_burn(
            START_SI, VEHICLE, lambda t, _x, k=k: direction(t)[:, k], [DURATION_S], rtol=3e-14, atol=1e-15
        )
        np.testing.assert_allclose(ends[:, k], UNITS.state_from_si(end[0]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("stages", [1, 2, 3])
def test_the_order_is_twice_the_number_of_stages(stages: int) -> None:
    """On a circular orbit: half the step length, 2^(2s) times less error."""

    def force(_window: slice, r: np.ndarray) -> np.ndarray:
        return -r / np.linalg.norm(r, axis=1, keepdims=True) ** 3

    errors = []
    for steps in (16, 32):
        scheme = gauss_steps(2.0, steps, stages)
        arc = integrate(scheme, np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [1.0], [0.0]]), force)
        errors.append(np.abs(arc.end_position[:, 0] - [np.cos(2.0), np.sin(2.0), 0.0]).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2 * stages, abs=0.1)


def test_a_motion_through_the_centre_becomes_nan_and_leaves_the_others_alone() -> None:
    scheme = gauss_steps(2.0, 4)

    def force(_window: slice, r: np.ndarray) -> np.ndarray:
        return -r / np.linalg.norm(r, axis=1, keepdims=True) ** 3

    position = np.array([[1.0, 1.0], [0.0, 0.0], [0.0, 0.0]])
    velocity = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]])
    with np.errstate(all="ignore"):
        arc = integrate(scheme, position, velocity, force)
    np.testing.assert_allclose(arc.end_position[:, 0], [np.cos(2.0), np.sin(2.0), 0.0], atol=1e-12)
    assert np.isnan(arc.end_position[:, 1]).any()


@pytest.mark.parametrize("bad", [(0.0, 1, 8), (1.0, 0, 8), (1.0, 1, 0)])
def test_a_scheme_needs_positive_numbers(bad: tuple[float, int, int]) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        gauss_steps(*bad)
