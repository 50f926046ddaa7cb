"""A table that has changed in memory is noticed before the first solve."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from benchmarks.guidance import rendezvous
from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.flight.selftest import moved
from orbsoc.flight.tables import LISTS, SIZES, Tables, tables_of
from tests.flight.c_library import ROOT, compiled, need
from tests.flight.test_bits import PROBLEMS

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


NODE = ("kind", "scattered", "width", "diagonal", "leading", "updates")
UPDATE = ("target", "lo", "hi")
TRUTHS = ("absent", "positive", "scattered")
CONDENSED, LEAVES = 2, 3


@dataclass(frozen=True)
class Mutation:
    """One bit of one number of a list: its place in bytes, and what the number was and is."""

    name: str
    row: int
    field: str
    offset: int
    bit: int
    before: int

    @property
    def after(self) -> int:
        return self.before ^ 1 << self.bit

    def line(self) -> str:
        return f"{LISTS.index(self.name)} {self.offset} {self.bit}\n"


def mutation_of(tables: Tables, random: np.random.Generator) -> Mutation:
    name = str(random.choice([name for name in LISTS if tables.lists[name].size]))
    rows = tables.lists[name]
    row, fields = int(random.integers(len(rows))), {"nodes": NODE, "updates": UPDATE}.get(name, (name,))
    at = int(random.integers(len(fields)))
    byte = fields[at] in (*TRUTHS, "kind")
    start = {"nodes": (0, 1, 2, 4, 6, 8)[at], "updates": 2 * at}.get(name, 0)
    width = {"nodes": 10, "updates": 6}.get(name, 1 if byte else 2)
    before = int(rows[row, at]) if rows.ndim == 2 else int(rows[row])
    return Mutation(
        name, row, fields[at], width * row + start, int(random.integers(8 if byte else 16)), before
    )


def subtracts_zero(place: int, tables: Tables) -> bool:
    """Whether what goes to this scatter index is a product of entries of L that are zero in a factor of other numbers."""
    engine = _core.ExactEngine(moved(rendezvous(10, 0)), Settings(), 64)
    for stage in ("equilibrate", "load_kkt", "identity_blocks", "factorize"):
        engine.run(stage)
    factor, panel, at = engine.words("factor_l").view(np.float64), 0, 0
    for kind, scattered, width, diagonal, leading, _ in tables.lists["nodes"].tolist():
        rows = leading - diagonal
        pairs = [(i, j) for j in range(rows) for i in range(j, rows)]
        each = range(width) if kind == LEAVES else range(1)
        if scattered and at <= place < at + len(each) * len(pairs):
            column, pair = divmod(place - at, len(pairs))
            columns = [column] if kind == LEAVES else range(width)
            begins = [panel + c * leading + diagonal for c in columns]
            return kind != CONDENSED and all(
                factor[b + pairs[pair][0]] * factor[b + pairs[pair][1]] == 0 for b in begins
            )
        at += len(each) * len(pairs) if scattered else 0
        panel += 0 if kind == CONDENSED else width * leading
    return False


def is_equivalent(mutation: Mutation, tables: Tables) -> bool:
    """Whether the library does the same with both numbers, whatever the data, and why."""
    lists, row = tables.lists, mutation.row
    if mutation.field in TRUTHS:  # compared with zero alone
        return bool(mutation.before) and bool(mutation.after)
    if mutation.field == "kind":  # compared with these two alone
        return not {mutation.before, mutation.after} & {CONDENSED, LEAVES}
    if (
        mutation.name == "kkt_rowidx"
    ):  # residual() reads no row of a diagonal, and of a contiguous column the first alone
        column = int(np.searchsorted(lists["kkt_colptr"], row, side="right")) - 1
        blocks = lists["kkt_contiguous"].reshape(-1, 2)
        inside = any(first <= column < end for first, end in blocks)
        return row == lists["kkt_colptr"][column + 1] - 1 or (inside and row > lists["kkt_colptr"][column])
    # Entries of the matrix that are zero whatever the data are: the factor has them without their being copied.
    written = {int(k) for name in ("from_p", "from_a", "from_g", "orthant", "soc") for k in lists[name]}
    runs = zip(lists["run_value"].tolist(), lists["run_length"].tolist(), strict=True)
    sources = [entry for first, length in runs for entry in range(first, first + length)]
    if mutation.name == "run_length" and row == len(lists["run_length"]) - 1:
        lost = sources[mutation.after - mutation.before :]
        return mutation.after < mutation.before and not written.intersection(lost)
    if mutation.name == "entry_targets" and sources[row] not in written:
        earlier = np.flatnonzero(lists["entry_targets"][:row] == mutation.after)
        return not any(sources[k] in written for k in earlier)
    return mutation.name == "scatter" and subtracts_zero(row, tables)


def test_without_the_checksum_what_selftest_and_checked_indices_miss_is_equivalent(tmp_path: Path) -> None:
    need("gcc")
    problem = rendezvous(10, 0)
    tables, random = tables_of(problem, Settings()), np.random.default_rng(17)
    mutations = [mutation_of(tables, random) for _ in range(MUTATIONS)]
    orbsoc.export_c(problem, tmp_path / "c")
    plain = ended(apart(tmp_path / "c", "-O2"), mutations)
    missed = [mutation for mutation, code in zip(mutations, plain, strict=True) if code == 0]
    assert len(missed) < MUTATIONS // 2
    checked = ended(apart(tmp_path / "c", *SANITIZED), missed)
    missed = [mutation for mutation, code in zip(missed, checked, strict=True) if code == 0]
    assert [mutation for mutation in missed if not is_equivalent(mutation, tables)] == []


@pytest.mark.parametrize("name", ["insertion", "quadratic", "condensed", "infeasible"])
def test_every_index_is_inside_its_own_list(name: str, tmp_path: Path) -> None:
    """Each table and each buffer in memory of its own, under AddressSanitizer; solves from cold, warm and of other data."""
    need("gcc")
    make, settings = PROBLEMS[name]
    orbsoc.export_c(make(), tmp_path / "c", settings=settings)
    done = subprocess.run([apart(tmp_path / "c", *SANITIZED)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("the recorded bits") >= 2


SANITIZED = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def apart(folder: Path, *options: str) -> Path:
    """The self-test with its lists in memory of their own."""
    made = folder / f"apart{len(options)}"
    bits = re.search(r"ORBSOC_INDEX_BITS=(\d+)", (folder / "README.md").read_text())
    assert bits
    sources = [*folder.glob("flight/*.c"), folder / "pattern.c", ROOT / "tests" / "flight" / "apart.c"]
    command = ["gcc", "-std=gnu99", "-ffp-contract=off", *options, "-DORBSOC_FP=64", f"-DORBSOC_INDEX_BITS={bits[1]}",
               f"-I{folder}/flight", f"-I{folder}", *map(str, sources), "-lm", "-o", str(made)]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return made


def ended(program: Path, mutations: list[Mutation]) -> list[int]:
    """How the self-test ends on each: 0 where it notices nothing."""
    text = "".join(mutation.line() for mutation in mutations)
    done = subprocess.run([program, "-"], input=text, capture_output=True, text=True, check=True)
    return [int(line) for line in done.stdout.split()]


PLACES = (
    "cone_dims", "given_cone_dims", "p_colptr", "p_rowidx", "a_colptr", "a_rowidx", "g_colptr", "g_rowidx",
    "given_g_colptr", "given_g_rowidx", "row_origin", "g_origin", "absent", "kkt_colptr", "kkt_rowidx",
    "kkt_contiguous", "position", "positive", "from_p", "from_a", "from_g", "orthant", "soc", "rows", "scatter",
    "gather", "relative", "run_value", "run_length", "entry_targets",
)  # fmt: skip
"""The lists that `harness_change` knows, by number."""
