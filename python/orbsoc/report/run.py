"""The output of a planning run: `plan.json`, tables, figures, `hardware.json`, `report.html`.

All of it is built from one plan document, so that the report states nothing that `plan.json` does not.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbsoc.files.output_folder import write_manifest, written_at_once
from orbsoc.files.versions import versions
from orbsoc.guidance.mission import Agreement, FigureFile, Mission, Plan
from orbsoc.guidance.verdict import Verdict, VerdictLine

if TYPE_CHECKING:
    from orbsoc.hw.cycle_budget import CycleBudget

TEMPLATE = "plan.html.j2"
OWN_TEMPLATE = "report.html.j2"
"""In a mission's folder: extends `TEMPLATE`."""
COMPUTER = "computer.png"
"""Figure of the modelled run of the plan's solves."""


@dataclass(frozen=True, slots=True)
class PlanRun:
    """A plan and what was found out about it; `solver` names what solved the subproblems."""

    mission: Mission
    plan: Plan
    solver: str
    budget: CycleBudget | None
    check: Agreement | None
    too_large: tuple[str, str] | None = None
    """The device whose engine does not hold the solves, which are not priced, and why."""
    file: tuple[str, Mapping[str, Any]] | None = None
    """The scenario's file and its changed keys, where it is of one."""

    def __repr__(self) -> str:
        found = self.verdict.lines[0]
        return f"PlanRun({self.plan.status.name}: {found.figure})"

    def _repr_html_(self) -> str:
        return self.verdict._repr_html_()

    @property
    def verdict(self) -> Verdict:
        """The plan's lines with the second solver's, the deadline's and the computer's."""
        from orbsoc.hw.verdict_lines import hardware_lines, nothing_solved, unpriced

        more: list[VerdictLine] = [self.check.line("clarabel")] if self.check else []
        if self.budget:
            more += hardware_lines(self.budget)
        elif self.too_large:
            more.append(unpriced(*self.too_large))
        elif not self.plan.subproblems:
            more.append(nothing_solved())
        found = self.plan.verdict.with_lines(more)
        return found.of_file(*self.file) if self.file else found

    @property
    def succeeded(self) -> bool:
        """Whether no word of the verdict is a bad one: the exit code."""
        return self.verdict.succeeded

    def to_dict(self) -> dict[str, Any]:
        """The content of `plan.json`, apart from its schema and file list."""
        return {
            **self.plan.to_dict(),
            "verdict": self.verdict.to_list(),
            "solver": self.solver,
            "hardware": self.budget.summary() if self.budget else self._unpriced(),
            "check": self.check and {**self.check.to_dict(), "solver": "clarabel"},
            "versions": versions(),
        }

    def _unpriced(self) -> dict[str, Any] | None:
        """`hardware` without a price: what does not fit, in the keys of a budget's summary; None where none was asked for."""
        if not self.too_large:
            return None
        nothing = dict.fromkeys(
            ("cycles", "pl_cycles_from", "time_ms", "speedup", "verdict", "deadline", "same_bits")
        )
        device, reason = self.too_large
        headline = (
            f"the conic solves of the plan do NOT FIT the engine of {device}, and are not priced: {reason}"
        )
        return {"provenance": "modelled", "headline": headline, "fits": False, **nothing}


def write_run(
    folder: Path,
    run: PlanRun,
    document: dict[str, Any],
    *,
    report: bool = True,
    commit: Callable[[], None] = lambda: None,
) -> None:
    """Write everything into `folder`, complete or not at all; raises `orbsoc.files.output_folder.OutputFolderError`.

    Without `report` the figures and the page are left out.

    `commit` is called when all is written and about to move into place; what it raises keeps the folder as it was.
    """
    with written_at_once(folder) as place:
        tables = run.plan.tables()
        for name, text in tables.items():
            (place / name).write_text(text, encoding="utf-8")
        hardware = run.budget.to_dict() if run.budget else None
        if hardware is not None:
            text = json.dumps(hardware, indent=2, allow_nan=False)
            (place / "hardware.json").write_text(text + "\n", encoding="utf-8")
        if report:
            figures = run.plan.figures(place)
            computer = _drawn_computer(run.budget, place) if run.budget else None
            page = report_page(run.mission, document, hardware, tables, figures, place, computer)
            (place / "report.html").write_text(page, encoding="utf-8")
        write_manifest(place, document)
        commit()


def _drawn_computer(budget: CycleBudget, place: Path) -> FigureFile:
    """The modelled run of a plan's solves, drawn into `place`."""
    budget.draw(place / COMPUTER)
    caption = (
        f"Modelled run of {budget.summary()['scope']} on {budget.report.device}, partition {budget.report.partition}:"
        " which of PS, PL modules, link and interrupts works when. Above all solves, below the longest iteration."
    )
    return FigureFile(COMPUTER, caption)


def report_page(
    mission: Mission,
    document: dict[str, Any],
    hardware: dict[str, Any] | None,
    tables: Mapping[str, str],
    figures: tuple[FigureFile, ...],
    place: Path,
    computer: FigureFile | None = None,
) -> str:
    """The page of a plan's document, with the figures in `place`; templates see the columns of each table.

    `computer`: the figure of the modelled run, beside its cycle budget.
    """
    from .page import image, render

    folder = Path(mission.__file__).parent if mission.__file__ else None
    own = folder is not None and (folder / OWN_TEMPLATE).is_file()
    return render(
        OWN_TEMPLATE if own else TEMPLATE,
        figures,
        place,
        folder=folder if own else None,
        plan=document,
        hardware=hardware,
        computer=computer and image(computer, place),
        columns=mission.COLUMNS,
        tables={name: ", ".join(text.partition("\n")[0].split(",")) for name, text in tables.items()},
    )
