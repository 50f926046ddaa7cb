"""The scenarios that come with orbsoc, by name: in a source tree `scenarios/`, in a wheel the same files beside this package."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[1] / "scenarios"


def scenario_folder(here: Path = HERE) -> Path:
    """Where the files are; `here` is a folder, a link to one, or, checked out without links, a file that names one.

    Raises FileNotFoundError where they were left out.
    """
    named = here.parent / here.read_text(encoding="utf-8").strip() if here.is_file() else here
    if named.is_dir():
        return named.resolve()
    raise FileNotFoundError(f"{here}: the shipped scenarios are not there; must be a folder, or name one")


@dataclass(frozen=True, slots=True)
class ShippedScenario:
    """A scenario file: its name, its mission, and the first sentence of its comment."""

    name: str
    mission: str
    about: str
    path: Path

    def document(self) -> dict[str, Any]:
        """Its tables, as they stand in the file."""
        return tomllib.loads(self.path.read_text(encoding="utf-8"))


@cache
def shipped_scenarios() -> Mapping[str, ShippedScenario]:
    """All of them, by name."""
    return {path.stem: _read(path) for path in sorted(scenario_folder().glob("*.toml"))}


def _read(path: Path) -> ShippedScenario:
    text = path.read_text(encoding="utf-8")
    comment = takewhile(lambda line: line.startswith("#") and line.strip("# "), text.splitlines())
    about = re.split(r"(?<=[a-z0-9)])\. ", " ".join(line.strip("# ") for line in comment))[0].rstrip(".")
    return ShippedScenario(path.stem, str(tomllib.loads(text)["mission"]), about, path)
