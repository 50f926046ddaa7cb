"""`orbsoc solve`, as a user and as another program meet it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import orbsoc
from orbsoc.commands.app import app
from orbsoc.solving.bundle import read_bundle
from tests.processes import started

COMMAND = [sys.executable, "-m", "orbsoc", "solve"]

SOLVABLE = orbsoc.Problem(
    P=[[2.0, 0.0], [0.0, 0.0]], c=[1.0, 1.0], A=[[1.0, 2.0]], b=[1.0], G=-np.eye(2), h=[0.0, 0.0],
    cones=orbsoc.Cones(l=2),
)  # fmt: skip
INFEASIBLE = orbsoc.Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=orbsoc.Cones(l=2))
UNBOUNDED = orbsoc.Problem(c=[-1.0], G=[[-1.0]], h=[0.0], cones=orbsoc.Cones(l=1))


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["solve", *map(str, arguments)])


def saved(problem: orbsoc.Problem, folder: Path) -> Path:
    path = folder / "problem.json"
    problem.save(path)
    return path


def test_a_solved_problem_exits_0_with_a_verdict_and_the_bits_of_orbsoc_solve(tmp_path: Path) -> None:
    result = invoke(saved(SOLVABLE, tmp_path), "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    assert lines[0] == repr(SOLVABLE)
    assert any(line.startswith("verified on the data of the file: primal ") for line in lines)
    assert lines[-1].startswith("SOLVED: ")
    assert lines[-2] == f"written to {tmp_path / 'out' / 'solution.json'}"
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["solution.json"]
    written, expected = orbsoc.Solution.load(tmp_path / "out" / "solution.json"), orbsoc.solve(SOLVABLE)
    assert all(getattr(written, name).tobytes() == getattr(expected, name).tobytes() for name in "xyzs")


def test_the_verified_residuals_are_the_referees(tmp_path: Path) -> None:
    result = invoke(saved(SOLVABLE, tmp_path), "--out", tmp_path, "--json")
    document = json.loads(result.stdout)
    verification = orbsoc.verify(SOLVABLE, orbsoc.Solution.load(tmp_path / "solution.json"))
    assert document["verification"] == {name: getattr(verification, name) for name in ("pres", "dres", "gap")}


def test_json_prints_solution_json_and_nothing_else_on_standard_output(tmp_path: Path) -> None:
    result = invoke(saved(SOLVABLE, tmp_path), "--out", tmp_path, "--json")
    assert json.loads(result.stdout) == json.loads((tmp_path / "solution.json").read_text())
    assert "SOLVED: " in result.stderr


def test_without_out_the_solution_goes_below_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert invoke(saved(SOLVABLE, tmp_path)).exit_code == 0
    assert (tmp_path / "out" / "problem" / "solution.json").is_file()


@pytest.mark.parametrize(
    ("problem", "options", "status"),
    [
        (INFEASIBLE, (), "PRIMAL_INFEASIBLE"),
        (UNBOUNDED, (), "DUAL_INFEASIBLE"),
        (SOLVABLE, ("--max-iterations", "2"), "MAX_ITERATIONS"),
        (SOLVABLE, ("--max-time-s", "1e-12"), "MAX_TIME"),
    ],
)
def test_an_unsolved_problem_exits_1_and_says_why(
    tmp_path: Path, problem: orbsoc.Problem, options: tuple[str, ...], status: str
) -> None:
    result = invoke(saved(problem, tmp_path), "--out", tmp_path / "out", *options)
    assert result.exit_code == 1, result.output
    verdict = result.stdout.splitlines()[-1]
    assert verdict.startswith(f"{status}: ")
    assert len(verdict) > len(status) + 12
    assert orbsoc.Solution.load(tmp_path / "out" / "solution.json").status.name == status
    if "INFEASIBLE" in status:
        assert "certified radius" in result.stdout


def test_tolerances_are_obeyed(tmp_path: Path) -> None:
    path = saved(SOLVABLE, tmp_path)
    iterations = []
    for tolerance in ("1e-3", "1e-10"):
        assert invoke(path, "--out", tmp_path, "--tol", tolerance).exit_code == 0
        iterations.append(orbsoc.Solution.load(tmp_path / "solution.json").iterations)
    assert iterations[0] < iterations[1]


def test_verbose_shows_each_iteration_on_standard_error(tmp_path: Path) -> None:
    command = [*COMMAND, saved(SOLVABLE, tmp_path), "--out", tmp_path, "--verbose", "--json"]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    iterations = json.loads(run.stdout)["iterations"]
    numbered = [line.split()[0] for line in run.stderr.splitlines() if line[:4].strip().isdigit()]
    assert numbered == [str(k) for k in range(1, iterations + 1)]


def test_verbose_without_a_standard_error_solves(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", None)
    assert orbsoc.solve(SOLVABLE, verbose=True).status is orbsoc.Status.SOLVED


def test_a_bundle_written_by_one_run_is_replayed_bit_for_bit_by_another(tmp_path: Path) -> None:
    path, bundle = saved(SOLVABLE, tmp_path), tmp_path / "bundle.json"
    options = ("--max-iterations", "3", "--tol", "1e-9")
    assert invoke(path, "--out", tmp_path / "first", *options, "--bundle", bundle).exit_code == 1
    assert invoke(bundle, "--out", tmp_path / "second").exit_code == 1
    first, second = (
        json.loads((tmp_path / run / "solution.json").read_text()) for run in ("first", "second")
    )
    for document in (first, second):
        del document["setup_s"], document["solve_s"]
    assert first == second
    assert read_bundle(bundle).settings == orbsoc.Settings(max_iterations=3, tol=1e-9)


def test_options_override_the_settings_of_a_bundle(tmp_path: Path) -> None:
    bundle = tmp_path / "bundle.json"
    orbsoc.solve(SOLVABLE, max_iterations=3, bundle=bundle)
    assert invoke(bundle, "--out", tmp_path, "--max-iterations", "50").exit_code == 0


BAD = [
    ("none.json", None, (), "none.json: No such file or directory"),
    ("p.json", "{", (), "p.json: the document is not JSON"),
    ("p.toml", "mission = 'a'", (), "`orbsoc plan` takes a scenario in TOML"),
    ("p.json", "[1]", (), "p.json: the document must be one JSON object"),
    ("p.json", "{}", (), "field `schema` is None; this command reads 'orbsoc.problem/1' and 'orbsoc.bundle/1'"),
    ("p.json", '{"schema": "orbsoc.problem/1", "n": 1, "p": 0, "m": 0, "c": [1, 2]}', (), "field `c` has 2"),
    ("p.json", '{"schema": "orbsoc.problem/1", "n": 1, "p": 0, "n": 2}', (), "p.json: field `n` is set twice"),
    ("p.json", '{"schema": "orbsoc.problem/1", "n": 1000000000000, "p": 0, "m": 0}', (), "field `c` has 0"),
    ("p.json", '{"schema": "orbsoc.bundle/1"}', (), "field `history` is None; it must be a list"),
    ("p.json", SOLVABLE, ("--tol", "-1"), "tol = -1.0 must be a positive number"),
    ("p.json", SOLVABLE, ("--tol", "nan"), "tol = nan must be a positive number"),
    ("p.json", SOLVABLE, ("--max-iterations", "0"), "max_iterations = 0 must be at least 1"),
    ("p.json", SOLVABLE, ("--bundle", "no/where.json"), "bundle = no/where.json: there is no folder no"),
    ("p.json", SOLVABLE, ("--out", "p.json"), "p.json: File exists"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "content", "options", "message"), BAD, ids=[row[3] for row in BAD])
@pytest.mark.parametrize("as_json", [False, True], ids=["words", "json"])
def test_bad_input_exits_2_names_its_cause_and_writes_nothing(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    content: str | orbsoc.Problem | None,
    options: tuple[str, ...],
    message: str,
    as_json: bool,
) -> None:
    monkeypatch.chdir(tmp_path)
    if isinstance(content, orbsoc.Problem):
        content.save(name)
    elif content is not None:
        Path(name).write_text(content)
    before = sorted(tmp_path.rglob("*"))
    result = invoke(name, *options, *(["--json"] if as_json else []))
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    if as_json:
        assert message in json.loads(result.stdout)["error"]
    assert sorted(tmp_path.rglob("*")) == before


def test_ctrl_c_exits_130_and_keeps_the_best_iterate(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    n, m = 420, 1260  # tens of milliseconds an iteration
    G = rng.normal(size=(m, n))
    problem = orbsoc.Problem(
        c=G.T @ -rng.uniform(0.1, 1.0, m), G=G, h=rng.uniform(0.1, 1.0, m), cones=orbsoc.Cones(l=m)
    )
    command = [*COMMAND, saved(problem, tmp_path), "--out", tmp_path, "--verbose"]
    with started(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as run:
        assert run.stderr is not None
        for line in run.stderr:
            if line.startswith("   1 "):
                run.send_signal(signal.SIGINT)
                break
        output, _ = run.communicate(timeout=60)
    assert run.returncode == 130
    assert output.splitlines()[-1].startswith("INTERRUPTED: ")
    solution = orbsoc.Solution.load(tmp_path / "solution.json")
    assert solution.status is orbsoc.Status.INTERRUPTED
    assert solution.iterations < 5
    assert np.isfinite(solution.x).all()
