"""What a key of a scenario file may be, in words: from the JSON Schema of its table, the one source of errors and templates."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from pydantic import BaseModel

Schema = Mapping[str, Any]
UNITS = {
    "_km2_s2": "km²/s²", "_kg_m2": "kg m²", "_m2_kg": "m²/kg", "_rad_s": "rad/s", "_deg_s": "deg/s", "_m_s2": "m/s²",
    "_kg_s": "kg/s", "_n_m": "N m", "_m_s": "m/s", "_deg": "deg", "_rad": "rad", "_km": "km", "_kg": "kg", "_m": "m",
    "_s": "s", "_h": "h", "_n": "N",
}  # fmt: skip
"""By the end of a key; longer ends first."""


def unit_of(key: str) -> str:
    """The unit that a key ends with; empty for a number without one.

    >>> unit_of("mass_flow_kg_s")
    'kg/s'
    """
    return next((unit for end, unit in UNITS.items() if key.endswith(end)), "")


@cache
def schema_of(model: type[BaseModel]) -> Schema:
    """The JSON Schema of a table."""
    return model.model_json_schema()


def key_schema(model: type[BaseModel], key: str) -> Schema:
    """The part of the schema that is of one key."""
    found: Schema = schema_of(model)["properties"][key]
    return found


def allowed_words(model: type[BaseModel], key: str) -> str:
    """What the key may be: 'a number above 0 and at most 1e+08'."""
    return _words(key_schema(model, key), schema_of(model).get("$defs", {}))


def _words(schema: Schema, tables: Schema) -> str:
    if "$ref" in schema:
        table = tables[schema["$ref"].rpartition("/")[2]]
        required = table.get("required", [])
        return f"a table with {', '.join(required)}" if required else "a table"
    if "anyOf" in schema:
        found = [_words(each, tables) for each in schema["anyOf"] if each.get("type") != "null"]
        return " or ".join(dict.fromkeys(found))
    if "const" in schema or "enum" in schema:
        *others, last = [repr(each) for each in schema.get("enum", [schema.get("const")])]
        return f"{', '.join(others)} or {last}" if others else last
    return _plain_words(schema, tables)


def _plain_words(schema: Schema, tables: Schema) -> str:
    match schema.get("type"):
        case "boolean":
            return "true or false"
        case "number" | "integer":
            kind = "a number" if schema["type"] == "number" else "a whole number"
            return f"{kind}{_bounds(schema)}"
        case "array":
            places = schema.get("prefixItems")
            if places:
                return f"a list of {len(places)}, each {_words(places[0], tables)}"
            return f"a list, each {_words(schema.get('items', {}), tables)}"
        case "string":
            pattern = schema.get("pattern")
            return f"text like {pattern}" if pattern else "text"
    return "a value"


def _bounds(schema: Schema) -> str:
    """` above 0 and at most 10`; empty for any number."""
    if {"minimum", "maximum"} <= set(schema):
        step = f", a multiple of {schema['multipleOf']:g}" if "multipleOf" in schema else ""
        return f" from {schema['minimum']:g} to {schema['maximum']:g}{step}"
    names = {
        "exclusiveMinimum": "above", "minimum": "at least", "exclusiveMaximum": "below", "maximum": "at most",
        "multipleOf": "a multiple of",
    }  # fmt: skip
    found = [f"{words} {schema[name]:g}" for name, words in names.items() if name in schema]
    return f" {' and '.join(found)}" if found else ""
