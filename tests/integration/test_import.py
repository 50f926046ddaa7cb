"""What `import orbsoc` brings: nothing that a solve from arrays does not need."""

from __future__ import annotations

import subprocess
import sys

import pytest

OPTIONAL = ("pydantic", "typer", "rich", "matplotlib", "jinja2", "pyarrow")
HEAVY = ("scipy", "hw_model.report", *OPTIONAL)
WITHOUT = f"import sys; sys.modules.update(dict.fromkeys({OPTIONAL!r}))"
"""Makes an import of these fail as if they were not installed."""
PROBLEM = "orbsoc.Problem(c=[1.0, 2.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=orbsoc.Cones(l=2))"


def loaded(statement: str) -> list[str]:
    code = f"import sys; {statement}; print(*[name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout.split()


@pytest.mark.parametrize("statement", ["import orbsoc", "import orbsoc; orbsoc.Problem; orbsoc.PsScheduler"])
def test_the_package_is_imported_without_what_is_heavy(statement: str) -> None:
    assert loaded(statement) == []


def test_names_that_are_imported_late_are_there() -> None:
    names = "orbsoc.__version__, orbsoc.PsScheduler, orbsoc.plan_file, orbsoc.missions"
    assert "scipy" not in loaded("import orbsoc; orbsoc.__version__")
    assert loaded(f"import orbsoc; {names}; from orbsoc import *; PsScheduler")


def test_dir_names_what_is_meant_for_users() -> None:
    import orbsoc

    public = {name for name in dir(orbsoc) if not name.startswith("_")}
    lazy = {"CVXPY", "export_c", "missions", "plan", "plan_file", "reach"}
    assert public == {name for name in orbsoc.__all__ if not name.startswith("_")} | lazy
    assert set(dir(orbsoc.missions)) == {"MISSIONS", *orbsoc.missions.MISSIONS}
    for mission in orbsoc.missions.MISSIONS.values():
        assert {"plan", "Scenario"} <= set(dir(mission))
        assert all(hasattr(mission, name) and not name.startswith("_") for name in dir(mission))


def run(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)


def test_the_solver_needs_no_package_of_an_extra() -> None:
    solves = f"p = {PROBLEM}; print(orbsoc.solve(p).status.name, orbsoc.solve_batch(p, c=[[1.0, 2.0]]))"
    done = run(f"{WITHOUT}; import orbsoc; {solves}")
    assert done.stdout.startswith("SOLVED"), done.stderr


@pytest.mark.parametrize("command", ["plan", "hw", "solve", "--help"])
def test_a_command_without_the_extra_says_what_to_install(command: str) -> None:
    done = run(f"{WITHOUT}; from orbsoc.__main__ import main; main()", command)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "orbsoc: error: typer is not installed; pip install 'orbsoc[missions]'\n"


@pytest.mark.parametrize("name", ["missions.phasing", "plan_file", "reach.load"])
def test_what_needs_an_extra_names_it_in_python(name: str) -> None:
    done = run(f"{WITHOUT}; import orbsoc; orbsoc.{name}")
    assert "is not installed; pip install 'orbsoc[" in done.stderr.splitlines()[-1]
