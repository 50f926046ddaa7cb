"""Problems A and B of Li et al. 2025: every reference number, on the product's solver and on an independent one.

rec1 and rec2 are self-consistent instances (acceptance tests of the solver); the printed data do not give the
printed results, and what they do give is tested here too.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.mission import Agreement
from orbsoc.guidance.scp import ExitReason
from orbsoc.interfaces import clarabel
from orbsoc.missions.reachable_insertion import Plan, PlanStatus, load_scenario, plan
from orbsoc.missions.reachable_insertion.model.problems import Row
from orbsoc.missions.reachable_insertion.paper import compare
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.missions.reachable_insertion.record.document import violations
from orbsoc.missions.reachable_insertion.targets.target_orbit import LargestOrbit

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"
SOLVERS = {"orbsoc": orbsoc.solve, "clarabel": clarabel.solve}
REC1, REC2 = "rec1", "rec2"
ZF196, PRINTED = "paper004_insertion_zf196", "paper004_insertion"


@cache
def planned(solver: str, name: str, problem: str, direction: str = "fixed") -> Plan:
    scenario = load_scenario(SCENARIOS / f"{name}.toml")
    changed = scenario.with_changes(problem=problem, target={"perigee_direction": direction})
    return plan(changed, solve=SOLVERS[solver])


@pytest.fixture(params=["orbsoc"])
def solver(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def apogee_km(found: Plan) -> float:
    assert found.verification is not None
    return found.verification.planned_orbit.apogee_height_m() / 1e3


@pytest.mark.parametrize("name", [REC1, REC2])
def test_shortest_burn_of_the_consistent_instances(solver: str, name: str) -> None:
    found = planned(solver, name, "min_time")
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == pytest.approx(56.570, abs=0.005)
    assert found.trajectory.grid.size == 12
    assert len(found.subproblems) <= 8


@pytest.mark.parametrize(("name", "time_s"), [(REC1, 56.570006), (REC2, 56.569981)])
def test_shortest_burn_agrees_with_the_indirect_solution_to_a_microsecond(
    solver: str, name: str, time_s: float
) -> None:
    assert planned(solver, name, "min_time").time_of_flight_s == pytest.approx(time_s, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "pitch_deg", "yaw_deg"),
    [(REC1, (-2.00, -1.95), (-11.02, -10.17)), (REC2, (-2.00, -1.96), (-10.76, -10.44))],
)
def test_attitude_ranges_of_the_shortest_burn(
    solver: str, name: str, pitch_deg: tuple[float, float], yaw_deg: tuple[float, float]
) -> None:
    found = planned(solver, name, "min_time").verification
    assert found is not None
    pitch, yaw = np.rad2deg(eq_21(found.flight.direction))
    assert (pitch.min(), pitch.max()) == pytest.approx(pitch_deg, abs=0.006)
    assert (yaw.min(), yaw.max()) == pytest.approx(yaw_deg, abs=0.006)


def eq_21(direction: np.ndarray) -> np.ndarray:
    """Pitch and yaw, written out again: atan2(u_y, u_x) and −asin(u_z)."""
    return np.stack([np.arctan2(direction[:, 1], direction[:, 0]), -np.arcsin(direction[:, 2])])


@pytest.mark.parametrize("name", [REC1, REC2])
def test_largest_orbit_with_the_perigee_direction_fixed(solver: str, name: str) -> None:
    found = planned(solver, name, "max_energy")
    assert found.status is PlanStatus.VERIFIED
    assert apogee_km(found) == pytest.approx(203.950, abs=0.02)
    assert found.verification is not None
    assert found.verification.planned_orbit.perigee_height_m() == pytest.approx(150e3, abs=0.1)
    assert found.time_of_flight_s == pytest.approx(63.0, abs=1e-12)


@pytest.mark.parametrize(("name", "apogee"), [(REC1, 349.28), (REC2, 358.18), (ZF196, 353.65)])
def test_largest_orbit_with_the_perigee_direction_free(solver: str, name: str, apogee: float) -> None:
    found = planned(solver, name, "max_energy", "free")
    assert found.status is PlanStatus.VERIFIED
    assert apogee_km(found) == pytest.approx(apogee, abs=0.05)
    assert found.verification is not None
    assert isinstance(found.target, LargestOrbit)
    assert found.target.perigee_error_m(found.verification.propagated_orbit) >= -0.1
    assert apogee_km(found) > apogee_km(planned(solver, name, "max_energy")) + 100.0


@pytest.mark.parametrize(
    ("problem", "direction"), [("min_time", "fixed"), ("max_energy", "fixed"), ("max_energy", "free")]
)
def test_rec1_flown_by_the_independent_integrator_ends_within_1e_9(
    solver: str, problem: str, direction: str
) -> None:
    found = planned(solver, REC1, problem, direction)
    assert found.trajectory.grid.size == 12
    assert found.verification is not None
    assert found.verification.angular_momentum_rel <= 1e-9
    assert found.verification.laplace_rel <= 1e-9
    assert found.verification.plane_rad <= 1e-9


def test_one_changed_z_digit_gives_85_217_seconds_and_206_322_km(solver: str) -> None:
    shortest = planned(solver, ZF196, "min_time")
    assert shortest.status is PlanStatus.VERIFIED
    assert shortest.time_of_flight_s == pytest.approx(85.217, abs=0.005)
    assert len(shortest.attempts[0].outcome.iterations) <= 9
    largest = planned(solver, ZF196, "max_energy")
    assert largest.status is PlanStatus.VERIFIED
    assert apogee_km(largest) == pytest.approx(206.322, abs=0.02)


def test_a_coarse_grid_that_over_promises_is_refined_until_the_propagation_confirms_it(solver: str) -> None:
    found = planned(solver, ZF196, "min_time")
    assert [stage.nodes for stage in found.attempts[:3]] == [12, 18, 27]
    # On 27 the thrust exceeds its bound by 0.98e-4 to 1.01e-4 between nodes, with every solver; 1e-4 is allowed.
    for stage in found.attempts[3:]:
        assert stage.nodes == 41
        assert "between nodes is 1.01e-04, allowed 1e-04" in stage.note
    assert all(stage.note.startswith("refined: ") for stage in found.attempts[1:])
    scenario = found.scenario.model_copy(
        update={"method": found.scenario.method.model_copy(update={"max_nodes": 12})}
    )
    on_twelve = plan(scenario, solve=SOLVERS[solver])
    assert on_twelve.status is PlanStatus.NOT_VERIFIED
    assert on_twelve.verification is not None
    assert on_twelve.verification.thrust_excess > 0.01
    assert "do not fly" in details(on_twelve)


def test_data_as_printed_need_93_379_seconds(solver: str) -> None:
    found = planned(solver, PRINTED, "min_time")
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == pytest.approx(93.379, abs=0.01)


def test_data_as_printed_are_not_found_at_63_seconds_in_words_with_the_worst_row(solver: str) -> None:
    found = planned(solver, PRINTED, "max_energy")
    assert found.status is PlanStatus.NOT_FOUND
    assert found.exit_reason is ExitReason.INFEASIBLE
    assert found.verification is None
    worst = violations(found)[0]
    assert worst.row is Row.LEAN_ACROSS
    assert abs(worst.value) == pytest.approx(5.4e-4, abs=0.05e-4)
    words = details(found)
    assert words.startswith("NOT FOUND: no burn of 63.000 s")
    assert "from 3 starts" in words
    assert "orbit plane tilted by 0.0304° about the line of apsides" in words
    assert "not a proof" in words


def test_free_perigee_restarts_once_with_slack_and_says_so(solver: str) -> None:
    found = planned(solver, PRINTED, "max_energy", "free")
    assert found.status is PlanStatus.NOT_FOUND
    assert [stage.outcome.reason for stage in found.attempts[:2]] == [
        ExitReason.SUBPROBLEM_INFEASIBLE,
        ExitReason.INFEASIBLE,
    ]
    assert found.attempts[1].note == "restart with slack: a subproblem was infeasible"
    assert "orbit plane" in details(found)


@pytest.mark.parametrize("name", [REC1, REC2, ZF196, PRINTED])
@pytest.mark.parametrize(
    ("problem", "direction"), [("min_time", "fixed"), ("max_energy", "fixed"), ("max_energy", "free")]
)
def test_clarabel_gives_the_same_plan(name: str, problem: str, direction: str) -> None:
    ours, theirs = (planned(solver, name, problem, direction) for solver in ("orbsoc", "clarabel"))
    compared = Agreement.of(ours, theirs)
    found = compared.to_dict()
    assert compared.ours == compared.theirs
    assert found["time_of_flight_rel"] <= 1e-7
    assert found["sma_rel"] <= 1e-7
    assert found["node_state"] <= 1e-6
    assert compared.agrees


def test_emulated_computer_plans_with_the_same_bits() -> None:
    from orbsoc import PsScheduler

    scheduled = plan(load_scenario(SCENARIOS / "rec1.toml"), solve=PsScheduler())
    native = planned("orbsoc", REC1, "min_time")
    assert len(scheduled.subproblems) == len(native.subproblems)
    for a, b in zip(scheduled.subproblems, native.subproblems, strict=True):
        assert np.array_equal(a.solution.x, b.solution.x)
        assert np.array_equal(a.solution.z, b.solution.z)


@pytest.mark.parametrize("nodes", [2, 3, 5, 8, 20, 40])
def test_any_number_of_nodes_plans_rec1(solver: str, nodes: int) -> None:
    scenario = load_scenario(SCENARIOS / "rec1.toml").with_changes(method={"nodes": nodes})
    found = plan(scenario, solve=SOLVERS[solver])
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == pytest.approx(56.570006, abs=5e-5)


@pytest.mark.parametrize("duration_s", [20.0, 40.0, 90.0, 200.0])
def test_shortest_burn_does_not_depend_on_the_first_guess(solver: str, duration_s: float) -> None:
    scenario = load_scenario(SCENARIOS / "rec1.toml")
    guess = scenario.burn.model_copy(update={"duration_s": duration_s})
    found = plan(scenario.model_copy(update={"burn": guess}), solve=SOLVERS[solver])
    assert found.time_of_flight_s == pytest.approx(56.570006, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "problem", "quantity", "expected"),
    [
        (REC1, "min_time", "shortest burn", "met by construction"),
        (ZF196, "min_time", "shortest burn", "not reproduced"),
        (PRINTED, "min_time", "shortest burn", "misprint"),
        (REC2, "max_energy", "apogee height", "met by construction"),
        (ZF196, "max_energy", "apogee height", "not reproduced"),
        (PRINTED, "max_energy", "apogee height", "misprint"),
        (REC1, "max_energy", "perigee height", "reproduced"),
    ],
)
def test_paper_table_says_what_each_data_set_is_worth(
    solver: str, name: str, problem: str, quantity: str, expected: str
) -> None:
    rows = {row.quantity: row for row in compare(planned(solver, name, problem))}
    assert rows[quantity].verdict == expected
    assert rows[quantity].reason


def test_paper_table_does_not_explain_other_data_with_the_papers_misprint(solver: str) -> None:
    scenario = load_scenario(SCENARIOS / "rec1.toml")
    relabelled = scenario.model_copy(update={"compare_with": "paper004_as_printed"})
    row = compare(plan(relabelled, solve=SOLVERS[solver]))[0]
    assert row.verdict == "other data"
    assert "93.379" in row.reason
