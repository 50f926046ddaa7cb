"""Anomalies: Kepler's equation holds, and a place comes back."""

from __future__ import annotations

from math import atan2, cos, cosh, pi, sin, sinh, sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbsoc.orbit.anomalies import mean_from_true, true_from_eccentric, true_from_mean


@given(st.floats(-20.0, 20.0), st.floats(0.0, 0.99))
def test_keplers_equation_holds_on_an_ellipse(eccentric: float, ecc: float) -> None:
    true = true_from_mean(eccentric - ecc * sin(eccentric), ecc)
    assert true == pytest.approx(true_from_eccentric(eccentric, ecc), abs=2e-12)
    there = atan2(sqrt(1.0 - ecc**2) * sin(eccentric), cos(eccentric) - ecc)
    assert abs(sin(0.5 * (true - there))) < 2e-12
    assert abs(true - eccentric) <= pi


@given(st.floats(-12.0, 12.0), st.floats(1.001, 30.0))
def test_keplers_equation_holds_on_a_hyperbola(hyperbolic: float, ecc: float) -> None:
    true = true_from_mean(ecc * sinh(hyperbolic) - hyperbolic, ecc)
    there = atan2(sqrt(ecc**2 - 1.0) * sinh(hyperbolic), ecc - cosh(hyperbolic))
    assert true == pytest.approx(there, abs=1e-9)


@given(st.floats(-3.1, 3.1), st.floats(0.0, 0.95))
def test_a_mean_anomaly_goes_there_and_back(true: float, ecc: float) -> None:
    assert true_from_mean(mean_from_true(true, ecc), ecc) == pytest.approx(true, abs=1e-11)


@pytest.mark.parametrize("convert", [true_from_mean, true_from_eccentric, mean_from_true])
def test_a_parabola_is_refused(convert: object) -> None:
    assert callable(convert)
    with pytest.raises(ValueError, match="parabola"):
        convert(0.1, 1.0)
