"""`orbsoc.plan`: one call for a scenario in any form."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

import orbsoc
from orbsoc.guidance.scenario_file import ScenarioError

FILE = Path(__file__).parents[2] / "scenarios" / "rec1.toml"


def test_a_path_a_dict_and_a_scenario_give_one_plan() -> None:
    document = tomllib.loads(FILE.read_text(encoding="utf-8"))
    scenario = orbsoc.missions.reachable_insertion.Scenario.model_validate(document)
    runs = [orbsoc.plan(each, device="none") for each in (FILE, str(FILE), document, scenario)]
    assert len({str(run.verdict) for run in runs}) == 1
    assert len({repr(run.plan.subproblems[-1].solution.x.tobytes()) for run in runs}) == 1
    assert repr(runs[0]).startswith("PlanRun(VERIFIED: ")
    assert runs[0]._repr_html_().startswith("<table>")


def test_settings_override_keys_of_every_form() -> None:
    document = tomllib.loads(FILE.read_text(encoding="utf-8"))
    scenario = orbsoc.missions.reachable_insertion.Scenario.model_validate(document)
    settings = {"method.nodes": 9}
    for each in (FILE, document, scenario):
        run = orbsoc.plan(each, settings=settings, device="none")
        assert run.to_dict()["scenario"]["method"]["nodes"] == 9


def test_what_is_no_scenario_is_refused_by_name() -> None:
    with pytest.raises(TypeError, match="`scenario` is of type int; it must be a Scenario"):
        orbsoc.plan(3)  # type: ignore[arg-type]
    with pytest.raises(ScenarioError, match=r"scenario: `mission` = 'moon': no such mission; allowed: "):
        orbsoc.plan({"mission": "moon"})
