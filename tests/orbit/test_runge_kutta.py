"""The explicit batch integrator: against SciPy's own DOP853, its order, its estimate of its error, its cut steps."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.orbit import propagate_burn
from orbsoc.orbit.runge_kutta import RungeKuttaArc, force_times, integrate_explicitly, refined
from tests.orbit.steered_burns import DURATION_S, START_SI, UNITS, VEHICLE, direction, push


def burns(ends: np.ndarray) -> RungeKuttaArc:
    times_s = force_times(ends) * UNITS.time_s
    thrust = push(times_s)

    def force(k: int, r: np.ndarray) -> np.ndarray:
        return thrust[k] - r / np.linalg.norm(r, axis=0) ** 3

    start = np.repeat(UNITS.state_from_si(START_SI)[:, None], 6, axis=1)
    return integrate_explicitly(ends, start[:3], start[3:], force)


def steps(count: int) -> np.ndarray:
    return np.linspace(0.0, DURATION_S / UNITS.time_s, count + 1)


def test_a_batch_of_burns_agrees_with_scipy_to_1e_12() -> None:
    arc = burns(steps(24))
    ends = np.concatenate([arc.positions[-1], arc.velocities[-1]])
    for k in range(6):
        end = propagate_burn(
            START_SI, VEHICLE, lambda t, _x, k=k: direction(t)[:, k], [DURATION_S], rtol=3e-14, atol=1e-15
        )
        np.testing.assert_allclose(ends[:, k], UNITS.state_from_si(end[0]), rtol=0, atol=1e-12)


def circle(count: int) -> tuple[float, float]:
    """True and estimated error after 2 radians of a circular orbit in `count` steps."""

    def force(_k: int, r: np.ndarray) -> np.ndarray:
        return -r / np.linalg.norm(r, axis=0) ** 3

    start = np.array([[1.0], [0.0], [0.0]]), np.array([[0.0], [1.0], [0.0]])
    arc = integrate_explicitly(np.linspace(0.0, 2.0, count + 1), *start, force)
    miss = np.abs(arc.positions[-1][:, 0] - [np.cos(2.0), np.sin(2.0), 0.0]).max()
    return float(miss), float(arc.errors.sum())


def test_the_order_is_eight_and_the_estimate_no_smaller_than_the_error() -> None:
    (coarse, coarse_estimate), (fine, fine_estimate) = circle(4), circle(8)
    assert np.log2(coarse / fine) == pytest.approx(8.0, abs=0.7)
    assert coarse <= coarse_estimate < 1e4 * coarse
    assert fine <= fine_estimate < 1e4 * fine


def test_steps_are_cut_where_the_error_is() -> None:
    """A push that turns within a hundredth of the time: cut there, and not elsewhere."""

    def swung(ends: np.ndarray) -> RungeKuttaArc:
        at = force_times(ends)

        def force(k: int, r: np.ndarray) -> np.ndarray:
            return np.array([[np.tanh(200.0 * (at[k] - 0.63))], [0.0]]) + 0.0 * r

        return integrate_explicitly(ends, np.zeros((2, 1)), np.zeros((2, 1)), force)

    first = swung(np.linspace(0.0, 1.0, 9))
    ends = refined(first, np.array([0]), 1e-9, 8)
    lengths = np.diff(ends)
    assert ends[lengths.argmin()] == pytest.approx(0.63, abs=0.13)
    assert lengths.max() == pytest.approx(0.125)
    assert swung(ends).errors.sum() < 0.1 * first.errors.sum()


def test_times_that_do_not_increase_are_refused() -> None:
    with pytest.raises(ValueError, match="each after the one before"):
        integrate_explicitly([0.0, 0.0], np.zeros((3, 1)), np.zeros((3, 1)), lambda _k, r: r)
