"""Bad input: key, value, what is allowed."""

from __future__ import annotations

from typing import Any

import pytest

from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.passive_safety.dispersion import disperse
from orbsoc.missions.passive_safety.scenario import Scenario

GOOD: dict[str, Any] = {
    "mission": "passive_safety",
    "name": "good",
    "target": {"mean_motion_rad_s": 1e-3},
    "start": {"x_m": -1000.0},
    "capture": {"x_m": 0.0, "z_m": 60.0},
    "keep_out_m": 40.0,
    "duration_s": 3600.0,
    "condition": "short",
}
ERRORS = {"position_m": 0.5, "velocity_m_s": 1e-3}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"start": {"x_m": -30.0}}, "start.x_m = -30: 30 m from the target, inside keep_out_m = 40"),
        (
            {"capture": {"x_m": 0.0, "z_m": 20.0}},
            "capture.z_m = 20: the keep-out is a band along the V-bar: must be at least 40",
        ),
        ({"duration_s": 20000.0}, "duration_s = 20000: impulse 2 at 5000 s comes half an orbit or more"),
        ({"duration_s": -1.0}, "duration_s = -1.0: Input should be greater than 0"),
        ({"duration_s": float("nan")}, "duration_s = nan: Input should be a finite number"),
        ({"target": {}}, "target.mean_motion_rad_s: is missing; give it or target.altitude_km"),
        (
            {"target": {"mean_motion_rad_s": 1e-3, "altitude_km": 600.0}},
            "target.altitude_km = 600: target.mean_motion_rad_s is given too; give one of them",
        ),
        (
            {"target": {"mean_motion_rad_s": 0.5}},
            "mean_motion_rad_s = 0.5: Input should be less than or equal",
        ),
        (
            {"target": {"mean_motion_rad_s": 1e-3, "eccentricity": 0.01}},
            "safety = 'cone': for all time only about a circular target",
        ),
        (
            {"target": {"mean_motion_rad_s": 1e-3, "eccentricity": 0.2}, "safety": "samples"},
            "target.eccentricity = 0.2: the perigee is in the ground; must be below 0.13",
        ),
        (
            {"target": {"mean_motion_rad_s": 1e-3, "motion": "circular"}},
            "target.motion = 'circular': a circular",
        ),
        (
            {"target": {"mean_motion_rad_s": 1e-3, "true_anomaly_deg": 5.0}},
            "target.true_anomaly_deg = 5: a circ",
        ),
        (
            {"start": {"x_m": -1000.0, "vz_m_s": 0.1}},
            "start.vz_m_s = 0.1: condition = 'short' starts at rest",
        ),
        (
            {"start": {"x_m": -1000.0, "z_m": 5.0}},
            "start.z_m = 5: condition = 'short' starts at rest on the V-bar",
        ),
        ({"keep_out_m": 0.0}, "condition = 'short': without keep_out_m must be 'none'"),
        (
            {"impulses": {"timing": "free", "count": 2}, "capture": {"x_m": 0.0, "z_m": 60.0, "vz_m_s": 0.0}},
            "impulses.count = 2: one at the start, one whose time is free and one that matches the velocity",
        ),
        ({"interruption_orbits": 1}, "interruption_orbits = 1: two impulses cannot be made so"),
        (
            {"interruption_orbits": 1, "condition": "beyond", "impulses": {"timing": "generated"}},
            "interruption_orbits = 1: condition = 'beyond' cannot be made so; must be 0 unless it is 'short'",
        ),
        ({"interruption_orbits": 3}, "interruption_orbits = 3: Input should be 0, 1 or 2"),
        (
            {"impulses": {"timing": "generated", "count": 4}},
            "impulses.count = 4: timing = 'generated' takes as many",
        ),
        ({"samples": 36}, "samples = 36: safety = 'cone' takes no samples; leave it out"),
        (
            {"safety": "samples", "uncertainty": ERRORS},
            "safety = 'samples': with [uncertainty] must be 'cone'",
        ),
        ({"uncertainty": {**ERRORS, "sigmas": -1.0}}, "uncertainty.sigmas = -1.0: Input should be greater"),
        ({"keep_out": 40.0}, "keep_out = 40.0: unknown key; allowed here: body, capture, capture_box_m"),
        ({"start": {"x": -1000.0}}, "x = -1000.0: unknown key"),
        ({"compare_with": "row9"}, "compare_with = 'row9': String should match pattern"),
        ({"condition": "maybe"}, "condition = 'maybe': Input should be 'short', 'beyond' or 'none'"),
    ],
)
def test_what_is_wrong_is_named(change: dict[str, Any], says: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        checked(Scenario, GOOD | change, source="here")
    assert says in str(caught.value)


def test_axes_are_those_of_the_paper() -> None:
    scenario = checked(
        Scenario,
        GOOD | {"condition": "none", "start": {"x_m": 1.0, "y_m": 2.0, "z_m": 300.0, "vx_m_s": 4.0, "vy_m_s": 5.0, "vz_m_s": 6.0}},
        source="here",
    )  # fmt: skip
    assert scenario.start.state().tolist() == [-300.0, 1.0, -2.0, -6.0, 4.0, -5.0]
    assert scenario.capture.velocity() is None


def test_a_case_is_dispersed_and_is_no_row_of_the_paper() -> None:
    scenario = checked(Scenario, GOOD | {"compare_with": "row1"}, source="here")
    assert disperse(scenario, 0).start == scenario.start
    case = disperse(scenario, 3, seed=1)
    assert case.start.x_m != scenario.start.x_m
    assert case.compare_with is None
    assert case.name == "good-case-0003"
