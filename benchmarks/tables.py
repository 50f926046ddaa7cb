"""Measurements as CSV, as JSON, and as the Markdown tables of README and docs."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.measure import COUNTS_BELOW, Measurement, geometric_mean

OURS = "orbsoc"
REFERENCE = "Clarabel"
"""Whose iterations ours are compared with."""


def records(measurements: Iterable[Measurement]) -> list[dict[str, Any]]:
    """One flat record for each solver on each problem; times in µs."""
    return [
        {
            "problem": m.instance.name,
            "group": m.instance.group,
            "n": m.instance.problem.n,
            "p": m.instance.problem.p,
            "m": m.instance.problem.m,
            "solver": m.solver,
            "settings": m.variant or "default",
            "status": m.status,
            "counts": m.counts,
            "failure": m.failure,
            "iterations": m.iterations,
            "pres": m.verification.pres,
            "dres": m.verification.dres,
            "gap": m.verification.gap,
            **{
                f"{name}_{part}_us": round(getattr(spread, part), 2)
                for name, spread in (("setup", m.setup), ("solve", m.solve), ("total", m.total))
                for part in ("median", "q1", "q3")
            },
        }
        for m in measurements
    ]


def to_csv(header: Mapping[str, str], measurements: Sequence[Measurement]) -> str:
    """CSV with the header as `# key: value` lines."""
    out = io.StringIO()
    out.writelines(f"# {key}: {value}\n" for key, value in header.items())
    rows = records(measurements)
    writer = csv.DictWriter(out, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def to_json(header: Mapping[str, str], measurements: Sequence[Measurement]) -> str:
    """Schema `orbsoc.bench/1`: header and records; a residual that is not finite is null."""
    rows = [
        {k: None if isinstance(v, float) and not np.isfinite(v) else v for k, v in row.items()}
        for row in records(measurements)
    ]
    document = {"schema": "orbsoc.bench/1", "header": dict(header), "measurements": rows}
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def circumstances_line(header: Mapping[str, str]) -> str:
    """The header as one sentence."""
    return (
        f"Measured {header['date']} on {header['machine']}, orbsoc at {header['commit']}; {header['solvers']}; "
        f"tolerance {header['tolerance']}; {header['repeats']} repetitions, interleaved, medians."
    )


def group_table(measurements: Sequence[Measurement]) -> str:
    """A row for each group and solver. Medians are over the problems of the group, of each problem's median."""
    lines = [
        "| problems (n / p / m) | solver | solved | iterations, mean | solve, µs (quartiles) | set-up, µs | both, µs "
        "| verified residual, worst |",
        "|---|---|--:|--:|--:|--:|--:|--:|",
    ]
    for group, members in _by(measurements, "group").items():
        for solver, rows in _by_solver(members).items():
            lines.append(_group_row(_label(group, members), solver, rows))
    return "\n".join(lines)


def _group_row(label: str, solver: str, rows: Sequence[Measurement]) -> str:
    good = [m for m in rows if m.counts]
    name = f"**{solver}**" if solver == OURS else solver
    settings = {m.variant for m in good if m.variant}
    name += "".join(f" ({text})" for text in sorted(settings))
    solved = f"{len(good)} of {len(rows)}"
    if not good:
        return f"| {label} | {name} | {solved} | – | {_why(rows)}, so no time | – | – | {_worst(rows)} |"
    q1, median, q3 = (
        float(np.median([getattr(m.solve, part) for m in good])) for part in ("q1", "median", "q3")
    )
    setup, total = (
        float(np.median([spread.median for spread in s]))
        for s in ([m.setup for m in good], [m.total for m in good])
    )
    mean = float(np.mean([m.iterations for m in good]))
    return (
        f"| {label} | {name} | {solved} | {mean:.1f} | {median:.0f} ({q1:.0f}–{q3:.0f}) | {setup:.0f} | {total:.0f} "
        f"| {_worst(good)} |"
    )


def comparison_table(measurements: Sequence[Measurement]) -> str:
    """Peer by peer: how many times as long as ours it takes, and whether every requirement holds, in numbers."""
    lines = [
        "| against | problems both solve | its solve time over ours, geometric mean (least, most) "
        "| its set-up and solve over ours | our iterations over its, ratio of means | faster than it on |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    ours = {m.instance.name: m for m in measurements if m.solver == OURS and m.counts}
    for peer, rows in _by_solver(measurements).items():
        pairs = [(ours[m.instance.name], m) for m in rows if m.counts and m.instance.name in ours]
        if peer == OURS or not pairs:
            continue
        ratios = [theirs.solve.median / mine.solve.median for mine, theirs in pairs]
        totals = [theirs.total.median / mine.total.median for mine, theirs in pairs]
        iterations = sum(mine.iterations for mine, _ in pairs) / sum(theirs.iterations for _, theirs in pairs)
        lines.append(
            f"| {peer} | {len(pairs)} | {geometric_mean(ratios):.2f} ({min(ratios):.2f}–{max(ratios):.2f}) "
            f"| {geometric_mean(totals):.2f} | {iterations:.2f} | {sum(r > 1.0 for r in ratios)} of {len(ratios)} |"
        )
    return "\n".join(lines)


def requirements(measurements: Sequence[Measurement], *, iterations: float = 1.15) -> list[str]:
    """What is demanded of our solver and does not hold, a line each; empty when all holds.

    On every problem: verified at 1e-7, solve time below each peer's that counts, verified residual no worse than
    the worst of the peers'. Over all: mean iterations ≤ `iterations` × the reference's.
    """
    failures: list[str] = []
    mine_all: list[int] = []
    reference_all: list[int] = []
    for name, rows in _by(measurements, "name").items():
        by_solver = {m.solver: m for m in rows}
        mine = by_solver.pop(OURS, None)
        if mine is None:
            continue
        if not mine.counts:
            failures.append(f"{name}: ours does not count ({mine.failure})")
            continue
        peers = [m for m in by_solver.values() if m.counts]
        failures += [
            f"{name}: {mine.solve.median:.0f} µs, {m.solver} {m.solve.median:.0f} µs"
            for m in peers
            if not mine.solve.median < m.solve.median
        ]
        if peers and mine.verification.worst > max(m.verification.worst for m in peers):
            worst = max(peers, key=lambda m: m.verification.worst)
            failures.append(
                f"{name}: residual {mine.verification.worst:.1e}, {worst.solver} {worst.verification.worst:.1e}"
            )
        if REFERENCE in by_solver and by_solver[REFERENCE].counts:
            mine_all.append(mine.iterations)
            reference_all.append(by_solver[REFERENCE].iterations)
    if reference_all and sum(mine_all) > iterations * sum(reference_all):
        failures.append(f"iterations: {sum(mine_all)} against {sum(reference_all)} of {REFERENCE}")
    return failures


def residual_table(measurements: Sequence[Measurement]) -> str:
    """Verified residuals over all problems that count: median and worst, a row each solver."""
    lines = ["| solver | verified residual, median | worst |", "|---|--:|--:|"]
    for solver, rows in _by_solver(measurements).items():
        values = [m.verification.worst for m in rows if m.counts]
        if values:
            lines.append(f"| {solver} | {np.median(values):.1e} | {max(values):.1e} |")
    return "\n".join(lines)


def _by(measurements: Iterable[Measurement], attribute: str) -> dict[str, list[Measurement]]:
    groups: dict[str, list[Measurement]] = {}
    for m in measurements:
        groups.setdefault(getattr(m.instance, attribute), []).append(m)
    return groups


def _by_solver(measurements: Iterable[Measurement]) -> dict[str, list[Measurement]]:
    groups: dict[str, list[Measurement]] = {}
    for m in measurements:
        groups.setdefault(m.solver, []).append(m)
    return groups


def _label(group: str, members: Sequence[Measurement]) -> str:
    p = members[0].instance.problem
    count = len({m.instance.name for m in members})
    return f"{group}: {count} of {p.n} / {p.p} / {p.m}"


def _why(rows: Sequence[Measurement]) -> str:
    statuses = sorted({m.status for m in rows})
    return f"failed ({', '.join(statuses)}; not below {COUNTS_BELOW:g})"


def _worst(rows: Sequence[Measurement]) -> str:
    worst = max(m.verification.worst for m in rows)
    return f"{worst:.1e}" if np.isfinite(worst) else "not finite"
