"""What a Python user sees of a plan: a short repr, its orbit, figures, and what its burn does over time."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions.reachable_insertion import Plan, load_scenario, plan
from orbsoc.missions.reachable_insertion.figures.history import History

from .test_verdicts import scenario

REC1 = Path(__file__).resolve().parents[3] / "scenarios" / "rec1.toml"


@cache
def raised() -> Plan:
    return plan(load_scenario(REC1))


@cache
def lowered() -> Plan:
    return plan(scenario("circular 500 km to 50 x 500 km"))


def test_a_plan_says_what_it_is_in_a_few_lines() -> None:
    text = repr(raised())
    assert len(text.splitlines()) <= 5
    assert "verified" in text
    assert "56.570 s" in text
    assert "152.76 × 201.84 km" in text


def test_orbit_and_propellant_are_those_of_the_document() -> None:
    document = raised().to_dict()
    assert raised().propellant_kg == document["propellant_kg"]
    assert raised().orbit is not None
    assert raised().orbit.sma_m / 1e3 == document["orbit"]["a_km"]  # type: ignore[union-attr]


def test_a_notebook_shows_verdict_and_figure_and_plot_refuses_what_was_not_flown() -> None:
    html = raised()._repr_html_()
    assert html.startswith("<table><tr><th>Answer</th><td><b>VERIFIED</b></td>")
    assert 'src="data:image/png;base64,' in html
    lost = plan(load_scenario(REC1.with_name("paper004_insertion.toml"), {"problem": "max_energy"}))
    with pytest.raises(ValueError, match="nothing to plot: the plan is not_found"):
        lost.plot()
    assert "<img" not in lost._repr_html_()


def test_changes_are_checked_as_a_file_is() -> None:
    with pytest.raises(ScenarioError, match=r"vehicle\.thrust_n = -5\.0: .*greater than 0"):
        load_scenario(REC1).with_changes(vehicle={"thrust_n": -5.0})


@pytest.mark.parametrize(("found", "brakes"), [(raised, False), (lowered, True)])
def test_the_shares_of_the_spent_delta_v_add_up(found: object, brakes: bool) -> None:
    made: Plan = found()  # type: ignore[operator]
    assert made.verification is not None
    history = History.of(made.scenario.vehicle.thruster(), made.verification.flight)
    assert history.brakes is brakes
    total = history.speed_change_m_s + history.gravity_m_s + history.steering_m_s
    np.testing.assert_allclose(total, history.delta_v_m_s, atol=1e-4)
    assert history.mass_kg[0] - history.mass_kg[-1] == pytest.approx(made.propellant_kg)
    assert (history.steering_m_s >= 0.0).all()


def test_figures_tell_their_axes_and_name_the_paper_only_for_its_own_scenarios(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    of_paper = {each.name: each.caption for each in raised().figures(tmp_path / "a")}
    own = {each.name: each.caption for each in lowered().figures(tmp_path / "b")}
    assert list(own) == [
        "space.png",
        "orbit.png",
        "history.png",
        "velocity.png",
        "position.png",
        "attitude.png",
    ]
    assert "the paper's figure 5a" in of_paper["velocity.png"]
    assert "launch-inertial" in of_paper["velocity.png"]
    assert not any("paper" in caption for caption in own.values())


def test_figures_of_no_burn_are_the_orbit_alone(tmp_path: Path) -> None:
    found = plan(scenario("on its target orbit"))
    assert [each.name for each in found.figures(tmp_path)] == ["space.png", "orbit.png"]
