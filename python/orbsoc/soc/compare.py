"""The model beside the chip: what `rocket_soc` says of the runs that were counted, part by part."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from hw_model import load_partition, load_platform
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.instructions import FOLDER, summed
from hw_model.timing.trace import Trace, parse_trace

if TYPE_CHECKING:
    from orbsoc.conic.problem import Problem
    from orbsoc.hw.schedules import Engine

    from .counted import Counted

DEVICE = "rocket_soc"
REST = "rest: certificate, calls, control"
LAUNCHED = ("launch", "interrupt", "flags", "compute", "control")
"""Kinds of work that the chip counts as a part on the PL: from a launch to its end."""


@dataclass(frozen=True, slots=True)
class Pair:
    """A part of a solve, or the whole, in clocks of the core."""

    name: str
    counted: int
    modelled: float

    @property
    def error(self) -> float:
        """Relative, of the modelled clocks."""
        return self.modelled / self.counted - 1.0


@cache
def _certificate() -> dict[str, float]:
    return dict(json.loads((FOLDER / "rocket.json").read_text(encoding="utf-8"))["rest"])


def pairs(runs: Sequence[Counted], problems: Sequence[Problem], partition: str | None, engine: Engine, ratio: float) -> list[Pair]:
    """Parts of the runs with what the model says of them, the dearest first, then the whole; without loading the program.

    `problems`: of each run, solved with the usual settings. `partition`: None for the core alone.
    """
    counted: defaultdict[str, int] = defaultdict(int)
    modelled: defaultdict[str, float] = defaultdict(float)
    for run, problem in zip(runs, problems, strict=True):
        trace = _trace(problem)
        for name, clocks in _modelled(trace, problem, partition, engine, ratio).items():
            modelled[name] += clocks
        inside = 0
        for part in run.stages:
            inside += part.core_cycles
            if part.name != "load":
                counted[part.name if part.where != "link" else "link"] += part.core_cycles
        counted[REST] += run.core_cycles - inside
    rows = [Pair(name, clocks, modelled[name]) for name, clocks in counted.items()]
    rows.sort(key=lambda row: -row.counted)
    return [*rows, Pair("whole", sum(counted.values()), sum(modelled.values()))]


def _trace(problem: Problem) -> Trace:
    from orbsoc.hw.emulation import PsScheduler

    scheduler = PsScheduler()
    scheduler(problem)
    return parse_trace(scheduler.trace)


def _modelled(trace: Trace, problem: Problem, partition: str | None, engine: Engine, ratio: float) -> dict[str, float]:
    """Clocks of the core by part, as the chip counts them."""
    from orbsoc.hw.exact_cycles import exact_cycles

    platform = load_platform(DEVICE)
    values: dict[str, Any] = {
        "pl.clock_mhz": platform.ps.clock_mhz.value / ratio, "pl.lanes": engine.lanes, "pl.dividers": engine.dividers,
        "pl.banks": engine.banks, "pl.clusters": engine.clusters,
    }  # fmt: skip
    split = load_partition(partition or "all_ps")
    durations = Durations(trace, platform.with_values(values), split, exact_cycles([problem]))
    found: defaultdict[str, float] = defaultdict(float)
    for action in actions_of(trace, split):
        work = action.work
        name = action.stage
        if work.kind in ("copy", "publish", "rest"):
            name = "link"
        elif split.control == "pl" and work.kind in LAUNCHED:
            name = "attempt"
        found[name] += durations.picoseconds(work) / 1000.0
    pattern = trace.patterns[0]
    sizes = {"run": 1, "unknowns": pattern.n + pattern.p + pattern.m, "nonzeros_kkt": pattern.nnz_kkt}
    found[REST] += summed(_certificate(), sizes)
    return found


def lines_of(rows: Sequence[Pair], title: str) -> list[str]:
    """A table: parts of a hundredth or more, and the whole."""
    whole = rows[-1]
    named = [row for row in rows if row.counted >= whole.counted / 100]
    width = max(len(row.name) for row in named)
    lines = [f"{title}: counted and modelled", f"{'part'.ljust(width)}  {'counted':>11}  {'modelled':>11}  {'error':>7}   share"]
    lines += [
        f"{row.name.ljust(width)}  {row.counted:11d}  {row.modelled:11.0f}  {100 * row.error:+6.1f} %  {100 * row.counted / whole.counted:4.1f} %"
        for row in named
    ]
    return lines
