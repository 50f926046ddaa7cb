"""A report as Markdown, for a reader: verdict, assumptions, where the time goes, why."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from statistics import mean
from typing import TYPE_CHECKING

from hw_model.vocabulary import CAUSES, PL_CAUSES, by_place

if TYPE_CHECKING:
    from hw_model.platform.platform import Assumption

    from .report import Report
    from .rows import IterationRow

_FEW_ITERATIONS = 40


def render(report: Report) -> str:
    """The whole report; every time in it is modelled, and its headings say so."""
    parts = [
        f"# Modelled cycle budget: {report.partition} on {report.device}",
        f"**{report.headline}.**",
        *([f"**{report.deadline_line}.**"] if report.deadline else []),
        *_slower(report),
        f"{report.description}. {report.core} as PS; PL engine of {report.lanes} lanes at "
        f"{report.pl_clock_mhz:g} MHz; datapath {report.datapath}; on the PL: "
        f"{', '.join(report.modules_on_pl) or 'nothing'}. Brackets hold the band over the assumed ranges.",
        "## Assumptions",
        _assumptions(report.assumptions),
        "Not modelled:\n\n" + "\n".join(f"- {line}" for line in report.not_modelled),
        "## Modelled time by cause",
        _causes(report),
        "## Modelled time by module",
        _modules(report),
        "## Modelled cycles of one run of each stage",
        _stages(report),
        "## Modelled time by iteration",
        _iterations(report),
        "## Transfers and interrupts",
        _transfers(report),
    ]
    return "\n\n".join(parts) + "\n"


def _slower(report: Report) -> list[str]:
    if not report.slower_modules:
        return []
    named = ", ".join(
        f"{row.module} ({_us(row.picos)} µs instead of {_us(row.baseline_picos)} µs)"
        for row in report.slower_modules
    )
    return [f"Modelled slower on the PL than in {report.baseline}, copies and interrupts included: {named}."]


def _assumptions(rows: Iterable[Assumption]) -> str:
    order = {"assumed": 0, "sourced": 1, "measured": 2}
    used = sorted((row for row in rows if row.used), key=lambda row: order[row.tag])
    return _table(
        ("parameter", "value", "band", "tag", "source"),
        [
            (
                f"`{row.key}`",
                row.value if isinstance(row.value, str) else f"{row.value:g}",
                "" if row.low is None or row.high is None else f"{row.low:g}–{row.high:g}",
                row.tag,
                row.source,
            )
            for row in used
        ],
    )


def _causes(report: Report) -> str:
    total = report.makespan_picos
    rows = [
        (cause, _us(report.causes_picos[cause]), f"{100 * report.causes_picos[cause] / total:.1f} %")
        for cause in CAUSES
    ]
    return _table(("cause", "µs", "share"), [*rows, ("**sum**", _us(total), "100.0 %")])


def _modules(report: Report) -> str:
    head = (
        "module",
        "on",
        "runs",
        "cycles",
        "compute µs",
        "link µs",
        "interrupt µs",
        "sum µs",
        f"{report.baseline} µs",
    )
    rows: list[tuple[str, ...]] = []
    for row in report.modules:
        parts = by_place(row.causes_picos)
        computing = parts["PS"] + parts["PL"]
        times = (computing, parts["link"], parts["interrupt"], row.picos, row.baseline_picos)
        rows.append(
            (row.module, row.side.upper(), f"{row.runs}", f"{row.cycles}", *(_us(time) for time in times))
        )
    return _table(head, rows)


def _stages(report: Report) -> str:
    head = (
        "stage",
        "module",
        "on",
        "runs",
        "cycles",
        "from",
        "L0 bound",
        "bottleneck",
        *PL_CAUSES,
    )
    several = len({row.pattern for row in report.stages}) > 1
    rows = [
        (
            f"{row.stage} (pattern {row.pattern})" if several else row.stage,
            row.module,
            row.side.upper(),
            f"{row.runs}",
            f"{row.cycles_each}",
            row.origin,
            "" if row.lower_bound_each is None else f"{row.lower_bound_each}",
            row.bottleneck,
            *(f"{row.causes_each.get(cause, 0)}" if row.side == "pl" else "" for cause in PL_CAUSES),
        )
        for row in report.stages
    ]
    note = (
        "Cycles are in the clock of the side. Those of the PL come from an exact schedule, equal to the RTL, or are an "
        "estimate above the L0 bound."
    )
    return f"{_table(head, rows)}\n\n{note}"


def _iterations(report: Report) -> str:
    head = (
        "solve",
        "iteration",
        "PS cycles",
        "PL cycles",
        "PS µs",
        "PL µs",
        "link µs",
        "interrupt µs",
        "sum µs",
    )
    if len(report.iterations) <= _FEW_ITERATIONS:
        return _table(
            head,
            [
                (f"{row.solve}", f"{row.iteration}", f"{row.ps_cycles}", f"{row.pl_cycles}", *_times(row))
                for row in report.iterations
            ],
        )
    rows: list[tuple[str, ...]] = []
    for solve, group in groupby(report.iterations, key=lambda row: row.solve):
        times = [row.picos for row in group]
        outcome = report.solves[solve]
        rows.append(
            (
                f"{solve}",
                outcome.status,
                f"{outcome.iterations}",
                _us(min(times)),
                _us(mean(times)),
                _us(max(times)),
                _us(outcome.picos),
            )
        )
    return _table(("solve", "status", "iterations", "shortest µs", "mean µs", "longest µs", "sum µs"), rows)


def _times(row: IterationRow) -> tuple[str, ...]:
    return tuple(_us(time) for time in (*by_place(row.causes_picos).values(), row.picos))


def _transfers(report: Report) -> str:
    lines = [f"{report.launches} launches, {report.interrupts} interrupts."]
    for to in ("pl", "ps"):
        rows = [row for row in report.copies if row.to == to]
        lines.append(
            f"To the {to.upper()}: {sum(row.count for row in rows)} copies, "
            f"{sum(row.count * row.size_bytes for row in rows)} bytes, {_us(sum(row.picos for row in rows))} µs."
        )
    if report.copies:
        table = _table(
            ("buffer", "to", "copies", "bytes each", "µs"),
            [
                (row.buffer, row.to.upper(), f"{row.count}", f"{row.size_bytes}", _us(row.picos))
                for row in report.copies
            ],
        )
        lines.append("\n" + table)
    return "\n".join(lines)


def _us(picos: float) -> str:
    return f"{picos / 1e6:.3f}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
