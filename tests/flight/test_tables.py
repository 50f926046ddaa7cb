"""A table that has changed in memory is noticed before the first solve."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.guidance import rendezvous
from orbsoc.conic.settings import Settings
from orbsoc.flight.tables import LISTS, SIZES, Tables, tables_of
from tests.flight.c_library import compiled

MUTATIONS = 200
TABLES_CHANGED = 3


def test_any_changed_number_changes_a_checksum() -> None:
    tables = tables_of(rendezvous(10, 0), Settings())
    random = np.random.default_rng(3)
    names = [*SIZES, *(name for name in LISTS if tables.lists[name].size)]
    for _ in range(MUTATIONS):
        name = str(random.choice(names))
        changed = _changed(tables, name, random)
        assert (changed.size_checksum, changed.checksum) != (tables.size_checksum, tables.checksum), name


def _changed(tables: Tables, name: str, random: np.random.Generator) -> Tables:
    """One bit of one number is another."""
    if name in SIZES:
        return Tables(tables.sizes | {name: tables.sizes[name] ^ 1 << int(random.integers(16))}, tables.lists)
    rows = tables.lists[name].copy()
    at: Any = tuple(int(random.integers(size)) for size in rows.shape)
    byte = name in ("absent", "positive") or (name == "nodes" and at[-1] < 2)
    rows[at] ^= np.uint32(1 << int(random.integers(8 if byte else 16)))
    return Tables(tables.sizes, tables.lists | {name: rows})


def test_a_solver_refuses_tables_with_one_bit_changed(tmp_path: Path) -> None:
    solver = compiled(tmp_path, rendezvous(10, 0), Settings(), 64)
    lists, random = solver.tables.lists, np.random.default_rng(5)
    filled = [number for number, name in enumerate(PLACES) if lists[name].size]
    for _ in range(MUTATIONS):
        number = int(random.choice(filled))
        name = PLACES[number]
        size, bits = lists[name].size, 8 if name in ("absent", "positive") else 16
        at, bit = int(random.integers(size)), int(random.integers(bits))
        assert solver.library.harness_change(number, size, at, bit) == TABLES_CHANGED, (name, at, bit)
    assert solver.library.harness_open() == 0


PLACES = (
    "cone_dims", "given_cone_dims", "p_colptr", "p_rowidx", "a_colptr", "a_rowidx", "g_colptr", "g_rowidx",
    "given_g_colptr", "given_g_rowidx", "row_origin", "g_origin", "absent", "kkt_colptr", "kkt_rowidx",
    "kkt_contiguous", "position", "positive", "from_p", "from_a", "from_g", "orthant", "soc", "rows", "scatter",
    "gather", "relative", "run_value", "run_length", "entry_targets",
)  # fmt: skip
"""The lists that `harness_change` knows, by number."""
