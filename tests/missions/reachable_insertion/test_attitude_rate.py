"""The rate of a commanded attitude and its cones: against closed forms and the theorem that they rest on."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.missions.reachable_insertion.model.attitude_rate import (
    peak_rate,
    rates,
    slope_matrix,
)
from orbsoc.missions.reachable_insertion.tuning import CONES_PER_NODE


def arc(tau: np.ndarray, turn: float) -> np.ndarray:
    """A great circle flown at `turn` rad per unit of τ."""
    return np.column_stack([np.cos(turn * tau), 0.6 * np.sin(turn * tau), 0.8 * np.sin(turn * tau)])


@pytest.mark.parametrize("turn", [1e-4, 0.1, 1.0])
def test_a_great_circle_turns_at_its_own_rate(turn: float) -> None:
    grid = legendre_gauss(12)
    controls = arc(grid.nodes, turn)
    found = rates(grid, controls, np.linspace(-1.0, 1.0, 101))
    np.testing.assert_allclose(found, turn, rtol=1e-6, atol=1e-9)
    assert peak_rate(grid, controls) == pytest.approx(turn, rel=1e-6, abs=1e-9)
    assert peak_rate(grid, 3.0 * controls) == pytest.approx(
        turn, rel=1e-6, abs=1e-9
    )  # of the direction alone


def test_thrust_through_the_inside_of_the_ball_turns_faster_than_its_chord() -> None:
    grid = legendre_gauss(8)
    controls = np.column_stack([grid.nodes, np.full(8, 0.1), np.zeros(8)])  # p' = 1, |p| = 0.1 half-way
    assert rates(grid, controls, [0.0])[0] == pytest.approx(10.0, rel=1e-6)
    assert np.linalg.norm(slope_matrix(8) @ controls, axis=1) == pytest.approx(np.ones(33))


@pytest.mark.parametrize("nodes", [2, 5, 12, 48])
def test_slopes_are_the_derivative_of_the_interpolant(nodes: int) -> None:
    grid = legendre_gauss(nodes)
    series = np.polynomial.legendre.Legendre(np.random.default_rng(nodes).standard_normal(nodes))
    points = -np.cos(np.pi * np.arange(CONES_PER_NODE * nodes + 1) / (CONES_PER_NODE * nodes))
    answer = series.deriv()(points)
    np.testing.assert_allclose(
        slope_matrix(nodes) @ series(grid.nodes), answer, rtol=0.0, atol=1e-10 * np.abs(answer).max()
    )


@pytest.mark.parametrize("nodes", [4, 12, 24])
def test_between_the_cones_no_interpolant_is_faster_than_the_theorem_allows(nodes: int) -> None:
    noise = np.random.default_rng(3)
    grid, tau = legendre_gauss(nodes), np.linspace(-1.0, 1.0, 4001)
    allowed = 1.0 / np.cos(np.pi * (nodes - 2) / (2 * CONES_PER_NODE * nodes))
    for _ in range(50):
        controls = noise.standard_normal((nodes, 3))
        at_cones = np.linalg.norm(slope_matrix(nodes) @ controls, axis=1).max()
        between = np.linalg.norm(np.gradient(grid.interpolate(controls, tau), tau, axis=0)[1:-1], axis=1)
        assert between.max() <= allowed * at_cones
    assert allowed < 1.083
