"""What leaves the mission: verification that objects, an attitude file that flies, a document that is JSON."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import orbsoc
from orbsoc.guidance.progress import iteration_cells
from orbsoc.missions.reachable_insertion import COLUMNS, Plan, Scenario, load_scenario, plan
from orbsoc.missions.reachable_insertion.model.problems import Row
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.missions.reachable_insertion.record.document import violations
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.verification import verify
from orbsoc.orbit import EARTH, angular_momentum, laplace_vector, propagate_burn, thrust_direction

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@cache
def planned(name: str = "rec1", problem: str = "min_time", direction: str = "fixed") -> Plan:
    scenario = load_scenario(SCENARIOS / f"{name}.toml")
    return plan(
        scenario.with_changes(problem=problem, target={"perigee_direction": direction}), solve=orbsoc.solve
    )


def tampered(found: Plan, **changes: Any) -> tuple[str, ...]:
    """What the verification objects to when the trajectory is changed after planning."""
    iterate = replace(found.iterate, trajectory=replace(found.trajectory, **changes))
    return verify(found.scenario, found.target, iterate).failures


def test_verification_objects_to_a_thrust_that_points_elsewhere() -> None:
    controls = planned().trajectory.controls + np.array([0.0, 0.0, 1e-3])
    failures = tampered(planned(), controls=controls / np.linalg.norm(controls, axis=1, keepdims=True))
    assert any("|ΔH|/|H|" in failure for failure in failures)
    assert any("plane error" in failure for failure in failures)


def test_verification_objects_to_a_thrust_above_one_though_it_is_flown_at_one() -> None:
    failures = tampered(planned(), controls=1.001 * planned().trajectory.controls)
    assert [failure for failure in failures if "max‖u‖" in failure] == [
        "max‖u‖ − 1 between nodes is 1.00e-03, allowed 1e-04"
    ]
    assert len(failures) == 1


def test_verification_objects_to_another_burn_time() -> None:
    failures = tampered(planned(), duration=1.001 * planned().trajectory.duration)
    assert any("|ΔL|/μ" in failure for failure in failures)


def test_verification_objects_to_a_perigee_below_the_one_required() -> None:
    found = planned("rec1", "max_energy", "free")
    higher = found.scenario.with_changes(target={"perigee_height_km": 150.1})
    failures = verify(higher, InsertionSetup.of(higher).target, found.iterate).failures
    assert [failure.split(" is ")[0] for failure in failures] == ["perigee error in m"]


@pytest.mark.parametrize(("problem", "direction"), [("min_time", "fixed"), ("max_energy", "free")])
def test_attitude_file_read_back_and_flown_reaches_the_planned_orbit(problem: str, direction: str) -> None:
    """From the CSV alone: pitch and yaw through a spline of the 401 lines, flown by DOP853."""
    found = planned("rec1", problem, direction)
    text = found.tables().get("attitude.csv")
    assert text is not None
    rows = list(csv.DictReader(io.StringIO(text)))
    assert list(rows[0]) == ["t_s", "pitch_deg", "yaw_deg", "ux", "uy", "uz", "rate_deg_s"]
    t, pitch, yaw = (np.array([float(row[key]) for row in rows]) for key in ("t_s", "pitch_deg", "yaw_deg"))
    u = np.array([[float(row[key]) for key in ("ux", "uy", "uz")] for row in rows])
    np.testing.assert_allclose(thrust_direction(np.deg2rad(pitch), np.deg2rad(yaw)), u, atol=1e-10)
    angles = CubicSpline(t, np.deg2rad(np.column_stack([pitch, yaw])))
    scenario = found.scenario
    end = propagate_burn(
        scenario.initial.vector(),
        scenario.vehicle.thruster(),
        lambda t_s, _x: thrust_direction(*angles(t_s)),
        [t[-1]],
    )[0]
    assert found.verification is not None
    reached = found.verification.flight.propagated[-1]
    assert np.linalg.norm(end[:3] - reached[:3]) < 1e-3
    assert np.linalg.norm(end[3:] - reached[3:]) < 1e-4


def test_terminal_error_is_against_the_target_state_of_the_scenario() -> None:
    found = planned()
    assert found.verification is not None
    wanted, reached = found.scenario.target.vector(), found.verification.flight.propagated[-1]
    h, h_wanted = (angular_momentum(x[:3], x[3:]) for x in (reached, wanted))
    laplace, laplace_wanted = (laplace_vector(x[:3], x[3:], EARTH.mu_m3_s2) for x in (reached, wanted))
    assert np.linalg.norm(h - h_wanted) / np.linalg.norm(h_wanted) <= 1e-9
    assert np.linalg.norm(laplace - laplace_wanted) / EARTH.mu_m3_s2 <= 1e-9


REQUIRED = {
    "status", "exit_reason", "problem", "time_of_flight_s", "orbit", "propagated_orbit", "terminal_error",
    "scp_iterations", "subproblems", "constants", "scenario",
}  # fmt: skip
ORBIT = {"a_km", "e", "inc_deg", "raan_deg", "argp_deg", "perigee_height_km", "apogee_height_km"}
SUBPROBLEM = {"iterations", "status", "n", "p", "m", "nnz_kkt", "nnz_l", "solve_us"}


def test_plan_document_is_json_with_the_public_keys() -> None:
    document = json.loads(json.dumps(planned().to_dict(), allow_nan=False))
    assert document.keys() >= REQUIRED
    assert document["orbit"].keys() >= ORBIT
    assert document["propagated_orbit"].keys() == document["orbit"].keys()
    assert document["terminal_error"].keys() == {"angular_momentum_rel", "laplace_rel"}
    assert all(row.keys() >= SUBPROBLEM for row in document["subproblems"])
    assert len(document["subproblems"]) == document["scp_iterations"] == len(planned().subproblems)
    assert document["status"] == "verified"
    assert document["orbit"]["inc_deg"] == pytest.approx(28.3, abs=0.1)
    assert len(document["trajectory"]["time_s"]) == 12


def test_documented_scenario_plans_the_same_again() -> None:
    document = json.loads(json.dumps(planned().to_dict()))
    again = plan(Scenario.model_validate_json(json.dumps(document["scenario"])), solve=orbsoc.solve)
    assert again.time_of_flight_s == planned().time_of_flight_s


def test_document_of_nothing_found_promises_no_orbit_and_no_attitude(tmp_path: Path) -> None:
    found = planned("paper004_insertion", "max_energy")
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert document["status"] == "not_found"
    assert document["orbit"] is None
    assert document["propagated_orbit"] is None
    assert document["violations"][0]["row"] == "orbit plane, lean across the perigee line"
    assert found.tables().get("attitude.csv") is None
    assert found.figures(tmp_path) == ()
    assert list(tmp_path.iterdir()) == []


def test_subproblem_without_a_point_is_null_in_json_and_a_dash_in_the_table() -> None:
    found = planned("paper004_insertion", "max_energy", "free")
    first = found.to_dict()["subproblems"][0]
    assert first["status"] == "PRIMAL_INFEASIBLE"
    assert first["change"] is None
    cells = iteration_cells(found.subproblems[0], COLUMNS)
    assert cells["change"] == cells["burn s"] == "–"
    assert list(cells) == list(iteration_cells(found.subproblems[-1], COLUMNS))


def test_figures_are_written_with_captions(tmp_path: Path) -> None:
    figures = planned("rec1", "max_energy").figures(tmp_path)
    assert {figure.name for figure in figures} == {
        "space.png", "orbit.png", "history.png", "velocity.png", "position.png", "attitude.png",
    }  # fmt: skip
    assert {path.name for path in tmp_path.iterdir()} == {figure.name for figure in figures}
    for path in tmp_path.iterdir():
        assert path.read_bytes().startswith(b"\x89PNG\r\n")
        assert path.stat().st_size > 20_000
    assert "figure 7" in figures[-1].caption


def test_planning_does_not_import_matplotlib() -> None:
    code = (
        "import sys; from orbsoc.missions.reachable_insertion import load_scenario, plan;"
        f"plan(load_scenario({str(SCENARIOS / 'rec1.toml')!r}));"
        "sys.exit('matplotlib' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(
    ("row", "value", "words"),
    [
        ("MOMENTUM", -1e-3, "the angular momentum too small by 9.86e-04 of itself"),
        ("ECCENTRICITY", 2e-3, "the eccentricity too large by 2.00e-03"),
        ("PERIGEE_DIRECTION", 1e-4, "the perigee direction off by 1.392°"),
        ("PERIGEE_RADIUS", 1e-3, "the perigee too low by 6.53 km"),
        ("LEAN_TO_PERIGEE", 1e-3, "the orbit plane tilted by 0.0565° about the in-plane normal"),
    ],
)
def test_every_violated_row_has_words_in_units_a_person_can_picture(
    row: str, value: float, words: str
) -> None:
    """On 150 × 203.95 km: e = 0.004115 and |H| = √(r_p (1 + e)) = 1.01377 canonical."""
    found = planned("rec1", "max_energy")
    outcome = replace(found.best.outcome, iterate=replace(found.iterate, slack=((Row[row], value),)))
    broken = replace(found, attempts=(replace(found.best, outcome=outcome),))
    assert violations(broken)[0].words.startswith(words)


def test_verdict_of_a_verified_plan_names_orbit_time_and_evidence() -> None:
    words = details(planned())
    assert words.startswith(
        "VERIFIED: the shortest burn found onto the target orbit, 152.76 × 201.84 km, takes 56.570 s"
    )
    assert "independent integrator" in words
