"""The output of a planning run: `plan.json`, `attitude.csv`, figures, `hardware.json`, `report.html`.

All of it is built from one plan document, so that the report can say nothing that `plan.json` does not.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from orbsoc.files.output_folder import write_manifest, written_at_once
from orbsoc.files.versions import versions
from orbsoc.hw.cycle_budget import CycleBudget
from orbsoc.missions.reachable_insertion.agreement import Agreement
from orbsoc.missions.reachable_insertion.planner import Plan
from orbsoc.missions.reachable_insertion.plots import FigureFile, draw_figures
from orbsoc.missions.reachable_insertion.record import ATTITUDE_COLUMNS, attitude_csv, plan_document


@dataclass(frozen=True, slots=True)
class Run:
    """A plan and what was found out about it; `solver` says in words what solved the subproblems."""

    plan: Plan
    solver: str
    budget: CycleBudget | None
    check: Agreement | None


def run_document(run: Run) -> dict[str, Any]:
    """The content of `plan.json`, apart from its schema and file list."""
    return {
        **plan_document(run.plan),
        "solver": run.solver,
        "hardware": run.budget and run.budget.summary(),
        "check": run.check
        and {
            **asdict(run.check),
            "agrees": run.check.agrees,
            "words": run.check.words(),
            "solver": "clarabel",
        },
        "versions": versions(),
    }


def write_run(
    folder: Path, run: Run, document: dict[str, Any], *, commit: Callable[[], None] = lambda: None
) -> None:
    """Write everything into `folder`, complete or not at all; raises `orbsoc.files.output_folder.OutputFolderError`.

    `commit` is called when all is written and about to move into place; what it raises keeps the folder as it was.
    """
    with written_at_once(folder) as place:
        table = attitude_csv(run.plan)
        if table is not None:
            (place / "attitude.csv").write_text(table, encoding="utf-8")
        figures = draw_figures(run.plan, place)
        hardware = run.budget.to_dict() if run.budget else None
        if hardware is not None:
            text = json.dumps(hardware, indent=2, allow_nan=False)
            (place / "hardware.json").write_text(text + "\n", encoding="utf-8")
        page = render(document, figures, hardware, place)
        (place / "report.html").write_text(page, encoding="utf-8")
        write_manifest(place, document)
        commit()


def render(
    document: dict[str, Any], figures: tuple[FigureFile, ...], hardware: dict[str, Any] | None, place: Path
) -> str:
    """The self-contained page: every image of `place` is inlined, nothing is fetched."""
    environment = Environment(
        loader=PackageLoader("orbsoc.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["number"] = _number
    environment.filters["difference"] = _difference
    environment.filters["scientific"] = _scientific
    environment.filters["sentence"] = _sentence
    images = [
        {
            "caption": figure.caption,
            "data": base64.b64encode((place / figure.name).read_bytes()).decode("ascii"),
        }
        for figure in figures
    ]
    template = environment.get_template("insertion.html.j2")
    return template.render(
        plan=document, images=images, hardware=hardware, attitude_columns=", ".join(ATTITUDE_COLUMNS)
    )


def _number(value: float | None, form: str, *, per: float = 1.0) -> str:
    """`value` / `per` in a printf form; a dash for what the document leaves out (null)."""
    if value is None:
        return "–"
    return form % (value if per == 1.0 else value / per)


def _difference(value: float | None, other: float | None) -> float | None:
    """value − other; None when either is missing."""
    return None if value is None or other is None else value - other


def _scientific(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def _sentence(text: str) -> str:
    """The text with its first letter in upper case, the rest as it is."""
    return text[:1].upper() + text[1:]
