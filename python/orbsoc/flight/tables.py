"""A pattern's tables as the C library reads them: sizes, lists, and their checksums."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings

VERSION = 1
List = NDArray[np.uint32]

SIZES = (
    "version", "index_bits", "n", "p", "m", "l", "cones", "given_m", "given_l", "given_cones", "nnz_p", "nnz_a",
    "nnz_g", "given_nnz_g", "dim", "nnz_kkt", "contiguous", "nodes", "updates", "rows", "scatter", "gather",
    "relative", "runs", "panel_entries", "scratch", "work_words", "number_words", "soc_words", "targets",
)  # fmt: skip
"""The sizes of `orbsoc_pattern`, in the order of its fields and of its checksum."""

LISTS = (
    "cone_dims", "given_cone_dims", "p_colptr", "p_rowidx", "a_colptr", "a_rowidx", "g_colptr", "g_rowidx",
    "given_g_colptr", "given_g_rowidx", "row_origin", "g_origin", "absent", "kkt_colptr", "kkt_rowidx",
    "kkt_contiguous", "position", "positive", "from_p", "from_a", "from_g", "orthant", "soc", "nodes", "updates",
    "rows", "scatter", "gather", "relative", "run_value", "run_length", "entry_targets",
)  # fmt: skip
"""The lists in the order of the tables' checksum; `nodes` and `updates` are rows of numbers."""

BYTES = ("absent", "positive")
"""Lists of bytes; all others are of the index width."""

RAW = ("raw_p", "raw_a", "raw_g", "raw_q")
"""Buffers that the library does without: equilibration reads the given data themselves."""


@dataclass(frozen=True, slots=True)
class Tables:
    """What C needs of a pattern: sizes by name, lists by name (rows of numbers for nodes and updates)."""

    sizes: dict[str, int]
    lists: dict[str, List]

    @property
    def index_bits(self) -> int:
        return self.sizes["index_bits"]

    @property
    def table_bytes(self) -> int:
        """Bytes of the lists, those that are equal to one another counted once."""
        return sum(self.bytes_of(name) for name in self.lists if self.same_as(name) is None)

    def bytes_of(self, name: str) -> int:
        """Bytes of one list in memory."""
        wide = self.index_bits // 8
        if name in BYTES:
            return self.lists[name].size
        if name == "nodes":
            return len(self.lists[name]) * (2 + 4 * wide) if wide == 2 else len(self.lists[name]) * 20
        return self.lists[name].size * wide

    def same_as(self, name: str) -> str | None:
        """The given G's list that is the reduced one's as well: it is stored once."""
        other = name.removeprefix("given_")
        same = name in ("given_g_colptr", "given_g_rowidx") and np.array_equal(
            self.lists[name], self.lists[other]
        )
        return other if same else None

    @property
    def size_checksum(self) -> int:
        return zlib.crc32(np.array([self.sizes[name] for name in SIZES], "<u4").tobytes())

    @property
    def checksum(self) -> int:
        """CRC-32 over the lists, as `orbsoc_checksum` makes it."""
        found = 0
        for name in LISTS:
            found = zlib.crc32(self._packed(name), found)
        return found

    def _packed(self, name: str) -> bytes:
        kind = "<u2" if self.index_bits == 16 else "<u4"
        rows = self.lists[name]
        if name in BYTES:
            return rows.astype("u1").tobytes()
        if name != "nodes":
            return rows.astype(kind).tobytes()
        return b"".join(row[:2].astype("u1").tobytes() + row[2:].astype(kind).tobytes() for row in rows)


def tables_of(problem: Problem, settings: Settings) -> Tables:
    """The tables of a problem's pattern; raises CoreError where 32-bit indices cannot address it."""
    sizes, lists, words = _core.pattern_tables(problem, settings)
    lists = dict(lists)
    nodes = [
        lists.pop(f"node_{name}") for name in ("kind", "scattered", "width", "diagonal", "leading", "updates")
    ]
    updates = [lists.pop(f"update_{name}") for name in ("target", "lo", "hi")]
    lists["nodes"], lists["updates"] = np.column_stack(nodes), np.column_stack(updates)
    absent = np.ones(sizes["given_m"], np.uint32)
    absent[lists["row_origin"]] = 0
    lists["absent"] = absent
    largest = max((int(values.max()) for values in lists.values() if values.size), default=0)
    longest = max(sizes["n"], sizes["dim"], sizes["given_m"], largest)
    return Tables(_sizes(sizes, lists, words, 16 if longest < 1 << 16 else 32), lists)


def _sizes(core: dict[str, int], lists: dict[str, List], words: dict[str, int], bits: int) -> dict[str, int]:
    nodes = lists["nodes"]
    widest = max((int(width * leading + leading) for _, _, width, _, leading, _ in nodes.tolist()), default=0)
    n, p, given_m = core["n"], core["p"], core["given_m"]
    sizes: dict[str, Any] = {
        "version": VERSION, "index_bits": bits, "n": n, "p": p, "m": core["m"], "l": core["l"],
        "cones": lists["cone_dims"].size, "given_m": given_m, "given_l": core["given_l"],
        "given_cones": lists["given_cone_dims"].size, "nnz_p": lists["p_rowidx"].size,
        "nnz_a": lists["a_rowidx"].size, "nnz_g": lists["g_rowidx"].size,
        "given_nnz_g": lists["given_g_rowidx"].size, "dim": core["dim"], "nnz_kkt": core["nnz_kkt"],
        "contiguous": lists["kkt_contiguous"].size, "nodes": len(nodes), "updates": len(lists["updates"]),
        "rows": lists["rows"].size, "scatter": lists["scatter"].size, "gather": lists["gather"].size,
        "relative": lists["relative"].size, "runs": lists["run_value"].size,
        "panel_entries": core["panel_entries"], "scratch": max(core["scratch"], widest),
        "soc_words": lists["soc"].size, "targets": lists["entry_targets"].size,
    }  # fmt: skip
    matrices = sizes["nnz_p"] + sizes["nnz_a"] + sizes["given_nnz_g"]
    sizes["work_words"] = sum(words.values()) - sum(words[name] for name in RAW) + sizes["scratch"]
    sizes["number_words"] = matrices + 9 * n + 7 * p + 12 * given_m
    return {name: int(sizes[name]) for name in SIZES}
