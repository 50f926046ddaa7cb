"""What a plan of two burns writes and says; that its attitude file flies; and what is refused."""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from typer.testing import CliRunner, Result

from orbsoc.commands.app import app
from orbsoc.guidance.mission import Agreement
from orbsoc.missions.reachable_insertion import (
    Plan,
    PlanStatus,
    Scenario,
    ScenarioError,
    TwoBurnPlan,
    load_scenario,
    plan,
)
from orbsoc.missions.reachable_insertion.plan import details as verdict_of_one_burn
from orbsoc.missions.reachable_insertion.record.attitude import turned
from orbsoc.missions.reachable_insertion.two_burns.verdict import verdict
from orbsoc.orbit import EARTH, elements_from_state

Array = NDArray[np.float64]
SCENARIOS = Path(__file__).resolve().parents[4] / "scenarios"
RAISE = SCENARIOS / "raise_two_burns.toml"


def scenario(**settings: Any) -> Scenario:
    return load_scenario(RAISE, settings)


def planned(**settings: Any) -> TwoBurnPlan:
    found = plan(scenario(**settings))
    assert isinstance(found, TwoBurnPlan)
    return found


@pytest.fixture(scope="module")
def raised() -> TwoBurnPlan:
    return planned(axes="eci")


def test_a_plan_says_what_each_burn_takes(raised: TwoBurnPlan) -> None:
    first, second = raised.burns
    vehicle = raised.scenario.vehicle
    assert raised.time_of_flight_s == pytest.approx(70.761, abs=0.001)
    assert raised.coast_s == pytest.approx(2896.5, abs=1.0)
    assert second.ignition_s == pytest.approx(first.ignition_s + first.duration_s + raised.coast_s)
    assert raised.total_time_s == pytest.approx(second.ignition_s + second.duration_s)
    assert first.propellant_kg + second.propellant_kg == pytest.approx(raised.propellant_kg)
    exhaust = vehicle.thrust_n / vehicle.mass_flow_kg_s
    last_kg = vehicle.mass_kg - raised.propellant_kg
    assert raised.delta_v_m_s == pytest.approx(exhaust * np.log(vehicle.mass_kg / last_kg))
    words = verdict(raised)
    assert words.startswith(
        "VERIFIED: the two shortest burns found onto the target orbit, 1000.00 × 1000.00 km, take 36.8"
    )
    assert "375.4 m/s" in words
    assert "kg of propellant" in words


def test_the_document_is_json_and_holds_both_burns(raised: TwoBurnPlan) -> None:
    document = json.loads(json.dumps(raised.to_dict(), allow_nan=False))
    assert len(document["burns"]) == len(document["trajectory"]["burns"]) == 2
    assert document["coast_s"] == raised.coast_s
    assert document["scenario"]["burn"]["count"] == 2
    assert document["verification"]["verified"]
    assert document["scp_iterations"] == len(document["subproblems"]) > 0
    assert document["orbit"]["perigee_height_km"] == pytest.approx(1000.0, abs=1e-6)
    assert Agreement.of(raised, raised).agrees
    assert "two burns" in repr(raised)


def test_the_attitude_file_flown_by_its_rows_ends_on_the_target_orbit(raised: TwoBurnPlan) -> None:
    """Linear between rows, thrust and its mass flow where the file says so: nothing of the planner is used."""
    rows = list(csv.DictReader(io.StringIO(raised.tables()["attitude.csv"])))
    assert list(rows[0]) == ["t_s", "ux_eci", "uy_eci", "uz_eci", "mass_kg", "rate_deg_s", "thrust_n"]
    table = np.array([[float(value) for value in row.values()] for row in rows])
    times, thrust = table[:, 0], table[:, 6]
    assert times[0] == 0.0
    assert (np.diff(times) > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(table[:, 1:4], axis=1), 1.0, atol=1e-9)
    burning = thrust > 0.0
    edges = np.flatnonzero(np.diff(burning.astype(int)))
    assert len(edges) == 2
    assert (table[~burning, 4] == table[edges[0], 4]).all()
    vehicle = raised.scenario.vehicle
    state = np.append(raised.scenario.initial.vector(), vehicle.mass_kg)

    def rate(t: float, x: Array, on: bool) -> Array:
        u = np.array([np.interp(t, times, table[:, k]) for k in (1, 2, 3)])
        pull = -EARTH.mu_m3_s2 * x[:3] / np.linalg.norm(x[:3]) ** 3
        push = on * vehicle.thrust_n / x[6] * u / np.linalg.norm(u)
        return np.concatenate([x[3:6], pull + push, [-on * vehicle.mass_flow_kg_s]])

    ends = [times[edges[0]], times[edges[1] + 1], times[-1]]
    for on, start, end in zip((True, False, True), (0.0, *ends), ends, strict=False):
        ran: Any = solve_ivp(
            rate, (start, end), state, method="DOP853", rtol=1e-10, atol=1e-9, args=(on,), max_step=30.0
        )
        state = ran.y[:, -1]
    reached = elements_from_state(state[:3], state[3:6])
    assert reached.perigee_height_m() == pytest.approx(1000e3, abs=5.0)
    assert reached.apogee_height_m() == pytest.approx(1000e3, abs=5.0)
    assert state[6] == pytest.approx(vehicle.mass_kg - raised.propellant_kg, abs=1e-6)


def test_between_the_burns_the_attitude_turns_on_a_great_circle() -> None:
    first, last = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.6, 0.8])
    found = turned(first, last, np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(found, [first, (first + last) / np.sqrt(2.0), last], atol=1e-15)
    opposite = turned(first, -first, np.linspace(0.0, 1.0, 5))
    np.testing.assert_allclose(np.linalg.norm(opposite, axis=1), 1.0)
    np.testing.assert_allclose(opposite[-1], -first, atol=1e-15)


def test_figures_are_written(raised: TwoBurnPlan, tmp_path: Path) -> None:
    files = raised.figures(tmp_path)
    assert [each.name for each in files] == ["space.png", "orbit.png", "history.png", "attitude.png"]
    assert all((tmp_path / each.name).stat().st_size > 10_000 for each in files)
    assert "<img" in raised._repr_html_()


def test_one_burn_that_fails_names_two_and_two_are_then_verified() -> None:
    one = plan(scenario(**{"burn.count": 1, "burn.duration_s": 60.0}))
    assert isinstance(one, Plan)
    assert one.status is PlanStatus.NOT_FOUND
    assert "--set burn.count=2" in verdict_of_one_burn(one)
    told = one.to_dict()["two_burns"]
    found = planned(**{"burn.duration_s": 60.0})
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s <= told["first_s"] + told["second_s"]


def test_one_burn_that_is_verified_names_no_other() -> None:
    found = plan(load_scenario(SCENARIOS / "rec1.toml"))
    assert found.to_dict()["two_burns"] is None
    assert "burn.count" not in found.to_dict()["details"]


def test_propellant_for_neither_is_a_proof_and_too_little_is_not_found() -> None:
    none = planned(**{"vehicle.dry_mass_kg": 990.0})
    assert none.status is PlanStatus.INFEASIBLE
    assert "any number of burns" in verdict(none)
    assert none.to_dict()["proof"]["needed_m_s"] > none.to_dict()["proof"]["available_m_s"]
    assert none.tables() == {}
    little = planned(**{"vehicle.dry_mass_kg": 888.0})
    assert little.status is PlanStatus.NOT_FOUND
    assert "the propellant lasts for 70.3 s" in verdict(little)
    enough = planned(**{"vehicle.dry_mass_kg": 887.0})
    assert enough.status is PlanStatus.VERIFIED


def test_limits_on_the_coast_are_kept_and_cost_propellant(raised: TwoBurnPlan) -> None:
    short = planned(**{"burn.longest_coast_s": 2500.0})
    assert short.status is PlanStatus.VERIFIED
    assert short.coast_s <= 2500.0 + 1e-6
    assert short.time_of_flight_s > raised.time_of_flight_s
    shorter = planned(**{"burn.longest_coast_s": 300.0})
    assert shorter.status is PlanStatus.NOT_FOUND
    assert "try" in verdict(shorter)


def test_a_vehicle_on_its_target_orbit_has_nothing_to_burn() -> None:
    found = plan(scenario(**{"target.sma_km": 6678.137, "target.ecc": 0.0}))
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s == 0.0


def test_free_elements_are_left_to_the_burns() -> None:
    found = plan(load_scenario(SCENARIOS / "turn_two_burns.toml"))
    assert isinstance(found, TwoBurnPlan)
    assert found.status is PlanStatus.VERIFIED
    assert found.orbit is not None
    assert np.rad2deg(found.orbit.inc_rad) == pytest.approx(55.0, abs=1e-6)
    assert found.orbit.sma_m == pytest.approx(7278137.0, abs=0.1)
    assert found.delta_v_m_s == pytest.approx(520.6, abs=0.2)


REFUSED = {
    "a coast between one burn": ({"burn.count": 1, "burn.duration_s": 9.0, "burn.longest_coast_s": 9.0}, "burn.longest_coast_s"),
    "three burns": ({"burn.count": 3}, "burn.count"),
    "an ignition that is not free": ({"burn.latest_ignition_s": 9.0}, "burn.latest_ignition_s"),
}  # fmt: skip


@pytest.mark.parametrize(("settings", "words"), REFUSED.values(), ids=REFUSED)
def test_what_says_nothing_is_refused_by_name(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words.replace(".", r"\.")):
        scenario(**settings)


def test_two_burns_are_for_the_shortest_time_alone() -> None:
    with pytest.raises(ScenarioError, match=r"burn\.count = 2: problem = 'max_energy' has one burn"):
        load_scenario(SCENARIOS / "rec1.toml", {"problem": "max_energy", "burn.count": 2})


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_the_command_plans_prices_and_reports(tmp_path: Path) -> None:
    found = invoke("plan", RAISE, "--out", tmp_path / "raise", "--check", "clarabel")
    assert found.exit_code == 0, found.output
    assert re.search("^Check +AGREES +clarabel: ", found.output, re.MULTILINE)
    names = sorted(path.name for path in (tmp_path / "raise").iterdir())
    assert names == [
        "attitude.csv",
        "attitude.png",
        "computer.png",
        "hardware.json",
        "history.png",
        "orbit.oem",
        "orbit.opm",
        "orbit.png",
        "plan.json",
        "report.html",
        "space.png",
    ]
    page = (tmp_path / "raise" / "report.html").read_text(encoding="utf-8")
    assert "two burns" in page
    assert "Burn 2" in page
    assert "None" not in page


def test_dispersed_cases_are_planned_and_judged(tmp_path: Path) -> None:
    found = invoke("plan", RAISE, "--cases", "2", "--deadline-ms", "500", "--out", tmp_path / "cases")
    assert found.exit_code == 0, found.output
    assert "0 without a verified plan" in found.output
