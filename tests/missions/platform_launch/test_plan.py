"""The plan: its document, its flights about the Earth, the second solver, and the paper row by row."""

from __future__ import annotations

import html
import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.guidance.mission import BROKEN, Agreement, Dispersible, PlanStatus
from orbsoc.guidance.scenario_file import checked, read_toml
from orbsoc.guidance.verdict import Question, Word
from orbsoc.interfaces import clarabel
from orbsoc.missions import MISSIONS, platform_launch
from orbsoc.missions.platform_launch import Plan, Scenario, load_scenario, plan, reproduce, samples
from orbsoc.missions.platform_launch.paper import compare
from orbsoc.orbit.perturbations import PointMass, coast
from orbsoc.orbit.relative import relative_state
from orbsoc.report.run import PlanRun, report_page
from tests.missions.platform_launch.data import SCENARIOS, launched, paper
from tests.missions.verdict_rules import assert_rules

NEARLY_ROUND = {
    "sma_km": 6878.137, "ecc": 0.001, "inc_deg": 30.0, "raan_deg": 10.0, "argp_deg": 20.0, "true_anomaly_deg": 30.0,
    "epoch_utc": "2026-01-01T00:00:00+00:00", "frame": "TEME",
}  # fmt: skip


@cache
def planned(name: str = "paper002") -> Plan:
    return plan(load_scenario(SCENARIOS / f"{name}.toml"))


def test_the_plan_is_the_papers() -> None:
    found = planned().to_dict()
    assert found["status"] == "verified"
    assert found["duration_s"] == pytest.approx(920.954, abs=5e-4)
    assert found["cost"] == pytest.approx(0.62488, abs=5.1e-6)
    assert [each["norm_m_s"] for each in found["impulses"]] == pytest.approx([0.6388, 0.4657], abs=5.1e-5)
    assert found["impulses"][0]["dv_m_s"] == pytest.approx([-0.6036, -0.2090, 0.0], abs=5.1e-5)
    assert len(found["minima"]) == found["certificates"]["minima"]["bound"] == 9
    assert found["certificates"]["minima"]["apart_s"] < 0.05
    assert abs(found["certificates"]["optimum"]["gap"]) < 1e-8


def test_the_document_has_what_other_programs_read() -> None:
    found = planned().to_dict()
    launch = {"separation_s", "position_m", "velocity_m_s", "yaw_deg", "yaw_rate_deg_s", "slide_m_s"}
    assert launch <= set(found["launch"])
    assert found["launch"]["position_m"] == pytest.approx([-498.253, 1.118, 0.0], abs=5.1e-4)
    assert found["launch"]["velocity_m_s"] == pytest.approx([1.44115, 0.89452, 0.0], abs=5.1e-6)
    assert found["launch"]["yaw_deg"] == pytest.approx(4.092, abs=5.1e-4)
    keys = {
        "delta_v_m_s",
        "terminal_error",
        "constraints",
        "audits",
        "subproblems",
        "paper",
        "constants",
        "scenario",
    }
    assert keys <= set(found)
    assert {"position_m", "velocity_m_s"} == set(found["terminal_error"])
    assert all({"name", "margin", "unit", "at_s"} == set(row) for row in found["constraints"])
    assert isinstance(MISSIONS["platform_launch"], Dispersible)


def test_two_bodies_miss_by_centimetres_and_meet_once_corrected() -> None:
    """The miss of the linear model in low orbit, and in geostationary orbit after 1.41 revolutions."""
    found = planned().verification
    assert found is not None
    assert found.as_planned.end[:2] == pytest.approx([-0.023, 0.015], abs=5.1e-4)
    assert found.corrected.miss_m < 1e-5
    assert abs(found.corrected.programme.total_m_s - found.as_planned.programme.total_m_s) < 1e-4
    far = plan(launched(orbit={"altitude_km": 35_786.0}))
    assert far.verification is not None
    assert far.verification.as_planned.miss_m == pytest.approx(31.15, abs=0.02)
    assert far.verification.corrected.miss_m < 1e-3
    assert far.status is PlanStatus.VERIFIED


def test_messages_hold_the_corrected_flight(tmp_path: Path) -> None:
    reader = pytest.importorskip("ccsds_ndm.ndm_io", reason="the independent reader is not installed").NdmIo
    found = planned()
    for name, text in found.tables().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    segment = reader().from_path(tmp_path / "chaser.oem").body.segment[0]
    last = segment.data.state_vector[-1]
    server = 1e3 * np.array(
        [float(getattr(last, key).value) for key in ("x", "y", "z", "x_dot", "y_dot", "z_dot")]
    )
    assert found.meeting is not None
    forces = [PointMass(paper().constants)]
    target = coast(paper().target_state()[None], [0.0, found.meeting.time_s], forces)[-1, 0]
    assert np.linalg.norm(relative_state(target, server)[:3]) < 1e-4
    elements = (tmp_path / "chaser.opm").read_text().splitlines()
    assert "GM = 397865.5000000 [km**3/s**2]" in elements


def test_without_a_launch_towards_the_target_there_is_a_plan_and_no_series() -> None:
    found = plan(launched(yaw_bias_deg=180.0)).to_dict()
    assert found["status"] == "verified"
    assert found["series"]["orders"] == []
    assert found["series"]["reason"].endswith("must be below 0, towards the target")


@pytest.mark.parametrize(
    "change",
    [
        {"rendezvous": {"longest_orbits": 0.06}},  # shorter than any minimum
        {"rendezvous": {"duration_s": 3000.0}},
        {"slot": [1, 1], "platform": {"columns": 1, "rows": 1}},
        {"platform": {"columns": 1, "rows": 1, "torque_n_m": 10.0}, "slot": [1, 1]},
        {"orbit": {"altitude_km": 20_000.0, "semi_minor_m": 50.0, "constants": "wgs84"}},
    ],
)
def test_other_launches_are_planned_verified_and_told(change: dict[str, Any]) -> None:
    found = plan(launched(**change))
    assert found.status is PlanStatus.VERIFIED
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert document["details"].startswith("the server leaves")
    assert_rules(found.verdict, found.status)


def test_what_two_bodies_do_not_meet_is_not_verified() -> None:
    """At 300 m/s the linear model is no guide, and the correction from it does not get there."""
    found = plan(launched(1e7))
    assert found.status is PlanStatus.NOT_VERIFIED
    assert_rules(found.verdict, found.status)
    assert "two-body rendezvous, corrected: position is broken by" in found.to_dict()["details"]


def test_generated_impulses_beat_two_by_a_third() -> None:
    found = planned("paper002_norms").to_dict()
    assert found["status"] == "verified"
    assert found["cost"] == found["delta_v_m_s"] == pytest.approx(0.7222, abs=5e-5)
    assert found["certificates"]["optimum"]["gap"] < 1e-6
    two = min(each["cost"] for each in found["minima"])
    assert found["cost"] / two == pytest.approx(0.66, abs=5e-3)
    falling = [row["generated_m_s"] for row in found["front"]]
    assert falling == sorted(falling, reverse=True) or max(np.diff(falling)) < 1e-6


@pytest.mark.parametrize("name", ["paper002", "paper002_norms"])
def test_clarabel_agrees(name: str) -> None:
    scenario = load_scenario(SCENARIOS / f"{name}.toml")
    agreement = Agreement.of(planned(name), plan(scenario, solve=clarabel.solve))
    assert agreement.agrees, agreement.message
    assert len(agreement.differences) == (3 if name == "paper002" else 2)


def test_ctrl_c_in_a_solve_is_a_status() -> None:
    def solve(problem: Problem, settings: Settings | None = None) -> Solution:
        raise KeyboardInterrupt

    found = plan(paper(), solve=solve)
    assert found.status is PlanStatus.INTERRUPTED
    assert found.tables() == {}
    assert found.verdict.word(Question.ANSWER) is Word.INTERRUPTED


def test_a_problem_that_is_not_solved_is_told() -> None:
    def solve(problem: Problem, settings: Settings | None = None) -> Solution:
        return orbsoc.solve(problem, Settings(max_iterations=1, max_restarts=0))

    found = plan(load_scenario(SCENARIOS / "paper002_norms.toml"), solve=solve)
    assert found.status is PlanStatus.FAILED
    assert str(found.verdict).startswith("Answer   NO ANSWER    the conic problem ended with")


def test_figures_are_written_with_captions(tmp_path: Path) -> None:
    scenario = paper().with_changes(
        uncertainty={"runs": 20}, rendezvous={"cost": "norms", "impulses": "generated", "longest_orbits": 1.5}
    )
    figures = plan(scenario).figures(tmp_path)
    names = ["rendezvous", "launch", "cost", "engine_out", "scans", "front", "dispersed", "tube", "primer"]
    assert [each.name for each in figures] == [f"{name}.png" for name in names]
    assert all((tmp_path / each.name).stat().st_size > 10_000 and each.caption for each in figures)


def test_what_is_drawn_agrees_with_other_draws() -> None:
    rows = [row for draw in samples(SCENARIOS).values() for row in draw()]
    assert [row.verdict for row in rows] == ["inferred", "inferred"]


def test_the_papers_numbers_are_reproduced_or_their_misprint_is_named() -> None:
    rows = {row.quantity: (row.paper, row.ours, row.verdict) for row in reproduce(SCENARIOS)}
    verdicts = [verdict for *_, verdict in rows.values()]
    assert BROKEN not in verdicts
    assert rows["paper002: platform, yaw rate"] == ("4.29 °/s", "4.289 °/s", "reproduced")
    assert rows["paper002: platform, z"] == ("-0.13 m", "-0.135 m", "reproduced")
    assert rows["paper002: platform, vz"] == ("-0.19 m/s", "-0.185 m/s", "reproduced")
    assert rows["paper002: time of flight"] == ("920.72 s", "920.954 s", "not reproduced")
    assert rows["paper002: platform, semi-major axis (km)"] == ("6772.00", "6771.00", "misprint")
    assert rows["paper002: server, argument of perigee (°)"] == ("20.24", "-50.98", "misprint")
    assert rows["paper002_printed: speed in the tube"] == ("1.67 m/s", "2.143 m/s", "misprint")
    assert (verdicts.count("reproduced"), verdicts.count("misprint")) == (14, 9)


def test_a_plan_that_does_not_give_the_papers_numbers_is_told_as_failed() -> None:
    """Another launch under the paper's data."""
    other = replace(planned(), separation=launched(320.0).separation())
    verdicts = {row.quantity: row.verdict for row in compare(other)}
    assert verdicts["speed in the tube"] == BROKEN
    assert verdicts["first impulse"] == "reproduced"


def test_other_data_have_no_rows_of_the_paper() -> None:
    assert plan(launched()).to_dict()["paper"] == []


def test_an_eccentricity_left_out_is_told_in_document_report_and_messages(tmp_path: Path) -> None:
    document = {
        **read_toml(SCENARIOS / "paper002_norms.toml"),
        "orbit": {"semi_minor_m": 500.0},
        "target": NEARLY_ROUND,
    }
    found = plan(checked(Scenario, document, source="nearly round"))
    told = found.to_dict()
    assert told["scenario"]["orbit"]["ecc_left_out"] == pytest.approx(0.001, abs=1e-9)
    [words] = told["assumptions"]
    assert "eccentricity 0.001 is left out" in words
    assert "4 a e = 27.5 km" in words
    tables = found.tables()
    for name in ("chaser.oem", "chaser.opm"):
        assert "REF_FRAME = EME2000" in tables[name]
        assert f"COMMENT {words}" in tables[name].splitlines()
    run = PlanRun(platform_launch, found, "orbsoc", None, None)
    page = html.unescape(report_page(platform_launch, run.to_dict(), None, tables, (), tmp_path))
    assert f"Assumed: {words}." in page
    again = Scenario.model_validate_json(json.dumps(told["scenario"]))
    assert again == found.scenario
    assert again.assumptions == [words]
    assert planned().to_dict()["assumptions"] == []
