"""`orbsoc hw validate --solve`: whole solves on the RTL, Python as the PS, bit for bit against Rust."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from .hw_validate_runs import report_runs

if TYPE_CHECKING:
    from orbsoc.rtl.solve import SolveOutcome

SCHEMA = "orbsoc.rtl-solves/1"


def validate_solves(folder: Path, where: Path, *, quick: bool, exact_depth: bool, as_json: bool) -> NoReturn:
    """Run the solves, write rtl-solves.json and rtl-solves.md to `where`, and end with 0 or, at any difference, 1."""
    from orbsoc.rtl.solve import described
    from orbsoc.rtl.solve_cases import all_solves, quick_solves, run_solves

    points = (quick_solves if quick else all_solves)(folder.parent / "scenarios")
    report_runs(
        run_solves(folder, points, exact_depth=exact_depth),
        len(points),
        where,
        name="solves",
        head={
            "schema": SCHEMA,
            "provenance": {
                "iterates, cycles, clocks": "measured: RTL under Verilator",
                "model_clocks": "modelled: hw_model on rtl/harness/platform.toml, segments by their schedules",
            },
        },
        line=lambda outcome: f"{_title(outcome)}: {'; '.join(described(outcome)) or 'equal'}",
        record=_record,
        table=_table,
        verdict=lambda outcomes, equal: (
            f"measured: {len(outcomes)} solves on the RTL are {'EQUAL to' if equal else 'DIFFERENT from'} Rust's,"
            f" {sum(outcome.iterations for outcome in outcomes)} iterations"
        ),
        as_json=as_json,
    )


def _title(outcome: SolveOutcome) -> str:
    engine = outcome.engine
    control = ", resident" if outcome.resident else ""
    rows = f", {engine.rows} rows" if engine.rows else ""
    return f"{outcome.problem}, f{engine.fp}, {engine.lanes} lanes{rows}, {outcome.format}{control}"


def _record(outcome: SolveOutcome) -> dict[str, Any]:
    """As JSON, launches summed by stage."""
    stages: dict[str, dict[str, int]] = {}
    for launch in outcome.launches:
        row = stages.setdefault(launch.stage, {"launches": 0, "rtl_cycles": 0, "model_cycles": 0})
        row["launches"] += 1
        row["rtl_cycles"] += launch.rtl_cycles
        row["model_cycles"] += launch.model_cycles
    return {
        "problem": outcome.problem,
        "engine": asdict(outcome.engine),
        "format": outcome.format,
        "resident": outcome.resident,
        "status": outcome.status,
        "iterations": outcome.iterations,
        "iterates_compared": outcome.iterates,
        "words_compared": outcome.words,
        "words_different": outcome.different_words,
        "differences": [asdict(difference) for difference in outcome.differences],
        "same_stages": outcome.same_stages,
        "same_solution": outcome.same_solution,
        "assertions": outcome.assertions,
        "stages": stages,
        "rtl_clocks": outcome.rtl_clocks,
        "model_clocks": outcome.model_clocks,
        "clock_error": outcome.clock_error,
        "good": outcome.good,
    }


def _table(outcomes: Sequence[SolveOutcome]) -> list[str]:
    """Markdown, one row a solve."""
    rows = [
        f"| {_title(outcome)} | {outcome.iterations} | {outcome.words} | {outcome.different_words} |"
        f" {len(outcome.launches)} | {sum(launch.rtl_cycles for launch in outcome.launches)} |"
        f" {outcome.busy_error_cycles} | {outcome.rtl_clocks} | {sum(outcome.model_clocks.values())} |"
        f" {100 * outcome.clock_error:+.3f} % |"
        for outcome in outcomes
    ]
    return [
        "| solve | iterations | words compared | different | launches | busy cycles, RTL | off the schedules |"
        " clocks, RTL | clocks, model | error |",
        "|---|---|---|---|---|---|---|---|---|---|",
        *rows,
    ]
