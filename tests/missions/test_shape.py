"""Every mission has one shape: its files have known names, its packages say what they own, imports run one way."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

MISSIONS = Path(__file__).resolve().parents[2] / "python" / "orbsoc" / "missions"
NAMES = sorted(path.parent.name for path in MISSIONS.glob("*/__init__.py"))
LEVELS = {
    "scenario": 0,
    "model": 0,
    "targets": 0,
    "tuning": 0,
    "starts": 1,
    "search": 1,
    "verification": 1,
    "dispersion": 2,
    "planner": 3,
    "on_board": 3,
    "flight": 4,
    "outer_loop": 4,
    "paper": 4,
    "figures": 4,
    "record": 5,
    "two_burns": 5,
    "plan": 6,
}
"""Names of files and packages, and how high they stand: none imports from above itself. A search may fly what it finds."""
OWN = {"reachable_insertion": {"targets", "starts", "tuning", "two_burns", "on_board", "outer_loop"}}
"""Names that one mission alone has."""


def imports(mission: str) -> dict[str, set[str]]:
    """Of each file or package directly in a mission's folder, the others that it imports."""
    folder = MISSIONS / mission
    found: dict[str, set[str]] = {}
    for path in folder.rglob("*.py"):
        place = path.relative_to(folder)
        name = place.parts[0].removesuffix(".py")
        if name == "__init__":
            continue
        found.setdefault(name, set())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ImportFrom):
                continue
            parts = tuple((node.module or "").split(".")) if node.module else ()
            if node.level:
                here = place.parent.parts
                parts = here[: len(here) - node.level + 1] + parts
            elif parts[:3] == ("orbsoc", "missions", mission):
                parts = parts[3:]
            else:
                continue
            targets = [parts[0]] if parts else [alias.name for alias in node.names]
            found[name] |= set(targets) - {name}
    return found


def test_the_missions_are_found_with_their_imports() -> None:
    assert len(NAMES) >= 6
    assert all("model" in imports(name)["planner"] | imports(name)["search"] for name in NAMES)


@pytest.mark.parametrize("mission", NAMES)
def test_a_mission_has_files_and_packages_of_known_names_alone(mission: str) -> None:
    known = (set(LEVELS) - OWN["reachable_insertion"]) | OWN.get(mission, set())
    files = [path for path in (MISSIONS / mission).iterdir() if path.name != "__pycache__"]
    names = {path.name for path in files} - {"__init__.py", "report.html.j2"}
    assert {name.removesuffix(".py") for name in names} <= known
    assert {"scenario", "model", "planner"} <= {name.removesuffix(".py") for name in names}


@pytest.mark.parametrize("mission", NAMES)
def test_a_package_says_what_it_owns(mission: str) -> None:
    for path in (MISSIONS / mission).rglob("__init__.py"):
        assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))), path


@pytest.mark.parametrize("mission", NAMES)
def test_imports_within_a_mission_run_one_way(mission: str) -> None:
    found = imports(mission)
    tuple(TopologicalSorter(found).static_order())  # raises CycleError
    upward = [(a, b) for a, others in found.items() for b in others if LEVELS[a] < LEVELS[b]]
    assert not upward
