"""Two-body coasts in closed form, against the integrator that plans are verified by."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.orbit import CanonicalUnits, Elements, Thruster, propagate_burn, state_from_elements
from orbsoc.orbit.kepler import coasted_in_closed_form

UNITS = CanonicalUnits.of()
ORBITS = {
    "circular": Elements(7.0e6, 0.0, 0.5, 1.0, 0.0, 2.0),
    "nearly circular": Elements(7.0e6, 1e-9, 0.5, 1.0, 0.3, 2.0),
    "ellipse": Elements(1.2e7, 0.4, 1.0, 2.0, 3.0, 4.0),
    "stretched": Elements(2.0e8, 0.965, 2.5, 0.1, 0.2, 0.1),
    "hyperbola": Elements(-9.0e6, 1.8, 0.9, 4.0, 1.0, -0.8),
    "nearly a parabola": Elements(7.0e12, 1.0 - 1e-6, 0.9, 4.0, 1.0, 0.4),
}


def state(orbit: Elements) -> np.ndarray:
    return UNITS.state_from_si(np.concatenate(state_from_elements(orbit)))


@pytest.mark.parametrize("orbit", ORBITS.values(), ids=ORBITS)
def test_a_coast_ends_where_the_integrator_ends(orbit: Elements) -> None:
    start, times = state(orbit), np.array([0.1, 1.0, 4.0, 9.0])
    off = Thruster(1.0, 0.0, 0.0)
    flown = propagate_burn(UNITS.state_to_si(start), off, lambda _t, x: x[3:], times * UNITS.time_s)
    found = coasted_in_closed_form(np.tile(start, (4, 1)), times)
    np.testing.assert_allclose(found, UNITS.state_from_si(flown), rtol=1e-10, atol=2e-10)


@pytest.mark.parametrize("orbit", ORBITS.values(), ids=ORBITS)
def test_a_coast_backwards_undoes_one_forwards(orbit: Elements) -> None:
    start = np.tile(state(orbit), (3, 1))
    times = np.array([0.0, 0.7, 5.0])
    back = coasted_in_closed_form(coasted_in_closed_form(start, times), -times)
    np.testing.assert_allclose(back, start, atol=1e-11)


def test_whole_revolutions_lead_back() -> None:
    start = state(ORBITS["ellipse"])
    period = ORBITS["ellipse"].period_s() / UNITS.time_s
    found = coasted_in_closed_form(np.tile(start, (2, 1)), np.array([period, 7.0 * period]))
    np.testing.assert_allclose(found, np.tile(start, (2, 1)), atol=1e-11)
