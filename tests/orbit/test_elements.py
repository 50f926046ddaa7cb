"""Elements, frames, attitude and units against published numbers and against each other."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbsoc.orbit import (
    EARTH,
    CanonicalUnits,
    Elements,
    LaunchFrame,
    eci_from_launch_inertial,
    elements_from_state,
    pitch_yaw,
    rotate_state,
    state_from_elements,
    thrust_direction,
)

WENCHANG = LaunchFrame(np.deg2rad(19.6140), np.deg2rad(105.000), np.deg2rad(110.955))
R0_M, V0_M_S = np.array([3.04e6, 5.83e6, 1.61e5]), np.array([6.68e3, -3.60e3, 6.07e2])


def test_elements_equal_vallado_example_2_5() -> None:
    orbit = elements_from_state(
        np.array([6524.834, 6862.875, 6448.296]) * 1e3, np.array([4.901327, 5.533756, -1.976341]) * 1e3
    )
    assert orbit.sma_m == pytest.approx(36127.343e3, abs=50.0)
    assert orbit.ecc == pytest.approx(0.832853, abs=1e-6)
    angles = np.rad2deg([orbit.inc_rad, orbit.raan_rad, orbit.argp_rad, orbit.true_anomaly_rad])
    np.testing.assert_allclose(angles, [87.870, 227.898, 53.38, 92.335], atol=6e-3)


def test_paper_state_read_as_launch_inertial_gives_the_current_orbit_of_table_2() -> None:
    state = rotate_state(eci_from_launch_inertial(WENCHANG), np.concatenate([R0_M, V0_M_S]))
    half_digit = np.deg2rad(0.0005)  # the decoded angles are known to three decimals of a degree
    expected = np.array([-4780421.0, 4388673.2, 1069366.2, -4944.1088, -4692.4264, -3389.3615])
    assert np.linalg.norm(state[:3] - expected[:3]) < half_digit * np.linalg.norm(expected[:3])
    assert np.linalg.norm(state[3:] - expected[3:]) < half_digit * np.linalg.norm(expected[3:])
    orbit = elements_from_state(state[:3], state[3:])
    assert np.rad2deg(orbit.inc_rad) == pytest.approx(28.18, abs=0.005)
    assert np.rad2deg(orbit.raan_rad) == pytest.approx(335.36, abs=0.005)
    assert orbit.sma_m == pytest.approx(6300959.68, abs=0.2)  # from a state rounded to 0.1 m, 1e-4 m/s
    assert orbit.ecc == pytest.approx(0.045322, abs=1e-6)
    assert orbit.perigee_height_m() == pytest.approx(-362.749e3, abs=1.0)
    assert orbit.apogee_height_m() == pytest.approx(208.394e3, abs=1.0)


def test_paper_state_read_as_eci_would_be_retrograde() -> None:
    orbit = elements_from_state(R0_M, V0_M_S)
    assert np.rad2deg([orbit.inc_rad, orbit.raan_rad]) == pytest.approx([175.20, 79.41], abs=0.006)


@settings(derandomize=True, max_examples=150)
@given(
    st.floats(7e6, 5e7),
    st.sampled_from([0.0, 1e-14, 1e-6, 0.1, 0.9]),
    st.sampled_from([0.0, 1e-14, 1e-6, 0.5, np.pi / 2, np.pi - 1e-14, np.pi]),
    st.floats(0.0, 6.28),
    st.floats(0.0, 6.28),
    st.floats(0.0, 6.28),
)
def test_state_survives_the_round_trip_through_elements_even_where_angles_are_undefined(
    sma_m: float, ecc: float, inc: float, raan: float, argp: float, nu: float
) -> None:
    position, velocity = state_from_elements(Elements(sma_m, ecc, inc, raan, argp, nu))
    back = state_from_elements(elements_from_state(position, velocity))
    np.testing.assert_allclose(back[0], position, atol=2e-9 * sma_m)
    np.testing.assert_allclose(back[1], velocity, atol=2e-9 * np.linalg.norm(velocity))


def test_hyperbola_has_negative_semi_major_axis_and_infinite_apogee() -> None:
    orbit = elements_from_state([7.0e6, 0.0, 0.0], [0.0, 12.0e3, 0.0])
    assert orbit.sma_m < 0.0
    assert orbit.ecc > 1.0
    assert orbit.apogee_height_m() == float("inf")
    assert orbit.perigee_radius_m == pytest.approx(7.0e6, rel=1e-12)


@pytest.mark.parametrize(
    ("position", "velocity", "words"),
    [([7e6, 0, 0], [1e3, 0, 0], "parallel"), ([0.0, 0, 0], [1e3, 0, 0], "rectilinear|centre")],
)
def test_states_without_a_plane_are_refused(position: list[float], velocity: list[float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        elements_from_state(position, velocity)


def test_impossible_elements_are_refused() -> None:
    with pytest.raises(ValueError, match=r"a\(1 − e²\)"):
        state_from_elements(Elements(7e6, 1.5, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="asymptote"):
        state_from_elements(Elements(-7e6, 1.5, 0.0, 0.0, 0.0, 3.0))


def test_launch_frame_is_a_rotation_with_y_up_and_x_along_the_azimuth() -> None:
    rotation = eci_from_launch_inertial(LaunchFrame(np.deg2rad(30), np.deg2rad(90), np.deg2rad(0)))
    np.testing.assert_allclose(rotation.T @ rotation, np.eye(3), atol=1e-15)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(rotation[:, 0], [0.0, 1.0, 0.0], atol=1e-15)  # due east
    np.testing.assert_allclose(rotation[:, 1], [np.cos(np.pi / 6), 0.0, 0.5], atol=1e-15)  # up
    np.testing.assert_allclose(rotation[:, 2], [0.5, 0.0, -np.cos(np.pi / 6)], atol=1e-15)  # right: south


@settings(derandomize=True, max_examples=80)
@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5))
def test_pitch_yaw_inverts_thrust_direction(pitch: float, yaw: float) -> None:
    direction = thrust_direction(pitch, yaw)
    assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(np.array(pitch_yaw(3.0 * direction)), [pitch, yaw], atol=1e-12)


def test_yaw_is_positive_to_the_left_and_pitch_has_no_jump_through_the_vertical() -> None:
    assert pitch_yaw([0.0, 0.0, -1.0])[1] == pytest.approx(np.pi / 2)
    angles = np.linspace(0.0, 3 * np.pi, 200)
    pitch, _ = pitch_yaw(np.column_stack([np.cos(angles), np.sin(angles), 0 * angles]))
    np.testing.assert_allclose(pitch, angles, atol=1e-12)


def test_canonical_units_make_mu_one() -> None:
    units = CanonicalUnits.of()
    assert units.length_m**3 / units.time_s**2 == pytest.approx(EARTH.mu_m3_s2, rel=1e-15)
    assert units.speed_m_s == pytest.approx(7905.366, abs=1e-3)
    np.testing.assert_allclose(units.state_to_si(units.state_from_si(np.arange(6.0))), np.arange(6.0))


def test_the_period_is_that_of_the_mean_motion() -> None:
    orbit = Elements(7.0e6, 0.1, 0.5, 1.0, 2.0, 3.0)
    assert 2.0 * np.pi / orbit.period_s() == pytest.approx(np.sqrt(EARTH.mu_m3_s2 / 7.0e6**3))
