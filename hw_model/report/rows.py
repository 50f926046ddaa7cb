"""The tables of a report, summed from a timeline. Times are whole picoseconds, so that columns add up."""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hw_model.vocabulary import ACCOUNTS, CAUSES, Cause, Module, Side

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.timing.actions import Action
    from hw_model.timing.durations import Durations
    from hw_model.timing.timeline import Segment, Timeline


@dataclass(frozen=True, slots=True)
class ModuleRow:
    """One module over the whole run. Copies count for the module whose stage reads the buffer."""

    module: Module
    side: Side
    runs: int
    cycles: int
    """In the clock of `side`, computing only."""
    picoseconds: int
    causes_picoseconds: dict[Cause, int]
    baseline_picoseconds: int


@dataclass(frozen=True, slots=True)
class StageRow:
    """One stage of one pattern: cycles of one run; for the PL, its L0 bound and what sets it."""

    pattern: int
    stage: str
    module: Module
    side: Side
    runs: int
    cycles_each: int
    lower_bound_each: int | None
    bottleneck: str
    origin: str
    """Of the PL's cycles: "schedule" (exact) or "estimate"; empty for the PS."""
    causes_each: dict[str, int]


@dataclass(frozen=True, slots=True)
class IterationRow:
    """One iteration of one solve, cause by cause; `picoseconds` is their sum."""

    solve: int
    iteration: int
    ps_cycles: int
    pl_cycles: int
    picoseconds: int
    causes_picoseconds: dict[Cause, int]


@dataclass(frozen=True, slots=True)
class SolveRow:
    """One solve of the trace."""

    solve: int
    status: str
    iterations: int
    picoseconds: int


@dataclass(frozen=True, slots=True)
class CopyRow:
    """All copies of one buffer in one direction."""

    pattern: int
    buffer: str
    to: Side
    count: int
    size_bytes: int
    picoseconds: int


class _Sum:
    """What accumulates for one row."""

    def __init__(self) -> None:
        self.picoseconds = 0
        self.cycles: dict[Side, int] = {"ps": 0, "pl": 0}
        self.causes: dict[Cause, int] = dict.fromkeys(CAUSES, 0)

    def add(self, segment: Segment) -> None:
        self.cycles[segment.side] += segment.cycles
        if segment.critical:
            self.picoseconds += segment.duration_picoseconds
            self.causes[segment.cause] += segment.duration_picoseconds


def module_rows(
    actions: list[Action], timeline: Timeline, partition: Partition, baseline: Timeline
) -> list[ModuleRow]:
    """A row for every module that takes time in `timeline` or `baseline`, the PS's own tasks first."""
    sums: defaultdict[Module, _Sum] = defaultdict(_Sum)
    for segment in timeline.segments:
        sums[segment.module].add(segment)
    runs = Counter(action.module for action in actions if action.work.kind == "compute")
    before = baseline.totals("module")
    return [
        ModuleRow(
            module=module,
            side=partition.side(module),
            runs=runs[module],
            cycles=sums[module].cycles[partition.side(module)],
            picoseconds=sums[module].picoseconds,
            causes_picoseconds=sums[module].causes,
            baseline_picoseconds=before.get((module,), 0),
        )
        for module in ACCOUNTS
        if module in sums or (module,) in before
    ]


def iteration_rows(timeline: Timeline) -> list[IterationRow]:
    """A row for every iteration of every solve, in order."""
    sums: defaultdict[tuple[int, int], _Sum] = defaultdict(_Sum)
    for segment in timeline.segments:
        sums[segment.solve, segment.iteration].add(segment)
    return [
        IterationRow(
            solve, iteration, total.cycles["ps"], total.cycles["pl"], total.picoseconds, total.causes
        )
        for (solve, iteration), total in sorted(sums.items())
    ]


def solve_rows(timeline: Timeline, durations: Durations) -> list[SolveRow]:
    """A row for every solve."""
    picoseconds = timeline.totals("solve")
    return [
        SolveRow(s, solve.status, solve.iterations, picoseconds.get((s,), 0))
        for s, solve in enumerate(durations.trace.solves)
    ]


def stage_rows(actions: list[Action], durations: Durations) -> list[StageRow]:
    """A row for every stage that runs, for the generation of problems and a counted outer loop, in the order of their first run."""
    runs = Counter(action.work for action in actions if action.work.kind in ("compute", "build", "outer"))
    named = {action.work: (action.stage, action.module) for action in actions}
    rows: list[StageRow] = []
    for work, count in runs.items():
        stage, module = named[work]
        parts = durations.parts(work)
        found = durations.pl_cycles(work) if work.side == "pl" else None
        rows.append(
            StageRow(
                pattern=work.pattern,
                stage=stage,
                module=module,
                side=work.side,
                runs=count,
                cycles_each=sum(part.cycles for part in parts),
                lower_bound_each=None if found is None else found.lower_bound,
                bottleneck="" if found is None else found.bottleneck,
                origin="" if found is None else found.origin,
                causes_each={part.cause: part.cycles for part in parts},
            )
        )
    return rows


def copy_rows(actions: list[Action], durations: Durations) -> list[CopyRow]:
    """A row for every buffer that crosses, per direction, the most expensive first."""
    counts = Counter(action.work for action in actions if action.work.kind == "copy")
    rows = [
        CopyRow(
            pattern=work.pattern,
            buffer=work.what,
            to=work.side,
            count=count,
            size_bytes=durations.size_bytes(work),
            picoseconds=count * sum(part.picoseconds for part in durations.parts(work)),
        )
        for work, count in counts.items()
    ]
    return sorted(rows, key=lambda row: (-row.picoseconds, row.pattern, row.buffer, row.to))
