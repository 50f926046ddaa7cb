"""`orbsoc plan`, interrupted: 130 and no folder, or a complete one; and what ends before its body has begun."""

from __future__ import annotations

import contextlib
import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

import orbsoc.files.output_folder
import orbsoc.hw.cycle_budget
import orbsoc.solving.solver
from orbsoc.commands.app import app
from orbsoc.conic.settings import Settings
from orbsoc.ps.driver import Driver
from tests.processes import started

REC1 = Path(__file__).resolve().parents[2] / "scenarios" / "rec1.toml"
COMMAND = [sys.executable, "-m", "orbsoc"]


def invoke(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.parametrize("call", [1, 3])
def test_ctrl_c_inside_a_solve_exits_130_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int
) -> None:
    calls = 0

    def interrupted(problem: orbsoc.Problem, settings: Settings | None = None) -> orbsoc.Solution:
        nonlocal calls
        calls += 1
        if calls == call:
            raise KeyboardInterrupt
        return original(problem, settings)

    original = orbsoc.solving.solver.solve
    monkeypatch.setattr(orbsoc.solving.solver, "solve", interrupted)
    result = invoke("plan", REC1, "--out", tmp_path / "out")
    assert result.exit_code == 130
    assert "interrupted; nothing was written" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_sigint_while_planning_exits_130_and_leaves_nothing(tmp_path: Path) -> None:
    """A real signal to a real process, on a grid fine enough that planning is still going on."""
    scenario = tmp_path / "fine.toml"
    scenario.write_text(
        (REC1.parent / "paper004_insertion_zf196.toml")
        .read_text(encoding="utf-8")
        .replace("nodes = 12", "nodes = 90\nmax_nodes = 90"),
        encoding="utf-8",
    )
    command = [*COMMAND, "plan", str(scenario), "--verbose", "--out", str(tmp_path / "out")]
    with started(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("#=1")
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert "interrupted; nothing was written" in stderr
    assert "Traceback" not in stderr
    assert [path.name for path in tmp_path.iterdir()] == ["fine.toml"]


def signal_inside(monkeypatch: pytest.MonkeyPatch, call: int, *, heeded: bool) -> None:
    """Let SIGINT arrive in the `call`-th scheduled solve: at its start, or too late to be `heeded` by it."""
    run = Driver.run
    calls = 0

    def interrupted(driver: Driver, **arguments: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == call and heeded:
            signal.raise_signal(signal.SIGINT)
        run(driver, **arguments)
        if calls == call and not heeded:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Driver, "run", interrupted)


@pytest.mark.parametrize("heeded", [True, False])
@pytest.mark.parametrize("call", [1, 4])
def test_ctrl_c_while_the_budget_is_made_exits_130_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: int, heeded: bool
) -> None:
    """Scheduled solves serve the budget only: an interrupted one would shorten the modelled time."""
    signal_inside(monkeypatch, call, heeded=heeded)
    result = invoke("plan", REC1, "--verbose", "--json", "--out", tmp_path / "out")
    assert result.exit_code == 130
    assert json.loads(result.stdout)["exit_code"] == 130
    assert "#=4" in result.stderr  # planning was over
    assert "interrupted; nothing was written" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("heeded", [True, False])
def test_ctrl_c_while_planning_on_the_emulated_computer_exits_130_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, heeded: bool
) -> None:
    signal_inside(monkeypatch, 2, heeded=heeded)
    result = invoke("plan", REC1, "--ps", "--out", tmp_path / "out")
    assert result.exit_code == 130
    assert "interrupted; nothing was written" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("heeded", [True, False])
def test_ctrl_c_while_the_emulated_plan_is_solved_again_exits_130_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, heeded: bool
) -> None:
    def interrupted(problem: orbsoc.Problem, settings: Settings) -> orbsoc.Solution:
        if heeded:
            return original(problem, settings, callback=lambda _: signal.raise_signal(signal.SIGINT))
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        return original(problem, settings)

    original = orbsoc.solving.solver.solve
    monkeypatch.setattr(orbsoc.hw.cycle_budget, "solve", interrupted)
    result = invoke("plan", REC1, "--ps", "--out", tmp_path / "out")
    assert result.exit_code == 130
    assert "interrupted; nothing was written" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_after_the_folder_is_committed_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def moved(temporary: Path, folder: Path) -> None:
        signal.raise_signal(signal.SIGINT)
        move(temporary, folder)

    move = orbsoc.files.output_folder._move_into_place
    monkeypatch.setattr(orbsoc.files.output_folder, "_move_into_place", moved)
    result = invoke("plan", REC1, "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert (tmp_path / "out" / "plan.json").exists()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


MOMENTS = [
    "orbsoc.missions.reachable_insertion.planner",
    "hw_model.platform.data_file",
    "hw_model.timing.timeline",
    "matplotlib.figure",
]


@pytest.mark.parametrize("moment", MOMENTS)
def test_sigint_at_any_moment_exits_130_without_a_trace_or_a_folder(tmp_path: Path, moment: str) -> None:
    """A real signal to a real process, sent when the interpreter reports that it has imported a module."""
    program = [sys.executable, "-X", "importtime", "-m", "orbsoc"]
    command = [*program, "plan", str(REC1), "--json", "--out", str(tmp_path / "out")]
    with started(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if line.rstrip().endswith(f" {moment}"):
                process.send_signal(signal.SIGINT)
                break
        stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130, stderr
    assert json.loads(stdout)["exit_code"] == 130
    assert "orbsoc: interrupted" in stderr
    assert "Traceback" not in stderr
    assert list(tmp_path.iterdir()) == []


def test_sigint_inside_code_compiled_from_a_string_exits_130_too(tmp_path: Path) -> None:
    """As when a dataclass is being made: CPython then ends `python -m` by the signal, whatever caught the exception."""
    (tmp_path / "interrupted.py").write_text(
        "import orbsoc.commands.app\n"
        "def scenario(*arguments):\n"
        "    exec('import signal; signal.raise_signal(signal.SIGINT)')\n"
        "orbsoc.commands.plan._scenario = scenario\n"
        "orbsoc.commands.app.app(['plan', 'any.toml'])\n"
    )
    ended = subprocess.run(
        [sys.executable, "-m", "interrupted"], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 130
    assert ended.stderr == "orbsoc: interrupted; nothing was written\n"


def test_sigint_where_nothing_can_be_raised_exits_130_without_a_trace(tmp_path: Path) -> None:
    """As in a weak reference's callback: Python prints such an exception, and goes on."""
    (tmp_path / "interrupted.py").write_text(
        "import signal, weakref\n"
        "import orbsoc.commands.app\n"
        "load = orbsoc.commands.plan._scenario\n"
        "class Thing: pass\n"
        "def scenario(*arguments):\n"
        "    thing = Thing()\n"
        "    reference = weakref.ref(thing, lambda _: signal.raise_signal(signal.SIGINT))\n"
        "    del thing\n"
        "    return load(*arguments)\n"
        "orbsoc.commands.plan._scenario = scenario\n"
        f"orbsoc.commands.app.app(['plan', {str(REC1)!r}, '--out', 'out'])\n"
    )
    ended = subprocess.run(
        [sys.executable, "-m", "interrupted"], cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert ended.returncode == 130
    assert ended.stderr == "planning\norbsoc: interrupted; nothing was written\n"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([str(REC1), "--seed", "many"], "'--seed'"),
        ([str(REC1), "--velocity", "7"], "--velocity"),
        ([], "SCENARIO.toml"),
    ],
)
def test_arguments_that_do_not_parse_are_an_object_with_json(
    tmp_path: Path, arguments: list[str], words: str
) -> None:
    ended = subprocess.run(
        [*COMMAND, "plan", *arguments, "--json"], cwd=tmp_path, capture_output=True, text=True
    )
    assert ended.returncode == 2
    printed = json.loads(ended.stdout)
    assert printed["exit_code"] == 2
    assert words in printed["error"]
