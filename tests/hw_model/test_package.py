"""The package as a whole: what it offers, and what importing and reporting must not drag in."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import hw_model

HEAVY = ("matplotlib", "numpy", "scipy", "orbsoc")


def _loaded_after(statement: str) -> set[str]:
    code = f"import sys\n{statement}\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    paths = [str(Path(hw_model.__file__).parents[1])]
    found = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = {paths!r}\n{code}"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    return set(found.stdout.split())


def test_importing_the_package_loads_nothing_heavy() -> None:
    assert not _loaded_after("import hw_model") & {*HEAVY, "pydantic"}


def test_using_the_model_loads_neither_solver_nor_plots() -> None:
    assert not _loaded_after("from hw_model import speedup, simulate, load_platform, load_partition") & set(
        HEAVY
    )


def test_every_public_name_is_there() -> None:
    for name in hw_model.__all__:
        assert getattr(hw_model, name).__module__.startswith("hw_model.")
    with pytest.raises(AttributeError, match="no attribute 'sped'"):
        hw_model.sped  # noqa: B018
