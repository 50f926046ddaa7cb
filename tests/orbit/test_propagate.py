"""The independent propagation: conserved quantities, a closed form, and its own convergence."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.orbit import (
    EARTH,
    Elements,
    PropagationError,
    Thruster,
    angular_momentum,
    elements_from_state,
    propagate_burn,
    state_from_elements,
)

COASTING = Thruster(mass_kg=1000.0, thrust_n=0.0, mass_flow_kg_s=0.0)
BURNING = Thruster(mass_kg=84507.0, thrust_n=271239.0, mass_flow_kg_s=61.0)
STATE = np.concatenate(state_from_elements(Elements(7.2e6, 0.05, 0.6, 1.0, 2.0, 0.3)))


def along_velocity(_t_s: float, state: np.ndarray) -> np.ndarray:
    return state[3:]


def test_coast_returns_after_one_period() -> None:
    period_s = 2.0 * np.pi * np.sqrt(7.2e6**3 / EARTH.mu_m3_s2)
    end = propagate_burn(STATE, COASTING, along_velocity, [0.0, period_s])
    np.testing.assert_array_equal(end[0], STATE)
    np.testing.assert_allclose(end[1][:3], STATE[:3], atol=1e-4)
    np.testing.assert_allclose(end[1][3:], STATE[3:], atol=1e-7)


def test_coast_conserves_momentum_and_energy_to_the_integrators_tolerance() -> None:
    states = propagate_burn(STATE, COASTING, along_velocity, np.linspace(0.0, 3000.0, 20))
    momentum = np.array([angular_momentum(x[:3], x[3:]) for x in states])
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (20, 1)), rtol=0, atol=1e-11 * 5e10)
    axes = np.array([elements_from_state(x[:3], x[3:]).sma_m for x in states])
    np.testing.assert_allclose(axes, 7.2e6, rtol=1e-11)


def test_far_from_earth_a_straight_burn_gains_the_rocket_equations_speed() -> None:
    """At 1e12 m gravity is 4e-10 m/s²: Δv = (F/ṁ) ln(m₀/m₁) along a fixed direction."""
    start = np.array([1e12, 0.0, 0.0, 0.0, 100.0, 0.0])
    end = propagate_burn(start, BURNING, lambda _t, _x: [0.0, 3.0, 4.0], [60.0], rtol=1e-13)[0]
    gain = 271239.0 / 61.0 * np.log(84507.0 / (84507.0 - 61.0 * 60.0))
    np.testing.assert_allclose(end[3:], [0.0, 100.0 + 0.6 * gain, 0.8 * gain], atol=1e-4)


def test_tolerance_is_tight_enough_that_halving_it_changes_nothing_visible() -> None:
    loose = propagate_burn(STATE, BURNING, along_velocity, [100.0])[0]
    tight = propagate_burn(STATE, BURNING, along_velocity, [100.0], rtol=2.3e-14, atol=1e-15)[0]
    np.testing.assert_allclose(loose, tight, rtol=0, atol=1e-4)
    assert np.abs(loose - tight)[3:].max() < 1e-7


@pytest.mark.parametrize("times", [[], [1.0, 0.5], [-1.0], [[1.0]]])
def test_bad_times_are_refused(times: list[float]) -> None:
    with pytest.raises(ValueError, match="times_s"):
        propagate_burn(STATE, BURNING, along_velocity, times)


def test_burning_more_than_the_mass_is_refused() -> None:
    with pytest.raises(ValueError, match="burnt itself up"):
        propagate_burn(STATE, BURNING, along_velocity, [84507.0 / 61.0])


@pytest.mark.parametrize("times", [[10.0], [0.0, 10.0]])
def test_a_burn_that_cannot_be_integrated_says_when_it_stopped(times: list[float]) -> None:
    absurd = Thruster(mass_kg=1.0, thrust_n=1e300, mass_flow_kg_s=0.0)
    with pytest.raises(PropagationError, match=r"stopped after t = 0 s: .*step size"):
        propagate_burn(STATE, absurd, along_velocity, times)
