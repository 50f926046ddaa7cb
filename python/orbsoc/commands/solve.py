"""`orbsoc solve`: a conic problem, or a failure bundle, from a file; its verdict on the terminal, its solution in a file.

Exit codes: 0 solved, 1 not solved (the verdict says why), 2 bad input, 130 interrupted.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .failures import FAILED, INTERRUPTED, exit_handling

if TYPE_CHECKING:
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.settings import Settings
    from orbsoc.conic.solution import Solution, Start

SOLUTION = "solution.json"


def solve(
    problem: Annotated[
        Path,
        typer.Argument(help="problem or failure bundle, JSON", metavar="PROBLEM.json", show_default=False),
    ],
    out: Annotated[
        Path | None, typer.Option(help="folder for solution.json; out/NAME by default", metavar="DIR")
    ] = None,
    tol: Annotated[float | None, typer.Option(help="relative tolerance of residuals and gap")] = None,
    tol_inaccurate: Annotated[
        float | None, typer.Option(help="tolerance of an answer called inaccurate")
    ] = None,
    max_iterations: Annotated[int | None, typer.Option(help="iteration limit")] = None,
    max_time_s: Annotated[float | None, typer.Option(help="time limit, seconds")] = None,
    bundle: Annotated[
        Path | None, typer.Option(help="where to write a failure bundle if not solved", metavar="FILE")
    ] = None,
    verbose: Annotated[
        bool, typer.Option("--verbose", help="show each iteration, on standard error")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="print solution.json on standard output")] = False,
) -> None:
    """Solve a conic problem, verify the answer on its data, and write solution.json."""
    from orbsoc.conic.solution_file import encode_solution
    from orbsoc.conic.verify import verify
    from orbsoc.files.json_fields import write_json
    from orbsoc.solving.bundle import check_place
    from orbsoc.solving.solver import resolve
    from orbsoc.solving.solver import solve as run

    changes = {"tol": tol, "tol_inaccurate": tol_inaccurate}
    changes |= {"max_iterations": max_iterations, "max_time_s": max_time_s, "verbose": verbose or None}
    folder = out if out is not None else Path("out") / problem.stem
    with exit_handling(as_json, interrupted="interrupted; nothing was written"):
        stated, base, start = _read(problem)
        settings = resolve(base, {name: value for name, value in changes.items() if value is not None})
        if bundle is not None:
            check_place(bundle)
        folder.mkdir(parents=True, exist_ok=True)
        solution = run(stated, settings, warm_start=start, bundle=bundle)
        document = encode_solution(solution, None if _is_infeasible(solution) else verify(stated, solution))
        write_json(document, folder / SOLUTION)
    if as_json:
        typer.echo(json.dumps(document, allow_nan=False))
    for line in _summary(stated, settings, solution, folder):
        typer.echo(line, err=as_json)
    raise typer.Exit(_exit_code(solution))


def _read(path: Path) -> tuple[Problem, Settings, Start | None]:
    """The problem of a problem file with the default settings, or those and the start of a failure bundle."""
    from orbsoc.conic import problem_file
    from orbsoc.conic.errors import FileError, ProblemError
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.settings import Settings
    from orbsoc.files.json_fields import FieldError, Fields, read_json, shown
    from orbsoc.solving import bundle

    try:
        document = read_json(path)
        schema = Fields(document).document.get("schema")
        if schema == bundle.SCHEMA:
            found = bundle.decode_bundle(document)
            return found.problem, found.settings, found.start
        if schema == problem_file.SCHEMA:
            return Problem(**problem_file.decode_problem(document)), Settings(), None
        known = f"{problem_file.SCHEMA!r} and {bundle.SCHEMA!r}"
        raise FieldError("schema", f"is {shown(schema)}; this command reads {known}")
    except (FieldError, ProblemError) as error:
        other = "; `orbsoc plan` takes a scenario in TOML" if path.suffix == ".toml" else ""
        raise FileError(f"{path}: {error}{other}") from error


def _is_infeasible(solution: Solution) -> bool:
    """Whether x, or y and z, prove that there is no solution."""
    from orbsoc.conic.solution import Status

    return solution.status in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE)


def _summary(problem: Problem, settings: Settings, solution: Solution, folder: Path) -> list[str]:
    """What was solved, how, how well by independent verification, and the verdict last."""
    from orbsoc.conic.verify import check_certificate, verify

    spent = (
        f"{solution.iterations} iterations, set-up {solution.setup_s:.3g} s, solve {solution.solve_s:.3g} s"
    )
    lines = [repr(problem), f"tolerance {settings.tol:g}; {spent}"]
    if _is_infeasible(solution):
        radius = check_certificate(problem, solution).radius
        lines.append(f"verified on the data of the file: certified radius {radius:.4g}")
    else:
        verification = verify(problem, solution)
        lines.append(f"objective {solution.objective:.10g}, dual objective {solution.dual_objective:.10g}")
        residuals = (
            f"primal {verification.pres:.1e}, dual {verification.dres:.1e}, gap {verification.gap:.1e}"
        )
        lines.append(f"verified on the data of the file: {residuals}")
    lines.append(f"written to {folder / SOLUTION}")
    lines.append(f"{solution.status.name}: {solution.message}")
    return lines


def _exit_code(solution: Solution) -> int:
    from orbsoc.conic.solution import Status

    codes: dict[Any, int] = {Status.SOLVED: 0, Status.INTERRUPTED: INTERRUPTED}
    return codes.get(solution.status, FAILED)
