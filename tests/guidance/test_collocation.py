"""Legendre–Gauss collocation: known tables, and exactness on the polynomials it must be exact for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbsoc.guidance.collocation import interpolation_matrix, legendre_gauss

# Abramowitz & Stegun, table 25.4: positive abscissas and weights.
TABLE = {
    2: ([0.577350269189626], [1.0]),
    3: ([0.0, 0.774596669241483], [0.888888888888889, 0.555555555555556]),
    5: (
        [0.0, 0.538469310105683, 0.906179845938664],
        [0.568888888888889, 0.478628670499366, 0.236926885056189],
    ),
    12: (
        [
            0.125233408511469,
            0.367831498998180,
            0.587317954286617,
            0.769902674194305,
            0.904117256370475,
            0.981560634246719,
        ],
        [
            0.249147045813403,
            0.233492536538355,
            0.203167426723066,
            0.160078328543346,
            0.106939325995318,
            0.047175336386512,
        ],
    ),
}


@pytest.mark.parametrize("size", TABLE)
def test_nodes_and_weights_equal_the_printed_table(size: int) -> None:
    grid = legendre_gauss(size)
    upper = grid.nodes >= -1e-14
    np.testing.assert_allclose(grid.nodes[upper], TABLE[size][0], atol=1e-15)
    np.testing.assert_allclose(grid.weights[upper], TABLE[size][1], atol=1e-15)


@settings(derandomize=True, max_examples=60)
@given(st.integers(2, 48), st.integers(0, 2**32 - 1))
def test_differentiation_is_exact_for_degree_n(size: int, seed: int) -> None:
    grid = legendre_gauss(size)
    polynomial = np.polynomial.Legendre(np.random.default_rng(seed).uniform(-1, 1, size + 1))
    values = polynomial(np.concatenate([[-1.0], grid.nodes]))
    exact = polynomial.deriv()(grid.nodes)
    np.testing.assert_allclose(grid.differentiation @ values, exact, atol=1e-11 * np.abs(exact).max())


@settings(derandomize=True, max_examples=60)
@given(st.integers(2, 48), st.integers(0, 2**32 - 1))
def test_quadrature_is_exact_to_degree_2n_minus_1_and_not_beyond(size: int, seed: int) -> None:
    grid = legendre_gauss(size)
    polynomial = np.polynomial.Legendre(np.random.default_rng(seed).uniform(-1, 1, 2 * size))
    antiderivative = polynomial.integ()
    exact = antiderivative(1.0) - antiderivative(-1.0)
    assert grid.weights @ polynomial(grid.nodes) == pytest.approx(exact, abs=1e-12)
    squared = np.polynomial.Legendre.basis(size) ** 2  # degree 2N, zero at every node, positive between
    assert grid.weights @ squared(grid.nodes) == pytest.approx(0.0, abs=1e-12)
    assert squared.integ()(1.0) - squared.integ()(-1.0) > 1e-2


@pytest.mark.parametrize("size", [2, 3, 12, 30])
def test_interpolation_is_exact_on_its_polynomials_and_at_its_points(size: int) -> None:
    grid = legendre_gauss(size)
    tau = np.concatenate([np.linspace(-1.0, 1.0, 41), grid.nodes])
    controls = np.polynomial.Legendre(np.ones(size))
    np.testing.assert_allclose(grid.interpolate(controls(grid.nodes), tau), controls(tau), atol=1e-11)
    states = np.polynomial.Legendre(np.ones(size + 1))
    interpolated = grid.interpolate_from_start(states(-1.0), states(grid.nodes), tau)
    np.testing.assert_allclose(interpolated, states(tau), atol=1e-11)
    np.testing.assert_array_equal(interpolation_matrix(grid.nodes, grid.nodes), np.eye(size))


def test_interpolation_keeps_trailing_axes() -> None:
    grid = legendre_gauss(4)
    values = np.arange(12.0).reshape(4, 3)
    assert grid.interpolate(values, [0.0, 0.5]).shape == (2, 3)


@pytest.mark.parametrize("size", [1, 0, -3, 2.5, True])
def test_too_few_nodes_are_refused(size: float) -> None:
    with pytest.raises(ValueError, match="at least 2"):
        legendre_gauss(size)  # type: ignore[arg-type]


def test_grids_are_shared_and_read_only() -> None:
    assert legendre_gauss(7) is legendre_gauss(7)
    with pytest.raises(ValueError, match="read-only"):
        legendre_gauss(7).nodes[0] = 0.0
