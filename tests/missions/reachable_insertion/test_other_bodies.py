"""An insertion about the Moon: flown by SciPy's DOP853 with the pull and the thrust that are written here."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.reachable_insertion import Scenario, plan

MU, RADIUS = 4.902800118e12, 1.738e6
EXHAUST_M_S = 310.0 * 9.80665
THRUST_N, MASS_KG = 2000.0, 1200.0


def scenario(**tables: Any) -> Scenario:
    """From a hyperbola of 800 m/s, a little before its lowest point 100 km above the Moon, into 100 × 5000 km."""
    document = {
        "mission": "reachable_insertion", "name": "lunar", "problem": "min_time", "axes": "eci",
        "body": {"name": "moon"}, "vehicle": {"mass_kg": MASS_KG, "thrust_n": THRUST_N, "isp_s": 310.0},
        "initial": {
            "perigee_height_km": 100.0, "v_infinity_m_s": 800.0, "inc_deg": 85.0, "raan_deg": 40.0, "argp_deg": 10.0,
            "true_anomaly_deg": -12.0,
        },
        "target": {
            "perigee_height_km": 100.0, "apogee_height_km": 5000.0, "inc_deg": 85.0, "raan_deg": 40.0,
            "free": ["argp_deg"],
        },
        **tables,
    }  # fmt: skip
    return checked(Scenario, document, source="lunar")


def initial_state() -> NDArray[Any]:
    """Vis-viva and the conic in its own plane, turned by three angles."""
    sma = -MU / 800.0**2
    ecc = 1.0 - (RADIUS + 100e3) / sma
    p, nu = sma * (1.0 - ecc**2), np.deg2rad(-12.0)
    place = p / (1.0 + ecc * np.cos(nu)) * np.array([np.cos(nu), np.sin(nu), 0.0])
    speed = np.sqrt(MU / p) * np.array([-np.sin(nu), ecc + np.cos(nu), 0.0])
    node, tilt, apsis = np.deg2rad([40.0, 85.0, 10.0])

    def about_z(angle: float) -> NDArray[Any]:
        return np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])

    lean = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    turn = about_z(node) @ lean @ about_z(apsis)
    return np.concatenate([turn @ place, turn @ speed])


def test_burn_into_a_lunar_orbit_ends_on_it() -> None:
    found = plan(scenario())
    assert found.status is PlanStatus.VERIFIED, found.verdict
    lines = found.tables()["attitude.csv"].splitlines()
    names = lines[0].split(",")
    rows = np.array([[float(each) for each in line.split(",")] for line in lines[1:]])
    columns = [names.index(name) for name in ("ux_eci", "uy_eci", "uz_eci")]
    direction = CubicSpline(rows[:, names.index("t_s")], rows[:, columns])

    def rate(t: float, y: NDArray[Any]) -> NDArray[Any]:
        u = direction(t)
        thrust = THRUST_N / (MASS_KG - THRUST_N / EXHAUST_M_S * t) * u / np.linalg.norm(u)
        return np.concatenate([y[3:], -MU * y[:3] / np.linalg.norm(y[:3]) ** 3 + thrust])

    burn_s = found.time_of_flight_s
    end = solve_ivp(rate, (0.0, burn_s), initial_state(), method="DOP853", rtol=1e-12, atol=1e-6).y[:, -1]
    r, v = end[:3], end[3:]
    sma = 1.0 / (2.0 / np.linalg.norm(r) - v @ v / MU)
    ecc = np.linalg.norm(np.cross(v, np.cross(r, v)) / MU - r / np.linalg.norm(r))
    normal = np.cross(r, v) / np.linalg.norm(np.cross(r, v))
    assert sma * (1.0 - ecc) == pytest.approx(RADIUS + 100e3, abs=10.0)
    assert sma * (1.0 + ecc) == pytest.approx(RADIUS + 5000e3, abs=50.0)
    assert np.rad2deg(np.arccos(normal[2])) == pytest.approx(85.0, abs=1e-4)
    assert "100.00 × 5000.00 km" in str(found.verdict)
    low = np.linalg.norm(initial_state()[:3])
    impulse = np.sqrt(MU * 2.0 / low + 800.0**2) - np.sqrt(MU * (2.0 / low - 2.0 / (2 * RADIUS + 5100e3)))
    spent = -EXHAUST_M_S * np.log1p(-THRUST_N / EXHAUST_M_S * burn_s / MASS_KG)
    assert 0.97 * impulse < spent < 1.05 * impulse


def test_messages_and_document_name_the_moon(tmp_path: Any) -> None:
    found = plan(scenario())
    assert "CENTER_NAME = MOON" in found.tables()["orbit.oem"]
    document = found.to_dict()
    assert document["constants"]["name"] == "moon"
    assert document["orbit"]["perigee_height_km"] == pytest.approx(100.0, abs=1e-3)
    assert [each.name for each in found.figures(tmp_path)][:2] == ["space.png", "orbit.png"]


def test_a_free_ignition_and_two_burns_about_mars_are_flown_about_mars() -> None:
    mars = {"name": "mars"}
    orbit = {
        "sma_km": 3796.0,
        "ecc": 0.0,
        "inc_deg": 40.0,
        "raan_deg": 0.0,
        "argp_deg": 0.0,
        "true_anomaly_deg": 0.0,
    }
    goal = {"sma_km": 4396.0, "ecc": 0.0, "inc_deg": 40.0, "raan_deg": 0.0, "argp_deg": 0.0}
    found = plan(
        scenario(body=mars, initial=orbit, target=goal, burn={"count": 2, "ignition": "free"}, name="mars")
    )
    assert found.status is PlanStatus.VERIFIED, found.verdict
    mu, low, high = 4.2828375e13, 3796e3, 4396e3
    middle = 0.5 * (low + high)
    hohmann = np.sqrt(mu * (2 / low - 1 / middle)) - np.sqrt(mu / low)
    hohmann += np.sqrt(mu / high) - np.sqrt(mu * (2 / high - 1 / middle))
    assert hohmann <= found.delta_v_m_s <= 1.01 * hohmann


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"initial": {"frame": "EME2000", "sma_km": 1900.0, "ecc": 0.0, "inc_deg": 1.0, "raan_deg": 0.0, "argp_deg": 0.0,
                      "true_anomaly_deg": 0.0}}, "initial.frame"),
        ({"initial": {"sma_km": 1700.0, "ecc": 0.0, "inc_deg": 1.0, "raan_deg": 0.0, "argp_deg": 0.0,
                      "true_anomaly_deg": 0.0}}, "must be at least 1738.000"),
        ({"launch_site": {"preset": "kourou", "azimuth_deg": 90.0}}, "launch_site: is the Earth's"),
    ],
)  # fmt: skip
def test_what_belongs_to_the_earth_is_refused_about_the_moon(tables: dict[str, Any], said: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        scenario(**tables)
    assert said in str(refused.value)
