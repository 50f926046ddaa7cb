"""What the public sets say: solved and verified by set and solver, false claims, and what we miss."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from benchmarks.grading import LOOSE, TIGHT, Graded
from benchmarks.tables import ORBSOC

SHIFT_S = 1e-3
"""Shift of the geometric mean of times: below it a time hardly matters."""


def report(rows: Sequence[Graded]) -> str:
    """All of it in Markdown."""
    return "\n\n".join(
        [counts_table(rows), false_claims(rows), missed(rows, LOOSE), missed(rows, TIGHT), requirement(rows)]
    )


def counts_table(rows: Sequence[Graded]) -> str:
    """A row each set and solver."""
    lines = [
        f"| set | solver | takes part in | verified at {LOOSE:g} | at {TIGHT:g} | false claims | limit or crash "
        "| set-up and solve, ms, shifted geometric mean |",
        "|---|---|--:|--:|--:|--:|--:|--:|",
    ]
    for name, members in _by(rows, lambda row: row.set).items():
        label = f"{name}, {len({row.problem for row in members})} problems"
        for solver, found in _by(members, lambda row: row.label).items():
            done = [row for row in found if not row.outcome]
            lines.append(
                f"| {label} | {solver} | {len(found)} | {_verified(found, LOOSE)} | {_verified(found, TIGHT)} "
                f"| {sum(bool(row.falsehood()) for row in found)} | {len(found) - len(done)} | {_mean_ms(done):.1f} |"
            )
            label = ""
    return "\n".join(lines)


def false_claims(rows: Iterable[Graded]) -> str:
    """Each false claim in a line."""
    found = [f"- {row.label}, {row.set}/{row.problem}: {row.falsehood()}" for row in rows if row.falsehood()]
    return "\n".join(["False claims:", "", *(found or ["- none"])])


def missed(rows: Sequence[Graded], tol: float) -> str:
    """Every problem that some peer solves, verified at `tol`, and orbsoc does not, with what orbsoc says of it."""
    lines = [f"Problems that some peer solves, verified at {tol:g}, and orbsoc does not:", ""]
    for members in _by(rows, lambda row: f"{row.set}/{row.problem}").values():
        own = next((row for row in members if row.solver == ORBSOC), None)
        winners = [row.label for row in members if row.solver != ORBSOC and row.verified(tol)]
        if own is None or own.verified(tol) or not winners:
            continue
        said = own.outcome or f"{own.status}, residual {own.residual:.1e}. {own.message}".strip()
        lines.append(f"- {own.set}/{own.problem} ({', '.join(winners)}): {said}")
    return "\n".join(lines if len(lines) > 2 else [*lines, "- none"])


def requirement(rows: Sequence[Graded]) -> str:
    """Per set and tolerance, whether orbsoc verifies at least as many as the best peer."""
    lines: list[str] = []
    for name, members in _by(rows, lambda row: row.set).items():
        for tol in (LOOSE, TIGHT):
            counts = {
                solver: _verified(found, tol) for solver, found in _by(members, lambda row: row.label).items()
            }
            own = counts.pop(ORBSOC, 0)
            best = max(counts, key=lambda solver: counts[solver], default="")
            most = counts.get(best, 0)
            holds = "holds:" if own >= most else "**does not hold**:"
            lines.append(f"- {holds} {name} at {tol:g}: {own}, best peer {most} ({best})")
    false = sum(bool(row.falsehood()) for row in rows if row.solver == ORBSOC)
    lines.append(f"- {'holds:' if not false else '**does not hold**:'} no false claim: {false}")
    return "\n".join(lines)


def _verified(rows: Iterable[Graded], tol: float) -> int:
    return sum(row.verified(tol) for row in rows)


def _mean_ms(rows: Sequence[Graded]) -> float:
    times = np.array([row.setup_s + row.solve_s for row in rows])
    return 1e3 * float(np.exp(np.mean(np.log(times + SHIFT_S))) - SHIFT_S) if times.size else math.nan


def _by(rows: Iterable[Graded], key: Callable[[Graded], str]) -> dict[str, list[Graded]]:
    groups: dict[str, list[Graded]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups
