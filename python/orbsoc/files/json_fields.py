"""JSON documents read field by field: what is missing or damaged is named, numbers come back exactly.

Numbers that JSON lacks are strings: "inf", "-inf", "nan". Every other number is written with as many digits as bring
the same double back.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from .atomic_write import write_atomically

Document = dict[str, Any]

NON_FINITE = ("inf", "-inf", "nan")
"""How the numbers that JSON lacks are written."""


class FieldError(ValueError):
    """A field of a document is missing, unknown or damaged; without a name, the document as a whole."""

    def __init__(self, field: str, reason: str) -> None:
        super().__init__(f"field `{field}` {reason}" if field else f"the document {reason}")


class Fields:
    """Typed access to the fields of one object of a document; `prefix` is where in the document it stands."""

    def __init__(self, document: Any, prefix: str = "") -> None:
        if not is_object(document):
            raise FieldError(prefix, "must be one JSON object")
        self.document = document
        self._prefix = f"{prefix}." if prefix else ""

    def check_names(self, schema: str, known: Sequence[str]) -> None:
        """Raise FieldError for another schema or an unknown field."""
        if self.document.get("schema") != schema:
            found = shown(self.document.get("schema"))
            raise FieldError(self.name("schema"), f"is {found}; this reader knows {schema!r}")
        unknown = sorted(set(self.document) - set(known))
        if unknown:
            raise FieldError(self.name(unknown[0]), f"is unknown; known fields are {', '.join(known)}")

    def name(self, field: str) -> str:
        """The field's name in the whole document."""
        return self._prefix + field

    def inner(self, field: str) -> Fields:
        """The object in a field."""
        return Fields(self.document.get(field), self.name(field))

    def count(self, field: str) -> int:
        """An integer, 0 or more."""
        value = self.document.get(field)
        if type(value) is not int or value < 0:
            raise FieldError(self.name(field), f"is {shown(value)}; it must be an integer, 0 or more")
        return value

    def text(self, field: str) -> str:
        """A string."""
        value = self.document.get(field)
        if not isinstance(value, str):
            raise FieldError(self.name(field), f"is {shown(value)}; it must be text")
        return value

    def number(self, field: str) -> float:
        """A number, or one of NON_FINITE."""
        return decode_number(self.name(field), self.document.get(field), NON_FINITE)

    def numbers(
        self, field: str, size: int | None = None, non_finite: Sequence[str] = NON_FINITE
    ) -> NDArray[np.float64]:
        """A list of numbers, of `size` if given; absent is an empty one."""
        return decode_numbers(self.name(field), self.document.get(field, []), size, non_finite)


def decode_numbers(
    name: str, value: Any, size: int | None, non_finite: Sequence[str] = NON_FINITE
) -> NDArray[np.float64]:
    """The list of numbers `value` as an array."""
    entries = checked_list(name, value, size)
    if all(type(entry) is float for entry in entries):
        plain = np.array(entries, dtype=float)
        if np.isfinite(plain).all():
            return plain
    return np.array(
        [decode_number(f"{name}[{k}]", entry, non_finite) for k, entry in enumerate(entries)], dtype=float
    )


def decode_number(name: str, value: Any, non_finite: Sequence[str] = NON_FINITE) -> float:
    """One number, or one of `non_finite` as the number it stands for."""
    if type(value) is float or type(value) is int:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if math.isinf(number):
            raise FieldError(name, f"is {shown(value)}; it is too large")
        return number
    if isinstance(value, str) and value in non_finite:
        return float(value)
    allowed = ", ".join(f'"{name}"' for name in non_finite[:-1])
    raise FieldError(name, f'is {shown(value)}; it must be a number, {allowed} or "{non_finite[-1]}"')


def decode_integers(name: str, value: Any, size: int) -> NDArray[np.int64]:
    """The list of 64-bit integers `value`, of `size`, as an array."""
    entries = checked_list(name, value, size)
    for k, entry in enumerate(entries):
        if type(entry) is not int or abs(entry) > np.iinfo(np.int64).max:
            raise FieldError(f"{name}[{k}]", f"is {shown(entry)}; it must be an integer")
    return np.array(entries, dtype=np.int64)


def checked_list(name: str, value: Any, size: int | None) -> list[Any]:
    """`value` if it is a list (of `size` entries)."""
    if not is_list(value):
        raise FieldError(name, f"is {shown(value)}; it must be a list")
    if size is not None and len(value) != size:
        raise FieldError(name, f"has {len(value)} entries; {size} are needed")
    return value


def encode_number(value: float) -> float | str:
    """A number as JSON can hold it."""
    return value if math.isfinite(value) else str(value)


def encode_numbers(values: NDArray[np.float64]) -> list[float | str]:
    """An array of numbers as JSON can hold it."""
    return [encode_number(value) for value in values.tolist()]


def is_object(value: Any) -> TypeGuard[Document]:
    """Whether a JSON value is an object."""
    return isinstance(value, dict)


def is_list(value: Any) -> TypeGuard[list[Any]]:
    """Whether a JSON value is a list."""
    return isinstance(value, list)


def shown(value: Any) -> str:
    """A value as an error quotes it."""
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


def _each_once(pairs: list[tuple[str, Any]]) -> Document:
    """An object; a key that is set twice is refused, of which `json` takes the last."""
    document = dict(pairs)
    if len(document) < len(pairs):
        keys = [key for key, _ in pairs]
        raise FieldError(next(key for key in keys if keys.count(key) > 1), "is set twice")
    return document


def read_json(path: str | os.PathLike[str]) -> Any:
    """The document of a file; raises FieldError if it is none, OSError if the file cannot be read."""
    try:
        text = Path(path).read_text(encoding="utf-8")
        return json.loads(text, parse_constant=_refuse_constant, object_pairs_hook=_each_once)
    except FieldError:
        raise
    except (json.JSONDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FieldError("", f"is not JSON: {error}") from error
    except ValueError as error:
        raise FieldError("", "contains an integer of too many digits") from error


def write_json(document: Document, path: str | os.PathLike[str]) -> None:
    """Write a document as `write_atomically` does."""
    write_atomically(path, json.dumps(document, allow_nan=False) + "\n")


def _refuse_constant(text: str) -> float:
    raise FieldError("", f'contains the bare word {text}; it is written as a string, as in "inf"')
