"""One point of the domain as a plan: the same as in the domain's table, with every subproblem, or with its evidence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.mission import DOCUMENT_KEYS, Mission, PlanStatus
from orbsoc.missions import reachable_domain
from orbsoc.missions.reachable_domain import plan, reproduce
from orbsoc.orbit import elements_from_state, propagate_burn
from tests.missions.reachable_domain.cases import SCENARIOS, domain, paper


def test_the_module_is_a_mission() -> None:
    assert isinstance(reachable_domain, Mission)


def test_a_plan_is_the_largest_orbit_of_the_current_plane_with_all_its_subproblems() -> None:
    rows: list[int] = []
    found = plan(paper(), callback=lambda row: rows.append(row.number))
    assert found.status is PlanStatus.VERIFIED
    assert found.point["a_km"] == pytest.approx(24860.2660, rel=1e-6)
    assert rows == list(range(1, len(found.subproblems) + 1))
    assert found.subproblems[-1].change < 1e-7
    assert found.subproblems[-1].figures["a_km"] == pytest.approx(found.point["a_km"], rel=1e-6)
    document = found.to_dict()
    assert set(DOCUMENT_KEYS) <= set(document)
    assert len(document["subproblems"]) == found.point["sequence_iterations"]


@pytest.mark.parametrize("point", [(28.3, 350.25, 100.0), (16.3, 318.25, 500.0)])
def test_a_plan_is_the_point_of_the_domain(point: tuple[float, float, float]) -> None:
    """At the first of these the plan of the sequence is polished."""
    found = plan(paper(), point=point)
    table = domain().solve_planes(*([value] for value in point))
    assert found.point["a_km"] == pytest.approx(table["a_km"][0], rel=1e-8)
    assert found.point["level"] == table["level"][0]
    assert found.differences(found)[0].value == 0.0


def test_the_attitude_programme_flies_to_the_planned_orbit() -> None:
    found, scenario = plan(paper()), paper()
    text = found.tables()["attitude.csv"].splitlines()
    rows = np.array([[float(value) for value in line.split(",")] for line in text[1:]])
    assert text[0] == "t_s,ux,uy,uz"
    np.testing.assert_allclose(np.linalg.norm(rows[:, 1:], axis=1), 1.0, rtol=1e-10)

    def steering(t_s: float, _state: np.ndarray) -> np.ndarray:
        return np.array([np.interp(t_s, rows[:, 0], rows[:, k]) for k in (1, 2, 3)])

    end = propagate_burn(scenario.initial_eci(), scenario.vehicle.thruster(), steering, [rows[-1, 0]])[-1]
    assert elements_from_state(end[:3], end[3:]).sma_m / 1e3 == pytest.approx(found.point["a_km"], rel=1e-4)


def test_the_first_figures_are_the_orbit_with_its_burn_in_space_and_flat(tmp_path: Path) -> None:
    figures = plan(paper()).figures(tmp_path)
    assert [each.name for each in figures] == ["space.png", "orbit.png"]
    for figure in figures:
        assert not figure.appendix
        assert (tmp_path / figure.name).stat().st_size > 10_000


def test_a_point_that_is_not_reached_has_its_evidence_and_no_files(tmp_path: Path) -> None:
    found = plan(paper(), point=(28.3, 351.3, 100.0))
    assert found.status is PlanStatus.NOT_FOUND
    assert "deg short" in found.message
    assert found.verification is None
    assert found.tables() == {}
    assert found.figures(tmp_path) == ()
    assert found.to_dict()["point"]["a_km"] is None


def test_an_interrupted_solve_interrupts_the_plan() -> None:
    def solve(problem: orbsoc.Problem, settings: orbsoc.Settings | None = None) -> orbsoc.Solution:
        return replace(orbsoc.solve(problem, settings), status=orbsoc.Status.INTERRUPTED)

    found = plan(paper(), solve=solve)
    assert found.status is PlanStatus.INTERRUPTED
    assert found.verdict.lines[0].figure.endswith("interrupted")


def test_the_papers_envelope_is_set_beside_the_boundary() -> None:
    rows = reproduce(SCENARIOS)
    assert [row.paper for row in rows] == ["16.31", "39.31", "318.27", "349.27"]
    assert all(row.verdict == "not reproduced" and row.reason for row in rows)


def test_the_only_plane_of_a_grid_is_the_point_that_is_planned() -> None:
    one = {"first": 28.3, "last": 28.3, "step": 1.0}
    node = {"first": 351.3, "last": 351.3, "step": 1.0}
    scenario = paper().with_changes(grid={"inclination_deg": one, "raan_deg": node})
    found = plan(scenario)
    assert (found.point["inc_deg"], found.point["raan_deg"]) == (28.3, 351.3)
    assert found.status is PlanStatus.NOT_FOUND
