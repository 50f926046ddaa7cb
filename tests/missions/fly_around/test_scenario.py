"""Scenario files: what is accepted, and that every bad one is refused by key, value and what is allowed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.missions.fly_around import ScenarioError, load_scenario

from .baseline import FEWEST, SCENARIOS, scenario

TEXT = FEWEST.read_text(encoding="utf-8")
OURS = sorted(SCENARIOS.glob("paper001_*.toml"))

BAD = {
    "tolerance 0": ("tolerance_m = 2.0", "tolerance_m = 0.0", r"tolerance_m = 0\.0: .*greater than 0"),
    "negative": ("tolerance_m = 2.0", "tolerance_m = -1.0", r"tolerance_m = -1\.0: .*greater than 0"),
    "NaN": ("tolerance_m = 2.0", "tolerance_m = nan", r"tolerance_m = nan: .*finite"),
    "tolerance that holds the target": (
        "tolerance_m = 2.0",
        "tolerance_m = 150.0",
        r"tolerance_m = 150: must be below the shorter semi-axis, 150",
    ),
    "tolerance of a millimetre": (
        "tolerance_m = 2.0",
        "tolerance_m = 0.001",
        r"tolerance_m = 0\.001: takes about 894 pulses, and at most 400 are planned; must be at least 0\.00499",
    ),
    "angle out of range": ("[60.0, 45.0", "[60.0, 450.0", r"ellipse\.angles_deg\.1 = 450\.0: .*less than or equal to 360"),
    "angle that is none": ("[60.0, 45.0", "[60.0, inf", r"ellipse\.angles_deg\.1 = inf: .*finite"),
    "axis 0": ("[200.0, 150.0]", "[200.0, 0.0]", r"ellipse\.semi_axes_m\.1 = 0: must be above 0 and at most 68781"),
    "axes in km": ("[200.0, 150.0]", "[2e5, 150.0]", r"ellipse\.semi_axes_m\.0 = 200000: must be .*at most 68781"),
    "period 0": ("period_s = 1800.0", "period_s = 0.0", r"ellipse\.period_s = 0\.0: .*greater than 0"),
    "direction": ("direction = 1", "direction = 2", r"ellipse\.direction = 2: .*1 or -1"),
    "no way": ('"fewest"', '"few"', r"impulses = 'few': must be 'fewest', 'adaptive', 'equal' or a number of pulses, 1 to 400"),
    "no pulses": ('"fewest"', "0", r"impulses = 0: must be 'fewest'.* 1 to 400"),
    "half a pulse": ('"fewest"', "12.5", r"impulses = 12\.5: must be"),
    "true": ('"fewest"', "true", r"impulses = True: must be"),
    "altitude in m": ("altitude_km = 500.0 ", "altitude_km = 500000.0 ", r"target\.altitude_km = 500000\.0: .*50000"),
    "below the air": ("altitude_km = 500.0 ", "altitude_km = 50.0 ", r"target\.altitude_km = 50\.0: .*150"),
    "unknown key": ("tolerance_m", "tolerance", r"tolerance = 2\.0: unknown key.*Did you mean tolerance_m"),
    "unknown table": ("[target]", "[orbit]", r"orbit = .*: unknown key"),
    "start off the ellipse": (
        "[target]",
        "[start]\nx_m = 200.0\ny_m = 3.0\nz_m = 0.0\n\n[target]",
        r"start = \(200\.0, 3\.0, 0\.0\): the start is 3 m from the ellipse's point at time 0; must be within tolerance_m = 2",
    ),
    "negative sigma": (
        "[target]",
        "[uncertainty]\nposition_m = -0.1\nvelocity_m_s = 0.0\n\n[target]",
        r"uncertainty\.position_m = -0\.1: .*greater than or equal to 0",
    ),
    "two numbers for a vector": (
        "[target]",
        "[disturbance]\nacceleration_m_s2 = [0.0, 1e-6]\n\n[target]",
        r"disturbance\.acceleration_m_s2 = \[0\.0, 1e-06\]: entry 3 is missing",
    ),
    "no target": ("[target]", "", r"altitude_km = 500\.0: unknown key"),
    "front": ("tolerance_m = 2.0", "tolerance_m = 2.0\nfront = [0]", r"front\.0 = 0: .*greater than or equal to 1"),
}  # fmt: skip


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.stem)
def test_every_shipped_scenario_loads_and_is_named_like_its_file(path: Path) -> None:
    assert load_scenario(path).name == path.stem


@pytest.mark.parametrize(("old", "new", "says"), BAD.values(), ids=BAD)
def test_a_bad_scenario_is_refused_by_key_value_and_what_is_allowed(
    tmp_path: Path, old: str, new: str, says: str
) -> None:
    assert old in TEXT
    path = tmp_path / "bad.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert re.search(says, str(caught.value).replace("\n", " ")), str(caught.value)


def test_the_start_is_at_rest_on_the_ellipse_unless_it_is_given_in_its_axes() -> None:
    resting = scenario()
    assert np.array_equal(resting.start_state[3:], np.zeros(3))
    written = resting.with_start()
    np.testing.assert_allclose(written.start_state, resting.start_state, atol=1e-12)
    assert written.with_start() is written
    moved: dict[str, Any] = {"x_m": 200.0, "y_m": 1.0, "z_m": 0.0, "vz_m_s": 0.5}
    state = scenario(start=moved).start_state
    frame = resting.flight.ellipse.frame
    np.testing.assert_allclose(frame @ state[:3], [200.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(frame @ state[3:], [0.0, 0.0, 0.5], atol=1e-15)


def test_a_disturbance_is_given_in_the_papers_axes() -> None:
    """z to the nadir is −R, x is T, y is −N."""
    push = scenario(disturbance={"acceleration_m_s2": [1e-6, 2e-6, 3e-6]}).flight.disturbance_m_s2
    np.testing.assert_allclose(push, [-3e-6, 1e-6, -2e-6])
