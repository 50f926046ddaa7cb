"""Why two configurations differ, cause by cause and module by module: every difference adds up to the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hw_model.timing.stage_cycles import StageCycles, estimated
from hw_model.timing.timeline import Timeline, as_partition, as_platform, simulate
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import ACCOUNTS, CAUSES, Cause, Module

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Trace


@dataclass(frozen=True, slots=True)
class Configuration:
    """A computer and a partition, under the name that a user gave the two."""

    name: str
    platform: Platform
    partition: Partition


@dataclass(frozen=True, slots=True)
class Difference:
    """B minus A, in picoseconds. Σ over causes = Σ over (module, cause) = the difference of the makespans."""

    a: str
    b: str
    a_picoseconds: int
    b_picoseconds: int
    by_cause: dict[Cause, tuple[int, int]]
    by_module: dict[Module, tuple[int, int]]
    by_module_and_cause: dict[tuple[Module, Cause], tuple[int, int]]
    parameters: tuple[tuple[str, object, object], ...]
    """Every parameter in which the two computers differ, with both values."""
    moved: tuple[str, ...]
    """Modules that are on another side."""

    @property
    def headline(self) -> str:
        """One sentence: which is faster, by how much, and the largest cause."""
        change = self.b_picoseconds - self.a_picoseconds
        if not change:
            return f"modelled: {self.a} and {self.b} take the same time, {self.a_picoseconds / 1e9:.3f} ms"
        cause = max(
            self.by_cause, key=lambda name: (self.by_cause[name][1] - self.by_cause[name][0]) * change
        )
        part = self.by_cause[cause][1] - self.by_cause[cause][0]
        return (
            f"modelled: {self.b} takes {self.b_picoseconds / 1e9:.3f} ms, {self.a} {self.a_picoseconds / 1e9:.3f} ms:"
            f" {change / 1e9:+.3f} ms ({self.a_picoseconds / self.b_picoseconds:.2f}×), of which {cause} is {part / 1e9:+.3f} ms"
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-able data, differences in milliseconds."""
        return {
            "schema": "orbsoc.hardware-difference/1",
            "provenance": "modelled",
            "headline": self.headline,
            "a": {"name": self.a, "time_ms": self.a_picoseconds / 1e9},
            "b": {"name": self.b, "time_ms": self.b_picoseconds / 1e9},
            "moved": list(self.moved),
            "parameters": [{"key": key, "a": one, "b": other} for key, one, other in self.parameters],
            "by_cause_ms": {cause: _ms(pair) for cause, pair in self.by_cause.items()},
            "by_module_ms": {module: _ms(pair) for module, pair in self.by_module.items()},
            "by_module_and_cause_ms": [
                {"module": module, "cause": cause, **_ms(pair)}
                for (module, cause), pair in self.by_module_and_cause.items()
            ],
        }


def explain(
    trace: Mapping[str, Any] | Trace, a: Configuration, b: Configuration, cycles: StageCycles = estimated
) -> Difference:
    """What B takes more or less than A on the same trace. Raises TraceError."""
    checked = parse_trace(trace)
    one, other = (
        simulate(checked, as_platform(side.platform), as_partition(side.partition), cycles) for side in (a, b)
    )
    parameters = tuple(
        (key, mine.value, theirs.value)
        for (key, mine), (_, theirs) in zip(a.platform.parameters(), b.platform.parameters(), strict=True)
        if mine.value != theirs.value
    )
    moved = tuple(name for name, side in a.partition.modules.items() if b.partition.modules[name] != side)
    causes, modules = _pairs(one, other, "cause"), _pairs(one, other, "module")
    both = _pairs(one, other, "module", "cause")
    return Difference(
        a.name,
        b.name,
        one.makespan_picoseconds,
        other.makespan_picoseconds,
        {cause: causes[cause,] for cause in CAUSES if (cause,) in causes},
        {module: modules[module,] for module in ACCOUNTS if (module,) in modules},
        {(m, c): both[m, c] for m in ACCOUNTS for c in CAUSES if (m, c) in both},
        parameters,
        moved,
    )


def _pairs(one: Timeline, other: Timeline, *levels: Any) -> dict[tuple[Any, ...], tuple[int, int]]:
    mine, theirs = one.totals(*levels), other.totals(*levels)
    return {key: (mine.get(key, 0), theirs.get(key, 0)) for key in mine.keys() | theirs.keys()}


def _ms(pair: tuple[int, int]) -> dict[str, float]:
    return {"a": pair[0] / 1e9, "b": pair[1] / 1e9, "difference": (pair[1] - pair[0]) / 1e9}
