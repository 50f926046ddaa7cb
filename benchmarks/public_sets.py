"""Folders of problems: the public sets with their index, or any folder of `orbsoc.problem/1` files."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

from orbsoc.conic.problem import Cones, Problem

sparse: Any = _scipy_sparse  # published without types

INDEX = "index.json"
EXPECTED = {
    "optimal": "SOLVED",
    "primal_infeasible": "PRIMAL_INFEASIBLE",
    "dual_infeasible": "DUAL_INFEASIBLE",
}
"""Answers that an index knows, as statuses."""


@dataclass(frozen=True, slots=True)
class Listed:
    """One problem of a folder; `expected` is SOLVED, PRIMAL_INFEASIBLE or empty when it is not known."""

    path: str
    set: str
    name: str
    expected: str

    @property
    def key(self) -> str:
        return f"{self.set}/{self.name}"


def listed(folder: Path) -> list[Listed]:
    """The problems of a folder: those of its index, or else every .json file.

    Raises FileNotFoundError when there is none, ValueError for an answer that is not known here.
    """
    index = folder / INDEX
    if not index.is_file():
        files = sorted(folder.glob("*.json"))
        if not files:
            raise FileNotFoundError(f"{folder} has neither {INDEX} nor orbsoc.problem/1 files")
        return [Listed(str(file), folder.name, file.stem, "") for file in files]
    found: list[Listed] = []
    for entry in json.loads(index.read_text(encoding="utf-8")):
        if entry["expect"] not in EXPECTED:
            raise ValueError(
                f"{INDEX}: {entry['name']} expects {entry['expect']!r}; known are {list(EXPECTED)}"
            )
        path = str(folder / entry["file"])
        found.append(Listed(path, entry["set"], entry["name"], EXPECTED[entry["expect"]]))
    return found


def load(path: Path) -> Problem:
    """A problem file: `.json` as `Problem.save` writes it, or `.npz` with the matrices' CSC arrays (P's upper triangle)."""
    if path.suffix == ".json":
        return Problem.load(path)
    with np.load(path) as file:
        data = {name: file[name] for name in file.files}
    c, b, h = data["c"], data["b"], data["h"]

    def matrix(name: str, rows: int) -> Any:
        arrays = tuple(data[f"{name}_{part}"] for part in ("data", "indices", "indptr"))
        return sparse.csc_array(arrays, shape=(rows, c.size))

    cones = Cones(l=int(data["l"]), q=[int(q) for q in data["q"]])
    return Problem.from_upper(
        matrix("P", c.size), c=c, A=matrix("A", b.size), b=b, G=matrix("G", h.size), h=h, cones=cones
    )
