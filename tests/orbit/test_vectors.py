"""Angular momentum and Laplace vectors: laws, known geometry, and Jacobians against the complex step."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from orbsoc.orbit import (
    EARTH,
    angular_momentum,
    angular_momentum_jacobian,
    laplace_jacobian,
    laplace_vector,
    state_from_elements,
)
from orbsoc.orbit.elements import Elements

_components = st.floats(-2.0, 2.0, allow_subnormal=False)
states = arrays(np.float64, 6, elements=_components).filter(lambda x: np.linalg.norm(x[:3]) > 0.1)


def complex_step(function, x: np.ndarray) -> np.ndarray:
    columns = []
    for k in range(x.size):
        shifted = x.astype(complex)
        shifted[k] += 1e-30j
        columns.append(function(shifted[:3], shifted[3:]).imag / 1e-30)
    return np.column_stack(columns)


@settings(derandomize=True, max_examples=60)
@given(states)
def test_momentum_jacobian_equals_complex_step(x: np.ndarray) -> None:
    expected = complex_step(angular_momentum, x)
    np.testing.assert_allclose(angular_momentum_jacobian(x[:3], x[3:]), expected, rtol=1e-14, atol=1e-14)


@settings(derandomize=True, max_examples=60)
@given(states, st.floats(0.5, 2.0))
def test_laplace_jacobian_equals_complex_step(x: np.ndarray, mu: float) -> None:
    expected = complex_step(lambda r, v: laplace_vector(r, v, mu), x)
    scale = 1.0 + np.abs(expected).max()
    np.testing.assert_allclose(laplace_jacobian(x[:3], x[3:], mu), expected, rtol=0, atol=1e-13 * scale)


@settings(derandomize=True, max_examples=60)
@given(states)
def test_laplace_equals_its_definition_and_is_normal_to_momentum(x: np.ndarray) -> None:
    r, v = x[:3], x[3:]
    h = np.cross(r, v)
    laplace = laplace_vector(r, v, 1.0)
    np.testing.assert_allclose(angular_momentum(r, v), h, atol=1e-14)
    np.testing.assert_allclose(laplace, np.cross(v, h) - r / np.linalg.norm(r), atol=1e-13)
    assert abs(laplace @ h) <= 1e-13 * (1.0 + np.linalg.norm(laplace)) * (1.0 + np.linalg.norm(h))


def test_laplace_points_to_perigee_with_length_mu_e() -> None:
    orbit = Elements(8.0e6, 0.15, np.deg2rad(40), np.deg2rad(70), np.deg2rad(200), np.deg2rad(130))
    laplace = laplace_vector(*state_from_elements(orbit), EARTH.mu_m3_s2)
    perigee, _ = state_from_elements(
        Elements(8.0e6, 0.15, np.deg2rad(40), np.deg2rad(70), np.deg2rad(200), 0.0)
    )
    expected = EARTH.mu_m3_s2 * 0.15 * perigee / np.linalg.norm(perigee)
    np.testing.assert_allclose(laplace, expected, rtol=1e-12, atol=1e-12 * EARTH.mu_m3_s2)


def test_centre_of_attraction_is_refused() -> None:
    with pytest.raises(ValueError, match="centre of attraction"):
        laplace_vector([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1.0)
