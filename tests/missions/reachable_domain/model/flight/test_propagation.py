"""The flight that judges every plan: independent of what makes the plans, exact between its steps, and strict."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.missions.reachable_domain.model.flight import propagation as flight
from orbsoc.missions.reachable_domain.model.flight.propagation import fly
from orbsoc.missions.reachable_domain.search.continuation import tools
from orbsoc.orbit import CanonicalUnits, gauss, propagate_burn
from tests.missions.reachable_domain.cases import domain, paper

BURN, DURATION = domain().tools.burn, domain().tools.duration
UNITS = CanonicalUnits.of()


def programmes(count: int = 6) -> np.ndarray:
    """Unit vectors on 12 nodes that swing about the velocity."""
    draw = np.random.default_rng(4)
    ahead = BURN.start[3:] / np.linalg.norm(BURN.start[3:])
    vectors = ahead + 0.3 * draw.normal(size=(count, 1, 3)) + 0.05 * draw.normal(size=(count, 12, 3))
    return vectors / np.linalg.norm(vectors, axis=2, keepdims=True)


def by_scipy(vectors: np.ndarray, times_s: np.ndarray) -> np.ndarray:
    """States (K, 6), canonical, of one programme flown by SciPy."""
    grid, scenario = legendre_gauss(len(vectors)), paper()

    def steering(t_s: float, _state: np.ndarray) -> np.ndarray:
        return grid.interpolate(vectors, 2.0 * t_s / scenario.burn.duration_s - 1.0)[0]

    found = propagate_burn(scenario.initial_eci(), scenario.vehicle.thruster(), steering, times_s)
    return found / UNITS.state_to_si(np.ones(6))


def test_flights_are_scipys_and_their_lowest_point_lies_between_the_steps() -> None:
    vectors = programmes()
    found = fly(BURN, DURATION, vectors)
    times_s = np.linspace(0.0, paper().burn.duration_s, 4001)
    for k, one in enumerate(vectors):
        states = by_scipy(one, times_s)
        np.testing.assert_allclose(found.ends[k], states[-1], rtol=0, atol=1e-8)
        radius = np.linalg.norm(states[:, :3], axis=1)
        assert found.lowest[k] == pytest.approx(radius.min(), abs=2e-8)  # 13 cm
    dives = programmes(1)
    dives[0] = -np.array([0.2, 0.2, 1.0]) * np.sign(BURN.start[2])
    radius = np.linalg.norm(by_scipy(dives[0], times_s)[:, :3], axis=1)
    nodes = np.linspace(0, 4000, flight.FIRST_STEPS + 1).astype(int)
    assert fly(BURN, DURATION, dives).lowest[0] == pytest.approx(radius.min(), abs=2e-8)
    assert radius[nodes].min() >= radius.min()


def test_the_raw_length_is_that_of_the_interpolant_on_200_points() -> None:
    vectors = programmes()
    found = fly(BURN, DURATION, vectors)
    at = np.linspace(-1.0, 1.0, 2001)
    lengths = [np.linalg.norm(legendre_gauss(12).interpolate(one, at), axis=1) for one in vectors]
    np.testing.assert_allclose(found.raw_most, [length.max() for length in lengths], rtol=1e-3)
    np.testing.assert_allclose(found.raw_least, [length.min() for length in lengths], rtol=1e-3)
    assert flight.RAW_SAMPLES >= 200


def test_a_programme_that_swings_fast_is_flown_in_shorter_steps() -> None:
    """A primer that passes near zero turns the thrust around within seconds."""
    nodes = legendre_gauss(16).nodes
    primer = np.stack([nodes - 0.21, 0.01 + 0.0 * nodes, 0.0 * nodes], axis=1)
    found = fly(BURN, DURATION, primer[None])
    assert found.error[0] <= flight.ERROR
    states = by_scipy(primer, np.array([paper().burn.duration_s]))
    np.testing.assert_allclose(found.ends[0], states[-1], rtol=0, atol=1e-7)


def test_neither_collocation_nor_the_polishs_integrator_takes_part(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object, **__: object) -> None:
        raise AssertionError("the flight used what it is to judge")

    vectors = programmes(1)
    for name in ("integrate", "gauss_steps"):
        monkeypatch.setattr(gauss, name, forbidden)
    monkeypatch.setattr("orbsoc.guidance.collocation.interpolation_matrix", forbidden)
    for cached in (flight._moments, flight._raw_sampling):
        cached.cache_clear()
    assert np.isfinite(fly(BURN, DURATION, vectors).ends).all()
    assert not {"interpolation_matrix", "legendre_gauss", "integrate", "gauss_steps"} & set(vars(flight))


def test_no_plan_counts_whose_raw_programme_is_longer_than_1_by_1e_4() -> None:
    """This one flies to its promise on 12 nodes, but ‖u‖ reaches 1.0004 between them: it is polished."""
    inc, raan = domain().planes()
    table = domain().solve_planes(inc[::10], raan[::10], np.array([100.0]))
    reached = table.reached()
    assert table["raw_most_rel"][reached].max() <= 1e-4
    assert (table["raw_least_rel"][reached] <= table["raw_most_rel"][reached]).all()
    assert tools.Tolerances().raw_excess == 1e-4
    lenient = domain().of(paper())
    object.__setattr__(lenient.tools.tolerances, "raw_excess", np.inf)
    loose = lenient.solve_planes(inc[::10], raan[::10], np.array([100.0]))
    too_long = loose["raw_most_rel"] > 1e-4
    assert too_long.sum() >= 3
    assert set(table["level"][too_long]) == {"polished"}
