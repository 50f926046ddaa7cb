"""Bad input: key, value, what is allowed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions.approach.dispersion import disperse
from tests.missions.approach.cases import station


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"points__S2__x_m": -190.0},
            "points.S2 = (-190, 0, 0): 190 m from the target, inside the keep-out with its margin; must be at least 245 m",
        ),
        ({"start__x_m": 100.0}, "start = (100, 0, 0): 100 m from the target, inside the keep-out"),
        (
            {"points__S2__z_m": 60.0},
            "points.S2 = (-250, 0, 60): the gate of the keep-out is 16 m outside the corridor about -V-bar of 10°",
        ),
        (
            {"points__contact__z_m": 10.0},
            "points.contact = (-20, 0, 10): a point of the corridor is 6.68 m outside the corridor",
        ),
        (
            {"points__S2__hold_within_m": 44.0},
            "points.S2.hold_within_m = 44: the corridor begins there and is 43.1 m away at its side; must be at most that",
        ),
        (
            {"points__contact__arrive_s": 6500.0},
            "points.contact.arrive_s = 6500: from 250 to 20 m within the speed limit takes at least 861 s;"
            " must be at least 7161",
        ),
        ({"points__contact__vx_m_s": 0.2}, "points.contact = 0.2 m/s: at 20 m the speed is at most 0.1 m/s"),
        (
            {"points__contact__arrive_s": 6000.0},
            "points.contact.arrive_s = 6000: S2 is left at 6300 s; must be later",
        ),
        (
            {"points__contact__hold_s": 10.0},
            "points.contact.hold_s = 10: the flight ends at the last point; must be 0",
        ),
        (
            {"points__S2__hold_s": 0.0},
            "points.S2.hold_impulses = 4: there is no hold; leave it out, or give hold_s",
        ),
        (
            {"half_space__x": -1.0, "half_space__at_least_m": 100.0},
            "points.contact = (-20, 0, 0): 80 m beyond the plane of half_space; must be on its side",
        ),
        ({"half_space__at_least_m": 1.0}, "half_space.x = 0: a direction has a component that is not 0"),
        (
            {"half_space__z": -1.0, "half_space__after": "S3"},
            "half_space.after = 'S3': no such point; must be one of S2, contact",
        ),
        ({"keep_out__until": "S3"}, "keep_out.until = 'S3': no such point; must be one of S2, contact"),
        (
            {"keep_out__semi_axes_m": [300.0, 200.0, 200.0]},
            "keep_out.radius_m: must be given, or keep_out.semi_axes_m",
        ),
        ({"keep_out__body_m": 200.0}, "keep_out.body_m = 200: must be below 200, the least of the keep-out"),
        ({"corridor__axis": "V-bar"}, "corridor.axis = 'V-bar': Input should be '+V-bar', '-V-bar'"),
        ({"points__S2__hld_s": 1.0}, "points.S2.hld_s = 1.0: unknown key; allowed here: arrive_s"),
        (
            {"target__mean_motion_rad_s": 1e-3},
            "target.altitude_km = 420: target.mean_motion_rad_s is given too",
        ),
        (
            {"target__eccentricity": 0.01, "safety__all_time": True},
            "safety.all_time = true: for all time only about a circular target; give orbits",
        ),
        (
            {"target__eccentricity": 0.3},
            "target.eccentricity = 0.3: the perigee is in the ground; must be below 0.06",
        ),
        ({"start__x_m": float("nan")}, "start.x_m = nan: Input should be a finite number"),
    ],
)
def test_what_contradicts_itself_is_refused_by_key_value_and_what_is_allowed(
    changes: dict[str, Any], says: str
) -> None:
    with pytest.raises(ScenarioError) as error:
        station(**changes)
    assert says in str(error.value)


def test_speed_at_its_limit_needs_the_time_that_is_told() -> None:
    """dr/dt = −(a + b r), integrated in small steps."""
    speed = station().speed
    assert speed is not None
    away, lapse, step = 250.0, 0.0, 0.01
    while away > 20.0:
        away -= step * float(speed.limit(away))
        lapse += step
    assert lapse == pytest.approx(861.0, abs=0.6)


@pytest.mark.parametrize("axis", ["+V-bar", "-V-bar", "+R-bar", "-R-bar", "+H-bar", "-H-bar"])
def test_depth_in_the_corridor_is_the_distance_from_the_side_of_the_cone(axis: str) -> None:
    corridor = station().corridor
    assert corridor is not None
    cone = corridor.model_copy(update={"axis": axis, "apex_m": 3.0})
    rng = np.random.default_rng(5)
    along, angle = cone.direction(), np.radians(cone.half_angle_deg)
    across = np.cross(along, rng.standard_normal(3))
    across /= np.linalg.norm(across)
    on_side = 3.0 * along + 50.0 * (np.cos(angle) * along + np.sin(angle) * across)
    inward = np.sin(angle) * along - np.cos(angle) * across
    assert cone.depth(on_side) == pytest.approx(0.0, abs=1e-12)
    assert cone.depth(on_side + 0.7 * inward) == pytest.approx(0.7)


def test_start_in_named_axes_is_that_of_own_keys() -> None:
    own = station(start__x_m=-1500.0, start__z_m=400.0, start__vx_m_s=0.6)
    state = own.start.state()
    named = {"frame": "RTN", "position_m": state[:3].tolist(), "velocity_m_s": state[3:].tolist()}
    document = own.model_dump() | {"start": named}
    np.testing.assert_allclose(type(own).model_validate(document).start.state(), state, atol=1e-9)


def test_dispersed_cases_depend_on_seed_and_number_alone() -> None:
    first, again, other = (disperse(station(), number, 7) for number in (3, 3, 4))
    assert first == again
    assert first.start != other.start
    assert disperse(station(), 0, 7).start == station().start
