"""An insertion from elements with a date: its burn, and its messages as an independent reader has them."""

from __future__ import annotations

import warnings
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from orbsoc.missions.reachable_insertion import Plan, load_scenario, plan
from orbsoc.orbit import EARTH, elements_from_state

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"
OREKIT_S = 3653.99
"""Of Orekit's burn along one direction, which ends on the target."""


@cache
def apogee_burn() -> Plan:
    found = plan(load_scenario(SCENARIOS / "orekit_apogee.toml"))
    assert isinstance(found, Plan)
    return found


def test_the_apogee_burn_from_elements_takes_as_long_as_orekits() -> None:
    found = apogee_burn()
    assert found.status.value == "verified"
    assert found.time_of_flight_s == pytest.approx(OREKIT_S, abs=0.01)
    assert found.ignition_s == pytest.approx(17134.08, abs=60.0)
    assert [each.split(" = ")[0] for each in found.to_dict()["assumptions"]] == ["burn.duration_s"]


def test_its_ephemeris_read_by_another_program_has_date_frame_and_the_target_orbit(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        reader = pytest.importorskip("oem", reason="the independent reader is not installed")
        (tmp_path / "orbit.oem").write_text(apogee_burn().tables()["orbit.oem"])
        segment = reader.OrbitEphemerisMessage.open(tmp_path / "orbit.oem").segments[0]
    assert segment.metadata["REF_FRAME"] == "EME2000"
    assert segment.metadata["CENTER_NAME"] == "EARTH"
    assert segment.metadata["START_TIME"].isot[:19] == "2004-01-01T23:30:00"
    last = list(segment.states)[-1]
    orbit = elements_from_state(1e3 * np.asarray(last.position), 1e3 * np.asarray(last.velocity))
    assert orbit.sma_m == pytest.approx(28970066.4358, abs=1.0)
    assert np.rad2deg(orbit.inc_rad) == pytest.approx(2.6871769, abs=1e-6)


def test_its_manoeuvre_read_by_another_program_is_the_burn(tmp_path: Path) -> None:
    """The velocity of the message, flown as one direction for its duration, comes within 0.3 % of the target's size."""
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io", reason="the independent reader is not installed").NdmIo
    found = apogee_burn()
    (tmp_path / "orbit.opm").write_text(found.tables()["orbit.opm"])
    message = ndm_io().from_path(tmp_path / "orbit.opm").body.segment
    assert message.metadata.ref_frame == "EME2000"
    [burn] = message.data.maneuver_parameters
    assert float(burn.man_duration.value) == pytest.approx(found.time_of_flight_s, rel=1e-12)
    assert float(burn.man_delta_mass.value) == pytest.approx(-found.propellant_kg, rel=1e-12)
    dv = 1e3 * np.array([float(getattr(burn, f"man_dv_{k}").value) for k in (1, 2, 3)])
    vehicle = found.scenario.vehicle
    exhaust = vehicle.thrust_n / vehicle.mass_flow_kg_s
    ideal = exhaust * np.log(vehicle.mass_kg / (vehicle.mass_kg - found.propellant_kg))
    assert np.linalg.norm(dv) == pytest.approx(ideal, rel=1e-4)  # the direction hardly turns
    assert found.verification is not None
    start = found.verification.flight.propagated[0]

    def pull(t: float, x: np.ndarray) -> np.ndarray:
        r = x[:3]
        mass = vehicle.mass_kg - vehicle.mass_flow_kg_s * t
        thrust = vehicle.thrust_n / mass * dv / np.linalg.norm(dv)
        return np.concatenate([x[3:], -EARTH.mu_m3_s2 * r / np.linalg.norm(r) ** 3 + thrust])

    end = solve_ivp(pull, (0.0, found.time_of_flight_s), start, rtol=1e-10, atol=1e-6).y[:, -1]
    assert elements_from_state(end[:3], end[3:]).sma_m == pytest.approx(28970066.4358, rel=3e-3)


def test_a_scenario_without_a_date_names_no_registered_frame() -> None:
    found = plan(load_scenario(SCENARIOS / "rec1.toml"))
    text = found.tables()["orbit.oem"]
    assert "REF_FRAME = SCENARIO_ECI" in text
    assert "the scenario gives no date" in text
