"""The JSON file of a problem, schema `orbsoc.problem/1`.

One object:

- `schema`: "orbsoc.problem/1"; `n`, `p`, `m`: numbers of variables, equality rows and cone rows;
- `P`, `A`, `G`: {"indptr": [columns + 1 integers], "indices": [nnz row numbers], "data": [nnz numbers]}, compressed
  columns, rows ascending and unique in each column; P is the full symmetric matrix; absent means no entries;
- `c`, `b`, `h`: numbers; "inf" (a string) in `h` is an R₊ row that does not constrain; absent b or h means no rows;
- `cones`: {"l": integer, "q": [integers]}; absent means none.

Numbers are written with as many digits as bring the same double back. Unknown fields are errors.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from orbsoc.files.json_fields import (
    Document,
    FieldError,
    Fields,
    decode_integers,
    decode_numbers,
    encode_numbers,
    is_list,
    is_object,
    shown,
)

from . import csc
from .cones import Cones
from .csc import Csc

SCHEMA = "orbsoc.problem/1"
_FIELDS = ("schema", "n", "p", "m", "P", "c", "A", "b", "G", "h", "cones")
_INFINITIES = ("inf", "-inf")


def encode_problem(problem: Any) -> Document:
    """The document of an `orbsoc.Problem`."""
    document: Document = {"schema": SCHEMA, "n": problem.n, "p": problem.p, "m": problem.m}
    for matrix, vector in (("P", "c"), ("A", "b"), ("G", "h")):
        document[matrix] = _encode_matrix(getattr(problem, matrix))
        document[vector] = encode_numbers(getattr(problem, vector))
    document["cones"] = {"l": problem.cones.l, "q": list(problem.cones.q)}
    return document


def decode_problem(document: Any, prefix: str = "") -> dict[str, Any]:
    """The arguments of `orbsoc.Problem`; raises FieldError (with `prefix` before the field) or ProblemError."""
    fields = Fields(document, prefix)
    fields.check_names(SCHEMA, _FIELDS)
    n, p, m = fields.count("n"), fields.count("p"), fields.count("m")
    l, q = _cones(fields)
    # Vectors first: they show that the sizes are real before a matrix of those sizes is made.
    c, b, h = (fields.numbers(name, size, _INFINITIES) for name, size in (("c", n), ("b", p), ("h", m)))
    P, A, G = (_matrix(fields, name, rows, n) for name, rows in (("P", n), ("A", p), ("G", m)))
    return {"P": P, "c": c, "A": A, "b": b, "G": G, "h": h, "cones": Cones(l, q)}


def _matrix(fields: Fields, field: str, rows: int, columns: int) -> Csc:
    value, name = fields.document.get(field), fields.name(field)
    if value is None:
        return csc.empty(rows, columns)
    if not is_object(value) or set(value) != {"indptr", "indices", "data"}:
        raise FieldError(name, "must be an object with indptr, indices and data")
    indptr = decode_integers(f"{name}.indptr", value["indptr"], columns + 1)
    nnz = int(indptr[-1])
    if indptr[0] != 0 or (np.diff(indptr) < 0).any():
        raise FieldError(f"{name}.indptr", "must ascend from 0")
    indices = decode_integers(f"{name}.indices", value["indices"], nnz)
    if nnz and (indices.min() < 0 or indices.max() >= rows):
        raise FieldError(f"{name}.indices", f"must lie in 0 … {rows - 1}")
    data = decode_numbers(f"{name}.data", value["data"], nnz, _INFINITIES)
    return csc.from_parts(data, indices, indptr, (rows, columns))


def _cones(fields: Fields) -> tuple[int, list[int]]:
    value, name = fields.document.get("cones", {"l": 0, "q": []}), fields.name("cones")
    if not is_object(value) or set(value) != {"l", "q"}:
        raise FieldError(name, "must be an object with l and q")
    if type(value["l"]) is not int:
        raise FieldError(f"{name}.l", f"is {shown(value['l'])}; it must be an integer")
    if not is_list(value["q"]) or not all(type(size) is int for size in value["q"]):
        raise FieldError(f"{name}.q", f"is {shown(value['q'])}; it must be a list of integers")
    return value["l"], value["q"]


def _encode_matrix(matrix: Csc) -> Document:
    return {
        "indptr": matrix.indptr.tolist(),
        "indices": matrix.indices.tolist(),
        "data": encode_numbers(matrix.data),
    }
