"""The coast with J2: against an integrator of its own, and what a plan that leaves J2 out is worth."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.reachable_insertion import PlanStatus, Scenario, plan
from orbsoc.missions.reachable_insertion.model.coast import coasted
from orbsoc.missions.reachable_insertion.verification import verify
from orbsoc.orbit import EARTH, rotate_state

INCLINATION_DEG = 51.6
RADIUS_M = EARTH.earth_radius_m + 300e3
LATEST_S = 18000.0


def scenario(**burn: Any) -> Scenario:
    """A circular orbit at 300 km, and an orbit of apogee 400 km whose node lies 1° to the west: J2 turns the first one there."""
    speed, inc = np.sqrt(EARTH.mu_m3_s2 / RADIUS_M), np.deg2rad(INCLINATION_DEG)
    target = {"apogee_height_km": 400.0, "inc_deg": INCLINATION_DEG, "raan_deg": 359.0}
    document = {
        "mission": "reachable_insertion",
        "name": "wait for the node",
        "problem": "min_time",
        "axes": "eci",
        "vehicle": {"mass_kg": 8000.0, "dry_mass_kg": 5000.0, "thrust_n": 60000.0, "isp_s": 320.0},
        "initial": {
            "position_m": [RADIUS_M, 0.0, 0.0],
            "velocity_m_s": [0.0, speed * np.cos(inc), speed * np.sin(inc)],
        },
        "target": {**target, "free": ["argp_deg", "shape"]},
        "burn": {"duration_s": 40.0, "ignition": "free", "latest_ignition_s": LATEST_S, **burn},
    }
    return checked(Scenario, document, source="test")


def oblate(_t: float, state: np.ndarray) -> np.ndarray:
    """r̈ of the textbook (Vallado, section 8.6), J₂ of EGM96."""
    r = state[:3]
    radius = np.linalg.norm(r)
    k = 1.5 * 1.08262668e-3 * EARTH.mu_m3_s2 * EARTH.earth_radius_m**2 / radius**5
    ratio = 5.0 * (r[2] / radius) ** 2
    pull = -EARTH.mu_m3_s2 * r / radius**3 + k * r * (ratio - np.array([1.0, 1.0, 3.0]))
    return np.concatenate([state[3:], pull])


@pytest.mark.parametrize("independent", [False, True])
def test_the_coast_is_that_of_an_integration_of_the_textbooks_equation(independent: bool) -> None:
    case = scenario(coast_j2=True)
    times = [0.0, 5000.0, LATEST_S]
    found = coasted(case, times, independent=independent)
    start = case.initial.vector()
    answer = solve_ivp(oblate, (0.0, LATEST_S), start, method="DOP853", t_eval=times, rtol=3e-14, atol=1e-6)
    np.testing.assert_allclose(found[:, :3], answer.y.T[:, :3], rtol=0.0, atol=0.01)
    np.testing.assert_allclose(found[:, 3:], answer.y.T[:, 3:], rtol=0.0, atol=1e-5)
    np.testing.assert_array_equal(found[0], start)
    without = coasted(scenario(), times, independent=independent)
    assert np.linalg.norm((found - without)[-1, :3]) > 1e5


def test_the_pole_is_that_of_eci_in_launch_inertial_axes_too() -> None:
    case = scenario(coast_j2=True)
    site = {"geocentric_latitude_deg": 19.614, "azimuth_deg": 105.0, "inertial_longitude_deg": 110.955}
    moved = case.with_changes(launch_site=site)
    found = coasted(moved, [5000.0])
    np.testing.assert_allclose(
        rotate_state(moved.eci_rotation, found), coasted(case, [5000.0]), rtol=0.0, atol=1e-4
    )
    assert np.abs(found - coasted(case, [5000.0])).max() > 1e6


def test_a_plan_that_waits_for_the_node_is_shorter_and_one_that_ignores_j2_misses_its_target() -> None:
    point_mass, j2 = plan(scenario()), plan(scenario(coast_j2=True))
    assert point_mass.status is j2.status is PlanStatus.VERIFIED
    assert j2.time_of_flight_s < 0.5 * point_mass.time_of_flight_s  # 4.0 s and 14.4 s
    assert j2.ignition_s > 4.0 * 3600.0
    assert j2.to_dict()["forces"] == {"coast": ["point mass", "J2"], "burn": ["point mass"]}
    assert point_mass.to_dict()["forces"] == {"coast": ["point mass"], "burn": ["point mass"]}
    missed = verify(
        scenario(coast_j2=True), point_mass.target, point_mass.iterate, ignition_s=point_mass.ignition_s
    )
    assert not missed.verified
    assert np.deg2rad(0.3) < missed.plane_rad < np.deg2rad(0.35)  # 1.9 h of −0.22°/h by sin i


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "no coast": ({"ignition": "now", "latest_ignition_s": None, "coast_j2": True}, r"burn\.coast_j2 = true: needs burn\.ignition"),
    "text": ({"coast_j2": "yes"}, r"burn\.coast_j2 = 'yes': .*boolean"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_with_the_key_is_said(name: str) -> None:
    changes, words = BAD[name]
    with pytest.raises(ScenarioError, match=words):
        scenario(**changes)
