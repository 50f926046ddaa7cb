"""Every command that a page names can be given as it stands: the parser takes it, its files are there, its scenario keys are known.

Tutorials, how-to pages and the front page are run (test_pages.py). The other pages have commands that take minutes or need a
tool; here they are read as the command line reads them, and nothing is computed. Their Python runs, on a small problem; docs/solver.md
has a test of its own (tests/integration/test_solver_guide.py).
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer
from typer.exceptions import TyperException
from typer.main import get_command

import orbsoc
from hw_model import load_platform
from orbsoc.commands.app import app
from orbsoc.commands.hw_options import parsed_settings
from orbsoc.missions.registry import load_scenario

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"])
FENCE = re.compile(r"^```(?:sh)?\n(.*?)^```$", re.DOTALL | re.MULTILINE)
COMMANDS = get_command(app)
REFUSED = {"orbsoc plan my_burn.toml --set vehicle.mass_kg=-3"}
"""Shown because it is refused."""
PLACEHOLDER = re.compile(r"(?:^|(?<==))[A-Z]$")
"""A letter in place of a value."""
INLINE = re.compile(r"`(orbsoc [^`]+)`")


def commands_of(text: str) -> list[str]:
    """Commands `orbsoc …` in blocks and in sentences, without what is said of them."""
    found = []
    for block in FENCE.findall(text):
        joined = block.replace("\\\n", " ")
        found += [
            re.split(r"\s+#|\s{2,}|\s+\|\|?\s|\s+&&\s", line)[0]
            for line in joined.splitlines()
            if line.startswith("orbsoc ")
        ]
    prose = FENCE.sub("", text)
    return [*found, *(" ".join(each.split()) for each in INLINE.findall(prose))]


def split(command: str) -> tuple[list[str], Any, list[str]]:
    """The path to the command that a line names, the command, and the words after it."""
    words = [PLACEHOLDER.sub("4", word.strip("[]")) for word in shlex.split(command)[1:]]
    current: Any = COMMANDS
    path = ["orbsoc"]
    while words and words[0] in getattr(current, "commands", ()):
        path.append(words.pop(0))
        current = current.commands[path[-1]]
    return path, current, words


def is_complete(command: str) -> bool:
    """Whether a command has all that it needs, rather than being named."""
    path, current, words = split(command)
    try:
        return bool(words) and bool(current.make_context(path[-1], words))
    except (TyperException, typer.Exit):
        return False


def refusal(command: str) -> str:
    """Why the command line would not take a command; empty where it would."""
    path, current, words = split(command)
    if "…" in command or not words:
        return ""
    if hasattr(current, "commands"):
        return "" if words[0].startswith("-") else f"{' '.join([*path, words[0]])}: no such command"
    try:
        context = current.make_context(path[-1], list(words), resilient_parsing=False)
    except typer.Exit:
        return ""  # --help
    except TyperException as error:
        is_named_only = type(error).__name__ == "MissingParameter" or "requires an argument" in str(error)
        return "" if is_named_only else str(error)
    return what_is_wrong(path[1:], context.params)


def what_is_wrong(path: list[str], given: dict[str, Any]) -> str:
    """Of the scenario or device that a command names, and of the keys that it sets."""
    named = next((Path(str(given[name])) for name in ("scenario", "workload") if given.get(name)), Path())
    settings = parsed_settings(given.get("settings"), example="")
    try:
        if named.parts[:1] == ("scenarios",):
            if not (ROOT / named).exists():
                return f"there is no {named}"
            if named.suffix == ".toml":
                load_scenario(ROOT / named, {} if path[0] == "hw" else settings)
        if path[0] == "hw" and settings:
            load_platform(given.get("device") or "zu9eg").with_values(settings)
    except ValueError as error:
        return str(error)
    return ""


CASES = [
    (page, command)
    for page in PAGES
    for command in dict.fromkeys(commands_of(page.read_text(encoding="utf-8")))
]


@pytest.mark.parametrize(
    "page", dict.fromkeys(page for page, _ in CASES), ids=lambda page: str(page.relative_to(ROOT))
)
def test_the_command_line_would_take_every_command(page: Path) -> None:
    refused = {command: refusal(command) for place, command in CASES if place == page}
    assert not {command: why for command, why in refused.items() if why and command not in REFUSED}


def test_all_guides_with_commands_are_found() -> None:
    assert len(CASES) > 120
    assert len([command for _, command in CASES if "scenarios/" in command]) > 60


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ("orbsoc plam scenarios/rec1.toml", "no such command"),
        ("orbsoc plan scenarios/rec1.toml --deadlin-ms 50", "No such option"),
        ("orbsoc plan scenarios/rec1.toml --deadline-ms soon", "should be a valid number"),
        ("orbsoc plan scenarios/rec9.toml", "there is no"),
        ("orbsoc plan scenarios/rec1.toml --set burn.ignitoin=free", "ignitoin"),
        ("orbsoc plan scenarios/rec1.toml --set burn.ignition=sometimes", "sometimes"),
        ("orbsoc hw run scenarios/rec1.toml --set pl.lames=4", "pl.lames"),
    ],
)
def test_a_command_that_is_wrong_is_refused(command: str, why: str) -> None:
    assert why in refusal(command)


PYTHON = re.compile(r"^```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
GUIDES = {
    page.name: PYTHON.findall(page.read_text(encoding="utf-8"))
    for page in sorted((ROOT / "docs").glob("*.md"))
}
ELSEWHERE = {
    "solver.md": "has a test of its own",
    "solver-in-the-page.md": "needs the browser's problem",
    "reach.md": "needs a domain: minutes",
}


@pytest.mark.parametrize(
    "guide", [name for name, blocks in GUIDES.items() if blocks and name not in ELSEWHERE]
)
def test_the_python_of_a_guide_runs(guide: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a rendezvous of twelve impulses, which the names `problem`, `scheduler` and `trace` of the pages are of."""
    monkeypatch.chdir(tmp_path)
    problem = orbsoc.Problem.load(ROOT / "scenarios" / "rendezvous_lp.json")
    problem.save("problem.json")
    scheduler = orbsoc.PsScheduler()
    scheduler(problem)
    names: dict[str, Any] = {"problem": problem, "scheduler": scheduler, "trace": scheduler.trace}
    for block in GUIDES[guide]:
        exec(compile(block, guide, "exec"), names)
