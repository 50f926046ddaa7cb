"""Pairs of impulses: each ends on the target orbit, and the cheapest are the textbook's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from orbsoc.missions.reachable_insertion.targets.target_orbit import TargetOrbit
from orbsoc.missions.reachable_insertion.two_burns.impulses import Rules, cheapest
from orbsoc.orbit import EARTH, CanonicalUnits, Elements, state_from_elements
from orbsoc.orbit.kepler import coasted_in_closed_form

UNITS = CanonicalUnits.of()
LOW = Elements(EARTH.earth_radius_m + 300e3, 0.0, 0.5, 0.2, 0.0, 0.0)
ORBITS = {
    "circle": Elements(EARTH.earth_radius_m + 1000e3, 0.0, 0.5, 0.2, 0.0, 0.0),
    "tilted ellipse": Elements(8.0e6, 0.1, 0.55, 0.3, 2.0, 0.0),
    "geostationary": Elements(42164e3, 0.0, 0.0, 0.0, 0.0, 0.0),
    "hyperbola": Elements(-4.0e7, 1.18, 0.52, 0.2, 1.0, 0.0),
}


def state(orbit: Elements) -> NDArray[np.float64]:
    return UNITS.state_from_si(np.concatenate(state_from_elements(orbit)))


def first_orbit(times: NDArray[np.float64]) -> NDArray[np.float64]:
    states = coasted_in_closed_form(np.tile(state(LOW), (times.size, 1)), times.ravel())
    return states.reshape(*times.shape, 6)


def found(target: Elements, **limits: Any) -> list[Any]:
    departures = np.linspace(0.0, 6.8, 60)
    whenever = limits.get("allowed", lambda departure, size: departure + size >= 0.0)
    rules = Rules(limits.get("longest", 1e3), limits.get("lowest", 1.0), whenever)
    return cheapest(departures, first_orbit, TargetOrbit.through(state(target)), rules)


@pytest.mark.parametrize("orbit", ORBITS.values(), ids=ORBITS)
def test_every_pair_ends_on_the_target_orbit_after_its_flight(orbit: Elements) -> None:
    pairs = found(orbit)
    assert len(pairs) >= 3
    target = TargetOrbit.through(state(orbit))
    for pair in pairs:
        first = coasted_in_closed_form(state(LOW)[None], np.array([pair.departure]))
        first[:, 3:] += pair.velocities[0]
        last = coasted_in_closed_form(first, np.array([pair.flight]))
        last[:, 3:] += pair.velocities[1]
        assert np.abs(target.conditions(last)).max() < 1e-9
        assert pair.cost == pytest.approx(np.linalg.norm(pair.velocities, axis=1).sum())


def test_between_two_circles_the_cheapest_is_hohmanns_within_the_grid() -> None:
    r1, r2 = UNITS.length_m**-1 * np.array([LOW.sma_m, ORBITS["circle"].sma_m])
    first = np.sqrt(2.0 * r2 / (r1 * (r1 + r2))) - np.sqrt(1.0 / r1)
    second = np.sqrt(1.0 / r2) - np.sqrt(2.0 * r1 / (r2 * (r1 + r2)))
    best = found(ORBITS["circle"])[0]
    assert first + second <= best.cost * (1.0 + 1e-12)
    assert best.cost <= 1.001 * (first + second)
    assert best.flight == pytest.approx(np.pi * ((r1 + r2) / 2.0) ** 1.5, rel=0.03)


def test_limits_on_flight_and_departure_are_kept() -> None:
    short = found(ORBITS["circle"], longest=1.0)
    assert short
    assert all(pair.flight <= 1.0 for pair in short)
    late = found(ORBITS["circle"], allowed=lambda departure, size: (departure > 3.0) & (size < 0.05))
    assert late
    assert all(pair.departure > 3.0 and np.linalg.norm(pair.velocities[0]) < 0.05 for pair in late)


def test_no_transfer_passes_below_the_ground() -> None:
    for pair in found(ORBITS["circle"]):
        first = coasted_in_closed_form(state(LOW)[None], np.array([pair.departure]))
        first[:, 3:] += pair.velocities[0]
        way = coasted_in_closed_form(np.tile(first, (200, 1)), np.linspace(0.0, pair.flight, 200))
        assert np.linalg.norm(way[:, :3], axis=1).min() > 1.0 - 1e-9
