"""A phasing from two catalogue entries: one frame, one clock, the flown meeting, and what is refused in one line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.orbit_input.catalogue import from_tle
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.phasing import Scenario, plan
from orbsoc.orbit.reference_frames import frame_rotation

TARGET = (
    "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
)
CHASER = (
    "1 99999U 08999A   08264.60000000  .00000000  00000-0  00000-0 0  0010",
    "2 99999  51.6400 247.3000 0010000 100.0000 200.0000 15.90000000000019",
)


def read(**tables: Any) -> Scenario:
    document = {
        "mission": "phasing", "name": "t", "window": {"revolutions": 12, "latest_h": 24.0},
        "chaser": {"tle": CHASER}, "target": {"tle": TARGET}, **tables,
    }  # fmt: skip
    return checked(Scenario, document, source="t")


def test_two_tles_stand_in_one_frame_and_on_one_clock() -> None:
    found = read(target={"tle": TARGET, "ballistic_m2_kg": 0.005})
    chaser, target = from_tle(CHASER), from_tle(TARGET)
    assert found.chaser.state == pytest.approx(chaser.vector, rel=1e-9)
    turn = frame_rotation("TEME", target.epoch, "TEME", chaser.epoch)
    assert found.target.state[:3] == pytest.approx(turn @ target.vector[:3], abs=1e-2)
    assert found.chaser.epoch_s == 0.0
    assert found.target.epoch_s == (target.epoch - chaser.epoch).total_seconds()
    assert found.target.ballistic_m2_kg == 0.005
    assert Scenario.model_validate_json(found.model_dump_json()) == found


def test_a_plan_from_two_tles_meets_and_says_where_in_a_registered_frame() -> None:
    found = plan(read())
    assert found.status.value == "verified"
    text = found.tables()["chaser.opm"]
    assert "REF_FRAME = EME2000" in text
    assert "EPOCH = 2008-09-20T14:24:00.000000" in text
    x = float(text.split("\nX = ")[1].split()[0])
    turned = frame_rotation("TEME", from_tle(CHASER).epoch, "EME2000") @ from_tle(CHASER).vector[:3]
    assert 1e3 * x == pytest.approx(turned[0], abs=1e-2)


def test_a_state_is_the_elements_that_it_has() -> None:
    elements = {
        "sma_km": 6800.0, "ecc": 0.001, "inc_deg": 50.0, "raan_deg": 20.0, "argp_deg": 30.0, "true_anomaly_deg": 40.0,
        "epoch_s": 5.0,
    }  # fmt: skip
    by_elements = read(chaser=elements, target=elements)
    x = by_elements.chaser.state
    state = {"position_m": x[:3].tolist(), "velocity_m_s": x[3:].tolist(), "epoch_s": 5.0}
    by_state = read(chaser=state, target=elements)
    assert by_state.chaser.sma_km == pytest.approx(6800.0, rel=1e-12)
    assert np.abs(by_state.chaser.state - x).max() < 1e-6
    assert by_state.target == by_elements.target


@pytest.mark.parametrize(
    ("tables", "expected"),
    [
        (
            {"chaser": {"tle": [CHASER[0], CHASER[1][:-1] + "0"]}},
            "tle = two lines: cannot be read: line 2 ends with 0",
        ),
        ({"chaser": {"tle": CHASER, "epoch_s": 3.0}}, "chaser.epoch_s = 3.0: there is a date already"),
        (
            {
                "target": {
                    "sma_km": 6800.0,
                    "ecc": 0.0,
                    "inc_deg": 1.0,
                    "raan_deg": 0.0,
                    "true_anomaly_deg": 0.0,
                }
            },
            "target.epoch_utc = nothing: is missing; chaser has a date",
        ),
        ({"chaser": {"sma_km": 6800.0, "period_s": 5e3}}, "only one of those that give the energy"),
    ],
)
def test_what_names_no_pair_of_orbits_is_refused(tables: dict[str, Any], expected: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        read(**tables)
    assert expected in str(refused.value)
    assert "\n" not in str(refused.value)
