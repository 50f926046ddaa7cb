"""The model beside the chip: what `rocket_soc` says of the runs that were counted, part by part.

Instructions of a part on the core are the run's own; what the model says is how many clocks they take. Parts on the PL and the link
come of the pattern alone.
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from hw_model import load_partition, load_platform
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.instructions import FOLDER, recorded
from hw_model.timing.ps import cycles_of
from hw_model.timing.trace import Trace, parse_trace
from orbsoc import _core

from .table import REST, rest_of

if TYPE_CHECKING:
    from orbsoc.hw.schedules import Engine
    from orbsoc.hw.workload import Posed

    from .counted import Counted

DEVICE = "rocket_soc"
NEEDS_RESIDUAL = 1
"""Place in the buffer `control` (flight/layout.h)."""
LINK, LOAD = "link", "load"
LAUNCH, INTERRUPT = "launch", "interrupt"
"""Within the parts on the PL: writing their launches, and the handlers at their ends."""
_NOT_THERE = ("build", "rest")
"""What the chip's program does not do: it finds its problem in memory, and reads no status before it takes an answer."""
_WITHIN = {"launch": LAUNCH, "interrupt": INTERRUPT, "flags": INTERRUPT}
LATENCY = 20
"""Clocks of memory that `rocket_soc` is of."""
_Clocks = defaultdict[str, float]
"""By part."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A part of a solve, or the whole, in clocks of the core. `within`: it is in other parts."""

    name: str
    counted: int
    modelled: float
    within: bool = False

    @property
    def error(self) -> float:
        """Relative, of the modelled clocks."""
        return self.modelled / self.counted - 1.0


def pairs(
    runs: Sequence[Counted], solves: Sequence[Posed], partition: str | None, engine: Engine, ratio: float
) -> list[Pair]:
    """Parts of the runs with what the model says of them, the dearest first, what is within them, then the whole; without loading the
    program.

    `solves`: of each run. `partition`: None for the core alone. `ratio`: core clocks in one of
    the engine.
    """
    counted, modelled = Counter[str](), _Clocks(float)
    within, modelled_within = Counter[str](), _Clocks(float)
    for run, posed in zip(runs, solves, strict=True):
        found, inside = _modelled(run, posed, partition, engine, ratio)
        _add(modelled, found)
        _add(modelled_within, inside)
        for part in run.stages:
            if part.name != LOAD:
                counted[LINK if part.where == "link" else part.name] += part.core_cycles
        counted[REST] += rest_of([run])[0]
        for part in run.within:
            within[part.name] += part.core_cycles
    rows = [Pair(name, clocks, modelled[name]) for name, clocks in counted.items()]
    rows.sort(key=lambda row: -row.counted)
    rows += [Pair(name, clocks, modelled_within[name], within=True) for name, clocks in within.items()]
    return [*rows, Pair("whole", sum(counted.values()), sum(modelled.values()))]


def lines_of(rows: Sequence[Pair], title: str) -> list[str]:
    """A table of the parts of a hundredth or more, of what is within them, and of the whole."""
    whole = rows[-1].counted
    named = [row for row in rows if row.within or row.counted >= whole / 100]
    names = [f"of these: {row.name}" if row.within else row.name for row in named]
    width = max(map(len, names))
    lines = [title, f"{'part'.ljust(width)}  {'counted':>11}  {'modelled':>11}    error   share"]
    return lines + [
        f"{name.ljust(width)}  {row.counted:11d}  {row.modelled:11.0f}  {row.error:+7.1%}  {row.counted / whole:6.1%}"
        for name, row in zip(names, named, strict=True)
    ]


def _add(sums: _Clocks, found: _Clocks) -> None:
    for name, clocks in found.items():
        sums[name] += clocks


def _modelled(
    run: Counted, posed: Posed, partition: str | None, engine: Engine, ratio: float
) -> tuple[_Clocks, _Clocks]:
    """Clocks of the core by part, as the chip counts them, and of what is within parts."""
    from orbsoc.hw.emulation import PsScheduler
    from orbsoc.hw.exact_cycles import exact_cycles

    scheduler = PsScheduler()
    scheduler(*posed)
    trace, split = parse_trace(scheduler.trace), load_partition(partition or "all_ps")
    platform = load_platform(DEVICE)
    shape: dict[str, Any] = {
        "pl.clock_mhz": platform.ps.clock_mhz.value / ratio, "pl.lanes": engine.lanes, "pl.dividers": engine.dividers,
        "pl.banks": engine.banks, "pl.clusters": engine.clusters,
    }  # fmt: skip
    platform = platform.with_values(shape)
    durations = Durations(
        trace, platform, split, exact_cycles([posed.problem], (), [posed.settings], engine.address_bits)
    )
    found, within = _Clocks(float), _Clocks(float)
    for action in actions_of(trace, split):
        work, clocks = action.work, durations.picoseconds(action.work) / 1000.0
        if work.kind in _NOT_THERE or (work.kind == "compute" and work.side == "ps"):
            continue
        if work.kind in ("copy", "publish"):
            found[LINK] += clocks
        else:
            found["attempt" if split.control == "pl" else action.stage] += clocks
        if work.kind in _WITHIN:
            within[_WITHIN[work.kind]] += clocks
    pattern = trace.patterns[0]
    shares = _shares(posed, trace) if partition is None else {}
    there = {part.name for part in run.stages if part.where == "PL"}
    calls = platform.ps.cycles_per_instruction.value
    for part in run.stages:
        if part.where == "core" and part.name in there:
            found[part.name] += part.instructions * calls
        elif part.where == "core" and part.name in pattern.stages:
            each = part.instructions / part.runs
            clocks = cycles_of(each, part.name, pattern, platform.ps, "f64", share=shares.get(part.name, 1.0))
            found[part.name] += part.runs * clocks
    found[REST] += (
        rest_of([run])[1] * _record(platform.ps.instruction_record)["rest"]["cycles_per_instruction"]
    )
    return found, within


def _shares(posed: Posed, trace: Trace) -> dict[str, float]:
    """Of the stages that the core alone runs without a residual where no decision needs it: the share of its work that is done."""
    law, pattern = recorded(load_platform(DEVICE).ps.instruction_record), trace.patterns[0]
    native, spared = _core.Engine(*posed), Counter[str]()
    events = trace.solves[0].events
    for name, _ in events:
        spared[name] += int(
            f"{name}, spared" in law.costs and native.buffer("control")[NEEDS_RESIDUAL] == 0.0
        )
        native.run(name)
    runs = Counter(name for name, _ in events)
    left = {
        name: law.instructions(f"{name}, spared", pattern) / law.instructions(name, pattern)
        for name in +spared
    }
    return {name: 1.0 - max(0.0, 1.0 - left[name]) * spared[name] / runs[name] for name in left}


@cache
def _record(name: str) -> dict[str, Any]:
    return dict(json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8")))
