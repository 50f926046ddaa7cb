"""Scenario files: TOML in, a checked scenario out, or an error that names key, value and what is allowed."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Self, TypeVar, cast, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import PydanticCustomError


class Table(BaseModel):
    """A table of a scenario file: unknown keys, coerced types, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class BaseScenario(Table):
    """A whole scenario file: which mission it is of, its name, and what the mission adds."""

    mission: str
    name: str = Field(min_length=1)

    @property
    def variant(self) -> str:
        """What tells apart the plans of one file, for the name of an output folder; empty where it holds one."""
        return ""

    @property
    def idle_keys(self) -> Mapping[str, str]:
        """Dotted keys that the plan of this scenario does not depend on, with the reason; a file may hold them for another plan."""
        return {}

    def with_changes(self, **changes: Any) -> Self:
        """A checked copy: `with_changes(problem="max_energy", method={"nodes": 16})` keeps the table's other keys.

        Raises ScenarioError when a change contradicts the rest.
        """
        return checked(type(self), merged(self.model_dump(), changes), source=self.name)


MISSING = "is missing and has no default"
T = TypeVar("T", bound=BaseModel)
S = TypeVar("S", bound=BaseScenario)


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
        other = "; `orbsoc solve` takes a problem in JSON" if source.suffix == ".json" else ""
        raise _unreadable(source, f"not TOML: {error}{other}") from error


def read_document(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """The document of a scenario file with `settings` in place of its own: values by dotted key, "vehicle.thrust_n".

    Raises ScenarioError as `read_toml` does.
    """
    return merged(read_toml(path), nested(settings or {}))


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values by dotted key as tables: {"vehicle.thrust_n": 2.0} is {"vehicle": {"thrust_n": 2.0}}."""
    found: dict[str, Any] = {}
    for key, value in values.items():
        *tables, last = key.split(".")
        change = {last: value}
        for table in reversed(tables):
            change = {table: change}
        found = merged(found, change)
    return found


def merged(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """The document with the values of `changes`; of a table in both, keys that are not named stay."""
    found = dict(document)
    for key, value in changes.items():
        old = found.get(key)
        tables = isinstance(old, Mapping) and isinstance(value, Mapping)
        found[key] = merged(cast(Mapping[str, Any], old), value) if tables else value
    return found


def load(model: type[S], path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> S:
    """A mission's scenario file, checked; `settings` as in `read_document`. Raises ScenarioError, also for a setting that
    would change nothing."""
    return configured(model, read_toml(path), settings, source=str(path))


def configured(
    model: type[S], document: Mapping[str, Any], settings: Mapping[str, Any] | None = None, *, source: str
) -> S:
    """The same of a document that was read or made; `source` names it in errors."""
    found = checked(model, merged(document, nested(settings or {})), source=source)
    idle = found.idle_keys
    changes_nothing = [
        Complaint(key, repr(value), idle[key]) for key, value in (settings or {}).items() if key in idle
    ]
    if changes_nothing:
        raise ScenarioError(source, changes_nothing)
    return found


def checked(model: type[T], document: Mapping[str, Any], *, source: str) -> T:
    """The document as `model`; raises ScenarioError with every complaint, or that it is of another mission."""
    try:
        return model.model_validate(dict(document))
    except ValidationError as error:
        found = complaints(model, error)
        foreign = [each for each in found if each.key == "mission"] if "mission" in document else []
        raise ScenarioError(source, foreign or found) from error


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
        elif location == ["mission"] and detail["type"] == "literal_error":
            allowed = f"a scenario of another mission; must be {context['expected']}"
            found.append(Complaint("mission", repr(detail["input"]), allowed))
        elif detail["type"] == "missing" and location[-1].isdigit():
            allowed = f"entry {int(location[-1]) + 1} is missing"
            found.append(Complaint(".".join(location[:-1]), repr(detail["input"]), allowed))
        elif detail["type"] == "missing":
            found.append(Complaint(".".join(location), "", MISSING))
        else:
            found.append(Complaint(".".join(location), repr(detail["input"]), detail["msg"]))
    return found


def _unknown_key(model: type[BaseModel], location: list[str], value: Any) -> Complaint:
    allowed = sorted(_table_at(model, location[:-1]).model_fields)
    message = f"unknown key; allowed here: {', '.join(allowed)}"
    near = difflib.get_close_matches(location[-1], allowed, n=1, cutoff=0.5)
    if near:
        message += f". Did you mean {near[0]}? The unit is part of the key"
    return Complaint(".".join(location), repr(value), message)


def _table_at(model: type[BaseModel], location: list[str]) -> type[BaseModel]:
    """The model of the table at a dotted location; of an optional table or a list of tables, the table's."""
    for part in location:
        if part.isdigit():
            continue
        annotation = model.model_fields[part].annotation
        found = [annotation, *get_args(annotation)]
        [model] = [each for each in found if isinstance(each, type) and issubclass(each, BaseModel)]
    return model


def _unreadable(source: Path, message: str) -> ScenarioError:
    return ScenarioError(str(source), [Complaint("file", "", message)])
