"""Scenario files of the reachable domain: the paper's, axes, and what they may not say."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.scenario_file import checked
from orbsoc.missions.reachable_domain import Scenario, ScenarioError, load_scenario
from orbsoc.orbit import LaunchFrame, eci_from_launch_inertial, rotate_state
from tests.missions.reachable_domain.cases import SCENARIOS, paper


def test_the_scenario_is_the_papers() -> None:
    grid = paper().grid
    assert grid.inclination_deg.count * grid.raan_deg.count * grid.perigee_height_km.count == 33825
    assert 4500.0 * np.log(160.0 / 88.0) == pytest.approx(2690.0, abs=0.5)


def test_launch_inertial_states_are_turned_into_eci() -> None:
    """The paper's axes at Wenchang, azimuth 105 degrees: the scenario's vector, given in them, comes back."""
    site = {"geocentric_latitude_deg": 19.6140, "azimuth_deg": 105.0, "inertial_longitude_deg": 110.955}
    frame = LaunchFrame(*np.deg2rad(list(site.values())))
    state = rotate_state(eci_from_launch_inertial(frame).T, paper().initial_eci())
    np.testing.assert_allclose(state, [3.04e6, 5.83e6, 1.61e5, 6.68e3, -3.60e3, 6.07e2], rtol=1e-2)
    document = {
        **paper().model_dump(),
        "axes": "launch_inertial",
        "launch_site": site,
        "initial": {"position_m": list(state[:3]), "velocity_m_s": list(state[3:])},
    }
    turned = checked(Scenario, document, source="test")
    np.testing.assert_allclose(turned.initial_eci(), paper().initial_eci(), rtol=1e-12)
    with pytest.raises(ScenarioError, match="launch_site: is missing"):
        checked(Scenario, {**document, "launch_site": None}, source="test")


@pytest.mark.parametrize(
    ("table", "key", "value", "words"),
    [
        ("burn", "minimum_altitude_km", 250.0, "the burn begins below it; must be at most 198.8"),
        ("method", "fine_nodes", 8, "must be at least method.nodes = 12"),
    ],
)
def test_what_contradicts_the_rest_of_the_scenario_is_refused(
    table: str, key: str, value: float, words: str
) -> None:
    document = paper().model_dump()
    document[table][key] = value
    with pytest.raises(ScenarioError, match=f"{table}.{key} = {value:g}: {words}"):
        checked(Scenario, document, source="test")


def test_fewer_azimuths_at_most_than_to_begin_with_are_refused() -> None:
    with pytest.raises(
        ScenarioError, match=r"boundary\.most_azimuths = 16: must be at least boundary\.azimuths = 144"
    ):
        load_scenario(SCENARIOS / "paper004_reach.toml", {"boundary.most_azimuths": 16})
