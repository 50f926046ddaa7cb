"""Why two configurations differ, cause by cause and module by module: every difference adds up to the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hw_model.area.budget import Budget, budget
from hw_model.energy.joules import EnergyUse, counter_of, energy_use
from hw_model.timing.actions import actions_of
from hw_model.timing.stage_cycles import StageCycles, estimated
from hw_model.timing.timeline import Timeline
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import ACCOUNTS, CAUSES, Cause, Module

from .bands import corners_of
from .loading import Loading, loading
from .run import durations_of, simulate
from .speedup import ESTIMATED_WORDS
from .usage import EXPLAIN_USAGE, is_scheduled, why_ignored

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
    """Every parameter in which the two computers differ and that either run reads, with both values."""
    moved: tuple[str, ...]
    """Modules that are on another side."""
    a_energy: EnergyUse
    b_energy: EnergyUse
    a_area: Budget
    b_area: Budget
    a_loading: Loading
    b_loading: Loading
    estimated: bool
    """Whether cycles of the PL are estimated on either side."""

    @property
    def headline(self) -> str:
        """One sentence: which is faster, by how much, the largest cause, and whether PL cycles are estimated."""
        return self._comparison + (ESTIMATED_WORDS if self.estimated else "")

    @property
    def _comparison(self) -> str:
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

    @property
    def computer_lines(self) -> tuple[str, ...]:
        """Whether each engine fits, and what loading its programs takes."""
        sides = (("A", self.a_area, self.a_loading), ("B", self.b_area, self.b_loading))
        return tuple(
            f"{name}: {area.words}; {loaded.words}" for name, area, loaded in sides if loaded.patterns
        )

    @property
    def energy_line(self) -> str:
        """The energy of either, and of which action most of the difference is."""
        one, other = (
            {row.action: row.nominal_mj for row in use.rows} for use in (self.a_energy, self.b_energy)
        )
        changes = {action: other.get(action, 0.0) - one.get(action, 0.0) for action in one | other}
        most = max(changes, key=lambda action: abs(changes[action]))
        where = (
            f"most of the difference is {most}, {changes[most]:+.2f} mJ"
            if changes[most]
            else "no action differs"
        )
        return (
            f"modelled energy: A {self.a_energy.nominal_mj:.2f} mJ, B {self.b_energy.nominal_mj:.2f} mJ"
            f" ({self.b_energy.low_mj:.2f}–{self.b_energy.high_mj:.2f}); {where}"
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-able data, differences in milliseconds."""
        return {
            "schema": "orbsoc.hardware-difference/1",
            "provenance": "modelled",
            "headline": self.headline,
            "energy_line": self.energy_line,
            "a": {
                "name": self.a,
                "time_ms": self.a_picoseconds / 1e9,
                "energy_mj": self.a_energy.nominal_mj,
                "fits": self.a_area.fits,
                "area": self.a_area.by_kind(),
                "storage_words": self.a_area.storage_words,
                **self.a_loading.row(),
            },
            "b": {
                "name": self.b,
                "time_ms": self.b_picoseconds / 1e9,
                "energy_mj": self.b_energy.nominal_mj,
                "fits": self.b_area.fits,
                "area": self.b_area.by_kind(),
                "storage_words": self.b_area.storage_words,
                **self.b_loading.row(),
            },
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
    one, other = (simulate(checked, side.platform, side.partition, cycles) for side in (a, b))
    parameters = tuple(
        (key, mine.value, theirs.value)
        for (key, mine), (_, theirs) in zip(a.platform.parameters(), b.platform.parameters(), strict=True)
        if mine.value != theirs.value and _read(key, checked, a, b, cycles)
    )
    moved = tuple(name for name, side in a.partition.modules.items() if b.partition.modules[name] != side)
    causes, modules = _pairs(one, other, "cause"), _pairs(one, other, "module")
    both = _pairs(one, other, "module", "cause")
    here, there = (budget(checked, side.platform, side.partition, cycles) for side in (a, b))
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
        _energy(checked, a, cycles),
        _energy(checked, b, cycles),
        here,
        there,
        loading(a.platform, here.programs),
        loading(b.platform, there.programs),
        any(
            side.partition.uses_pl and not is_scheduled(checked, side.partition, side.platform, cycles)
            for side in (a, b)
        ),
    )


def _energy(trace: Trace, side: Configuration, cycles: StageCycles) -> EnergyUse:
    """Over the corners of the assumed bands."""
    nominal = durations_of(trace, side.platform, side.partition, cycles)
    corners = [nominal.on(corner) for corner in corners_of(side.platform)]
    return energy_use(corners, counter_of(actions_of(trace, side.partition), side.partition))


def _read(key: str, trace: Trace, a: Configuration, b: Configuration, cycles: StageCycles) -> bool:
    """Whether time or energy of either side depends on the parameter."""
    usages = ((side, EXPLAIN_USAGE.of(trace, side.partition, side.platform, cycles)) for side in (a, b))
    return any(why_ignored(key, side.platform, usage) is None for side, usage in usages)


def _pairs(one: Timeline, other: Timeline, *levels: Any) -> dict[tuple[Any, ...], tuple[int, int]]:
    mine, theirs = one.totals(*levels), other.totals(*levels)
    return {key: (mine.get(key, 0), theirs.get(key, 0)) for key in mine.keys() | theirs.keys()}


def _ms(pair: tuple[int, int]) -> dict[str, float]:
    return {"a": pair[0] / 1e9, "b": pair[1] / 1e9, "difference": (pair[1] - pair[0]) / 1e9}
