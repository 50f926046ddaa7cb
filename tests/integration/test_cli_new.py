"""`orbsoc new` and `orbsoc list`: a scenario of one's own at the first try, and every name there is."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from hw_model import load_partition, load_platform
from orbsoc.commands.app import app
from orbsoc.commands.list_names import KINDS
from orbsoc.guidance.presets import presets
from orbsoc.guidance.scenario_file import checked, table_of
from orbsoc.guidance.shipped import scenario_folder, shipped_scenarios
from orbsoc.missions.registry import EXAMPLES, MISSIONS

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def _empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def written(mission: str, like: str) -> str:
    result = invoke("new", mission, "--like", like, "--out", "own.toml")
    assert result.exit_code == 0, result.output
    return Path("own.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("mission", MISSIONS)
def test_a_fresh_scenario_of_every_mission_is_planned_as_it_is(mission: str) -> None:
    result = invoke("new", mission)
    assert result.exit_code == 0, result.output
    assert f"next: orbsoc plan {mission}.toml" in result.stdout
    planned = invoke("plan", f"{mission}.toml", "--no-report", "--device", "none", "--json")
    answer = json.loads(planned.stdout)["verdict"][0]
    assert (answer["question"], answer["word"]) == ("Answer", "VERIFIED"), planned.output


@pytest.mark.parametrize("name", shipped_scenarios())
def test_a_scenario_like_a_shipped_one_says_the_same_and_documents_every_key(name: str) -> None:
    shipped = shipped_scenarios()[name]
    model = MISSIONS[shipped.mission].Scenario
    text = written(shipped.mission, name)
    own = checked(model, tomllib.loads(text), source=name).model_dump()
    theirs = checked(model, shipped.document(), source=name).model_dump()
    for document in (own, theirs):
        document.pop("name")
        document.pop("compare_with", None)
    assert own == theirs
    lines = [line.removeprefix("# ") for line in text.splitlines()]
    for key in model.model_fields:
        assert any(line.startswith((f"{key} = ", f"[{key}]")) for line in lines), key
    assert max(map(len, text.splitlines())) <= 130


def defaults(text: str) -> Iterator[tuple[str, str, Any]]:
    """Table, key and value of each default that stands behind a #, of the tables that are given."""
    table: str | None = ""
    for line in text.splitlines():
        if line.removeprefix("# ").startswith("["):
            table = None if line.startswith("#") else line[1:].partition("]")[0]
        elif table is not None and (found := re.match(r"# (\w+) = ([^?].*)", line)):
            yield table, found[1], tomllib.loads(f"value = {found[2]}")["value"]


@pytest.mark.parametrize("mission", MISSIONS)
def test_a_default_behind_a_number_sign_is_the_one_that_holds(mission: str) -> None:
    text = written(mission, EXAMPLES[mission])
    scenario = checked(MISSIONS[mission].Scenario, tomllib.loads(text), source=mission)
    document = json.loads(scenario.model_dump_json())
    found = list(defaults(text))
    assert len(found) >= 3
    for table, key, value in found:
        here = document
        for name in filter(None, (table or "").split(".")):
            here = here[name]
        assert here[key] == value, f"{table}.{key}"


def test_a_scenario_that_exists_stays_as_it_is() -> None:
    Path("phasing.toml").write_text("mine", encoding="utf-8")
    assert invoke("new", "phasing").exit_code == 2
    assert Path("phasing.toml").read_text(encoding="utf-8") == "mine"


def test_shipped_scenarios_are_the_files_of_the_source_tree() -> None:
    assert {path.stem for path in (ROOT / "scenarios").glob("*.toml")} == set(shipped_scenarios())
    assert set(EXAMPLES) == set(MISSIONS)


def test_shipped_scenarios_are_found_without_links_and_their_absence_is_told(tmp_path: Path) -> None:
    (tmp_path / "python" / "orbsoc").mkdir(parents=True)
    (tmp_path / "scenarios").mkdir()
    here = tmp_path / "python" / "orbsoc" / "scenarios"
    with pytest.raises(FileNotFoundError, match="the shipped scenarios are not there"):
        scenario_folder(here)
    here.write_text("../../scenarios", encoding="utf-8")  # what git writes where links are not allowed
    assert scenario_folder(here) == (tmp_path / "scenarios").resolve()


def test_list_names_all_that_commands_take() -> None:
    found = json.loads(invoke("list", "--json").stdout)
    assert list(found) == list(KINDS)
    assert set(found["missions"]) == set(MISSIONS)
    assert set(found["scenarios"]) == set(shipped_scenarios())
    for device in found["devices"]:
        assert load_platform(device).name == device
    for partition in found["partitions"]:
        load_partition(partition)
    assert all(about for names in found.values() for about in names.values())


def test_list_of_one_kind_has_a_line_a_name() -> None:
    lines = invoke("list", "vehicles").stdout.splitlines()
    assert [line.split()[0] for line in lines[1:]] == list(presets("vehicle"))
    assert all("[" in line for line in lines[1:])


def test_every_preset_has_a_source_and_keys_of_its_table() -> None:
    model = MISSIONS["reachable_insertion"].Scenario
    vehicle = table_of(model, "vehicle")
    assert vehicle is not None
    for preset in presets("vehicle").values():
        assert set(preset) - {"what", "source"} <= set(vehicle.model_fields)
    assert all(each["source"] for kind in ("vehicle", "site") for each in presets(kind).values())


def test_a_vehicle_by_preset_is_that_of_its_numbers_and_own_keys_win() -> None:
    model = MISSIONS["reachable_insertion"].Scenario
    document = shipped_scenarios()["rec1"].document()
    vehicle = {"preset": "li2025_insertion", "mass_kg": 80000.0, "isp_s": 300.0}
    found: Any = checked(model, document | {"vehicle": vehicle}, source="rec1")
    assert found.vehicle.preset is None
    assert (found.vehicle.mass_kg, found.vehicle.thrust_n) == (80000.0, 271239.0)
    assert found.vehicle.mass_flow_kg_s == pytest.approx(271239.0 / (9.80665 * 300.0), rel=1e-15)
    again = checked(model, found.model_dump(), source="again")
    assert again == found


def test_a_launch_site_by_preset_has_its_geocentric_latitude() -> None:
    model = MISSIONS["reachable_insertion"].Scenario
    document = shipped_scenarios()["rec1"].document()
    site = {"preset": "baikonur", "azimuth_deg": 63.0}
    found: Any = checked(model, document | {"launch_site": site}, source="rec1")
    # the normal of the ellipsoid leads 0.1924 degrees past the radius at 45 degrees, where it is most (WGS 84)
    assert 45.965 - found.launch_site.geocentric_latitude_deg == pytest.approx(0.1923, abs=2e-4)
    assert found.launch_site.inertial_longitude_deg == 63.305
