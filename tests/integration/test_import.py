"""What `import orbsoc` brings: nothing that a solve from arrays does not need."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("scipy", "pydantic", "typer", "rich", "matplotlib", "pyarrow", "hw_model.report")


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
