"""`orbsoc hw validate --solve` with `pl.interleaved`: whole attempts at several problems together on the RTL."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from .hw_validate_runs import report_runs

if TYPE_CHECKING:
    from orbsoc.rtl.group import GroupOutcome


def validate_groups(folder: Path, where: Path, copies: int, *, quick: bool, as_json: bool) -> NoReturn:
    """Run the groups, write rtl-groups.json and rtl-groups.md to `where`, and end with 0 or, at any difference, 1."""
    from orbsoc.rtl.group_cases import all_groups, quick_groups, run_groups

    points = (quick_groups if quick else all_groups)(copies)
    report_runs(
        run_groups(folder, points),
        len(points),
        where,
        name="groups",
        head={
            "schema": "orbsoc.rtl-groups/1",
            "provenance": {
                "words, cycles, clocks": "measured: RTL under Verilator",
                "model_clocks": "modelled: the segments that hw_model counts for a group, by their schedules",
            },
            "interleaved": copies,
        },
        line=lambda outcome: f"{_title(outcome)}: {'equal' if outcome.good else 'DIFFERENT'}",
        record=_record,
        table=_table,
        verdict=lambda outcomes, equal: (
            f"measured: {len(outcomes)} groups of {copies} interleaved problems on the RTL are"
            f" {'EQUAL to' if equal else 'DIFFERENT from'} Rust's solves of each"
        ),
        as_json=as_json,
    )


def _title(outcome: GroupOutcome) -> str:
    engine = outcome.engine
    return (
        f"{len(outcome.statuses)} × {outcome.name}, f{engine.fp}, {engine.lanes} lanes, clusters {engine.clusters},"
        f" {outcome.format}"
    )


def _record(outcome: GroupOutcome) -> dict[str, Any]:
    """As JSON, launches in sum."""
    return {
        "problem": outcome.name,
        "engine": asdict(outcome.engine),
        "format": outcome.format,
        "statuses": list(outcome.statuses),
        "iterations": list(outcome.iterations),
        "words_compared": outcome.words,
        "words_different": outcome.different_words,
        "same_solutions": outcome.same_solutions,
        "launches": len(outcome.launches),
        "uncounted_launches": dict(outcome.uncounted),
        "rtl_cycles": sum(launch.rtl_cycles for launch in outcome.launches),
        "cycles_off_the_schedules": outcome.busy_error_cycles,
        "assertions": outcome.assertions,
        "rtl_clocks": outcome.rtl_clocks,
        "model_clocks": outcome.model_clocks,
        "good": outcome.good,
    }


def _table(outcomes: Sequence[GroupOutcome]) -> list[str]:
    """Markdown, one row a group."""
    rows = [
        f"| {_title(outcome)} | {', '.join(map(str, outcome.iterations))} | {outcome.words} | {outcome.different_words} |"
        f" {len(outcome.launches)} | {sum(launch.rtl_cycles for launch in outcome.launches)} |"
        f" {outcome.busy_error_cycles} | {outcome.rtl_clocks} | {outcome.model_clocks} |"
        for outcome in outcomes
    ]
    return [
        "| group | iterations | words compared | different | launches | busy cycles, RTL | off the schedules |"
        " clocks, RTL | clocks, model |",
        "|---|---|---|---|---|---|---|---|---|",
        *rows,
    ]
