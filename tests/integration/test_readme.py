"""README and CONTRIBUTING say what is true: examples run, paths and targets exist, links lead somewhere."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from typer.main import get_command
from typer.testing import CliRunner

from orbsoc.commands.app import app
from orbsoc.conic.problem import Cones, Problem
from tests.printed import shows

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TEXTS = {name: (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "CONTRIBUTING.md")}
EXAMPLES = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
SHELL = "".join(re.findall(r"```sh\n(.*?)```", README, flags=re.DOTALL))
COMMANDS = re.findall(r"^orbsoc (.*)", SHELL, flags=re.MULTILINE)


def test_the_first_screen_shows_a_result() -> None:
    assert "docs/figures/station-approach.png" in README[:400]
    assert len(README.splitlines()) <= 90


def test_there_is_an_example_for_each_of_the_two_python_audiences() -> None:
    assert len(EXAMPLES) == 2


@pytest.mark.parametrize("example", EXAMPLES, ids=["solver", "hardware"])
def test_an_example_runs_as_it_stands(
    example: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Problem(c=[1.0, 2.0], G=-np.eye(2), h=[0.0, 0.0], cones=Cones(l=2)).save("problem.json")
    exec(compile(example, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert printed.startswith(("SOLVED", "# Modelled cycle budget"))


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_every_make_target_named_exists(text: str) -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE))
    named = set(re.findall(r"(?:`|^)make ([a-z]+)", text, flags=re.MULTILINE))
    assert named
    assert named <= targets


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_every_file_named_or_linked_exists(text: str) -> None:
    linked = re.findall(r"\]\((?!http)([^)#]+)\)", text)
    named = re.findall(
        r"`((?:python|rust|hw_model|rtl|benchmarks|tests|docs|scripts|scenarios|requirements)/[\w./-]+\w)`",
        text,
    )
    missing = [name for name in (*linked, *named) if not (ROOT / name).exists()]
    assert missing == []


def test_the_layout_lists_folders_that_exist() -> None:
    layout = re.search(r"## Layout\n\n```\n(.*?)```", README, flags=re.DOTALL)
    assert layout
    folders = [line.split()[0] for line in layout[1].splitlines()]
    assert [folder for folder in folders if not (ROOT / folder).is_dir()] == []


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_is_accepted_with_its_options(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    words = shlex.split(command, comments=True)
    assert [word for word in words if word.startswith("scenarios/") and not Path(word).is_file()] == []
    command_of = get_command(app)
    while hasattr(command_of, "commands"):
        command_of = command_of.commands[words.pop(0)]
    command_of.make_context("orbsoc", words).close()


def test_make_demo_runs_the_command_shown() -> None:
    assert re.search(r"`(orbsoc plan [^`]*)`", README)[1] in (ROOT / "Makefile").read_text()


def test_the_benchmarks_are_those_of_the_generated_table() -> None:
    """`make bench` renews the table, and then this page must follow."""
    table = (ROOT / "docs" / "mission004-benchmark.md").read_text(encoding="utf-8")
    for peer in ("Clarabel", "ECOS", "QOCO"):
        ratio = re.search(rf"{peer} (\d+\.\d\d)", README)
        assert ratio
        assert f"| {peer} | 49 | {ratio[1]} (" in table


def test_the_verdict_shown_is_that_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    shown = re.search(r"```text\n(.*?)```", README, flags=re.DOTALL)
    assert shown
    arguments = [
        "plan",
        "scenarios/rec1.toml",
        "--deadline-ms",
        "50",
        "--no-report",
        "--out",
        str(tmp_path / "out"),
    ]
    printed = CliRunner().invoke(app, arguments).output.splitlines()
    for line in shown[1].splitlines():
        assert any(shows(line, other) for other in printed), line
