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

import json
import math
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from orbsoc import csc
from orbsoc.csc import Csc

if TYPE_CHECKING:
    from orbsoc.problem import Problem

SCHEMA = "orbsoc.problem/1"
_FIELDS = ("schema", "n", "p", "m", "P", "c", "A", "b", "G", "h", "cones")


def write_problem(problem: Problem, path: str | PathLike[str]) -> None:
    """Write `problem` as JSON; raises OSError if the path cannot be written."""
    document: dict[str, Any] = {"schema": SCHEMA, "n": problem.n, "p": problem.p, "m": problem.m}
    for matrix, vector in (("P", "c"), ("A", "b"), ("G", "h")):
        document[matrix] = _encode_matrix(getattr(problem, matrix))
        document[vector] = _encode_numbers(getattr(problem, vector))
    document["cones"] = {"l": problem.cones.l, "q": list(problem.cones.q)}
    Path(path).write_text(json.dumps(document, allow_nan=False) + "\n", encoding="utf-8")


def read_problem(path: str | PathLike[str]) -> Problem:
    """Read a file of this schema; raises ProblemError naming the field, OSError if the file cannot be read."""
    from orbsoc.problem import Cones, Problem, ProblemError

    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"), parse_constant=_refuse_constant)
        if not _is_object(document):
            raise _FieldError("the document", "must be one JSON object")
        fields = _Fields(document)
        fields.check_names()
        n, p, m = fields.count("n"), fields.count("p"), fields.count("m")
        l, q = fields.cones()
        return Problem(
            P=fields.matrix("P", n, n),
            c=fields.vector("c", n),
            A=fields.matrix("A", p, n),
            b=fields.vector("b", p),
            G=fields.matrix("G", m, n),
            h=fields.vector("h", m),
            cones=Cones(l, q),
        )
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise ProblemError(f"{fspath(path)}: not a JSON document: {error}") from error
    except (_FieldError, ProblemError) as error:
        raise ProblemError(f"{fspath(path)}: {error}") from error


class _FieldError(Exception):
    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"field `{field}` {reason}")


class _Fields:
    """Typed access to the parsed document."""

    def __init__(self, document: dict[str, Any]) -> None:
        self._document = document

    def check_names(self) -> None:
        if self._document.get("schema") != SCHEMA:
            raise _FieldError("schema", f"is {self._document.get('schema')!r}; this reader knows {SCHEMA!r}")
        unknown = sorted(set(self._document) - set(_FIELDS))
        if unknown:
            raise _FieldError(unknown[0], f"is unknown; known fields are {', '.join(_FIELDS)}")

    def count(self, name: str) -> int:
        value = self._document.get(name)
        if type(value) is not int or value < 0:
            raise _FieldError(name, f"is {_shown(value)}; it must be an integer, 0 or more")
        return value

    def vector(self, name: str, size: int) -> NDArray[np.float64]:
        return _numbers(name, self._document.get(name, []), size)

    def matrix(self, name: str, rows: int, columns: int) -> Csc:
        value = self._document.get(name)
        if value is None:
            return csc.empty(rows, columns)
        if not _is_object(value) or set(value) != {"indptr", "indices", "data"}:
            raise _FieldError(name, "must be an object with indptr, indices and data")
        indptr = _integers(f"{name}.indptr", value["indptr"], columns + 1)
        nnz = int(indptr[-1])
        if indptr[0] != 0 or (np.diff(indptr) < 0).any():
            raise _FieldError(f"{name}.indptr", "must ascend from 0")
        indices = _integers(f"{name}.indices", value["indices"], nnz)
        if nnz and (indices.min() < 0 or indices.max() >= rows):
            raise _FieldError(f"{name}.indices", f"must lie in 0 … {rows - 1}")
        data = _numbers(f"{name}.data", value["data"], nnz)
        return csc.from_parts(data, indices, indptr, (rows, columns))

    def cones(self) -> tuple[int, list[int]]:
        value = self._document.get("cones", {"l": 0, "q": []})
        if not _is_object(value) or set(value) != {"l", "q"}:
            raise _FieldError("cones", "must be an object with l and q")
        if type(value["l"]) is not int:
            raise _FieldError("cones.l", f"is {_shown(value['l'])}; it must be an integer")
        if not _is_list(value["q"]) or not all(type(size) is int for size in value["q"]):
            raise _FieldError("cones.q", f"is {_shown(value['q'])}; it must be a list of integers")
        return value["l"], value["q"]


def _integers(name: str, value: Any, size: int) -> NDArray[np.int64]:
    _check_list(name, value, size)
    for k, entry in enumerate(value):
        if type(entry) is not int or abs(entry) > np.iinfo(np.int64).max:
            raise _FieldError(f"{name}[{k}]", f"is {_shown(entry)}; it must be an integer")
    return np.array(value, dtype=np.int64)


def _numbers(name: str, value: Any, size: int) -> NDArray[np.float64]:
    _check_list(name, value, size)
    out = np.empty(size)
    for k, entry in enumerate(value):
        if type(entry) is float or type(entry) is int:
            try:
                out[k] = entry
            except OverflowError as error:
                raise _FieldError(f"{name}[{k}]", f"is {_shown(entry)}; it is too large") from error
        elif entry in ("inf", "-inf"):
            out[k] = float(entry)
        else:
            raise _FieldError(f"{name}[{k}]", f'is {_shown(entry)}; it must be a number, "inf" or "-inf"')
    return out


def _check_list(name: str, value: Any, size: int) -> None:
    if not _is_list(value):
        raise _FieldError(name, f"is {_shown(value)}; it must be a list")
    if len(value) != size:
        raise _FieldError(name, f"has {len(value)} entries; {size} are needed")


def _is_object(value: Any) -> TypeGuard[dict[str, Any]]:
    return isinstance(value, dict)


def _is_list(value: Any) -> TypeGuard[list[Any]]:
    return isinstance(value, list)


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


def _refuse_constant(text: str) -> float:
    raise _FieldError(
        "the document", f'contains the bare word {text}; infinities are written as "inf", "-inf"'
    )


def _encode_numbers(values: NDArray[np.float64]) -> list[float | str]:
    return [x if math.isfinite(x) else str(x) for x in values.tolist()]


def _encode_matrix(matrix: Csc) -> dict[str, Any]:
    return {
        "indptr": matrix.indptr.tolist(),
        "indices": matrix.indices.tolist(),
        "data": _encode_numbers(matrix.data),
    }
