"""Typed errors of the hardware model: each message names the key, its value and what is allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, get_args

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError


class HwModelError(ValueError):
    """Any input that the hardware model cannot use."""


class PlatformError(HwModelError):
    """A platform file or value that describes no possible computer."""


class NoSuchEngineError(HwModelError):
    """An engine that rtl/ cannot be; an estimate of its time is possible, its area is not known."""


class PartitionError(HwModelError):
    """A partition that does not place exactly the PL's modules."""


class TraceError(HwModelError):
    """A trace that is damaged, incomplete or of another schema version."""


class IgnoredKeyError(HwModelError):
    """A parameter that was set where nothing reads it, set twice, or set beside the option that sets it."""


def describe(error: ValidationError, model: type[BaseModel]) -> str:
    """Every complaint of a validation as `key = value: what is allowed`, one per line, at most ten."""
    complaints = error.errors(include_url=False)
    lines = [_line(dict(complaint), model) for complaint in complaints[:10]]
    if len(complaints) > 10:
        lines.append(f"… and {len(complaints) - 10} more")
    return "\n".join(lines)


def _line(complaint: Mapping[str, Any], model: type[BaseModel]) -> str:
    loc: tuple[int | str, ...] = tuple(part for part in complaint["loc"] if part != "[key]")
    key = ".".join(str(part) for part in loc) or "(top level)"
    kind: str = complaint["type"]
    message = str(complaint["msg"]).removeprefix("Value error, ")
    if kind == "missing":
        return f"`{key}` is missing; required here: {_fields(model, loc[:-1])}"
    key = key.removesuffix(".value")  # as a setting says it
    value = _short(complaint["input"])
    if kind == "model_type":
        return f'`{key}` = {value}: must be a table, such as {{ value = {value}, tag = "assumed", source = "why" }}'
    if kind == "extra_forbidden":
        return f"`{key}` = {value} is not a known key; allowed here: {_fields(model, loc[:-1])}"
    if kind == "value_error":
        return f"`{key}`: {message}" if loc else message
    return f"`{key}` = {value}: {message[:1].lower()}{message[1:]}"


def _fields(model: type[BaseModel], loc: Sequence[int | str]) -> str:
    """Names of the keys that the model at `loc` below `model` accepts."""
    here = model
    for part in loc:
        field = here.model_fields.get(part) if isinstance(part, str) else None
        inner = here if field is None else _model_in(field.annotation)
        if inner is None:
            break
        here = inner
    return ", ".join(here.model_fields)


def _model_in(annotation: object) -> type[BaseModel] | None:
    """The first pydantic model inside an annotation such as `tuple[Stage, ...]` or `Stage | None`."""
    if isinstance(annotation, type) and hasattr(annotation, "model_fields"):
        return annotation
    for argument in get_args(annotation):
        found = _model_in(argument)
        if found is not None:
            return found
    return None


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}…"
