"""Free flight beside the path: an independent integrator agrees, with a disturbance too."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from orbsoc.guidance.impulses import KICK, ImpulseProgramme
from orbsoc.missions.fly_around.model.flight import Flight, fly

from .baseline import integrated, scenario

PATH = scenario().flight.ellipse
N = PATH.mean_motion_rad_s
seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=20)
@given(seeds, st.floats(10.0, 2500.0))
def test_arcs_and_transfers_are_those_of_an_integrator(seed: int, dt: float) -> None:
    rng = np.random.default_rng(seed)
    push = 1e-4 * rng.normal(size=3)
    flight = Flight(PATH, push)
    state = np.concatenate([200.0 * rng.normal(size=3), rng.normal(size=3)])
    expected = integrated(state, dt, N, push)
    np.testing.assert_allclose(flight.state_after(state, dt), expected, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(flight.arc(state, dt)[-1], expected, rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(flight.state_after(expected, -dt), state, rtol=1e-8, atol=1e-5)  # and back
    speed = flight.transfer(state[:3], expected[:3], dt)
    np.testing.assert_allclose(speed, state[3:], rtol=1e-7, atol=1e-7)


@given(seeds)
def test_the_largest_error_is_found_between_the_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    flight = scenario().flight
    start = float(rng.uniform(0.0, 1500.0))
    length = float(rng.uniform(30.0, 250.0))
    state = np.concatenate([PATH.position(start), PATH.velocity(start)])
    state += np.concatenate([rng.normal(size=3), 0.02 * rng.normal(size=3)])
    coarse = flight.largest_error(flight.arc(state, length), start, length)[0]
    dense = flight.largest_error(flight.arc(state, length, 6400), start, length)[0]
    assert abs(coarse - dense) < 1e-5 * dense


def test_a_programme_is_flown_from_impulse_to_impulse() -> None:
    flight = scenario(disturbance={"acceleration_m_s2": [1e-6, 2e-6, -1e-6]}).flight
    start = np.concatenate([PATH.position(0.0), np.zeros(3)])
    programme = ImpulseProgramme([0.0, 100.0], [[0.1, -0.2, 0.3], [0.0, 0.1, 0.0]])
    flown = fly(flight, start, programme, 250.0)
    first = integrated(start + KICK @ programme.dv_m_s[0], 100.0, N, flight.disturbance_m_s2)
    last = integrated(first + KICK @ programme.dv_m_s[1], 150.0, N, flight.disturbance_m_s2)
    np.testing.assert_allclose(flown.before, [start, first, last], atol=1e-8)
    after = np.array([start, first])[:, 3:] + programme.dv_m_s
    assert abs(flown.post_burn_speeds_m_s - np.linalg.norm(after, axis=1).sum()) < 1e-9


@settings(max_examples=20)
@given(seeds)
def test_no_sample_is_above_the_bound_on_the_error(seed: int) -> None:
    rng = np.random.default_rng(seed)
    flight = Flight(PATH, 1e-5 * rng.normal(size=3))
    start, length = float(rng.uniform(0.0, 1500.0)), float(rng.uniform(30.0, 600.0))
    state = np.concatenate([PATH.position(start), PATH.velocity(start)])
    state += np.concatenate([rng.normal(size=3), 0.02 * rng.normal(size=3)])
    dense = flight.largest_error(flight.arc(state, length, 20_000), start, length)[0]
    assert dense <= flight.error_at_most(state, start, length) <= dense * (1.0 + 1e-4)
