"""Motion about eccentric and perturbed orbits: the differential equation, limits, differences of true orbits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from orbsoc.orbit import EARTH, Elements, state_from_elements
from orbsoc.orbit.perturbations import J2, Drag, PointMass, coast
from orbsoc.orbit.relative import (
    AlongReference,
    ClohessyWiltshire,
    YamanakaAnkersen,
    absolute_state,
    relative_state,
)
from orbsoc.orbit.relative.yamanaka_ankersen import mean_anomaly, true_anomaly

N = 1e-3
SMA = (EARTH.mu_m3_s2 / N**2) ** (1 / 3)
UNITS = np.diag([1.0, 1.0, 1.0, N, N, N])


def scaled(matrix: np.ndarray) -> np.ndarray:
    """With speeds in units of N metres."""
    return np.linalg.inv(UNITS) @ matrix @ UNITS


@given(st.floats(0.0, 0.95), st.floats(-40.0, 40.0))
def test_keplers_equation_is_solved_both_ways(ecc: float, anomaly: float) -> None:
    assert true_anomaly(mean_anomaly(anomaly, ecc), ecc) == pytest.approx(anomaly, abs=1e-9)


@given(st.floats(-2e4, 2e4), st.floats(-2e4, 2e4))
def test_without_eccentricity_it_is_clohessy_wiltshire(t1: float, t0: float) -> None:
    found = scaled(YamanakaAnkersen(N, 0.0, 0.3).transition(t1, t0))
    assert found == pytest.approx(scaled(ClohessyWiltshire(N).transition(t1, t0)), abs=1e-9)


def test_it_comes_near_clohessy_wiltshire_with_the_eccentricity() -> None:
    circle = scaled(ClohessyWiltshire(N).transition(4000.0, 500.0))
    apart = [
        np.abs(scaled(YamanakaAnkersen(N, e, 1.0).transition(4000.0, 500.0)) - circle).max()
        for e in (1e-2, 1e-3, 1e-4)
    ]
    assert apart[0] / apart[1] == pytest.approx(10.0, rel=0.1)
    assert apart[1] / apart[2] == pytest.approx(10.0, rel=0.1)


@given(st.floats(0.0, 0.8), st.floats(0.0, 6.0), st.floats(0.0, 2e4), st.floats(0.0, 2e4))
def test_transitions_compose_and_keep_volume(ecc: float, start: float, a: float, b: float) -> None:
    motion = YamanakaAnkersen(N, ecc, start)
    whole = scaled(motion.transition(b, 0.0))
    parts = scaled(motion.transition(b, a) @ motion.transition(a, 0.0))
    assert np.abs(whole - parts).max() < 1e-8 * (1.0 + np.abs(parts).max()) / (1.0 - ecc) ** 3
    assert np.linalg.det(whole) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("ecc", "start"), [(0.01, np.pi), (0.3, 0.4), (0.7, 2.5)])
def test_solves_the_differential_equation(ecc: float, start: float) -> None:
    k = N * (1 - ecc**2) ** -1.5

    def rate(_: float, y: np.ndarray) -> list[float]:
        r, t, n, vr, vt, vn, nu = y
        rho = 1 + ecc * np.cos(nu)
        w, pull, slow = k * rho**2, k**2 * rho**3, -2 * k**2 * ecc * np.sin(nu) * rho**3
        return [
            vr,
            vt,
            vn,
            2 * w * vt + slow * t + w**2 * r + 2 * pull * r,
            -2 * w * vr - slow * r + w**2 * t - pull * t,
            -pull * n,
            w,
        ]

    first = np.array([100.0, -300.0, 50.0, 0.1, 0.2, -0.1])
    flown = solve_ivp(rate, (0.0, 9000.0), [*first, start], method="DOP853", rtol=1e-12, atol=1e-11)
    motion = YamanakaAnkersen(N, ecc, start)
    assert motion.true_anomaly(9000.0) == pytest.approx(flown.y[6, -1], abs=1e-8)
    assert motion.transition(9000.0, 0.0) @ first == pytest.approx(flown.y[:6, -1], abs=1e-4)


@pytest.mark.parametrize(("ecc", "inc"), [(0.0, 0.9), (0.05, 1.3)])
def test_along_a_keplerian_reference_it_is_the_closed_form(ecc: float, inc: float) -> None:
    orbit = Elements(SMA, ecc, inc, 0.4, 0.8, 2.0)
    along = AlongReference(np.concatenate(state_from_elements(orbit)), [PointMass()])
    closed = YamanakaAnkersen(N, ecc, 2.0)
    for t1, t0 in ((3000.0, 0.0), (7000.0, 3000.0), (1000.0, 4000.0)):
        assert scaled(along.transition(t1, t0)) == pytest.approx(scaled(closed.transition(t1, t0)), abs=1e-6)


def test_along_a_perturbed_reference_small_differences_are_those_of_true_orbits() -> None:
    target = np.concatenate(state_from_elements(Elements(6.9e6, 0.02, 1.1, 0.2, 0.3, 0.4)))
    forces = [PointMass(), J2(), Drag(0.02)]
    along = AlongReference(target, forces)
    along.prepare([1500.0, 6000.0])

    def pull(state: np.ndarray) -> np.ndarray:
        return np.asarray(sum(force.acceleration(state[None])[0] for force in forces))

    start = np.array([2.0, -3.0, 1.0, 1e-3, 2e-3, -1e-3])
    chaser = absolute_state(target, start, pull(target))
    ends = coast([target, chaser], [0.0, 1500.0, 6000.0], forces)
    for k, t in ((1, 1500.0), (2, 6000.0)):
        found = relative_state(ends[k, 0], ends[k, 1], pull(ends[k, 0]))
        assert along.target(t) == pytest.approx(ends[k, 0], abs=1e-2)
        assert (along.transition(t, 0.0) @ start)[:3] == pytest.approx(found[:3], abs=2e-3)
        assert (along.transition(t, 0.0) @ start)[3:] == pytest.approx(found[3:], abs=2e-6)
    circle = ClohessyWiltshire(np.sqrt(EARTH.mu_m3_s2 / 6.9e6**3)).transition(6000.0, 0.0) @ start
    assert np.abs(circle[:3] - found[:3]).max() > 0.1


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match=r"ecc = 1\.0: must be 0 or more and below 1"):
        YamanakaAnkersen(N, 1.0)
    with pytest.raises(ValueError, match=r"mean_motion_rad_s = 0\.0: must be positive"):
        YamanakaAnkersen(0.0, 0.1)
    with pytest.raises(ValueError, match="must not be before the reference"):
        AlongReference([7e6, 0, 0, 0, 7.5e3, 0], [PointMass()]).transition(-5.0, 0.0)
