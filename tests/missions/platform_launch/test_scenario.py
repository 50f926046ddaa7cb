"""Bad input: key, value, what is allowed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions.platform_launch import disperse
from tests.missions.platform_launch.data import launched, paper

PERIOD_S = paper().motion.period_s


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"slot": [4, 1]}, "slot = [4, 1]: must be a column and a row of the rack, 3 columns and 2 rows"),
        (
            {"slot": [1, 1]},
            "slot = [1, 1]: the server [1, 2] stands above it in the tube; must be launched first",
        ),
        (
            {"platform": {"missing": [[1, 2]]}},
            "slot = [1, 2]: its server is in platform.missing; must be one that is there and can leave: [1, 1], [2, 2],",
        ),
        (
            {"platform": {"missing": [[1, 3]]}},
            "platform.missing = [1, 3]: must be a column and a row of the rack",
        ),
        (
            {"platform": {"missing": [[2, 2], [2, 2]]}},
            "platform.missing = [[2, 2], [2, 2]]: must name every slot once",
        ),
        (
            {"platform": {"server_cm_m": 1.2}},
            "platform.server_cm_m = 1.2: must be below server_length_m = 1.2",
        ),
        (
            {"platform": {"server_length_m": 0.0}},
            "platform.server_length_m = 0.0: Input should be greater than 0",
        ),
        ({"platform": {"columns": 0}}, "platform.columns = 0: Input should be greater than or equal to 1"),
        ({"force_n": 0.0}, "force_n = 0.0: Input should be greater than 0"),
        ({"force_n": float("nan")}, "force_n = nan: Input should be a finite number"),
        ({"stop_s": None}, "stop_s = None: is missing; stop = 'time' needs it"),
        ({"stop": "stroke"}, "stop_s = 1.45: stop = 'stroke' takes none"),
        (
            {"stop_s": 1.2},
            "stop_s = 1.2: the server has slid 0.8334 m of 1.2 m by then; must be at least 1.44069 and at most 1.49069",
        ),
        (
            {"force_n": 1000.0},
            "stop_s = 1.45: the server has slid 4.025 m of 1.2 m by then; must be at least 0.789099 and at most 0.839099",
        ),
        ({"stop_s": 900.0}, "stop_s = 900: the server has slid beyond 1000 strokes by then"),
        (
            {"platform": {"thrust_n": [0.0, 1e5]}, "stop": "stroke", "stop_s": None},
            "force_n = 300: the platform's thrust and torque hold the server in its tube; it must leave it",
        ),
        ({"orbit": {"altitude_km": -5.0}}, "orbit.altitude_km = -5.0: Input should be greater than 0"),
        (
            {"orbit": {"altitude_km": 0.4}},
            "orbit.semi_minor_m = 500: the platform's orbit meets the ground; must be below the altitude, 400 m",
        ),
        (
            {"orbit": {"semi_minor_m": 4e4}},
            "orbit.semi_minor_m = 40000: must be at most 33855, half a hundredth",
        ),
        ({"orbit": {"height_km": 4.0}}, "orbit.height_km = 4.0: unknown key; allowed here: altitude_km,"),
        (
            {"rendezvous": {"impulses": "generated"}},
            "rendezvous.cost = 'squares': every further impulse lowers Σ‖Δv‖², there is no last one;",
        ),
        ({"rendezvous": {"impulses": 3}}, "rendezvous.impulses = 3: Input should be 2 or 'generated'"),
        (
            {"rendezvous": {"duration_s": 0.0}},
            "rendezvous.duration_s = 0.0: must be 'free' or a time, above 0",
        ),
        ({"rendezvous": {"duration_s": "soon"}}, "rendezvous.duration_s = 'soon': must be 'free' or a time"),
        (
            {"rendezvous": {"duration_s": PERIOD_S}},
            "rendezvous.duration_s = 5549.97: after 1.0000 orbits two positions determine no flight",
        ),
        ({"rendezvous": {"longest_orbits": 0.0}}, "rendezvous.longest_orbits = 0.0: Input should be greater"),
        ({"uncertainty": {"runs": 0}}, "uncertainty.runs = 0: Input should be greater than or equal to 1"),
    ],
)
def test_what_is_wrong_is_named(change: dict[str, Any], says: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        paper().with_changes(**change)
    assert says in str(caught.value)


def test_a_whole_number_of_seconds_is_a_time() -> None:
    assert paper().with_changes(rendezvous={"duration_s": 900}).rendezvous.duration_s == 900


def test_whole_orbits_are_allowed_to_many_impulses() -> None:
    table = {"cost": "norms", "impulses": "generated", "duration_s": PERIOD_S}
    assert paper().with_changes(rendezvous=table).rendezvous.impulses == "generated"


def test_constants_are_the_papers_unless_asked_otherwise() -> None:
    assert paper().motion.mean_motion_rad_s == pytest.approx(1.13211e-3, abs=5e-9)
    other = launched(orbit={"constants": "wgs84"})
    assert other.motion.mean_motion_rad_s == pytest.approx((3.986004418e14 / 6778137.0**3) ** 0.5)


def test_the_platform_stays_on_its_ellipse() -> None:
    """Its motion without a launch is a solution of the linear model."""
    scenario = launched(phase_deg=40.0)
    x, z, vx, vz = scenario.platform_state()
    later = scenario.motion.transition(700.0, 0.0) @ np.array([z, x, 0.0, vz, vx, 0.0])
    x, z, vx, vz = scenario.platform_state(700.0)
    np.testing.assert_allclose(later, [z, x, 0.0, vz, vx, 0.0], atol=1e-9)


def test_cases_are_dispersed_and_leave_with_the_stroke() -> None:
    assert disperse(paper(), 0).model_dump() == paper().model_dump() | {"name": "paper002-case-0000"}
    case = disperse(paper(), 3, seed=1)
    assert (case.stop, case.stop_s) == ("stroke", None)
    assert 0.0 < abs(case.force_n / 300.0 - 1.0) < 0.06
    assert 0.0 < abs(case.yaw_bias_deg) < 1.5
    assert disperse(paper(), 3, seed=1) == case
