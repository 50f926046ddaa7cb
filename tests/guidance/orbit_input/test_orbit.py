"""One orbit table: every form names the same orbit, and what names none or two is refused in one line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.ccsds import Subject, oem
from orbsoc.guidance.orbit_input import Orbit, vehicle_complaints
from orbsoc.guidance.orbit_input.catalogue import from_omm, from_tle, parse_utc
from orbsoc.guidance.scenario_file import ScenarioError, Table, checked, read_toml
from orbsoc.orbit import EARTH, Elements, propagate_burn, state_from_elements
from orbsoc.orbit.anomalies import mean_from_true
from orbsoc.orbit.propagate import Thruster
from orbsoc.orbit.reference_frames import frame_rotation

ISS = (
    "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
)
OMM = """CCSDS_OMM_VERS = 2.0
OBJECT_NAME = ISS
EPOCH = 2008-09-20T12:25:40.104192
MEAN_MOTION = 15.72125391 [rev/day]
ECCENTRICITY = 0.0006703
INCLINATION = 51.6416
RA_OF_ASC_NODE = 247.4627
ARG_OF_PERICENTER = 130.5360
MEAN_ANOMALY = 325.0288
BSTAR = -0.000011606
MEAN_MOTION_DOT = -0.00002182
MEAN_MOTION_DDOT = 0.0
"""
PLACE = Elements(7.2e6, 0.03, 0.9, 0.4, 0.3, 0.7)
ANGLES = {key: float(np.rad2deg(v)) for key, v in (("inc_deg", 0.9), ("raan_deg", 0.4), ("argp_deg", 0.3))}
STATE = np.concatenate(state_from_elements(PLACE))


class Holder(Table):
    initial: Orbit


def table(**keys: Any) -> Orbit:
    return checked(Holder, {"initial": keys}, source="t").initial


def message(**keys: Any) -> str:
    with pytest.raises(ScenarioError) as refused:
        table(**keys)
    return str(refused.value)


def complaint(**keys: Any) -> str:
    return str(next(vehicle_complaints("initial", table(**keys))))


@pytest.mark.parametrize(
    "shape",
    [
        {"sma_km": 7200.0, "ecc": 0.03},
        {"perigee_height_km": 7200.0 * 0.97 - 6378.137, "apogee_height_km": 7200.0 * 1.03 - 6378.137},
        {"mean_motion_rad_s": float(np.sqrt(EARTH.mu_m3_s2 / 7.2e6**3)), "ecc": 0.03},
        {"period_s": PLACE.period_s(), "perigee_height_km": 7200.0 * 0.97 - 6378.137},
    ],
)
@pytest.mark.parametrize(
    "anomaly",
    [
        {"true_anomaly_deg": float(np.rad2deg(0.7))},
        {"mean_anomaly_deg": float(np.rad2deg(mean_from_true(0.7, 0.03)))},
        {"eccentric_anomaly_deg": float(np.rad2deg(2.0 * np.arctan(np.sqrt(0.97 / 1.03) * np.tan(0.35))))},
        {"latitude_argument_deg": float(np.rad2deg(1.0))},
    ],
)
def test_any_two_of_the_shape_and_any_anomaly_name_the_same_state(
    shape: dict[str, float], anomaly: dict[str, float]
) -> None:
    orbit = table(**shape, **ANGLES, **anomaly)
    assert not list(vehicle_complaints("initial", orbit))
    assert orbit.vector() == pytest.approx(STATE, rel=1e-12)


def test_a_tle_gives_the_state_of_sgp4_at_its_epoch_in_the_frame_asked_for() -> None:
    found = from_tle(ISS)
    assert found.epoch.isoformat()[:22] == "2008-09-20T12:25:40.10"
    # the state that the package's own documentation prints for this epoch, by the same constants
    from sgp4.api import Satrec

    satellite = Satrec.twoline2rv(*ISS)
    _, position, velocity = satellite.sgp4(satellite.jdsatepoch, satellite.jdsatepochF)
    assert found.vector == pytest.approx(1e3 * np.array([*position, *velocity]), rel=1e-15)
    orbit = table(tle=list(ISS))
    assert (orbit.axes_name, orbit.tle, orbit.source) == ("EME2000", None, "a TLE, by SGP4")
    turn = frame_rotation("TEME", found.epoch, "EME2000")
    assert orbit.vector()[:3] == pytest.approx(turn @ found.vector[:3], abs=1e-6)
    assert table(tle=ISS, frame="TEME").vector() == pytest.approx(found.vector, rel=1e-15)
    assert orbit.vector_in("TEME", found.epoch) == pytest.approx(found.vector, rel=1e-14)
    assert 6.7e6 < np.linalg.norm(orbit.vector()[:3]) < 6.75e6


def test_an_omm_is_the_tle_that_it_says(tmp_path: Path) -> None:
    (tmp_path / "iss.omm").write_text(OMM)
    (tmp_path / "s.toml").write_text('[initial]\nomm = "iss.omm"\n')
    orbit = checked(Holder, read_toml(tmp_path / "s.toml"), source="t").initial
    tle = from_tle(ISS)
    assert from_omm(tmp_path / "iss.omm").vector == pytest.approx(tle.vector, rel=1e-6)
    assert abs((orbit.epoch or tle.epoch) - tle.epoch).total_seconds() < 1e-3


def test_an_ephemeris_is_interpolated_inside_its_span_and_refused_outside(tmp_path: Path) -> None:
    start = parse_utc("2026-03-01T00:00:00")
    coast = Thruster(mass_kg=1.0, thrust_n=0.0, mass_flow_kg_s=0.0)
    times = np.arange(0.0, 5000.0, 100.0)
    flown = propagate_burn(STATE, coast, lambda _t, x: x[3:], times)
    there = propagate_burn(STATE, coast, lambda _t, x: x[3:], [2537.25])[0]
    text = oem(Subject("a", "", "", start), times, flown, comment="a coast")
    (tmp_path / "a.oem").write_text(text.replace("SCENARIO_ECI", "EME2000"))
    path = str(tmp_path / "a.oem")
    found = table(oem=path, epoch_utc="2026-03-01T00:42:17.250")
    assert np.linalg.norm(found.vector()[:3] - there[:3]) < 1e-3
    assert np.linalg.norm(found.vector()[3:] - there[3:]) < 1e-6
    assert table(oem=path, epoch_utc="2026-03-01T00:01:40").vector() == pytest.approx(flown[1], abs=1e-5)
    late = message(oem=path, epoch_utc="2026-03-02T00:00:00")
    assert "spans 2026-03-01T00:00:00.000000 to 2026-03-01T01:21:40.000000" in late
    assert message(oem=path).startswith("t: initial.epoch_utc = nothing: is missing")
    (tmp_path / "b.oem").write_text(text)
    assert "REF_FRAME = SCENARIO_ECI: must be one of" in message(
        oem=str(tmp_path / "b.oem"), epoch_utc="2026-03-01T00:01:40"
    )


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        (
            {"tle": [ISS[0], ISS[1][:-1] + "0"]},
            "initial.tle = two lines: cannot be read: line 2 ends with 0, but",
        ),
        ({"tle": [ISS[1], ISS[0]]}, "line 1 must have 69 characters and begin with 1"),
        ({"tle": ISS, "sma_km": 7000.0}, "initial.sma_km = 7000.0: tle gives the orbit already"),
        ({"tle": ISS, "epoch_utc": "2026-01-01"}, "tle has an epoch of its own"),
        ({"epoch_utc": "yesterday"}, "initial.epoch_utc = 'yesterday': must be a date and time"),
        ({"omm": "no-such-file.omm"}, "initial.omm = 'no-such-file.omm': cannot be read"),
        ({"frame": "ITRF"}, "initial.frame = 'ITRF': Input should be 'EME2000', 'GCRF' or 'TEME'"),
    ],
)
def test_what_cannot_be_read_is_refused_by_name(keys: dict[str, Any], expected: str) -> None:
    assert expected in message(**keys)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({}, "initial: is missing what names an orbit; must be position_m and velocity_m_s, or elements, or tle"),
        ({"position_m": [7e6, 0.0, 0.0]}, "initial.velocity_m_s: is missing"),
        ({"sma_km": 7000.0, **ANGLES, "true_anomaly_deg": 0.0}, "initial = sma_km: must be two of"),
        ({"sma_km": 7000.0, "ecc": 0.1, **ANGLES}, "initial = no anomaly: must be one of true_anomaly_deg"),
        ({"sma_km": 7000.0, "period_s": 6e3, **ANGLES, "true_anomaly_deg": 0.0}, "only one of those that give"),
        ({"sma_km": 6500.0, "ecc": 0.1, **ANGLES, "true_anomaly_deg": 0.0}, "lies below the ground"),
        ({"position_m": STATE[:3].tolist(), "velocity_m_s": STATE[3:].tolist(), "frame": "TEME"},
         "initial.epoch_utc: is missing; frame = 'TEME'"),
    ],
)  # fmt: skip
def test_what_names_no_orbit_or_two_is_refused(keys: dict[str, Any], expected: str) -> None:
    assert expected in complaint(**keys)
