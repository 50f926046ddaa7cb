"""Weeks of drift: mean elements against the true motion, the search over revolutions and dates, and legs of a campaign."""

from __future__ import annotations

from math import tau
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.gtoc9 import debris, legs, reflown
from benchmarks.gtoc9 import scenario as leg_scenario
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions.phasing import Scenario, audit, plan, planner
from orbsoc.missions.phasing.model.approach import state_at
from orbsoc.missions.phasing.model.mean_approach import MeanApproach
from orbsoc.missions.phasing.model.mean_motion import (
    drifted,
    equinoctial,
    mean_elements,
    secular_rates,
    states_of,
    wrapped,
)
from orbsoc.missions.phasing.search.descent import Descended
from orbsoc.missions.phasing.search.drift import Transfer
from orbsoc.missions.phasing.search.refine import refine
from orbsoc.orbit import Elements, state_from_elements
from orbsoc.orbit.perturbations import J2, PointMass, fast_coast
from tests.missions.verdict_rules import assert_rules

FORCES = (PointMass(), J2())
ANGLES = st.floats(0.0, 6.28)
STATES = st.builds(
    lambda sma, ecc, inc, *angles: np.concatenate(state_from_elements(Elements(sma, ecc, inc, *angles))),
    st.floats(6.9e6, 8e6), st.floats(0.0, 0.02), st.floats(0.1, 2.0), ANGLES, ANGLES, ANGLES,
)  # fmt: skip


@given(STATES)
@settings(deadline=None, max_examples=50)
def test_elements_and_states_are_each_others_inverse(state: np.ndarray) -> None:
    assert np.abs(states_of(equinoctial(state)) - state).max() < 1e-6


@given(STATES)
@settings(deadline=None, max_examples=20)
def test_mean_elements_drift_as_the_true_motion_does(state: np.ndarray) -> None:
    """Ten days of secular rates against J2, both averaged: off by a thousandth of how far J2 turns the orbit."""
    before = mean_elements(state[None], FORCES)[0]
    later = mean_elements(fast_coast([state], [0.0, 864e3], FORCES)[-1], FORCES)[0]
    off = later - drifted(before, 864e3)
    off[5] = wrapped(off[5])
    assert abs(off[0]) < 50.0
    assert np.abs(off[1:5]).max() < 3e-3
    assert abs(off[5]) < 0.02


def test_an_approach_in_mean_elements_has_the_derivatives_of_its_end() -> None:
    start = np.append(
        equinoctial(np.concatenate(state_from_elements(Elements(7.1e6, 0.012, 1.7, 1.0, 2.0, 0.5))))[:5], 0.0
    )
    at = np.linspace(0.0, 900.0, 60)
    dv = np.zeros((60, 3))
    dv[[0, 20, 40, 59]] = [[1.0, 2.0, 3.0], [5.0, -3.0, 2.0], [1.0, 1.0, 1.0], [-2.0, 4.0, 5.0]]
    approach = MeanApproach(None, 1e3 * at, start, start, True, at)  # type: ignore[arg-type]
    found = approach.roll(dv).to_end
    for k in (0, 7, 20, 39, 40, 59):
        for axis in range(3):
            change = np.zeros_like(dv)
            change[k, axis] = 1e-2
            apart = (approach.roll(dv + change).off - approach.roll(dv - change).off) / 2e-2
            assert found[k, :, 3 + axis] == pytest.approx(apart, rel=1e-5, abs=1e-5 * np.abs(apart).max())
    by_start = approach.by_start(dv)
    moved = MeanApproach(None, 1e3 * at, start + 10.0 * np.eye(6)[0], start, True, at)  # type: ignore[arg-type]
    assert (moved.roll(dv).off - approach.roll(dv).off) / 10.0 == pytest.approx(
        by_start[:, 0], rel=1e-3, abs=1e-2
    )


def test_a_leg_of_hours_costs_less_than_the_campaign_spent_and_flies_by_another_integrator() -> None:
    known, leg = debris(), legs()[4]
    assert (leg.begin, leg.end, leg.dv_m_s) == (25, 20, 115.2)
    found = plan(leg_scenario(leg, known))
    assert found.status is PlanStatus.VERIFIED
    assert_rules(found.verdict, found.status)
    assert found.programme is not None
    assert found.programme.total_m_s <= leg.dv_m_s + 0.1
    miss_m, _, perigee_km = reflown(leg, found, known)
    assert miss_m < 1.0
    assert perigee_km > 221.863
    assert "descents in mean elements" in found.to_dict()["details"]
    dated = found.scenario.with_changes(
        window={"start_s": found.phasing.start_s, "end_s": found.phasing.end_s, "dates_h": 0.0}  # type: ignore[union-attr]
    )
    again = audit(dated, found.programme)
    assert again.status is PlanStatus.VERIFIED


def test_where_the_true_motion_has_no_flight_the_next_transfer_is_flown(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known, leg, flown = debris(), legs()[9], []

    def none_near_the_first(scenario: Scenario, transfer: Transfer, **how: Any) -> Descended | None:
        flown.append(transfer)
        return refine(scenario, transfer, **how) if len(flown) > 1 else None

    monkeypatch.setattr(planner, "refine", none_near_the_first)
    found = plan(leg_scenario(leg, known))
    assert found.status is PlanStatus.VERIFIED
    assert found.phasing is flown[-1]
    assert len({(each.start_s, each.end_s, each.revolutions) for each in flown}) == len(flown) == 2
    assert reflown(leg, found, known)[0] < 1.0


def drifting(**window: object) -> Scenario:
    """Two circular orbits 40 km apart in height and 1° in node, which ten days of drift bring together in part."""
    orbit = {"ecc": 0.001, "inc_deg": 98.0, "argp_deg": 0.0, "true_anomaly_deg": 0.0, "epoch_s": 0.0}
    return Scenario.model_validate(
        {
            "mission": "phasing", "name": "drifting", "forces": ["j2"],
            "chaser": orbit | {"sma_km": 7100.0, "raan_deg": 10.0}, "target": orbit | {"sma_km": 7140.0, "raan_deg": 11.0},
            "window": {"start_s": 0.0, "end_s": 864e3, "latest_h": 720.0} | window,
        }
    )  # fmt: skip


def test_ten_days_between_osculating_orbits_use_the_drift_of_the_node() -> None:
    found = plan(drifting())
    assert found.status is PlanStatus.VERIFIED
    assert found.programme is not None
    assert found.phasing is not None
    assert 130 < found.to_dict()["phasing"]["revolutions"] < 150
    # without drift: 20 m/s into the height, and 1° of node at 98° by 131 m/s
    assert found.programme.total_m_s < 130.0
    target = state_at(found.scenario, "target", 864e3)
    assert secular_rates(equinoctial(target)).sum() == pytest.approx(tau / 6004.0, rel=0.02)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"window": {"start_s": None}}, r"window.start_s = nothing: must be given where revolutions is not"),
        ({"window": {"end_s": None}}, r"window.end_s = nothing: must be given where revolutions is not"),
        ({"scheme": "paper"}, r"scheme = paper: must be 'socp' where revolutions are looked for"),
        ({"forces": ["j2", "drag"]}, r"forces = \['j2', 'drag'\]: must be \['j2'\] where revolutions are looked for"),
        ({"window": {"front": [4]}}, r"window.front = \(4,\): must be left out"),
        ({"window": {"dates_h": 25.0}}, r"window.dates_h = 25.0: .*less than or equal to 24"),
        ({"window": {"end_s": 36e3, "dates_h": 6.0}}, r"window.dates_h = 6: must be less than half of the 10 h"),
        ({"window": {"revolutions": 140, "dates_h": 1.0}}, r"window.dates_h = 1: does nothing with revolutions = 140"),
        ({"target": {"motion": "mean_j2"}, "window": {"revolutions": 140}}, r"window.revolutions = 140: must be left out"),
        ({"chaser": {"motion": "sgp4"}}, r"chaser.motion = 'sgp4'"),
        ({"window": {"latest_h": 721.0}}, r"window.latest_h = 721.0: .*less than or equal to 720"),
    ],
)  # fmt: skip
def test_what_the_search_cannot_use_is_refused(changes: dict[str, object], says: str) -> None:
    with pytest.raises(ScenarioError, match=says):
        drifting().with_changes(**changes)
