"""Deviations of navigation and execution errors are those of their draws."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from orbsoc.guidance.uncertainty import PHASES, Uncertainty, drift_rows
from orbsoc.orbit.relative import ClohessyWiltshire

ERRORS = Uncertainty(
    position_m=0.5, velocity_m_s=2e-3, execution_share=0.02, execution_fixed_m_s=3e-4, sigmas=3.0
)
ROW = np.array([7.0, 0.3, 0.1, 1800.0, 900.0, 50.0])


def test_the_deviation_of_a_row_is_that_of_draws() -> None:
    random = np.random.default_rng(5)
    state, dv = np.arange(6.0), np.array([0.1, -0.2, 0.05])
    moved = []
    for _ in range(4000):
        after = ERRORS.navigated(state, random)
        after[3:] += ERRORS.executed(dv, random) - dv
        moved.append(ROW @ (after - state))
    expected = np.hypot(ERRORS.deviation(ROW), ERRORS.gain(ROW) * np.linalg.norm(dv))
    assert np.std(moved) == pytest.approx(expected, rel=0.05)
    assert np.mean(moved) == pytest.approx(0.0, abs=0.08 * float(expected))


def test_rows_are_taken_many_at_once() -> None:
    rows = np.stack([ROW, 2.0 * ROW])
    assert ERRORS.deviation(rows) == pytest.approx(np.array([1.0, 2.0]) * ERRORS.deviation(ROW))
    assert ERRORS.gain(rows) == pytest.approx(np.array([1.0, 2.0]) * ERRORS.gain(ROW))


def test_nothing_is_fired_for_nothing() -> None:
    assert ERRORS.executed(np.zeros(3), np.random.default_rng(0)).tolist() == [0.0, 0.0, 0.0]


def test_a_millimetre_a_second_moves_a_closed_drift_by_6_pi_over_n_in_an_orbit() -> None:
    n = 1e-3
    rows = drift_rows(ClohessyWiltshire(n), np.eye(6)[1:2], 0.0, 2 * np.pi / n)
    assert rows.shape == (PHASES + 1, 1, 6)
    assert abs(rows[-1, 0, 4]) * 1e-3 == pytest.approx(6 * np.pi / n * 1e-3)


@pytest.mark.parametrize("change", [{"position_m": -1.0}, {"execution_share": 0.5}, {"sigma": 3.0}])
def test_bad_numbers_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        Uncertainty(**({"position_m": 0.5, "velocity_m_s": 1e-3} | change))
