"""README and CONTRIBUTING say what is true: examples run, paths and targets exist, links lead somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from orbsoc.conic.problem import Cones, Problem

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TEXTS = {name: (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "CONTRIBUTING.md")}
EXAMPLES = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


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
        r"`((?:python|rust|hw_model|tests|docs|scripts|scenarios|requirements)/[\w./-]+\w)`", text
    )
    missing = [name for name in (*linked, *named) if not (ROOT / name).exists()]
    assert missing == []


def test_the_layout_lists_folders_that_exist() -> None:
    layout = re.search(r"## Layout\n\n```\n(.*?)```", README, flags=re.DOTALL)
    assert layout
    folders = [line.split()[0] for line in layout[1].splitlines()]
    assert [folder for folder in folders if not (ROOT / folder).is_dir()] == []


def test_the_scenarios_of_the_commands_exist() -> None:
    commands = re.findall(r"^orbsoc (?:plan|hw \w+) (\S+)", README, flags=re.MULTILINE)
    assert len(commands) == 7
    assert [name for name in commands if not (ROOT / name).is_file()] == []
    assert re.search(r"`(orbsoc plan [^`]*)`", README)[1] in (ROOT / "Makefile").read_text()
