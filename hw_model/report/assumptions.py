"""The parameters of a platform as a report echoes them: value, band, provenance, and whether the report uses them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .usage import why_ignored

if TYPE_CHECKING:
    from hw_model.platform.parameter import Tag
    from hw_model.platform.platform import Platform

    from .usage import ParameterUse


@dataclass(frozen=True, slots=True)
class Assumption:
    """One parameter; `used` says whether the report reads it."""

    key: str
    value: float | int | str
    low: float | int | None
    high: float | int | None
    tag: Tag
    source: str
    used: bool


def assumptions(platform: Platform, usage: ParameterUse) -> list[Assumption]:
    """Every parameter of `platform`, as a report that reads `usage` uses it."""
    return [
        Assumption(
            key, item.value, item.low, item.high, item.tag, item.source,
            why_ignored(key, platform, usage) is None,
        )
        for key, item in platform.parameters()
    ]  # fmt: skip
