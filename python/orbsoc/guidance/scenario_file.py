"""Scenario files: TOML in, a checked scenario out, or an error that names key, value and what is allowed."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import PydanticCustomError


class Table(BaseModel):
    """A table of a scenario file: unknown keys, coerced types, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


T = TypeVar("T", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Complaint:
    """One thing that is wrong with a scenario: the dotted key, the value found, and what is allowed."""

    key: str
    value: str
    allowed: str

    def __str__(self) -> str:
        found = f"{self.key} = {self.value}" if self.value else self.key
        return f"{found}: {self.allowed}"


def refuse(complaints: Iterable[Complaint]) -> None:
    """For a model's validator: raise the first complaint, if there is one. Pydantic reports one error per validator."""
    for complaint in complaints:
        context = {"key": complaint.key, "value": complaint.value, "allowed": complaint.allowed}
        raise PydanticCustomError("physics", "{key} = {value}: {allowed}", context)


class ScenarioError(ValueError):
    """A scenario cannot be used; `complaints` lists every reason, the message is all of them."""

    def __init__(self, source: str, complaints: list[Complaint]) -> None:
        self.source = source
        self.complaints = tuple(complaints)
        lines = [str(complaint) for complaint in complaints]
        super().__init__(f"{source}: {lines[0]}" if len(lines) == 1 else "\n  ".join([f"{source}:", *lines]))


def read_toml(path: str | PathLike[str]) -> dict[str, Any]:
    """The document of a scenario file. Raises ScenarioError when it is missing, unreadable or not TOML."""
    source = Path(path)
    try:
        text = source.read_bytes().decode("utf-8")
    except FileNotFoundError as error:
        raise _unreadable(source, "no such file; give the path of a scenario in TOML") from error
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable(source, f"cannot be read as UTF-8 text: {error}") from error
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _unreadable(source, f"not TOML: {error}") from error


def checked(model: type[T], document: Mapping[str, Any], *, source: str) -> T:
    """The document as `model`; raises ScenarioError with every complaint."""
    try:
        return model.model_validate(dict(document))
    except ValidationError as error:
        raise ScenarioError(source, complaints(model, error)) from error


def complaints(model: type[BaseModel], error: ValidationError) -> list[Complaint]:
    """Pydantic's errors as key, value and what is allowed."""
    found: list[Complaint] = []
    for detail in error.errors(include_url=False):
        location = [str(part) for part in detail["loc"]]
        context: Mapping[str, Any] = detail.get("ctx") or {}
        if detail["type"] == "physics":
            found.append(Complaint(context["key"], context["value"], context["allowed"]))
        elif detail["type"] == "extra_forbidden":
            found.append(_unknown_key(model, location, detail["input"]))
        elif detail["type"] == "missing":
            found.append(Complaint(".".join(location), "", "is missing and has no default"))
        else:
            found.append(Complaint(".".join(location), repr(detail["input"]), detail["msg"]))
    return found


def _unknown_key(model: type[BaseModel], location: list[str], value: Any) -> Complaint:
    allowed = sorted(_table_at(model, location[:-1]).model_fields)
    words = f"unknown key; allowed here: {', '.join(allowed)}"
    near = difflib.get_close_matches(location[-1], allowed, n=1, cutoff=0.5)
    if near:
        words += f". Did you mean {near[0]}? The unit is part of the key"
    return Complaint(".".join(location), repr(value), words)


def _table_at(model: type[BaseModel], location: list[str]) -> type[BaseModel]:
    """The model of the table at a dotted location."""
    for part in location:
        annotation = model.model_fields[part].annotation
        assert isinstance(annotation, type)
        assert issubclass(annotation, BaseModel)
        model = annotation
    return model


def _unreadable(source: Path, words: str) -> ScenarioError:
    return ScenarioError(str(source), [Complaint("file", "", words)])
