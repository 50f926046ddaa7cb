"""The largest semi-major axis between the points of the grid, and the error that it states."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.search.query.largest_orbit import LargestOrbits


def test_the_height_counts_in_the_error_and_coarse_nodes_do_not_hide_it() -> None:
    """A table that bends in height only, read on a node of inclination and node."""
    axes = np.array([20.0, 21.0, 22.0]), np.array([330.0, 331.0, 332.0]), np.arange(100.0, 501.0, 100.0)
    bend = np.maximum(0.0, axes[2] - 250.0)
    table = LargestOrbits.of(axes, np.broadcast_to(20000.0 - 10.0 * bend, (3, 3, 5)).ravel())
    value, error = table(21.0, 331.0, 250.0)
    assert value == pytest.approx(19750.0)
    assert error >= 125.0
    assert table(21.0, 331.0, 300.0) == (pytest.approx(19500.0), pytest.approx(1e-3))
    assert np.isnan(table(21.0, 331.0, 90.0)[0])
    assert table(21.0, 331.5, 150.0)[0] == pytest.approx(20000.0)


def test_next_to_the_edge_and_on_small_grids_the_error_is_not_small() -> None:
    axes = np.array([20.0, 21.0, 22.0]), np.array([330.0, 331.0]), np.array([100.0])
    values = np.array([9000.0, 9000.0, 8000.0, 8000.0, np.nan, np.nan])
    table = LargestOrbits.of(axes, values)
    assert table(20.5, 330.0, 100.0) == (pytest.approx(8500.0), np.inf)
    assert np.isnan(table(21.5, 330.0, 100.0)[0])
    assert table(20.0, 330.0, 100.0) == (pytest.approx(9000.0), pytest.approx(1e-3))


def test_between_an_ellipse_and_a_hyperbola_the_energy_is_interpolated() -> None:
    """Semi-major axes jump from +∞ to −∞ where the energy, here linear in inclination, passes zero."""
    axes = np.arange(20.0, 25.0), np.array([330.0, 331.0, 332.0]), np.array([100.0, 200.0, 300.0])
    energy = np.array([-4.0, -3.0, -2.0, -1.0, 1.0]) * 1e-5
    table = LargestOrbits.of(axes, np.broadcast_to((-1.0 / energy)[:, None, None], (5, 3, 3)).ravel())
    value, error = table(22.5, 330.5, 150.0)
    assert value == pytest.approx(1e5 / 1.5)
    assert error == pytest.approx(1e5 / 1.25 - 1e5 / 1.5, abs=0.01)
    assert table(23.0, 330.0, 100.0) == (pytest.approx(1e5), pytest.approx(1e-3))
    assert table(24.0, 330.0, 100.0) == (np.inf, 0.0)
    assert table(23.9, 330.0, 100.0) == (np.inf, 0.0)
    assert table(23.6, 330.0, 100.0) == (np.inf, np.inf)
    assert table(23.4, 330.0, 100.0) == (pytest.approx(5e5), np.inf)
    assert table(20.5, 330.0, 100.0)[0] == pytest.approx((25000.0 + 1e5 / 3.0) / 2.0)
