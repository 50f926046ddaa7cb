"""Forces and coasts: Jacobians by differences, secular rates, laws of transition matrices, limits without J2."""

import numpy as np
import pytest

from orbsoc.orbit import EARTH, Elements, PropagationError, elements_from_state, state_from_elements
from orbsoc.orbit.perturbations import (
    EARTH_J2,
    J2,
    Drag,
    PointMass,
    coast,
    coast_with_transitions,
    density_kg_m3,
)
from orbsoc.orbit.perturbations.atmosphere import LAYERS

FORCES = [PointMass(), J2(), Drag(0.02)]


def states() -> np.ndarray:
    rows = [
        Elements(6.65e6, 0.003, 0.7, 1.0, 2.0, 0.5),
        Elements(7.1e6, 0.01, 1.7, 3.0, 0.2, 4.0),
        Elements(8.0e6, 0.1, 0.2, 5.0, 1.2, 1.0),
    ]
    return np.array([np.concatenate(state_from_elements(row)) for row in rows])


@pytest.mark.parametrize("force", FORCES, ids=lambda force: type(force).__name__)
def test_jacobians_are_the_derivatives(force: PointMass | J2 | Drag) -> None:
    found, start = force.jacobian(states()), states()
    for k, step in enumerate([10.0] * 3 + [1e-2] * 3):
        move = np.zeros(6)
        move[k] = step
        numeric = (force.acceleration(start + move) - force.acceleration(start - move)) / (2 * step)
        allowed = 1e-6 * np.abs(found).max(axis=(1, 2)) + 1e-22
        assert (np.abs(found[:, :, k] - numeric).max(axis=1) < allowed).all(), k


def test_j2_is_the_gradient_of_its_potential() -> None:
    r = states()[1, :3]

    def potential(p: np.ndarray) -> float:
        d = np.linalg.norm(p)
        return float(
            -EARTH.mu_m3_s2 * EARTH_J2 * EARTH.earth_radius_m**2 / (2 * d**3) * (3 * (p[2] / d) ** 2 - 1)
        )

    numeric = [(potential(r + 50 * e) - potential(r - 50 * e)) / 100 for e in np.eye(3)]
    assert np.allclose(J2().acceleration(states()[1:2])[0], numeric, rtol=1e-7)


def test_node_and_perigee_drift_at_the_secular_rates() -> None:
    """To first order, −(3/2) J₂ n (R/p)² cos i and (3/4) J₂ n (R/p)² (5cos²i − 1), over whole revolutions."""
    orbit = Elements(7.5e6, 0.05, 0.9, 1.0, 1.0, 0.0)
    start = np.concatenate(state_from_elements(orbit))
    period = 2 * np.pi * np.sqrt(orbit.sma_m**3 / EARTH.mu_m3_s2)
    end = coast([start], [0.0, 30 * period], [PointMass(), J2()])[-1, 0]
    found = elements_from_state(end[:3], end[3:])
    rate = EARTH_J2 * (EARTH.earth_radius_m / orbit.semilatus_rectum_m) ** 2 * 2 * np.pi * 30
    assert found.raan_rad - orbit.raan_rad == pytest.approx(-1.5 * rate * np.cos(0.9), rel=0.01)
    assert found.argp_rad - orbit.argp_rad == pytest.approx(
        0.75 * rate * (5 * np.cos(0.9) ** 2 - 1), rel=0.05
    )


def test_without_j2_elements_stay() -> None:
    start = states()
    end = coast(start, [0.0, 4000.0, 20000.0], [PointMass(), J2(j2=0.0), Drag(0.0)])[-1]
    for before, after in zip(start, end, strict=True):
        one, two = (elements_from_state(s[:3], s[3:]) for s in (before, after))
        assert two.sma_m == pytest.approx(one.sma_m, rel=1e-10)
        assert two.argp_rad == pytest.approx(one.argp_rad, abs=1e-8)


def test_many_at_once_are_as_each_alone_and_time_turns_back() -> None:
    start, times = states(), np.array([0.0, 700.0, 5000.0])
    together = coast(start, times, FORCES)
    for k, row in enumerate(start):
        alone = coast([row], times, [PointMass(), J2(), Drag(0.02)])[:, 0]
        assert np.abs(together[:, k] - alone).max() < 1e-3
    still = [PointMass(), J2()]
    there = coast(start, [0.0, 5000.0], still)[-1]
    there[:, 3:] *= -1.0
    back = coast(there, [0.0, 5000.0], still)[-1]
    assert np.abs(back[:, :3] - start[:, :3]).max() < 1e-3


def test_transitions_compose_keep_volume_and_are_derivatives() -> None:
    start, times = states()[:2], np.array([0.0, 1500.0, 4000.0])
    there, matrices = coast_with_transitions(start, times, FORCES)
    assert np.allclose(matrices[0], np.eye(6))
    _, second = coast_with_transitions(there[1], times[1:], FORCES)
    scale = np.diag([1.0, 1.0, 1.0, 1e3, 1e3, 1e3])
    one, two = (scale @ m @ np.linalg.inv(scale) for m in (matrices[2], second[1] @ matrices[1]))
    assert np.abs(one - two).max() < 1e-7 * np.abs(one).max()
    for move in np.diag([20.0, 20.0, 20.0, 0.02, 0.02, 0.02]):
        ends = [coast(start + side * move, times, FORCES)[-1] for side in (1, -1)]
        numeric = (ends[0] - ends[1]) / 2
        assert np.abs(numeric - matrices[2] @ move).max() < 1e-4 * np.abs(numeric).max()
    _, kept = coast_with_transitions(start, times, [PointMass(), J2()])
    assert np.linalg.det(scale @ kept[2] @ np.linalg.inv(scale)) == pytest.approx(1.0, abs=1e-8)


def test_kicks_change_velocities_after_their_time() -> None:
    start, times = states()[:2], np.array([0.0, 600.0, 1800.0])
    kicks = np.zeros((3, 2, 3))
    kicks[0, 0], kicks[1, 1] = (0.5, -0.2, 0.1), (0.0, 0.3, 0.0)
    found = coast(start, times, [PointMass()], kicks)
    moved = start.copy()
    moved[0, 3:] += kicks[0, 0]
    first = coast(moved, times[:2], [PointMass()])[-1]
    assert np.allclose(found[1], first, atol=1e-5)
    first[1, 3:] += kicks[1, 1]
    assert np.allclose(found[2], coast(first, times[1:], [PointMass()])[-1], atol=1e-5)


def test_drag_lowers_the_orbit_at_the_known_rate() -> None:
    """ȧ = −ρ B u² a/v on a circle, u the speed through air that turns along."""
    radius = EARTH.earth_radius_m + 300e3
    start = np.concatenate(state_from_elements(Elements(radius, 0.0, 1e-3, 0.0, 0.0, 0.0)))
    end = coast([start], [0.0, 3000.0], [PointMass(), Drag(0.01)])[-1, 0]
    lost = radius - elements_from_state(end[:3], end[3:]).sma_m
    speed = np.sqrt(EARTH.mu_m3_s2 / radius)
    wind = speed - 7.292115e-5 * radius
    density = density_kg_m3(300e3)[0]
    assert lost == pytest.approx(density * 0.01 * wind**2 * 3000.0 * radius / speed, rel=0.02)


def test_layers_meet_within_a_percent_and_the_slope_is_the_derivative() -> None:
    base, density, scale = LAYERS.T
    above_25 = slice(1, None)
    reached = density[:-1] * np.exp(-np.diff(base) / scale[:-1])
    assert np.abs(reached / density[1:] - 1.0)[above_25].max() < 0.01
    heights = np.array([-1e3, 10e3, 99.9e3, 412e3, 2000e3])
    value, slope = density_kg_m3(heights)
    numeric = (density_kg_m3(heights + 1.0)[0] - density_kg_m3(heights - 1.0)[0]) / 2.0
    assert np.allclose(slope, numeric, rtol=1e-4)
    assert (np.diff(value) < 0).all()


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match=r"states has shape \(6,\); it must be \(B, 6\)"):
        coast(states()[0], [0.0, 1.0], FORCES)
    with pytest.raises(ValueError, match="must be increasing times"):
        coast(states(), [0.0, 0.0], FORCES)
    with pytest.raises(ValueError, match=r"kicks has shape \(1,\)"):
        coast(states(), [0.0, 1.0], FORCES, [1.0])
    with pytest.raises(PropagationError, match="propagation stopped after"):
        coast([[1.0, 0, 0, 0, 0, 0]], [0.0, 1e4], [PointMass()])
