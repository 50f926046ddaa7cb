"""Targets of the relative missions by any form of the orbit table, and starts in named axes or on the chaser's own orbit."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.orbit_input.beside import circle_words
from orbsoc.guidance.orbit_input.catalogue import from_tle
from orbsoc.guidance.scenario_file import ScenarioError, checked, merged
from orbsoc.missions import fly_around, passive_safety, platform_launch
from orbsoc.missions.fly_around.verification import target_state
from orbsoc.missions.platform_launch.paper import is_papers
from orbsoc.orbit import Elements, elements_from_state, state_from_elements
from orbsoc.orbit.perturbations import PointMass, coast
from orbsoc.orbit.relative import LVLH, absolute_state

SCENARIOS = Path(__file__).parents[3] / "scenarios"
TLE = (
    "1 25544U 98067A   08264.51782528 -.00002182  00000-0 -11606-4 0  2927",
    "2 25544  51.6416 247.4627 0006703 130.5360 325.0288 15.72125391563537",
)
CIRCLE = {
    "sma_km": 6878.137, "ecc": 0.0, "inc_deg": 30.0, "raan_deg": 10.0, "latitude_argument_deg": 50.0,
}  # fmt: skip
FILES = {
    "fly_around": "paper001_fewest",
    "passive_safety": "paper000_1",
    "platform_launch": "paper002_norms",
}
MODELS = {
    "fly_around": fly_around.Scenario,
    "passive_safety": passive_safety.Scenario,
    "platform_launch": platform_launch.Scenario,
}


def read(mission: str, **tables: Any) -> Any:
    document = tomllib.loads((SCENARIOS / f"{FILES[mission]}.toml").read_text())
    document.pop("compare_with", None)
    if mission == "platform_launch" and "target" in tables:
        document["orbit"] = {"semi_minor_m": 500.0}
    return checked(MODELS[mission], {**document, **tables}, source="t")


def target(mission: str, found: Any) -> np.ndarray:
    if mission == "fly_around":
        return target_state(found)
    if mission == "platform_launch":
        return np.asarray(found.target_state())
    return np.concatenate(state_from_elements(found.target.elements))


@pytest.mark.parametrize("mission", MODELS)
def test_a_target_by_elements_or_by_its_state_is_one_target(mission: str) -> None:
    by_elements = target(mission, read(mission, target=CIRCLE))
    table = {"position_m": tuple(by_elements[:3].tolist()), "velocity_m_s": tuple(by_elements[3:].tolist())}
    by_state = read(mission, target=table)
    assert target(mission, by_state) == pytest.approx(by_elements, rel=1e-9, abs=1e-3)
    assert elements_from_state(by_elements[:3], by_elements[3:]).raan_rad == pytest.approx(np.deg2rad(10.0))
    assert MODELS[mission].model_validate_json(by_state.model_dump_json()) == by_state


@pytest.mark.parametrize("mission", MODELS)
def test_a_target_by_a_tle_keeps_its_date_and_its_energy(mission: str) -> None:
    extra = {"safety": "samples"} if mission == "passive_safety" else {}
    found = read(mission, target={"tle": TLE}, **extra)
    dated = found.orbit if mission == "platform_launch" else found.target
    assert (dated.epoch_utc, dated.frame) == (from_tle(TLE).epoch.isoformat(), "TEME")
    vector, state = from_tle(TLE).vector, target(mission, found)
    expected = elements_from_state(vector[:3], vector[3:])
    got = elements_from_state(state[:3], state[3:])
    assert got.sma_m == pytest.approx(expected.sma_m, rel=1e-9)
    assert got.raan_rad == pytest.approx(expected.raan_rad, abs=1e-9)
    if mission == "passive_safety":
        assert state == pytest.approx(vector, rel=1e-8, abs=1e-2)


def test_a_start_in_named_axes_is_the_start_in_the_papers() -> None:
    paper = read(
        "passive_safety", condition="none", start={"x_m": -1000.0, "y_m": 3.0, "z_m": 20.0, "vy_m_s": 0.1}
    )
    place, speed = (-20.0, -1000.0, -3.0), (0.0, 0.0, -0.1)
    rtn = read(
        "passive_safety", condition="none", start={"frame": "RTN", "position_m": place, "velocity_m_s": speed}
    )
    lvlh = {"frame": "LVLH", "position_m": (-1000.0, 3.0, 20.0), "velocity_m_s": (0.0, 0.1, 0.0)}
    assert rtn.start.state() == pytest.approx(paper.start.state())
    assert read("passive_safety", condition="none", start=lvlh).start.state() == pytest.approx(
        paper.start.state()
    )


def test_a_start_on_the_chasers_own_orbit_is_its_state_beside_the_target() -> None:
    own = read("passive_safety", target=CIRCLE)
    beside = np.array([-30.0, -900.0, 5.0, 0.01, -0.02, 0.03])
    chaser = absolute_state(target("passive_safety", own), beside)
    table = {"position_m": tuple(chaser[:3].tolist()), "velocity_m_s": tuple(chaser[3:].tolist())}
    found = read("passive_safety", target=CIRCLE, condition="none", start=table)
    assert found.start.state() == pytest.approx(beside, abs=1e-5)


def test_a_fly_around_starts_where_named_axes_say() -> None:
    usual = read("fly_around").start_state
    table = {"frame": "LVLH", "position_m": tuple((LVLH @ usual[:3]).tolist())}
    assert read("fly_around", start=table).start_state == pytest.approx(usual, abs=1e-9)


@pytest.mark.parametrize(
    ("mission", "tables", "says"),
    [
        ("fly_around", {"target": {**CIRCLE, "ecc": 0.1, "argp_deg": 0.0}}, "target = e = 0.1: .* at most 0.002"),
        ("fly_around", {"target": {"altitude_km": 500.0, "epoch_utc": "2026-01-01T00:00:00Z"}}, "target.frame"),
        ("fly_around", {"target": {"altitude_km": 500.0, "frame": "TEME"}}, "target.epoch_utc = nothing: is missing"),
        ("fly_around", {"target": {**CIRCLE, "frame": "TOD"}}, "target.frame = 'TOD': .*EME2000.*TEME"),
        ("fly_around", {"target": {**CIRCLE, "frame": "TEME"}}, "target.epoch_utc"),
        ("fly_around", {"target": {**CIRCLE, "epoch_utc": "2026-13-01"}}, "target.epoch_utc = '2026-13-01': must be a date"),
        ("fly_around", {"target": {"oem": "none.oem"}}, "target.epoch_utc = nothing: is missing, and oem needs"),
        ("fly_around", {"target": {"sma_km": 7000.0}}, "target = sma_km: must be two of"),
        ("fly_around", {"start": {"frame": "RTN"}}, "start.position_m"),
        ("passive_safety", {"start": {"frame": "RSW", "position_m": (1.0, 2.0, 3.0)}}, "start.frame = 'RSW'"),
        ("passive_safety", {"start": {**CIRCLE, "epoch_utc": "2026-01-01T00:00:00Z"}}, "start.epoch_utc = .*target's date, none"),
        ("passive_safety", {"target": {"sma_km": -9000.0, "ecc": 2.0, "inc_deg": 1.0, "raan_deg": 0.0,
                                       "argp_deg": 0.0, "true_anomaly_deg": 0.0}}, "e = 2: .*must be e < 1"),
        ("platform_launch", {"target": CIRCLE, "orbit": {"semi_minor_m": 500.0, "altitude_km": 400.0}},
         "orbit.altitude_km = 400.0: .*one of the two"),
        ("platform_launch", {"target": CIRCLE, "orbit": {"semi_minor_m": 500.0, "constants": "paper"}},
         "orbit.constants = 'paper': .*must be 'wgs84'"),
    ],
)  # fmt: skip
def test_a_false_form_is_one_line_with_key_value_and_what_is_allowed(
    mission: str, tables: dict[str, Any], says: str
) -> None:
    with pytest.raises(ScenarioError, match=says) as found:
        read(mission, **tables)
    assert len(found.value.complaints) == 1
    assert "\n" not in str(found.value)


def test_an_approach_about_a_dated_target_places_its_chaser_in_a_registered_frame() -> None:
    found = passive_safety.plan(read("passive_safety", target={"tle": TLE, "motion": "circular"}))
    text = found.tables()["chaser.opm"]
    assert "REF_FRAME = EME2000" in text
    assert f"EPOCH = {from_tle(TLE).epoch:%Y-%m-%dT%H:%M:%S.%f}" in text


def test_old_keys_alone_are_read_as_they_stand() -> None:
    for mission in MODELS:
        assert read(mission) == checked(MODELS[mission], merged(read(mission).model_dump(), {}), source="t")


def test_a_papers_launch_is_still_known_as_the_papers() -> None:
    document = tomllib.loads((SCENARIOS / "paper002.toml").read_text())
    ours = checked(platform_launch.Scenario, document, source="t")
    assert is_papers(ours)
    moved = checked(platform_launch.Scenario, merged(document, {"orbit": {"raan_deg": 1.0}}), source="t")
    assert not is_papers(moved)


def test_a_nearly_circular_target_leaves_its_circle_by_no_more_than_is_told() -> None:
    """The worst place to begin is a quarter of a revolution from the perigee: 4 a e, three quarters later."""
    sma, ecc = 6878137.0, 2e-3
    nearly = Elements(sma, ecc, 0.5, 0.2, 0.3, np.pi / 2)
    circle = Elements(sma, 0.0, 0.5, 0.2, 0.0, 0.3 + np.pi / 2)
    states = np.array([np.concatenate(state_from_elements(each)) for each in (nearly, circle)])
    flown = coast(states, np.linspace(0.0, 6000.0, 601), [PointMass()])[:, :, :3]
    farthest = float(np.linalg.norm(flown[:, 0] - flown[:, 1], axis=1).max())
    assert 0.99 * 4.0 * sma * ecc < farthest < 4.0 * sma * ecc
    [words] = circle_words((sma - 6378137.0) / 1e3, ecc)
    assert "4 a e = 55 km" in words
