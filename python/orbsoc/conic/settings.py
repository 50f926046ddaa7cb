"""Solver settings: one frozen record, the same names as the Rust `Settings`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from difflib import get_close_matches
from numbers import Integral, Real
from typing import Any

from .errors import SettingsError

COUNTS = {
    "max_iterations": (1, 100_000),
    "refinement_max": (0, 100),
    "ruiz_passes": (0, 100),
    "max_restarts": (0, 100),
}
"""Least and most of each count, as in the core, which allocates for as many in advance."""

POSITIVE = (
    "tol", "tol_inaccurate", "max_time_s", "static_regularization", "pivot_floor", "dynamic_regularization",
    "refinement_tol", "refinement_share", "step_fraction",
)  # fmt: skip
"""What has to be above zero, and, but for the time, finite, as in the core."""

ORDERINGS = ("amd", "nested_dissection", "automatic")
"""Orders of the KKT matrix's elimination, as in the core."""

_KINDS: dict[str, tuple[type, Any, str]] = {
    "bool": (bool, bool, "True or False"),
    "int": (Integral, int, "an integer"),
    "float": (Real, float, "a number"),
    "str": (str, str, "a string"),
}
"""Of a field's annotation: what is taken, what it becomes, and how an error calls it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What a solve may spend and how exact it must be.

    `tol` is the relative tolerance of docs/algorithm.md's status table (primal and dual
    residual, gap); `tol_inaccurate` the one at which `SOLVED_INACCURATE` is reported.
    `ordering`: the order of the KKT matrix's elimination; each has bits of its own, the same on every path.
    """

    tol: float = 1e-8
    tol_inaccurate: float = 1e-5
    max_iterations: int = 100
    max_time_s: float = float("inf")
    verbose: bool = False
    static_regularization: float = 1e-8
    pivot_floor: float = 1e-13
    dynamic_regularization: float = 1e-5
    refinement_tol: float = 1e-12
    refinement_share: float = 0.03
    refinement_max: int = 10
    step_fraction: float = 0.99
    ruiz_passes: int = 4
    max_restarts: int = 4
    ordering: str = "amd"

    def __new__(cls, **values: Any) -> Settings:
        """Before the fields are set: an unknown name is refused with the nearest that there is."""
        refuse_unknown(values)
        return object.__new__(cls)

    def __post_init__(self) -> None:
        for name, kind in self.__annotations__.items():
            value = getattr(self, name)
            if type(value).__name__ != kind:
                object.__setattr__(self, name, _typed(name, kind, value))
        for name in POSITIVE:
            value = getattr(self, name)
            if not value > 0.0:
                raise SettingsError(f"settings: {name} = {value!r} must be a positive number")
            if name != "max_time_s" and value == float("inf"):
                raise SettingsError(f"settings: {name} = {value!r} must be finite")
        if self.step_fraction >= 1.0:
            raise SettingsError(f"settings: step_fraction = {self.step_fraction!r} must be less than 1")
        if self.ordering not in ORDERINGS:
            allowed = ", ".join(ORDERINGS)
            raise SettingsError(f"settings: ordering = {self.ordering!r} must be one of {allowed}")
        for name, (least, most) in COUNTS.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise SettingsError(f"settings: {name} = {value!r} must be at least {least}, at most {most}")

    def __str__(self) -> str:
        return "\n".join(f"{f.name:<18} {getattr(self, f.name)}" for f in fields(self))


def refuse_unknown(names: Iterable[str]) -> None:
    """TypeError for the first name that is no setting, with the nearest that is one."""
    known = Settings.__annotations__
    for name in names:
        if name not in known:
            near = [other for other in known if name.startswith(other)] or get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"
            raise TypeError(f"unknown setting {name!r}; {hint}")


def _typed(name: str, annotation: Any, value: Any) -> bool | int | float | str:
    """The value as its field's type; TypeError names the field."""
    taken, made, expected = _KINDS[annotation]
    if not isinstance(value, taken) or (isinstance(value, bool) and taken is not bool):
        raise TypeError(f"settings: {name} = {value!r} must be {expected}")
    try:
        out: bool | int | float | str = made(value)
    except OverflowError:
        raise SettingsError(f"settings: {name} is too large, {value!r:.20}…") from None
    return out
