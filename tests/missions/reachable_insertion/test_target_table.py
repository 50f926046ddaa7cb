"""Targets and engines as people have them: states, elements, heights, C3, v∞, specific impulse; axes of the outputs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.reachable_insertion import PlanStatus, Scenario, plan
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.orbit import EARTH, Elements, elements_from_state, state_from_elements

START = Elements(EARTH.earth_radius_m + 250e3, 0.001, 0.9, 1.0, 0.3, 0.2)
R, V = state_from_elements(START)
ANGLES = {
    "inc_deg": float(np.rad2deg(0.91)),
    "raan_deg": float(np.rad2deg(1.0)),
    "argp_deg": float(np.rad2deg(0.35)),
}
VEHICLE = {"mass_kg": 5000.0, "dry_mass_kg": 1000.0, "thrust_n": 30000.0, "mass_flow_kg_s": 9.0}


def document(target: dict[str, Any], **changes: Any) -> dict[str, Any]:
    return {
        "mission": "reachable_insertion", "name": "t", "problem": "min_time", "axes": "eci", "vehicle": VEHICLE,
        "initial": {"position_m": R.tolist(), "velocity_m_s": V.tolist()}, "target": target,
        "burn": {"duration_s": 60.0},
    } | changes  # fmt: skip


def scenario(target: dict[str, Any], **changes: Any) -> Scenario:
    return checked(Scenario, document(target, **changes), source="t")


@pytest.mark.parametrize(
    "shape",
    [
        {"sma_km": 6900.0, "ecc": 0.04},
        {"perigee_height_km": 6900.0 * 0.96 - 6378.137, "apogee_height_km": 6900.0 * 1.04 - 6378.137},
        {"sma_km": 6900.0, "perigee_height_km": 6900.0 * 0.96 - 6378.137},
        {"sma_km": 6900.0, "apogee_height_km": 6900.0 * 1.04 - 6378.137},
        {"ecc": 0.04, "perigee_height_km": 6900.0 * 0.96 - 6378.137},
        {"ecc": 0.04, "apogee_height_km": 6900.0 * 1.04 - 6378.137},
        {"c3_km2_s2": -EARTH.mu_m3_s2 / 6900e3 / 1e6, "ecc": 0.04},
    ],
)
def test_two_numbers_of_the_shape_name_the_same_orbit(shape: dict[str, float]) -> None:
    x = scenario({**shape, **ANGLES, "true_anomaly_deg": 33.0}).target.vector()
    found = elements_from_state(x[:3], x[3:])
    assert found.sma_m == pytest.approx(6900e3, rel=1e-12)
    assert found.ecc == pytest.approx(0.04, rel=1e-10)
    assert np.rad2deg(
        [found.inc_rad, found.raan_rad, found.argp_rad, found.true_anomaly_rad]
    ) == pytest.approx([*ANGLES.values(), 33.0])


def test_elements_plan_as_the_state_on_the_orbit_does() -> None:
    by_elements = scenario({"sma_km": 6900.0, "ecc": 0.04, **ANGLES})
    x = by_elements.target.vector()
    by_state = scenario({"position_m": x[:3].tolist(), "velocity_m_s": x[3:].tolist()})
    found = plan(by_elements)
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == plan(by_state).time_of_flight_s


def test_elements_are_eci_beside_launch_inertial_states() -> None:
    site = {"geocentric_latitude_deg": 19.6, "azimuth_deg": 105.0, "inertial_longitude_deg": 111.0}
    given = scenario({"sma_km": 6900.0, "ecc": 0.04, **ANGLES}, launch_site=site)
    launch = given.launch_inertial(given.initial)
    turned = scenario(
        {"sma_km": 6900.0, "ecc": 0.04, **ANGLES},
        launch_site=site, axes="launch_inertial",
        initial={"position_m": launch[:3].tolist(), "velocity_m_s": launch[3:].tolist()},
    )  # fmt: skip
    np.testing.assert_allclose(
        turned.launch_inertial(turned.target), given.launch_inertial(given.target), rtol=1e-12
    )


def test_a_hyperbola_is_asked_for_and_told_by_c3_and_v_infinity() -> None:
    strong = VEHICLE | {"thrust_n": 100000.0, "mass_flow_kg_s": 25.0, "dry_mass_kg": 500.0}
    shape = {"v_infinity_m_s": 1000.0, "perigee_height_km": 260.0}
    angles = ANGLES | {"inc_deg": float(np.rad2deg(0.9)), "argp_deg": float(np.rad2deg(0.6))}
    found = plan(scenario({**shape, **angles}, vehicle=strong, burn={"duration_s": 120.0}))
    assert found.status is PlanStatus.VERIFIED
    assert "a hyperbola of C3 1.0000 km²/s² (v∞ 1000.0 m/s), perigee 260.00 km" in details(found)
    orbit = found.to_dict()["orbit"]
    assert orbit["apogee_height_km"] is None
    assert orbit["c3_km2_s2"] == pytest.approx(1.0, rel=1e-6)
    assert orbit["v_infinity_m_s"] == pytest.approx(1000.0, rel=1e-6)


@pytest.mark.parametrize(
    ("target", "complaint"),
    [
        ({"sma_km": 6900.0, "ecc": 0.04}, r"target\.inc_deg: is missing"),
        ({"sma_km": 6900.0, **ANGLES}, r"target = sma_km: must be two of sma_km, ecc"),
        ({"sma_km": 6900.0, "c3_km2_s2": 3.0, **ANGLES}, r"only one of those that give the energy"),
        ({"position_m": [7e6, 0.0, 0.0], **ANGLES}, r"target\.inc_deg = .*: there is a state already"),
        ({"position_m": [7e6, 0.0, 0.0]}, r"target\.velocity_m_s.*is missing"),
        ({"c3_km2_s2": 0.0, "ecc": 1.0, **ANGLES}, r"target\.c3_km2_s2 = 0: a parabola"),
        ({"sma_km": 6900.0, "ecc": 1.5, **ANGLES}, r"name no orbit"),
    ],
)  # fmt: skip
def test_a_target_that_names_no_orbit_or_two_is_refused_by_key(
    target: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(ScenarioError, match=complaint):
        scenario(target)


def test_a_specific_impulse_is_a_mass_flow_and_both_are_refused() -> None:
    target = {"sma_km": 6900.0, "ecc": 0.04, **ANGLES}
    engine = {"mass_kg": 5000.0, "dry_mass_kg": 1000.0, "thrust_n": 30000.0}
    assert scenario(target, vehicle=engine | {"isp_s": 320.0}).vehicle.mass_flow_kg_s == pytest.approx(
        30000.0 / (320.0 * 9.80665), rel=1e-15
    )
    with pytest.raises(ScenarioError, match=r"vehicle\.isp_s = 320\.0: .*one of the two"):
        scenario(target, vehicle=VEHICLE | {"isp_s": 320.0})
    with pytest.raises(ScenarioError, match=r"vehicle\.mass_flow_kg_s.*or give vehicle\.isp_s"):
        scenario(target, vehicle=engine)
    with pytest.raises(ScenarioError, match=r"vehicle\.thrust_n"):
        scenario(target).with_changes(vehicle={"thrust_n": -5.0})


def test_a_launch_site_is_needed_for_launch_axes_alone() -> None:
    target = {"sma_km": 6900.0, "ecc": 0.04, **ANGLES}
    with pytest.raises(ScenarioError, match=r"launch_site.*is missing"):
        scenario(target, axes="launch_inertial")
    found = plan(scenario(target))
    assert found.tables()["attitude.csv"].startswith("t_s,ux_eci,uy_eci,uz_eci,mass_kg,rate_deg_s\n")
    assert found.to_dict()["trajectory"]["axes"] == "eci"


def test_attitude_about_the_velocity_is_the_same_direction() -> None:
    target = {"sma_km": 6900.0, "ecc": 0.04, **ANGLES}
    inertial, about = (plan(scenario(target, axes=axes)) for axes in ("eci", "velocity"))
    header, *lines = about.tables()["attitude.csv"].splitlines()
    assert header.split(",")[1:3] == ["pitch_velocity_deg", "yaw_velocity_deg"]
    rows = np.array([[float(x) for x in line.split(",")] for line in lines])
    assert rows[-1, 6] == pytest.approx(5000.0 - about.to_dict()["propellant_kg"])
    state = inertial.verification.flight.propagated[0]  # type: ignore[union-attr]
    along = state[3:] / np.linalg.norm(state[3:])
    normal = np.cross(state[:3], state[3:])
    normal /= np.linalg.norm(normal)
    u = inertial.verification.flight.direction[0]  # type: ignore[union-attr]
    assert rows[0, 3:6] == pytest.approx([u @ along, u @ np.cross(along, normal), u @ normal], abs=1e-9)
    assert np.cross(along, normal) @ state[:3] > 0.0
