"""Scenario files: what is accepted, and that every bad one is refused by key, value and what is allowed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
import orbsoc.missions
from orbsoc.guidance.scenario_file import checked, read_toml
from orbsoc.missions.reachable_insertion import PlanStatus, Scenario, ScenarioError, load_scenario, plan
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.orbit import eci_from_launch_inertial, rotate_state

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"
REC1 = (SCENARIOS / "rec1.toml").read_text(encoding="utf-8")


def edited(tmp_path: Path, old: str, new: str) -> Path:
    """rec1 with one piece of text replaced, as a file."""
    assert old in REC1
    path = tmp_path / "edited.toml"
    path.write_text(REC1.replace(old, new, 1), encoding="utf-8")
    return path


INSERTIONS = [
    path for path in sorted(SCENARIOS.glob("*.toml")) if 'mission = "reachable_insertion"' in path.read_text()
]


@pytest.mark.parametrize("path", INSERTIONS, ids=lambda path: path.stem)
def test_every_shipped_scenario_loads_and_is_named_like_its_file(path: Path) -> None:
    assert load_scenario(path).name == path.stem


THRUST = "thrust_n = 271239.0"
POSITION = "position_m = [3035550.5, 5829440.9, 161119.1]"
VELOCITY = "velocity_m_s = [6678.4965, -3601.7676, 607.0052]"

BAD = {
    "zero thrust": (THRUST, "thrust_n = 0.0", r"vehicle\.thrust_n = 0\.0: .*greater than 0"),
    "NaN": (THRUST, "thrust_n = nan", r"vehicle\.thrust_n = nan: .*finite"),
    "infinity": (THRUST, "thrust_n = inf", r"vehicle\.thrust_n = inf: .*finite"),
    "text for a number": (THRUST, 'thrust_n = "271239"', r"vehicle\.thrust_n = '271239': .*number"),
    "boolean for a number": (THRUST, "thrust_n = true", r"vehicle\.thrust_n = True: .*number"),
    "wrong unit in a key": (
        THRUST,
        "thrust_kn = 271.239",
        r"vehicle\.thrust_kn = 271\.239: unknown key; allowed here: dry_mass_kg, .*Did you mean thrust_n",
    ),
    "two numbers for a vector": (
        POSITION,
        "position_m = [1.0, 2.0]",
        r"initial\.position_m = \[1\.0, 2\.0\]: entry 3 is missing",
    ),
    "missing key": (THRUST, "", r"vehicle\.thrust_n: is missing"),
    "unknown table": ("[method]", "[methods]", r"methods = .*: unknown key; allowed here: axes, body, burn"),
    "unknown top key": ("axes =", "axis =", r"axis = 'launch_inertial': unknown key.*Did you mean axes"),
    "unknown problem": ('"min_time"', '"fastest"', r"problem = 'fastest': .*'min_time' or 'max_energy'"),
    "unknown mission": ('"reachable_insertion"', '"moon"', r"mission = 'moon': .*'reachable_insertion'"),
    "one node": ("nodes = 12", "nodes = 1", r"method\.nodes = 1: .*greater than or equal to 2"),
    "half a node": ("nodes = 12", "nodes = 12.5", r"method\.nodes = 12\.5: .*integer"),
    "no vector": (POSITION, "position_m = [1.0, 2.0]", r"initial\.position_m.*: "),
    "below the ground": (
        POSITION,
        "position_m = [3.0e6, 5.5e6, 1.6e5]",
        r"initial\.position_m = \[3000000\.0, .*below the ground; must be at least 6378137 m",
    ),
    "position in km": (
        POSITION,
        "position_m = [3035.5505, 5829.4409, 161.1191]",
        r"initial\.position_m = .*not km",
    ),
    "velocity in km/s": (
        VELOCITY,
        "velocity_m_s = [6.6784965, -3.6017676, 0.6070052]",
        r"initial\.velocity_m_s = .*100…50000 m/s \(m/s, not km/s\)",
    ),
    "falling straight down": (
        VELOCITY,
        "velocity_m_s = [-3035.5505, -5829.4409, -161.1191]",
        r"initial\.velocity_m_s = .*must not be parallel",
    ),
    "target below the ground": (
        "position_m = [3409639.2, 5613637.7, 195876.2]",
        "position_m = [3.0e6, 5.5e6, 1.9e5]",
        r"target\.position_m = .*below the ground",
    ),
    "perigee height in metres": (
        "perigee_height_km = 150.0",
        "perigee_height_km = 150000.0",
        r"target\.perigee_height_km = 150000\.0: .*less than or equal to 100000",
    ),
    "dry mass above mass": (
        "dry_mass_kg = 0.0",
        "dry_mass_kg = 90000.0",
        r"vehicle\.dry_mass_kg = 90000: must be below vehicle\.mass_kg = 84507",
    ),
    "impossible mass": (
        "dry_mass_kg = 0.0",
        "dry_mass_kg = 80664.0",
        r"burn\.duration_s = 63: leaves 80664 kg, not more than vehicle\.dry_mass_kg = 80664; must be below 63 s",
    ),
    "thrust of no launcher": (
        THRUST,
        "thrust_n = 1e300",
        r"vehicle\.thrust_n = 1e\+300: .*less than or equal to 1000000000",
    ),
    "mass of no launcher": (
        "mass_kg = 84507.0",
        "mass_kg = 8.4507e9",
        r"vehicle\.mass_kg = 8450700000\.0: .*less than or equal to 100000000",
    ),
    "no burn": ("duration_s = 63.0", "duration_s = 0.0", r"burn\.duration_s = 0\.0: .*greater than 0"),
    "latitude": (
        "geocentric_latitude_deg = 19.6140",
        "geocentric_latitude_deg = 196.14",
        r"launch_site\.geocentric_latitude_deg = 196\.14: .*less than or equal to 90",
    ),
    "coarsest finer than finest": (
        "nodes = 12",
        "nodes = 12\nmax_nodes = 8",
        r"method\.max_nodes = 8: must be at least method\.nodes = 12",
    ),
    "TOML syntax": ("[burn]", "[burn", r"file: not TOML: .*line"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_scenarios_are_refused_by_key_value_and_what_is_allowed(tmp_path: Path, case: str) -> None:
    old, new, words = BAD[case]
    path = edited(tmp_path, old, new)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert re.search(words, str(caught.value), re.DOTALL), str(caught.value)
    assert str(path) in str(caught.value)


def test_every_complaint_is_listed_not_only_the_first(tmp_path: Path) -> None:
    path = edited(tmp_path, THRUST, "thrust_n = -1.0\nthrust_kn = 2.0")
    with pytest.raises(ScenarioError) as caught:
        load_scenario(path)
    assert [complaint.key for complaint in caught.value.complaints] == [
        "vehicle.thrust_n",
        "vehicle.thrust_kn",
    ]


def test_missing_file_folder_and_binary_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="no such file"):
        load_scenario(tmp_path / "absent.toml")
    with pytest.raises(ScenarioError, match="cannot be read"):
        load_scenario(tmp_path)
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ScenarioError, match="UTF-8"):
        load_scenario(binary)


def test_max_energy_without_a_perigee_height_is_refused_and_min_time_is_not(tmp_path: Path) -> None:
    scenario = load_scenario(edited(tmp_path, "perigee_height_km = 150.0", "# none"))
    assert scenario.problem == "min_time"
    with pytest.raises(ScenarioError, match=r"target\.perigee_height_km.*max_energy"):
        scenario.with_changes(problem="max_energy")
    with pytest.raises(ScenarioError, match=r"target\.perigee_height_km"):
        plan(scenario, solve=orbsoc.solve, problem="max_energy")


def circular_target(tmp_path: Path) -> Path:
    radius = 6378137.0 + 200e3
    speed = (3.986004418e14 / radius) ** 0.5
    path = tmp_path / "circular.toml"
    text = REC1.replace(
        "position_m = [3409639.2, 5613637.7, 195876.2]", f"position_m = [{radius!r}, 0.0, 0.0]"
    ).replace("velocity_m_s = [6605.7957, -4060.5966, 626.9973]", f"velocity_m_s = [0.0, -{speed!r}, 0.0]")
    path.write_text(text, encoding="utf-8")
    return path


def test_fixed_perigee_direction_of_a_circular_target_is_refused_and_free_is_not(tmp_path: Path) -> None:
    scenario = load_scenario(circular_target(tmp_path))
    with pytest.raises(ScenarioError, match=r"target\.perigee_direction = 'fixed': .*circular"):
        scenario.with_changes(problem="max_energy")
    assert (
        scenario.with_changes(problem="max_energy", target={"perigee_direction": "free"}).problem
        == "max_energy"
    )


def test_target_out_of_reach_is_a_status_in_words_not_an_exception(tmp_path: Path) -> None:
    """The circular target lies 4.8° off the vehicle's plane, some 650 m/s; 155.9 s of propellant give 540 m/s."""
    path = circular_target(tmp_path)
    path.write_text(path.read_text().replace("dry_mass_kg = 0.0", "dry_mass_kg = 75000.0"))
    found = plan(load_scenario(path), solve=orbsoc.solve)
    assert found.status is PlanStatus.INFEASIBLE
    assert found.verification is None
    words = details(found)
    assert words.startswith("INFEASIBLE: no burn, however steered, reaches the target.")
    assert "takes more than 657.1 m/s, and the vehicle has 530.7 m/s" in words
    assert "This is a proof" in words


def test_a_sequence_that_does_not_converge_is_no_answer_rather_than_out_of_reach() -> None:
    scenario = load_scenario(SCENARIOS / "rec1.toml")
    short = scenario.with_changes(problem="max_energy", method={"max_iterations": 2})
    found = plan(short, solve=orbsoc.solve)
    assert found.status is PlanStatus.FAILED
    words = details(found)
    assert words.startswith("NO ANSWER: no convergence in 2 iterations")
    assert "not evidence that the target is out of reach" in words


def test_eci_input_is_the_same_scenario_as_launch_inertial_input(tmp_path: Path) -> None:
    given = load_scenario(SCENARIOS / "rec1.toml")
    rotation = eci_from_launch_inertial(given.launch_site.frame())

    def in_eci(state: Any) -> dict[str, list[float]]:
        turned = rotate_state(rotation, state.vector())
        return {"position_m": turned[:3].tolist(), "velocity_m_s": turned[3:].tolist()}

    document = given.model_dump()
    document["axes"] = "eci"
    document["initial"] |= in_eci(given.initial)
    document["target"] |= in_eci(given.target)
    turned = type(given).model_validate(document)
    np.testing.assert_allclose(turned.launch_inertial(turned.initial), given.initial.vector(), rtol=1e-12)
    found = plan(turned, solve=orbsoc.solve)
    assert found.time_of_flight_s == pytest.approx(56.570006, abs=1e-6)


IDLE = [
    ("min_time", "target.perigee_direction", "free"),
    ("min_time", "target.perigee_height_km", 100.0),
    ("min_time", "target.true_anomaly_deg", 40.0),
    ("max_energy", "target.true_anomaly_deg", 40.0),
]


@pytest.mark.parametrize(("problem", "key", "value"), IDLE)
def test_a_setting_that_would_change_nothing_is_refused_and_a_file_may_hold_it(
    problem: str, key: str, value: object
) -> None:
    settings = {"problem": problem, key: value}
    with pytest.raises(ScenarioError, match=rf"{re.escape(key)} = .*: changes nothing"):
        load_scenario(SCENARIOS / "rec1.toml", settings)
    table, name = key.split(".")
    asked = load_scenario(SCENARIOS / "rec1.toml", {"problem": problem})
    changed = asked.with_changes(**{table: {name: value}})
    assert plan(changed).time_of_flight_s == plan(asked).time_of_flight_s


def test_settings_that_the_other_problem_takes_are_obeyed_there() -> None:
    settings = {
        "problem": "max_energy",
        "target.perigee_direction": "free",
        "target.perigee_height_km": 140.0,
    }
    assert load_scenario(SCENARIOS / "rec1.toml", settings).target.perigee_height_km == 140.0


def test_missions_are_attributes_that_load_themselves() -> None:
    code = (
        "import orbsoc.missions, sys; before = 'pydantic' in sys.modules;"
        "plan = orbsoc.missions.reachable_insertion.plan; sys.exit(before or not callable(plan))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    with pytest.raises(AttributeError, match=r"missions: .*reachable_insertion"):
        _ = orbsoc.missions.reachable_moon


def test_current_plane_is_that_of_the_papers_table_2() -> None:
    found = plan(load_scenario(SCENARIOS / "paper004_insertion_zf196.toml"), solve=orbsoc.solve)
    assert found.verification is not None
    orbit = found.verification.planned_orbit
    assert np.rad2deg([orbit.inc_rad, orbit.raan_rad]) == pytest.approx([28.18, 335.36], abs=0.2)


def test_a_dry_mass_and_a_burn_time_that_are_left_out_are_assumed_and_said() -> None:
    document = read_toml(SCENARIOS / "deorbit.toml")
    del document["vehicle"]["dry_mass_kg"], document["burn"]["duration_s"]
    found = checked(Scenario, document, source="t")
    assert found.vehicle.dry_mass_kg == 100.0
    assert found.burn.duration_s == pytest.approx(290.0, rel=0.05)  # what the best ignition takes
    assert [each.split(" = ")[0] for each in found.assumptions] == [
        "vehicle.dry_mass_kg", "burn.duration_s",
    ]  # fmt: skip
    again = Scenario.model_validate_json(found.model_dump_json())
    assert (again, again.assumptions) == (found, found.assumptions)
    assert load_scenario(SCENARIOS / "deorbit.toml").assumptions == []


def test_a_burn_of_max_energy_is_given_its_time() -> None:
    document = read_toml(SCENARIOS / "rec1.toml")
    del document["burn"]["duration_s"]
    with pytest.raises(ScenarioError, match=r'burn.duration_s.*problem = "max_energy" needs it'):
        checked(Scenario, document | {"problem": "max_energy"}, source="t")


def test_frames_are_turned_into_each_other_and_one_alone_is_refused() -> None:
    document = read_toml(SCENARIOS / "orekit_apogee.toml")
    found = checked(Scenario, document, source="t")
    document["target"]["frame"] = "GCRF"
    turned = checked(Scenario, document, source="t")
    apart = np.linalg.norm((turned.launch_inertial(turned.target) - found.launch_inertial(found.target))[:3])
    assert 0.1 < apart < 10.0  # 23 milliarcseconds
    del document["initial"]["epoch_utc"], document["initial"]["frame"]
    with pytest.raises(ScenarioError, match=r"target.frame = 'GCRF': initial.frame is not given"):
        checked(Scenario, document, source="t")
