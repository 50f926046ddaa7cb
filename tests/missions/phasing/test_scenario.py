"""Bad input: key, value, what is allowed."""

from typing import Any

import pytest

from orbsoc.missions.phasing import ScenarioError, plan

from .cases import scenario


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"target": {"ecc": 0.05}}, r"target.ecc = 0.05: with sma_km = 6670.4 the perigee is at -41.3 km: must be 80 or higher"),
        ({"forces": ["j2"]}, r"target.ballistic_m2_kg = 0.0016: does nothing without 'drag'"),
        ({"forces": ["j2", "j2", "drag"]}, "each at most once"),
        ({"forces": ["sun"]}, "forces"),
        ({"window": {"start_s": 100.0}}, r"window.start_s = 100: must not be before chaser.epoch_s = 83147.9"),
        ({"window": {"end_s": 85000.0}}, r"window.end_s = 85000: must be after the burns before it"),
        ({"window": {"end_s": 400000.0}}, r"window.end_s = 400000: must be at most latest_h = 24"),
        ({"window": {"phasing_s": 80000.0}}, r"window.phasing_s = 80000: must be after the first burn"),
        ({"target": {"epoch_s": 9e6}}, r"target.epoch_s = 9e\+06: must be within 10 days"),
        ({"window": {"revolutions": 0}}, "window.revolutions = 0"),
        ({"window": {"front": [4, 0]}}, r"window.front.1 = 0: .*greater than or equal to 1"),
        ({"window": {"front": [501]}}, r"window.front.0 = 501: .*less than or equal to 500"),
        ({"surprise": {"ballistic_m2_kg": 0.005, "replans_h": [-1.0]}}, r"surprise.replans_h.0 = -1.0: .*greater than 0"),
        ({"surprise": {"ballistic_m2_kg": 0.005, "replans_h": [8.0, 1000.0]}}, r"surprise.replans_h.1 = 1000.0: .*or equal to 720"),
        ({"limits": {"perigee_height_km": 900.0, "apogee_height_km": 500.0}}, "must be below apogee_height_km = 500"),
        ({"uncertainty": {"probability": 1.0}}, "uncertainty.probability = 1.0"),
        ({"window": {"revs": 3}}, "unknown key"),
    ],
)  # fmt: skip
def test_what_contradicts_itself_is_refused(changes: dict[str, Any], says: str) -> None:
    with pytest.raises(ScenarioError, match=says):
        scenario().with_changes(**changes)


def test_revolutions_that_cannot_meet_are_told_with_what_they_would_take() -> None:
    many = scenario().with_changes(window={"revolutions": 40})
    with pytest.raises(
        ScenarioError, match=r"window.revolutions = 40: no phasing orbit .* would be at -\d+ km"
    ):
        plan(many)
    free = scenario().with_changes(window={"end_s": None, "latest_h": 1.0, "revolutions": 3})
    with pytest.raises(ScenarioError, match=r"window.revolutions = 3: .* within latest_h = 1"):
        plan(free)


def test_a_leg_of_whole_revolutions_is_named() -> None:
    singular = scenario("design").with_changes(window={"phasing_s": 112737.0})
    with pytest.raises(ScenarioError, match=r"window.end_s = 149672.114: .* whole revolutions"):
        plan(singular)
