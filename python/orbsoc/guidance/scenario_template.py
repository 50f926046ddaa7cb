"""A scenario file in which every key stands, those that are not given as comments, each with unit, meaning, values and default."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from datetime import date, time
from typing import Any

from pydantic import BaseModel

from .allowed_values import allowed_words, key_schema, schema_of, unit_of
from .scenario_file import table_of, tables_by_name

COLUMN, WIDTH = 36, 130
"""Where the comments begin, and where they end."""
UNKNOWN = "?"
"""In place of the value of a key that has no default and need not be given."""


def template(model: type[BaseModel], document: Mapping[str, Any], *, heading: Sequence[str] = ()) -> str:
    """The text of a scenario file with the values of `document`, every key of `model` documented."""
    lines = [f"# {line}" for line in heading]
    tables = [key for key in model.model_fields if table_of(model, key) is not None]
    for key in model.model_fields:
        if key not in tables:
            lines += _key_lines(model, key, document)
    for key in tables:
        table = table_of(model, key)
        assert table is not None  # it is one of the tables
        if tables_by_name(model, key):
            about = key_schema(model, key).get("description", "")
            lines += ["", *_beside(f"[{key}]", f"tables by name; {about}")]
            for name, given in document.get(key, {}).items():
                lines += ["", *_named_lines(f"{key}.{name}", table, given)]
            continue
        lines += ["", *_table_lines(model, key, table, document.get(key))]
    return "\n".join(lines) + "\n"


def toml_value(value: Any) -> str:
    """A value as TOML writes it, tables in braces.

    >>> toml_value({"first": 1.0, "free": ["raan_deg"]})
    '{ first = 1.0, free = ["raan_deg"] }'
    """
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {toml_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, date | time):
        return value.isoformat()
    return json.dumps(value, ensure_ascii=False)


def _table_lines(
    model: type[BaseModel], key: str, table: type[BaseModel], given: Mapping[str, Any] | None
) -> Iterator[str]:
    """A table; as a comment where it is not given and its presence says something."""
    about = (table.__doc__ or "").split("\n")[0]
    left_out = (
        given is None and "default" in key_schema(model, key) and key_schema(model, key)["default"] is None
    )
    mark = "# " if left_out else ""
    yield from _beside(f"{mark}[{key}]", f"{about.rstrip('.')}; optional" if left_out else about.rstrip("."))
    yield from _keys_lines(table, given)


def _named_lines(name: str, table: type[BaseModel], given: Mapping[str, Any]) -> Iterator[str]:
    """A table of a name of the user's own."""
    yield from _beside(f"[{name}]", (table.__doc__ or "").split("\n")[0].rstrip("."))
    yield from _keys_lines(table, given)


def _keys_lines(table: type[BaseModel], given: Mapping[str, Any] | None) -> Iterator[str]:
    """Every key of a table, then those of another form of it."""
    for each in table.model_fields:
        yield from _key_lines(table, each, given or {})
    for each in given or {}:
        if (
            each not in table.model_fields
        ):  # another form of the table, which is turned to its keys when it is read
            yield from _long_value(each, (given or {})[each])


def _long_value(key: str, value: Any) -> Iterator[str]:
    """A key and its value; a list that is too long for a line has a line an entry."""
    line = f"{key} = {toml_value(value)}"
    if len(line) <= WIDTH or not isinstance(value, list):
        yield line
        return
    yield f"{key} = ["
    yield from (f"    {toml_value(each)}," for each in value)
    yield "]"


def _key_lines(model: type[BaseModel], key: str, given: Mapping[str, Any]) -> Iterator[str]:
    schema = key_schema(model, key)
    default = schema.get("default")
    if default is not None and default == schema.get("exclusiveMinimum"):
        default = None  # one that it may not be stands for a value that is worked out
    if key in given:
        left = f"{key} = {toml_value(given[key])}"
    else:
        left = f"# {key} = {UNKNOWN if default is None else toml_value(default)}"
    needed = "needed" if key in given or not given else "needed, unless another form of the table is given"
    if key not in schema_of(model).get("required", ()):
        needed = "optional" if default is None else f"default {toml_value(default)}"
    parts = (unit_of(key), schema.get("description", ""), allowed_words(model, key), needed)
    yield from _beside(left, "; ".join(filter(None, parts)))


def _beside(left: str, words: str) -> Iterator[str]:
    """A line with a comment beside it, which goes on below."""
    column = max(COLUMN, len(left) + 2)
    narrow = column > WIDTH - 40
    lines = textwrap.wrap(words, WIDTH - (COLUMN if narrow else column) - 2) or [""]
    if narrow:
        yield left
    else:
        yield f"{left.ljust(column)}# {lines.pop(0)}".rstrip()
    for line in lines:
        yield f"{' ' * (COLUMN if narrow else column)}# {line}"
