"""Scenario files: TOML in, a checked scenario out, or an error that names key, value and what is allowed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar, cast, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from orbsoc.files.nearest import nearest
from orbsoc.orbit import ConstantsSet

from .allowed_values import allowed_words, key_schema, unit_of
from .body import CentralBody


class Table(BaseModel):
    """A table of a scenario file: unknown keys, coerced types, NaN and infinity are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class BaseScenario(Table):
    """A whole scenario file: which mission it is of, its name, and what the mission adds."""

    mission: str
    name: str = Field(min_length=1)
    body: CentralBody = CentralBody()

    ABOUT_THE_EARTH: ClassVar[str] = "its mission plans about the Earth alone"
    """Why a mission takes no other body; empty where it does."""

    @property
    def constants(self) -> ConstantsSet:
        """Of the body that the orbits are about."""
        return self.body.constants

    @model_validator(mode="after")
    def _body(self) -> Self:
        if self.ABOUT_THE_EARTH and self.body.name != "earth":
            refuse([Complaint("body.name", repr(self.body.name), f"{self.ABOUT_THE_EARTH}; must be 'earth'")])
        for key in type(self).model_fields:
            table = getattr(self, key)
            if isinstance(table, BaseModel) and "_about" in table.__private_attributes__:
                table._about = self.constants  # type: ignore[attr-defined]
        return self

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
        return checked(type(self), merged(self.model_dump(exclude_unset=True), changes), source=self.name)


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


def refused(key: str, value: str, allowed: str) -> PydanticCustomError:
    """For a model's validator, which raises it: one complaint."""
    context = {"key": key, "value": value, "allowed": allowed}
    return PydanticCustomError("physics", "{key} = {value}: {allowed}", context)


def refuse(complaints: Iterable[Complaint]) -> None:
    """For a model's validator: raise the first complaint, if there is one. Pydantic reports one error per validator."""
    for each in complaints:
        raise refused(each.key, each.value, each.allowed)


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
        raise _unreadable(
            source, f"no such file; give the path of a scenario in TOML.{_beside(source)}"
        ) from error
    except (OSError, UnicodeDecodeError) as error:
        raise _unreadable(source, f"cannot be read as UTF-8 text: {error}") from error
    try:
        return _files_beside(tomllib.loads(text), source.parent)
    except tomllib.TOMLDecodeError as error:
        other = "; `orbsoc solve` takes a problem in JSON" if source.suffix == ".json" else ""
        raise _unreadable(source, f"not TOML: {error}{other}") from error


FILE_KEYS = ("oem", "omm")


def _files_beside(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The document with names of files that count from the scenario's folder."""
    found: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            value = _files_beside(value, folder)
        found[key] = str(folder / value) if key in FILE_KEYS and isinstance(value, str) else value
    return found


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
    """A mission's scenario file, checked; `settings` are values in place of its own by dotted key, "vehicle.thrust_n". Raises
    ScenarioError, also for a setting that would change nothing."""
    return configured(model, read_toml(path), settings, source=str(path))


def of_mission(model: type[S], folder: Path) -> Iterator[S]:
    """The scenarios of a folder that are of the model's mission, by the names of their files. Raises ScenarioError."""
    [mission] = get_args(model.model_fields["mission"].annotation)
    for path in sorted(folder.glob("*.toml")):
        if read_toml(path).get("mission") == mission:
            yield load(model, path)


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
        if detail["type"] == "default_factory_not_called":
            continue  # what it would be made from is refused by itself
        if detail["type"] == "physics":
            key = context["key"]  # one that begins with a dot counts from the table that was refused
            key = ".".join([*location, key[1:]]) if key.startswith(".") else key
            found.append(Complaint(key, context["value"], context["allowed"]))
        elif detail["type"] == "extra_forbidden":
            found.append(_unknown_key(model, location, detail["input"]))
        elif location == ["mission"] and detail["type"] == "literal_error":
            allowed = f"a scenario of another mission; must be {context['expected']}"
            found.append(Complaint("mission", repr(detail["input"]), allowed))
        elif detail["type"] == "missing" and location[-1].isdigit():
            allowed = f"entry {int(location[-1]) + 1} is missing"
            found.append(Complaint(".".join(location[:-1]), repr(detail["input"]), allowed))
        elif detail["type"] == "missing":
            words = missing_words(_table_at(model, location[:-1]), location[-1])
            found.append(Complaint(".".join(location), "", words))
        else:
            words = detail["msg"] + ("" if detail["type"] == "literal_error" else _also(model, location))
            found.append(Complaint(".".join(location), repr(detail["input"]), words))
    return found


def missing_words(model: type[BaseModel], key: str) -> str:
    """That the key is missing, what it may be, its unit and its meaning."""
    meaning = ", ".join(filter(None, (unit_of(key), key_schema(model, key).get("description", ""))))
    return f"{MISSING}; must be {allowed_words(model, key)}{meaning and f' ({meaning})'}"


def _also(model: type[BaseModel], location: list[str]) -> str:
    """What a key that was refused may be, and its default; empty for an entry of a list."""
    if any(part.isdigit() for part in location):
        return ""
    table, key = _table_at(model, location[:-1]), location[-1]
    if key not in table.model_fields:
        return ""
    default = key_schema(table, key).get("default")
    return f"; must be {allowed_words(table, key)}" + ("" if default is None else f", default {default!r}")


def _unknown_key(model: type[BaseModel], location: list[str], value: Any) -> Complaint:
    allowed = sorted(_table_at(model, location[:-1]).model_fields)
    message = f"unknown key; allowed here: {', '.join(allowed)}"
    near, elsewhere = nearest(location[-1], allowed), _in_another_table(model, location)
    if elsewhere:
        message += f". Did you mean {elsewhere}?"
    elif near:
        message += f". Did you mean {near}? The unit is part of the key"
    return Complaint(".".join(location), repr(value), message)


def _in_another_table(model: type[BaseModel], location: list[str]) -> str:
    """Where a key of that very name stands, if not in its table; empty where there is none, or more than one."""
    tables = {"": model}
    tables |= {
        f"{name}.": table for name in model.model_fields if (table := table_of(model, name)) is not None
    }
    found = [f"{name}{location[-1]}" for name, table in tables.items() if location[-1] in table.model_fields]
    return found[0] if len(found) == 1 else ""


def table_of(model: type[BaseModel], key: str) -> type[BaseModel] | None:
    """The model of a key that holds a table; None for any other."""
    found = _tables_of(model, key)
    return found[0] if found else None


def tables_by_name(model: type[BaseModel], key: str) -> bool:
    """Whether a key holds tables by names of the user's own."""
    return get_origin(model.model_fields[key].annotation) is dict and table_of(model, key) is not None


def _tables_of(model: type[BaseModel], key: str) -> list[type[BaseModel]]:
    annotation = model.model_fields[key].annotation
    found = [annotation, *get_args(annotation)]
    return [each for each in found if isinstance(each, type) and issubclass(each, BaseModel)]


def _table_at(model: type[BaseModel], location: list[str]) -> type[BaseModel]:
    """The model of the table at a dotted location; of an optional table, a list of tables or tables by name, the table's."""
    for part in location:
        if part not in model.model_fields:  # a number, or a name
            continue
        [model] = _tables_of(model, part)
    return model


def _beside(source: Path) -> str:
    """The file beside it, or in scenarios/, that was perhaps meant."""
    known = [
        str(path) for folder in (source.parent, Path("scenarios")) for path in sorted(folder.glob("*.toml"))
    ]
    by_name = {Path(path).stem: path for path in reversed(known)}
    near = nearest(source.stem, by_name)
    return f" Did you mean {by_name[near]}?" if near else ""


def _unreadable(source: Path, message: str) -> ScenarioError:
    return ScenarioError(str(source), [Complaint("file", "", message)])
