"""`orbsoc plan` and `orbsoc schema`, as a user and as another program meet them."""

from __future__ import annotations

import json
import os
import pty
import re
import select
import subprocess
import sys
import time
import tomllib
from html.parser import HTMLParser
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

import orbsoc.interfaces.clarabel
import orbsoc.report.run
from orbsoc.commands.app import app
from orbsoc.conic.settings import Settings
from orbsoc.guidance.verdict import WIDTH
from orbsoc.missions import reachable_insertion
from orbsoc.report.run import report_page
from tests.processes import started

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "scenarios"
REC1 = SCENARIOS / "rec1.toml"
COMMAND = [sys.executable, "-m", "orbsoc"]


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def rec1(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("cli") / "rec1"
    arguments = ("--out", folder, "--deadline-ms", "50", "--check", "clarabel")
    return folder, invoke("plan", REC1, *arguments)


def test_plan_writes_a_complete_folder_and_exits_0(rec1: tuple[Path, Result]) -> None:
    folder, result = rec1
    assert result.exit_code == 0, result.output
    expected = [
        "attitude.csv", "attitude.png", "computer.png", "hardware.json", "history.png", "orbit.oem", "orbit.opm", "orbit.png",
        "plan.json", "position.png",
        "report.html", "space.png",
        "velocity.png",
    ]  # fmt: skip
    assert sorted(path.name for path in folder.iterdir()) == expected
    document = json.loads((folder / "plan.json").read_text())
    assert document["schema"] == "orbsoc.plan/1"
    assert document["files"] == expected
    assert document["status"] == "verified"
    assert document["time_of_flight_s"] == pytest.approx(56.570006, abs=1e-6)


def test_plan_prints_the_verdict_a_line_a_question_and_the_folder(rec1: tuple[Path, Result]) -> None:
    folder, result = rec1
    *lines, last = result.stdout.strip().splitlines()
    assert [line.split()[0] for line in lines] == [
        "Answer", "Optimum", "Check", "Deadline", "Computer",
    ]  # fmt: skip
    assert re.match(r"Answer +VERIFIED +", lines[0])
    assert re.match(r"Check +AGREES +clarabel: .* differs by ", lines[2])
    assert re.match(r"Deadline +(PASS|MARGINAL|FAIL) +worst [0-9.e+]+, nominal ", lines[3])
    assert re.match(r"Computer +MODELLED +zu9eg, partition paper: ", lines[4])
    assert max(map(len, lines)) <= WIDTH
    assert last == f"written to {folder}"
    assert result.stderr == "planning\n"
    assert "\x1b" not in result.output


def test_every_iteration_is_a_line_if_asked_for(tmp_path: Path) -> None:
    result = invoke("plan", REC1, "--verbose", "--device", "none", "--no-report", "--out", tmp_path / "out")
    iterations = [line for line in result.stdout.splitlines() if line.startswith("#=")]
    document = json.loads((tmp_path / "out" / "plan.json").read_text())
    assert len(iterations) == document["scp_iterations"]
    assert f"burn s={document['time_of_flight_s']:.6f} " in iterations[-1]
    assert "tolerance=1e-10 " in iterations[-1]


def test_hardware_is_modelled_says_so_and_summarises_hardware_json(rec1: tuple[Path, Result]) -> None:
    folder, _ = rec1
    summary = json.loads((folder / "plan.json").read_text())["hardware"]
    full = json.loads((folder / "hardware.json").read_text())
    assert summary["provenance"] == "modelled"
    assert summary.keys() >= {"device", "partition", "cycles", "time_ms", "speedup", "verdict"}
    assert summary["time_ms"] == full["makespan_ms"]["nominal"]
    assert summary["cycles"] == full["cycles"]
    assert summary["verdict"] in ("PASS", "FAIL", "MARGINAL")
    assert full["same_bits"] is True
    document = json.loads((folder / "plan.json").read_text())
    assert len(full["solves"]) == len(document["subproblems"])
    assert [row["iterations"] for row in full["solves"]] == [
        row["iterations"] for row in document["subproblems"]
    ]


class Page(HTMLParser):
    """Text, images and references of a page; raises when elements do not nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.sources: list[str] = []
        self.headings: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)
        self.text += data


def test_report_is_self_contained_and_puts_the_verdict_first(rec1: tuple[Path, Result]) -> None:
    folder, _ = rec1
    source = (folder / "report.html").read_text(encoding="utf-8")
    page = Page(source)
    assert len(page.sources) == 7
    assert all(reference.startswith("data:image/png;base64,") for reference in page.sources)
    assert "<script" not in source
    assert "url(" not in source
    assert page.headings == [
        "Plan", "Verification", "Convergence", "Paper and ours", "Cycle budget", "Assumptions",
    ]  # fmt: skip
    assert page.text.index("VERIFIED") < page.text.index("planned")
    document = json.loads((folder / "plan.json").read_text())
    figures = [line["figure"] for line in document["verdict"]]
    for words in (*figures, document["check"]["words"], document["paper"][0]["reason"]):
        assert words in page.text
    assert "modelled" in page.text
    assert "None" not in page.text


def test_target_not_found_exits_1_with_words_a_report_and_no_attitude(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    arguments = ("--problem", "max_energy", "--deadline-ms", "1e6", "--out", folder)
    result = invoke("plan", SCENARIOS / "paper004_insertion.toml", *arguments)
    assert result.exit_code == 1
    assert re.search("^Answer +NOT FOUND +", result.stdout, re.MULTILINE)
    assert re.search("^Deadline +NOT JUDGED +", result.stdout, re.MULTILINE)
    assert sorted(path.name for path in folder.iterdir()) == [
        "computer.png", "hardware.json", "plan.json", "report.html",
    ]  # fmt: skip
    page = Page((folder / "report.html").read_text(encoding="utf-8"))
    assert "What could not be met" in page.headings
    assert "misprint" in page.text
    hardware = json.loads((folder / "plan.json").read_text())["hardware"]
    assert hardware["verdict"] is None
    assert hardware["deadline"].startswith("no deadline verdict: there is no verified plan")
    assert "No deadline verdict: there is no verified plan" in page.text


TARGET_POSITION = "position_m = [3409639.2, 5613637.7, 195876.2]"
TARGET_VELOCITY = "velocity_m_s = [6605.7957, -4060.5966, 626.9973]"
DRY_MASS = {"dry_mass_kg = 0.0": "dry_mass_kg = 60000.0"}
"""1.5 km/s; a vehicle that may burn itself up reaches the circular orbit."""
OUT_OF_REACH = {
    "other side of the Earth": {TARGET_POSITION: "position_m = [3409639.2, -5613637.7, 195876.2]"},
    "beyond escape speed": {TARGET_VELOCITY: "velocity_m_s = [16605.7957, -4060.5966, 626.9973]"},
    "circular": {
        TARGET_POSITION: "position_m = [6578137.0, 0.0, 0.0]",
        TARGET_VELOCITY: "velocity_m_s = [0.0, 7784.2613, 0.0]",
    },
}


@pytest.mark.parametrize("problem", ["min_time", "max_energy"])
@pytest.mark.parametrize("case", OUT_OF_REACH)
def test_target_out_of_reach_ends_in_words_a_report_and_one_object(
    tmp_path: Path, case: str, problem: str
) -> None:
    text = REC1.read_text(encoding="utf-8")
    for old, new in (OUT_OF_REACH[case] | DRY_MASS).items():
        assert old in text
        text = text.replace(old, new)
    path = tmp_path / "far.toml"
    path.write_text(text, encoding="utf-8")
    result = invoke("plan", path, "--problem", problem, "--json", "--out", tmp_path / "out")
    assert result.exit_code == 1, result.output
    assert "Traceback" not in result.stderr
    printed = json.loads(result.stdout)
    assert printed["status"] in ("infeasible", "not_found", "failed")
    answer = printed["verdict"][0]
    assert answer["word"] in ("INFEASIBLE", "NOT FOUND", "NO ANSWER")
    assert answer["figure"] in " ".join(result.stderr.split())  # a long line is continued
    page = Page((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert answer["word"] in page.text
    assert "None" not in page.text


def test_report_puts_a_dash_for_every_number_the_document_leaves_out(rec1: tuple[Path, Result]) -> None:
    """A hyperbola has no apogee, an iteration that failed has no orbit: null in plan.json."""
    folder, _ = rec1
    document = json.loads((folder / "plan.json").read_text())
    hardware = json.loads((folder / "hardware.json").read_text())
    for orbit in (document["orbit"], document["propagated_orbit"]):
        orbit.update(dict.fromkeys(orbit))
    for table in ("verification", "terminal_error"):
        document[table].update(dict.fromkeys(document[table]))
    document["time_of_flight_s"] = document["propellant_kg"] = None
    for key in ("time_of_flight_s", "perigee_height_km", "apogee_height_km", "change", "slack"):
        document["subproblems"][-1][key] = None
    for key in ("nodes", "time_of_flight_s", "perigee_height_km", "apogee_height_km"):
        del document["subproblems"][0][key]
    tables = {"attitude.csv": "t_s,pitch_deg"}
    page = Page(report_page(reachable_insertion, document, hardware, tables, (), folder))
    assert "apogee height (km)–––" in page.text.replace("\n", "")
    assert "None" not in page.text


def test_a_defect_is_one_object_too_and_leaves_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise RuntimeError("the chip is on fire")

    monkeypatch.setattr(orbsoc.report.run, "report_page", broken)
    result = invoke("plan", REC1, "--json", "--out", tmp_path / "out")
    assert result.exit_code == 1
    printed = json.loads(result.stdout)
    assert printed["exit_code"] == 1
    assert "a defect of orbsoc" in printed["error"]
    assert "RuntimeError: the chip is on fire" in printed["error"]
    assert "Traceback" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_json_is_one_object_on_stdout_and_progress_goes_to_stderr(tmp_path: Path) -> None:
    result = invoke("plan", REC1, "--problem", "max_energy", "--json", "--out", tmp_path / "out")
    assert result.exit_code == 0
    printed = json.loads(result.stdout)
    written = json.loads((tmp_path / "out" / "plan.json").read_text())
    assert printed == {key: value for key, value in written.items() if key not in ("schema", "files")}
    assert "VERIFIED" in result.stderr


def test_emulated_computer_writes_the_same_plan(rec1: tuple[Path, Result], tmp_path: Path) -> None:
    result = invoke("plan", REC1, "--ps", "--out", tmp_path / "ps")
    assert result.exit_code == 0, result.output
    native, scheduled = (
        json.loads((folder / "plan.json").read_text()) for folder in (rec1[0], tmp_path / "ps")
    )
    assert scheduled["solver"] == "orbsoc on the emulated PS+PL computer"
    assert scheduled["trajectory"] == native["trajectory"]
    assert scheduled["hardware"]["same_bits"] is True
    assert scheduled["hardware"]["time_ms"] == native["hardware"]["time_ms"]


def test_overrides_reach_the_plan(tmp_path: Path) -> None:
    result = invoke(
        "plan", REC1, "--problem", "max_energy", "--set", "target.perigee_direction=free", "--set", "method.nodes=9",
        "--device", "xc7z045", "--partition", "factor_only", "--json", "--out", tmp_path / "out",
    )  # fmt: skip
    document = json.loads(result.stdout)
    assert document["nodes"] == 9
    assert document["orbit"]["apogee_height_km"] == pytest.approx(349.28, abs=0.05)
    assert document["hardware"]["device"] == "xc7z045"
    assert document["hardware"]["partition"] == "factor_only"


def test_a_missed_deadline_ends_with_1_as_the_help_says(tmp_path: Path) -> None:
    result = invoke("plan", REC1, "--deadline-ms", "1e-3", "--out", tmp_path / "out")
    assert result.exit_code == 1
    assert re.search("^Answer +VERIFIED ", result.stdout, re.MULTILINE)
    assert re.search("^Deadline +FAIL ", result.stdout, re.MULTILINE)
    assert "a deadline missed" in " ".join(invoke("plan", "--help").stdout.split())


def test_default_output_folder_is_named_after_scenario_and_problem(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert invoke("plan", REC1).exit_code == 0
    assert (tmp_path / "out" / "rec1-min_time" / "report.html").exists()


BAD_ARGUMENTS = {
    "missing file": (["absent.toml"], r"absent\.toml: file: no such file"),
    "one node": ([REC1, "--set", "method.nodes=1"], r"method\.nodes = 1: .*greater than or equal to 2"),
    "unknown device": ([REC1, "--device", "moon"], r"'moon' is not known; known: .*zu9eg"),
    "unknown partition": ([REC1, "--partition", "none"], r"'none' is not known; known: .*paper"),
    "negative deadline": ([REC1, "--deadline-ms", "-1"], r"--deadline-ms = -1\.0: must be a positive number"),
    "NaN deadline": ([REC1, "--deadline-ms", "nan"], r"--deadline-ms = nan: must be a positive number"),
    "unknown problem": ([REC1, "--problem", "fastest"], r"min_time"),
    "unknown check": ([REC1, "--check", "ecos"], r"clarabel"),
}


@pytest.mark.parametrize("case", BAD_ARGUMENTS)
def test_bad_input_exits_2_names_it_and_writes_nothing(tmp_path: Path, case: str) -> None:
    arguments, words = BAD_ARGUMENTS[case]
    result = invoke("plan", *arguments, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert re.search(words, result.stderr), result.stderr
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("thrust_n = 271239.0", "thrust_kn = 271.239", "vehicle.thrust_kn"),
        ("thrust_n = 271239.0", "thrust_n = 0.0", "vehicle.thrust_n"),
        ("dry_mass_kg = 0.0", "dry_mass_kg = 84000.0", "burn.duration_s"),
        ("[burn]", "[burn", "not TOML"),
    ],
)
def test_bad_scenario_exits_2_and_is_an_object_with_json(
    tmp_path: Path, old: str, new: str, key: str
) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(REC1.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    result = invoke("plan", path, "--json", "--out", tmp_path / "out")
    assert result.exit_code == 2
    printed = json.loads(result.stdout)
    assert printed["exit_code"] == 2
    assert key in printed["error"]
    assert not (tmp_path / "out").exists()


def test_burn_that_cannot_be_integrated_exits_1_in_words_and_writes_nothing(tmp_path: Path) -> None:
    """An allowed thrust on a vehicle as light as nothing: 1e209 m/s²."""
    text = REC1.read_text(encoding="utf-8").replace("thrust_n = 271239.0", "thrust_n = 1e9")
    text = text.replace("mass_kg = 84507.0", "mass_kg = 1e-200").replace("= 61.0", "= 1e-203")
    path = tmp_path / "feather.toml"
    path.write_text(text, encoding="utf-8")
    result = invoke("plan", path, "--json", "--out", tmp_path / "out")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["error"].startswith(
        "no plan: the burn cannot be flown: propagation stopped"
    )
    assert "Traceback" not in result.stderr
    assert not (tmp_path / "out").exists()


def test_folder_with_foreign_files_is_refused_before_planning(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    result = invoke("plan", REC1, "--out", tmp_path)
    assert result.exit_code == 2
    assert "thesis.tex, which orbsoc did not write" in result.stderr
    assert "#=1" not in result.output
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_check_that_disagrees_exits_1_and_says_by_how_much(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second solver is given to understand that 1e-3 is good enough."""
    exact = orbsoc.interfaces.clarabel.solve
    monkeypatch.setattr(
        orbsoc.interfaces.clarabel,
        "solve",
        lambda problem, _settings=None: exact(problem, Settings(tol=1e-3, tol_inaccurate=1e-2)),
    )
    result = invoke("plan", REC1, "--check", "clarabel", "--out", tmp_path / "out")
    assert result.exit_code == 1
    assert re.search("^Check +DISAGREES +clarabel: ", result.stdout, re.MULTILINE)


def test_terminal_gets_a_live_table(tmp_path: Path) -> None:
    leader, follower = pty.openpty()
    command = [*COMMAND, "plan", str(REC1), "--verbose", "--out", str(tmp_path / "out")]
    environment = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "140"}
    with started(command, stdout=follower, stderr=follower, env=environment) as process:
        os.close(follower)
        shown, deadline = b"", time.monotonic() + 60
        while time.monotonic() < deadline:
            ready, _, _ = select.select([leader], [], [], 0.2)
            try:
                chunk = os.read(leader, 65536) if ready else b""
            except OSError:  # Linux: the other end is closed
                break
            if ready and not chunk:
                break
            shown += chunk
        os.close(leader)
        assert process.wait(timeout=60) == 0
    text = shown.decode()
    assert "\x1b[" in text  # redrawn in place
    assert "#=1" not in text
    assert re.search(r"#\s+nodes\s+burn s\s+perigee km", re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text))


def test_module_and_command_are_the_same_program() -> None:
    shown = subprocess.run([*COMMAND, "--help"], capture_output=True, text=True, check=True)
    assert shown.stdout.startswith("Usage: orbsoc [OPTIONS] COMMAND")
    assert "plan" in shown.stdout


def test_schema_without_a_name_lists_what_there_is() -> None:
    result = invoke("schema")
    names = [line.split()[0] for line in result.stdout.splitlines()]
    assert (result.exit_code, names) == (0, list(orbsoc.missions.MISSIONS))
    for name in result.stdout.replace(",", " ").split():
        assert invoke("schema", name).exit_code == 0


def test_schema_of_a_scenario_accepts_what_it_describes() -> None:
    result = invoke("schema", "scenario")
    assert result.exit_code == 0
    schema = json.loads(result.stdout)
    assert schema["additionalProperties"] is False
    assert set(schema["required"]) == {
        "mission", "name", "problem", "vehicle", "initial", "target",
    }  # fmt: skip
    assert schema["$defs"]["Vehicle"]["properties"]["thrust_n"]["exclusiveMinimum"] == 0.0


def test_schema_of_a_reach_scenario_accepts_the_papers() -> None:
    result = invoke("schema", "reach-scenario")
    assert result.exit_code == 0
    schema = json.loads(result.stdout)
    document = tomllib.loads((SCENARIOS / "paper004_reach.toml").read_text(encoding="utf-8"))
    assert set(schema["required"]) <= set(document) <= set(schema["properties"])
    assert set(schema["$defs"]["Grid"]["required"]) == set(document["grid"])
    assert schema["$defs"]["Method"]["properties"]["nodes"]["default"] == 12


def test_a_plan_that_the_engine_does_not_hold_is_written_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from orbsoc.hw import cycle_budget
    from orbsoc.hw.schedules import EngineTooSmallError

    def too_small(*_: object, **__: object) -> None:
        raise EngineTooSmallError("`microcode_words`: 2 words are needed, the engine's memory holds 1")

    monkeypatch.setattr(cycle_budget, "cycle_budget", too_small)
    result = CliRunner().invoke(
        app, ["plan", str(ROOT / "scenarios" / "rec1.toml"), "--out", str(tmp_path / "a")]
    )
    assert result.exit_code == 0, result.output
    assert "Computer DOES NOT FIT zu9eg is not priced; `microcode_words`: 2 words" in result.output
    hardware = json.loads((tmp_path / "a" / "plan.json").read_text())["hardware"]
    assert hardware["fits"] is False
    assert "2 words are needed" in hardware["headline"]
    assert not (tmp_path / "a" / "hardware.json").exists()
