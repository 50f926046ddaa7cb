"""The compiled coast against SciPy's DOP853, its matrices against those, its burns against an integration of the same thrust."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from orbsoc.orbit import Elements, PropagationError, state_from_elements
from orbsoc.orbit.perturbations import (
    J2,
    Drag,
    Force,
    PointMass,
    SteeredBurn,
    coast,
    coast_with_transitions,
    fast_burn,
    fast_coast,
    fast_coast_with_transitions,
)
from orbsoc.orbit.relative import local_frame

PARKING = np.concatenate(state_from_elements(Elements(6.7718e6, 6e-5, 0.7115, 5.417, 5.904, 4.475)))
LOW = np.concatenate(state_from_elements(Elements(6.6704e6, 0.0136, 0.712, 5.408, 3.09, 2.235)))
"""Its perigee is just above 200 km, where two layers of the air meet."""
OBLATE: list[Force] = [PointMass(), J2()]


def test_with_j2_it_is_dop853_to_a_millimetre_over_eleven_revolutions() -> None:
    times = np.linspace(0.0, 60_439.0, 25)
    states, matrices = fast_coast_with_transitions([PARKING], times, OBLATE)
    peer, peers = coast_with_transitions([PARKING], times, OBLATE)
    assert np.abs(states - peer)[..., :3].max() < 1e-3
    assert np.abs(matrices - peers).max() < 1e-9 * np.abs(peers).max()


def test_with_drag_it_is_dop853_to_decimetres_and_to_less_in_short_steps() -> None:
    forces = [*OBLATE, Drag(0.00545)]
    times = np.linspace(0.0, 60_439.0, 10)
    states, matrices = fast_coast_with_transitions([PARKING], times, forces)
    peer, peers = coast_with_transitions([PARKING], times, forces)
    assert np.abs(states - peer)[..., :3].max() < 0.15
    assert np.abs(matrices - peers).max() < 1e-6 * np.abs(peers).max()
    scale = np.repeat([6.7e6, 7.8e3], 3)

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        now = (y * scale)[None]
        return np.concatenate([now[0, 3:], sum(f.acceleration(now) for f in forces)[0]]) / scale

    # DOP853 steps over the corners of the density: in steps of 20 s it comes to what the events give
    short = solve_ivp(
        rate, (0.0, 11_000.0), LOW / scale, method="DOP853", rtol=1e-12, atol=1e-12, max_step=20.0
    )
    found = fast_coast([LOW], [0.0, 11_000.0], forces)[-1, 0]
    assert np.linalg.norm((short.y[:, -1] * scale - found)[:3]) < 0.01


def test_its_own_error_is_below_a_millimetre_where_layers_meet() -> None:
    forces = [*OBLATE, Drag(0.02)]
    ends = [fast_coast([LOW], [0.0, 60_000.0], forces, rtol=rtol)[-1, 0] for rtol in (1e-13, 1e-14)]
    assert np.linalg.norm((ends[0] - ends[1])[:3]) < 2e-3


def test_many_states_have_each_their_drag_and_kicks() -> None:
    times = [0.0, 2000.0, 5000.0]
    kicks = np.zeros((3, 2, 3))
    kicks[1, 1] = (1.0, -2.0, 3.0)
    both = fast_coast([PARKING, LOW], times, [*OBLATE, Drag([0.0, 0.01])], kicks)
    assert np.array_equal(both[:, 0], fast_coast([PARKING], times, OBLATE)[:, 0])
    peer = coast([PARKING, LOW], times, [*OBLATE, Drag([0.0, 0.01])], kicks)
    assert np.abs(both - peer)[..., :3].max() < 0.05


def test_a_burn_is_the_integral_of_its_thrust() -> None:
    burn = SteeredBurn(1.1, 3090.0, 0.4, 0.2, 230.0, -0.003)
    found = fast_burn(PARKING, burn, OBLATE)

    def rate(s: float, y: np.ndarray) -> np.ndarray:
        outward, along, normal = local_frame(y)[0]
        pitch = 0.4 - 0.003 * (s - 115.0)
        direction = np.cos(0.2) * (np.cos(pitch) * along + np.sin(pitch) * outward) + np.sin(0.2) * normal
        gravity = sum(f.acceleration(y[None]) for f in OBLATE)[0]
        return np.concatenate([y[3:], gravity + 1.1 / (1.0 - 1.1 * s / 3090.0) * direction])

    peer = solve_ivp(rate, (0.0, 230.0), PARKING, method="DOP853", rtol=1e-12, atol=1e-6)
    assert np.abs(peer.y[:, -1] - found).max() < 1e-4
    assert burn.dv_m_s == pytest.approx(-3090.0 * np.log(1.0 - 1.1 * 230.0 / 3090.0))


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match="must be PointMass, and J2 and Drag at most once"):
        fast_coast([PARKING], [0.0, 1.0], [J2()])
    with pytest.raises(ValueError, match="at most once"):
        fast_coast([PARKING], [0.0, 1.0], [PointMass(), J2(), J2()])
    with pytest.raises(ValueError, match="must be increasing times"):
        fast_coast([PARKING], [0.0, 0.0], OBLATE)
    with pytest.raises(ValueError, match="must be below 2809"):
        fast_burn(PARKING, SteeredBurn(1.1, 3090.0, 0.0, 0.0, 3000.0), OBLATE)
    fall = PARKING.copy()
    fall[3:] *= 1e-3
    with pytest.raises(PropagationError, match="propagation stopped after"):
        fast_coast([fall], [0.0, 9000.0], OBLATE)
