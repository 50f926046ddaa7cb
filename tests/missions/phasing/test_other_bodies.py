"""A phasing about another body than the Earth: flown by SciPy's DOP853 with forces that are written here."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.phasing import Scenario, plan

MU, RADIUS, J2 = 4.2828375e13, 3.396e6, 1.9566e-3
MOON_MU, MOON_RADIUS = 4.902800118e12, 1.738e6


def scenario(body: dict[str, Any], radius_km: float, **other: Any) -> Scenario:
    """A chaser on a circle, its target 30 km higher, a little eccentric, 0.1° to the side and a third of an orbit ahead."""
    orbit = {"ecc": 1e-4, "inc_deg": 74.0, "raan_deg": 20.0, "argp_deg": 30.0, "epoch_s": 0.0}
    chaser = orbit | {"sma_km": radius_km, "true_anomaly_deg": 0.0}
    target = orbit | {"sma_km": radius_km + 30.0, "ecc": 2e-3, "raan_deg": 20.1, "true_anomaly_deg": 120.0}
    document = {
        "mission": "phasing", "name": "other", "body": body, "chaser": chaser, "target": target,
        "window": {"revolutions": 8, "latest_h": 30.0}, "limits": {"perigee_height_km": 50.0}, **other,
    }  # fmt: skip
    return checked(Scenario, document, source="other")


def state(sma: float, ecc: float, inc: float, raan: float, argp: float, nu: float, mu: float) -> NDArray[Any]:
    """From elements in m and degrees, by three turns."""
    inc, raan, argp, nu = np.deg2rad([inc, raan, argp, nu])

    def about(axis: int, angle: float) -> NDArray[Any]:
        i, j = [(1, 2), (2, 0), (0, 1)][axis]
        turn = np.eye(3)
        turn[i, i] = turn[j, j] = np.cos(angle)
        turn[i, j], turn[j, i] = -np.sin(angle), np.sin(angle)
        return turn

    p = sma * (1.0 - ecc**2)
    turn = about(2, raan) @ about(0, inc) @ about(2, argp)
    place = p / (1.0 + ecc * np.cos(nu)) * np.array([np.cos(nu), np.sin(nu), 0.0])
    speed = np.sqrt(mu / p) * np.array([-np.sin(nu), ecc + np.cos(nu), 0.0])
    return np.concatenate([turn @ place, turn @ speed])


def flown(
    start: NDArray[Any], span: tuple[float, float], figures: tuple[float, float, float]
) -> NDArray[Any]:
    mu, radius, j2 = figures

    def rate(_: float, y: NDArray[Any]) -> NDArray[Any]:
        r = np.linalg.norm(y[:3])
        share = 1.5 * j2 * (radius / r) ** 2
        z2 = 5.0 * (y[2] / r) ** 2
        pull = -mu / r**3 * y[:3] * (1.0 - share * (z2 - np.array([1.0, 1.0, 3.0])))
        return np.concatenate([y[3:], pull])

    return solve_ivp(rate, span, start, method="DOP853", rtol=1e-12, atol=1e-6).y[:, -1]


@pytest.mark.parametrize(
    ("body", "figures", "sma_km"),
    [
        pytest.param({"name": "mars"}, (MU, RADIUS, J2), 3796.0, id="Mars"),
        pytest.param(
            {"name": "own", "mu_m3_s2": MOON_MU, "radius_m": MOON_RADIUS}, (MOON_MU, MOON_RADIUS, 0.0), 1838.0,
            id="a round Moon by its own figures",
        ),
    ],
)  # fmt: skip
def test_impulses_about_another_body_lead_to_the_target(
    body: dict[str, Any], figures: tuple[float, float, float], sma_km: float
) -> None:
    found = plan(scenario(body, sma_km))
    assert found.status is PlanStatus.VERIFIED, found.message
    assert found.programme is not None
    end_s = float(found.programme.times_s[-1])
    chaser = state(1e3 * sma_km, 1e-4, 74.0, 20.0, 30.0, 0.0, figures[0])
    at = 0.0
    for t, dv in zip(found.programme.times_s, inertial(found), strict=True):
        if t > at:
            chaser = flown(chaser, (at, float(t)), figures)
        chaser[3:] += dv
        at = float(t)
    target = flown(
        state(1e3 * (sma_km + 30.0), 2e-3, 74.0, 20.1, 30.0, 120.0, figures[0]), (0.0, end_s), figures
    )
    assert np.linalg.norm(chaser[:3] - target[:3]) < 1.0
    assert np.linalg.norm(chaser[3:] - target[3:]) < 1e-2


def inertial(found: Any) -> NDArray[Any]:
    return np.asarray(found.verification.dv_m_s)


def test_document_and_messages_name_the_body() -> None:
    found = plan(scenario({"name": "mars"}, 3796.0))
    assert found.to_dict()["constants"]["mu_m3_s2"] == MU
    for name in ("chaser.oem", "chaser.opm"):
        assert "CENTER_NAME = MARS" in found.tables()[name]
    assert "GM = 42828.3750000" in found.tables()["chaser.opm"]


@pytest.mark.parametrize(
    ("body", "other", "said"),
    [
        (
            {"name": "mars"},
            {"forces": ["j2", "drag"]},
            "forces = ['j2', 'drag']: 'drag' is of the Earth's air",
        ),
        ({"name": "venus"}, {}, "body.name = 'venus'"),
        ({"name": "own", "radius_m": 1e6}, {}, "mu_m3_s2 is missing"),
        ({"name": "moon", "j2": 1e-4}, {}, "j2 changes nothing; name must be 'own'"),
        ({"name": "mars"}, {"limits": {"perigee_height_km": 5000.0}}, "limits.perigee_height_km"),
    ],
)
def test_a_body_that_contradicts_itself_is_refused_by_key(
    body: dict[str, Any], other: dict[str, Any], said: str
) -> None:
    with pytest.raises(ScenarioError) as refused:
        scenario(body, 3796.0, **other)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_an_orbit_below_the_ground_of_its_own_body_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"chaser\.ecc .* perigee is at -1\d\d\d\.\d km"):
        scenario({"name": "earth"}, 5000.0, limits={"perigee_height_km": 100.0})
