"""`orbsoc hw precision`: the same problem with narrower datapaths on the PL: what it saves, and what it costs."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import exit_handling

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.timing.stage_cycles import StageCycles
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.settings import Settings

ALL = ("matrix_update", "matrix_scaling", "factorization", "linear_solve", "cone_ops", "line_search")
CHOICES: tuple[tuple[int, tuple[str, ...]], ...] = (
    (53, ALL),
    (53, ("factorization",)),
    (24, ("factorization",)),
    (24, ("factorization", "linear_solve")),
    (24, ALL),
    (20, ("factorization",)),
    (16, ("factorization",)),
    (12, ("factorization",)),
)
"""(significant bits, modules on the PL that compute with them)."""


def precision(
    workload: options.WorkloadArgument,
    tol: Annotated[float, typer.Option(help="relative tolerance asked of every datapath")] = 1e-6,
    device: options.DeviceOption = "zu9eg",
    settings: options.SetOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Solve the workload's problem with f64, f32 and narrower datapaths: iterations, verified residuals, cycles, area.

    Refinement and statistics stay on the PS in binary64, unless their module is narrow too. Of a plan, the first
    subproblem of each pattern is taken. Segments are scheduled, equal to the RTL.
    """
    with exit_handling(as_json):
        from hw_model.report.usage import PRECISION_USAGE, require_used
        from orbsoc.conic.settings import Settings
        from orbsoc.hw.exact_cycles import exact_cycles
        from orbsoc.hw.workload import WorkloadError, load_workload

        chosen = options.parsed_settings(settings)
        platform = options.computer(device, chosen)
        require_used(chosen, [(platform, PRECISION_USAGE)])
        if not 0.0 < tol < 1.0:
            raise WorkloadError(f"--tol = {tol}: must be above 0 and below 1, for residuals are relative")
        asked = Settings(tol=tol, tol_inaccurate=max(1e-5, 10.0 * tol))
        record = load_workload(workload)
        if not record.problems:
            raise WorkloadError(
                f"{workload}: a trace holds no problem to solve again; give a scenario or a problem"
            )
        rows = [
            {"problem": number, **_row(problem, asked, bits, modules, platform, cycles)}
            for number, problem in enumerate(record.problems)
            for cycles in [exact_cycles([problem])]
            for bits, modules in CHOICES
        ]
        document = {
            "schema": "orbsoc.hardware-precision/1",
            "workload": record.origin,
            "tol": tol,
            "rows": rows,
            "assumptions": options.echoed(platform, PRECISION_USAGE),
        }
        folder = out or Path("out") / f"hw-precision-{record.name}"
        options.write_all(
            folder,
            {
                "precision.json": options.as_json_text(json.loads(json.dumps(document, default=str))),
                "precision.csv": options.as_csv_text(rows),
            },
        )
        options.print_report(_lines(rows, tol), document, folder, as_json=as_json)


def _row(
    problem: Problem,
    settings: Settings,
    bits: int,
    modules: tuple[str, ...],
    platform: Platform,
    cycles: StageCycles,
) -> dict[str, Any]:
    """One solve, and what it would have cost."""
    from hw_model import parse_trace, speedup
    from hw_model.area.budget import budget
    from hw_model.area.fabric import multiplier_dsp
    from hw_model.platform.partition import on_pl
    from orbsoc.hw.precision import solve_narrow

    run = solve_narrow(problem, bits, modules, settings)
    split = on_pl(*modules)
    report = speedup(run.trace, platform, split, cycles=cycles)
    area = budget(parse_trace(run.trace), platform, split, cycles)
    reached = run.solution.status.name == "SOLVED" and run.worst <= settings.tol
    return {
        "bits": bits, "narrow_modules": "+".join(modules) if len(modules) < len(ALL) else "all six",
        "status": run.solution.status.name, "iterations": run.solution.iterations,
        "refinements": run.solution.refinements, "primal_residual": run.primal_residual,
        "dual_residual": run.dual_residual, "gap": run.gap, "reached": reached,
        "why_not": "" if reached else run.solution.message,
        "pl_cycles": report.cycles["pl"], "modelled_ms": report.makespan_ms.nominal,
        "dsp": platform.pl.lanes.value * multiplier_dsp(bits), "lut": area.of("lut").used,
        "bram36": area.of("bram36").used, "storage_words": area.storage_words,
    }  # fmt: skip


def _lines(rows: list[dict[str, Any]], tol: float) -> list[str]:
    head = "bits modules                       status             iter refine  worst residual  PL cycles  modelled ms  DSP"
    lines = [head]
    for row in rows:
        worst = max(row["primal_residual"], row["dual_residual"], row["gap"])
        lines.append(
            f"{row['bits']:4d} {row['narrow_modules']:29s} {row['status']:18s} {row['iterations']:4d} {row['refinements']:6d}"
            f" {worst:15.1e} {row['pl_cycles']:10d} {row['modelled_ms']:12.3f} {row['dsp']:4d}"
        )
    for row in rows:
        if not row["reached"]:
            lines.append(
                f"{row['bits']} bits in {row['narrow_modules']} do not reach {tol:g}: {row['why_not']}"
            )
    return lines
