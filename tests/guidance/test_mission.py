"""What makes a mission: one module that satisfies the protocol and one line in the registry, for every command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import orbsoc
import orbsoc.missions
from orbsoc.commands.app import app
from orbsoc.guidance.mission import DOCUMENT_KEYS, Dispersible, Mission, PlanStatus
from orbsoc.guidance.scenario_file import BaseScenario, ScenarioError, Table, checked
from orbsoc.missions import registry

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
REACH = SCENARIOS / "paper004_reach.toml"
TOY = 'mission = "toy"\nname = "push"\naxis = [3.0, 0.0, 4.0]\npart_m_s = 10.0\n'


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def toy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scenario of a mission that is registered by one line."""
    monkeypatch.setitem(registry.MODULES, "toy", "tests.guidance.toy_mission")
    path = tmp_path / "push.toml"
    path.write_text(TOY, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", registry.MISSIONS)
def test_every_registered_mission_satisfies_the_protocol(name: str) -> None:
    mission = registry.MISSIONS[name]
    assert isinstance(mission, Mission)
    assert issubclass(mission.Scenario, BaseScenario)
    assert mission.Scenario.model_fields["mission"].annotation.__args__ == (name,)  # type: ignore[union-attr]


def test_missions_are_shown_and_found_by_name() -> None:
    assert {*registry.MISSIONS} <= {*dir(orbsoc.missions)}
    assert orbsoc.missions.reachable_insertion is registry.MISSIONS["reachable_insertion"]
    assert "reachable_moon" not in registry.MISSIONS
    assert len(registry.MISSIONS) == len(list(registry.MISSIONS))


@pytest.mark.parametrize("path", sorted(SCENARIOS.glob("*.toml")), ids=lambda path: path.stem)
def test_every_shipped_scenario_is_read_by_its_mission_key(path: Path) -> None:
    mission, scenario = registry.load_scenario(path)
    assert isinstance(scenario, mission.Scenario)
    assert scenario.name == path.stem


def test_a_new_mission_is_planned_checked_priced_and_written(toy: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = invoke(
        "plan", toy, "--check", "clarabel", "--deadline-ms", 50, "--out", out, "--json", "--verbose"
    )
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert {*DOCUMENT_KEYS} <= {*document}
    assert document["verdict"][0]["figure"] == "2.000000 m/s"
    assert document["check"]["words"].startswith("velocity change differs by ")
    assert document["hardware"]["same_bits"]
    names = ["computer.png", "hardware.json", "impulses.csv", "plan.json", "report.html"]
    assert sorted(path.name for path in out.iterdir()) == names
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Mission <code>toy</code>" in page
    assert "Cycle budget" in page
    assert "change=0.0e+00" in result.stderr  # the live table


def test_any_key_of_a_new_mission_is_overridden(toy: Path, tmp_path: Path) -> None:
    arguments = ("--set", "part_m_s=5", "--set", "axis=[1.0, 0.0, 0.0]", "--device", "none", "--json")
    document = json.loads(invoke("plan", toy, *arguments, "--out", tmp_path / "out").stdout)
    assert document["verdict"][0]["figure"] == "5.000000 m/s"
    assert document["hardware"] is None


def test_a_python_user_runs_the_same_pipeline_in_one_line(toy: Path, tmp_path: Path) -> None:
    run = orbsoc.plan_file(
        toy, settings={"part_m_s": 15.0}, deadline_ms=50.0, check=True, out=tmp_path / "out"
    )
    assert run.plan.status is PlanStatus.VERIFIED
    assert run.succeeded
    assert run.budget is not None
    assert len(run.budget.report.solves) == len(run.plan.subproblems) == 1
    assert (tmp_path / "out" / "report.html").exists()


def test_a_new_mission_is_a_workload(toy: Path, tmp_path: Path) -> None:
    result = invoke(
        "hw",
        "partition",
        toy,
        "--device",
        "zu9eg",
        "--lanes",
        "2",
        "--clocks",
        "100",
        "--out",
        tmp_path / "out",
    )
    assert result.exit_code == 0, result.output
    assert "modelled: plan of push.toml (1 solve, " in result.stdout


def test_one_point_of_the_reachable_domain_is_a_workload(tmp_path: Path) -> None:
    result = invoke("hw", "budget", REACH, "--estimate", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "modelled: paper on zu9eg" in result.stdout


def test_a_new_mission_is_judged_over_dispersed_cases(toy: Path, tmp_path: Path) -> None:
    assert isinstance(registry.MISSIONS["toy"], Dispersible)
    result = invoke("plan", toy, "--cases", 3, "--deadline-ms", 50, "--out", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["verdict"] == "PASS"
    assert document["dispersion"]["sigma"] == {"axis": 0.01, "part": 0.1}


def test_a_new_mission_has_a_schema(toy: Path) -> None:
    schema = json.loads(invoke("schema", "toy").stdout)
    assert set(schema["required"]) == {"mission", "name", "axis", "part_m_s"}
    for alias, name in (("scenario", "reachable_insertion"), ("reach-scenario", "reachable_domain")):
        assert invoke("schema", alias).stdout == invoke("schema", name).stdout
    unknown = invoke("schema", "moon")
    assert unknown.exit_code == 2
    assert f"allowed: {', '.join(registry.MISSIONS)}, " in " ".join(unknown.stderr.split())


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--set", "part_m_s=-5"), "part_m_s = -5: Input should be greater than 0"),
        (("--set", "part_m_s=many"), "part_m_s = 'many': Input should be a valid number"),
        (("--set", "part=5"), "part = 5: unknown key; allowed here: axis, body, mission, name, part_m_s"),
        (("--set", "part_m_s"), "'part_m_s': must be KEY=VALUE, e.g. method.nodes=16"),
        (("--set", "part_m_s=1", "--set", "part_m_s=2"), "`part_m_s` was set to 1 before; set it once"),
        (("--set", "axis.x=1"), "axis = {'x': 1}: Input should be a valid tuple"),
        (("--problem", "any"), "problem = 'any': unknown key"),
        (("--problem", "a", "--set", "problem=b"), "would do nothing here: --problem sets `problem`"),
        (("--set", "mission=moon"), "`mission` = 'moon': no such mission; allowed: reachable_domain, "),
        (("--device", "none", "--deadline-ms", "5"), "no time to judge with --device none"),
    ],
)
def test_a_bad_override_names_key_value_and_what_is_allowed(
    toy: Path, tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    result = invoke("plan", toy, *arguments, "--out", tmp_path / "out")
    assert result.exit_code == 2, result.output
    assert says in result.stderr
    assert "Traceback" not in result.stderr
    assert not (tmp_path / "out").exists()


def test_a_scenario_of_another_mission_is_told_so() -> None:
    with pytest.raises(ScenarioError) as caught:
        orbsoc.missions.reachable_insertion.load_scenario(REACH)  # type: ignore[attr-defined]
    assert str(caught.value) == (
        f"{REACH}: mission = 'reachable_domain': a scenario of another mission; must be 'reachable_insertion'"
    )


def test_a_mission_without_dispersed_cases_says_what_to_use(tmp_path: Path) -> None:
    result = invoke("plan", REACH, "--cases", 2, "--deadline-ms", 50, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "this mission has no dispersed cases; missions with them: reachable_insertion, " in result.stderr


def test_an_unknown_key_of_an_optional_table_is_named() -> None:
    class Site(Table):
        latitude_deg: float

    class Scenario(BaseScenario):
        site: Site | None = None
        stops: tuple[Site, ...] = ()

    for change in ({"site": {"latitude": 1.0}}, {"stops": ({"latitude": 1.0},)}):
        with pytest.raises(
            ScenarioError, match=r"latitude = 1\.0: unknown key; allowed here: latitude_deg\. Did"
        ):
            checked(Scenario, {"mission": "any", "name": "any", **change}, source="here")


def test_a_paper_is_reproduced_by_number_or_mission(toy: Path, tmp_path: Path) -> None:
    name = "reachable_insertion"
    result = invoke("reproduce", name, "--scenarios", SCENARIOS, "--out", tmp_path / "out", "--json")
    assert result.exit_code == 0, result.output
    rows = json.loads(result.stdout)["missions"][name]
    found = {row["quantity"]: (row["paper"], row["ours"], row["tolerance"], row["verdict"]) for row in rows}
    expected = ("56.57 s", "56.570 s", "±0.005 s", "met by construction")
    assert found["rec1, min_time: shortest burn"] == expected
    assert found["paper004_insertion, max_energy: apogee height"][1] == "infeasible"
    assert "| quantity | source | paper | ours |" in (tmp_path / "out" / "reproduce.md").read_text()
    unknown = invoke("reproduce", "005", "--scenarios", SCENARIOS)
    assert unknown.exit_code == 2
    assert "no such mission; allowed: all, " in " ".join(unknown.stderr.split())
