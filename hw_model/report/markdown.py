"""The tables of a report as Markdown: assumptions, where the time goes, why. Every time in them is modelled."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from statistics import mean
from typing import TYPE_CHECKING

from hw_model.energy.actions import DYNAMIC
from hw_model.vocabulary import CAUSES, PL_CAUSES, Cause, by_place

if TYPE_CHECKING:
    from hw_model.energy.joules import EnergyUse

    from .assumptions import Assumption
    from .baselines import Beside
    from .rows import CopyRow, IterationRow, ModuleRow, SolveRow, StageRow

_FEW_ITERATIONS = 40


def slower_modules(rows: Sequence[ModuleRow], baseline: str) -> list[str]:
    """One sentence on the modules that the PL slows down, if there are any."""
    named = ", ".join(
        f"{row.module} ({_us(row.picoseconds)} µs instead of {_us(row.baseline_picoseconds)} µs)"
        for row in rows
    )
    text = f"Modelled slower on the PL than in {baseline}, copies and interrupts included: {named}."
    return [text] if rows else []


def assumption_table(rows: Iterable[Assumption]) -> str:
    """The parameters that were used, the assumed ones first."""
    order = {"assumed": 0, "scaled": 1, "sourced": 2, "executed": 3, "counted": 4, "routed": 5, "measured": 6}
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


def beside_table(rows: Sequence[Beside]) -> str:
    """The gain over the processor alone at each price of its work, and its energy."""
    prices = [price for price, _ in rows[0].gains] if rows else []
    return _table(
        ("beside", *(f"times as fast, by {price}" for price in prices), "its energy, mJ a run"),
        [
            (
                row.what,
                *(f"{gain:.2f}" for _, gain in row.gains),
                f"{row.energy_mj.nominal:.2f} ({row.energy_mj.low:.2f}–{row.energy_mj.high:.2f})",
            )
            for row in rows
        ],
    )


def cause_table(causes_picoseconds: Mapping[Cause, int]) -> str:
    """Time and share of each cause."""
    total = sum(causes_picoseconds.values())
    rows = [
        (cause, _us(causes_picoseconds[cause]), f"{100 * causes_picoseconds[cause] / total:.1f} %")
        for cause in CAUSES
    ]
    return _table(("cause", "µs", "share"), [*rows, ("**sum**", _us(total), "100.0 %")])


def module_table(modules: Iterable[ModuleRow], baseline: str) -> str:
    """Runs, cycles and times of each module, beside its time in `baseline`."""
    head = (
        "module", "on", "runs", "cycles", "compute µs", "link µs", "interrupt µs", "sum µs", f"{baseline} µs",
    )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for row in modules:
        parts = by_place(row.causes_picoseconds)
        computing = parts["PS"] + parts["PL"]
        times = (computing, parts["link"], parts["interrupt"], row.picoseconds, row.baseline_picoseconds)
        rows.append(
            (row.module, row.side.upper(), f"{row.runs}", f"{row.cycles}", *(_us(time) for time in times))
        )
    return _table(head, rows)


def stage_table(stages: Sequence[StageRow]) -> str:
    """Cycles of one run of each stage."""
    head = ("stage", "module", "on", "runs", "cycles", "from", "L0 bound", "bottleneck", *PL_CAUSES)
    several = len({row.pattern for row in stages}) > 1
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
        for row in stages
    ]
    note = (
        "Cycles are in the clock of the side. Those of the PL come from an exact schedule, equal to the RTL, or are an "
        "estimate above the L0 bound."
    )
    return f"{_table(head, rows)}\n\n{note}"


def iteration_table(iterations: Sequence[IterationRow], solves: Sequence[SolveRow]) -> str:
    """Every iteration; of more than forty, the shortest, mean and longest of each solve."""
    if len(iterations) <= _FEW_ITERATIONS:
        return _table(
            (
                "solve", "iteration", "PS cycles", "PL cycles", "PS µs", "PL µs", "link µs", "interrupt µs",
                "sum µs",
            ),
            [
                (f"{row.solve}", f"{row.iteration}", f"{row.ps_cycles}", f"{row.pl_cycles}", *_times(row))
                for row in iterations
            ],
        )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for solve, group in groupby(iterations, key=lambda row: row.solve):
        times = [row.picoseconds for row in group]
        outcome = solves[solve]
        rows.append(
            (
                f"{solve}",
                outcome.status,
                f"{outcome.iterations}",
                _us(min(times)),
                _us(mean(times)),
                _us(max(times)),
                _us(outcome.picoseconds),
            )
        )
    return _table(("solve", "status", "iterations", "shortest µs", "mean µs", "longest µs", "sum µs"), rows)


def _times(row: IterationRow) -> tuple[str, ...]:
    return tuple(_us(time) for time in (*by_place(row.causes_picoseconds).values(), row.picoseconds))


def energy_table(energy: EnergyUse) -> str:
    """Every action: how often, its energy, its share; what lasts is counted in seconds of one such part."""
    rows = [
        (
            row.action,
            f"{row.count}" if row.action in DYNAMIC else f"{row.count / 1e12:.6f} s",
            f"{row.nominal_mj:.4f}",
            f"{row.low_mj:.4f}–{row.high_mj:.4f}",
            f"{100 * row.share:.1f} %",
        )
        for row in energy.rows
    ]
    total = f"{sum(row.nominal_mj for row in energy.rows):.4f}"
    note = "A share is also the sensitivity: by how many per cent the total moves with one per cent of the entry."
    head = ("action", "count", "mJ", "band of its entry", "share")
    return f"{_table(head, [*rows, ('**sum**', '', total, '', '100.0 %')])}\n\n{note}"


def copy_table(copies: Sequence[CopyRow]) -> str:
    """Sums per direction, then every buffer that crosses."""
    lines: list[str] = []
    for to in ("pl", "ps"):
        rows = [row for row in copies if row.to == to]
        lines.append(
            f"To the {to.upper()}: {sum(row.count for row in rows)} copies, "
            f"{sum(row.count * row.size_bytes for row in rows)} bytes, {_us(sum(row.picoseconds for row in rows))} µs."
        )
    if copies:
        table = _table(
            ("buffer", "to", "copies", "bytes each", "µs"),
            [
                (row.buffer, row.to.upper(), f"{row.count}", f"{row.size_bytes}", _us(row.picoseconds))
                for row in copies
            ],
        )
        lines.append("\n" + table)
    return "\n".join(lines)


def _us(picoseconds: float) -> str:
    return f"{picoseconds / 1e6:.3f}"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
