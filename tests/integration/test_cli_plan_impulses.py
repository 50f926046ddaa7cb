"""`orbsoc plan SCENARIO --impulses FILE.csv`: a programme made elsewhere is judged by the scenario's mission."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import orbsoc
from orbsoc.commands.app import app

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
APPROACH = SCENARIOS / "paper000_1.toml"
HEADER = "time_s,dv_r_m_s,dv_t_m_s,dv_n_m_s\n"


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plan") / "out"
    run = orbsoc.plan_file(APPROACH, out=folder, device="none")
    assert run.succeeded
    return folder


def test_a_plan_judged_again_has_the_same_verdict(planned: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = invoke("plan", APPROACH, "--impulses", planned / "impulses.csv", "--out", out, "--json")
    assert result.exit_code == 0, result.output
    document, before = json.loads(result.stdout), json.loads((planned / "plan.json").read_text())
    known = ("Answer", "Safety")  # what a programme costs at the least is known of a plan alone
    for verdict in (document["verdict"], before["verdict"]):
        verdict[:] = [line for line in verdict if line["question"] in known]
    assert len(document["verdict"]) == len(known)
    assert document["verdict"] == before["verdict"]
    assert document["hardware"] is None
    assert document["subproblems"] == []
    assert (out / "impulses.csv").read_text() == (planned / "impulses.csv").read_text()
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "impulses as given, nothing was solved" in page
    assert "Cycle budget" not in page


def test_a_programme_that_breaks_a_condition_ends_with_1(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text(HEADER + "0,-0.2,0,0\n1800,0.1,0.05,0\n")
    result = invoke("plan", APPROACH, "--impulses", tmp_path / "mine.csv", "--out", tmp_path / "out")
    assert result.exit_code == 1
    assert "Answer   NOT VERIFIED capture is broken by" in result.output
    assert "Safety   NOT SAFE" in result.output


@pytest.mark.parametrize(
    ("text", "options", "says"),
    [
        ("t,x\n", (), "the first line is t,x; it must be time_s,dv_r_m_s,dv_t_m_s,dv_n_m_s"),
        (HEADER + "0,nan,0,0\n", (), "mine.csv, line 2, dv_r_m_s = 'nan': must be a finite number"),
        (HEADER + "9000,0.1,0,0\n", (), "impulses, time_s = 9000: must lie within 0 and duration_s = 3600"),
        (HEADER + "0,0.1,0,0\n", ("--check", "clarabel"), "--check would do nothing here"),
        (HEADER + "0,0.1,0,0\n", ("--ps",), "--ps would do nothing here: with --impulses nothing is solved"),
        (HEADER + "0,0.1,0,0\n", ("--cases", "3"), "--impulses judges one programme, and --cases plans many"),
    ],
)
def test_bad_input_is_told(text: str, options: tuple[str, ...], says: str, tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text(text)
    result = invoke(
        "plan", APPROACH, "--impulses", tmp_path / "mine.csv", *options, "--out", tmp_path / "out"
    )
    assert result.exit_code == 2, result.output
    assert says in " ".join(result.output.split())
    assert not (tmp_path / "out").exists()


def test_a_mission_that_judges_none_says_which_do(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text(HEADER + "0,0.1,0,0\n")
    result = invoke(
        "plan", SCENARIOS / "rec1.toml", "--impulses", tmp_path / "mine.csv", "--out", tmp_path / "out"
    )
    assert result.exit_code == 2
    assert (
        "this mission judges no impulses made elsewhere; missions with them: passive_safety" in result.output
    )
