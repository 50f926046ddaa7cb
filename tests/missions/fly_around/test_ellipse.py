"""The path: its derivatives, the acceleration that holds a chaser on it, and the one ellipse that needs none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbsoc.missions.fly_around.model.ellipse import Ellipse, ellipse_axes
from orbsoc.orbit.relative import ClohessyWiltshire

from .baseline import integrated, scenario

N = ClohessyWiltshire.at_altitude(500e3).mean_motion_rad_s
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@given(angles, st.floats(0.0, 1800.0), st.sampled_from([1, -1]))
def test_velocity_and_acceleration_are_derivatives_of_the_position(
    turned: tuple[float, float, float], t: float, direction: int
) -> None:
    path = Ellipse.of((200.0, 150.0), turned, 0.3, 1800.0, direction, N)
    h = 0.05
    slope = (path.position(t + h) - path.position(t - h)) / (2 * h)
    np.testing.assert_allclose(path.velocity(t), slope, atol=1e-8)
    assert np.linalg.norm(path.frame @ path.frame.T - np.eye(3)) < 1e-14
    assert abs((path.frame @ path.position(t))[1]) < 1e-12  # in its own plane


@given(angles, st.sampled_from([1, -1]))
def test_the_required_acceleration_holds_a_chaser_on_the_path(
    turned: tuple[float, float, float], direction: int
) -> None:
    path = Ellipse.of((200.0, 150.0), turned, 0.0, 1800.0, direction, N)
    start = np.concatenate([path.position(0.0), path.velocity(0.0)])
    end = integrated(start, 700.0, N, lambda t: path.required_acceleration(t))
    np.testing.assert_allclose(end, [*path.position(700.0), *path.velocity(700.0)], atol=1e-7)


@pytest.mark.parametrize(("direction", "needs"), [(1, False), (-1, True)])
def test_twice_as_long_along_the_motion_in_one_orbit_is_natural_one_way_round(
    direction: int, needs: bool
) -> None:
    period = 2.0 * np.pi / N
    path = Ellipse.of((200.0, 100.0), (0.0, 0.0, 0.0), 0.0, period, direction, N)
    largest = float(np.abs(path.required_acceleration(np.linspace(0.0, period, 50))).max())
    assert (largest > 1e-4) is needs
    assert needs or largest < 1e-15


def test_axes_are_those_that_the_paper_prints() -> None:
    """C = C_x(θx) C_z(θz) of section 2, and the turn about y."""
    x, z = 0.7, -0.4
    cx, sx, cz, sz = np.cos(x), np.sin(x), np.cos(z), np.sin(z)
    printed = [[cz, sz, 0.0], [-cx * sz, cx * cz, sx], [sx * sz, -sx * cz, cx]]
    np.testing.assert_allclose(ellipse_axes([x, 0.0, z]), printed, atol=1e-15)


def test_the_paper_starts_at_200_m_on_the_ellipses_own_axis() -> None:
    path = scenario().flight.ellipse
    np.testing.assert_allclose(path.frame @ path.position(0.0), [200.0, 0.0, 0.0], atol=1e-12)
