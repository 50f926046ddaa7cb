"""Measurements as the Markdown tables of README and docs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from benchmarks.measure import Measurement, geometric_mean

ORBSOC = "orbsoc"


def environment_line(header: Mapping[str, str]) -> str:
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
    for group, members in by_group(measurements).items():
        label = _label(group, members)
        for solver, rows in by_solver(members).items():
            lines.append(_group_row(label, solver, rows))
            label = ""
    return "\n".join([*lines, *_settings_notes(measurements)])


def _group_row(label: str, solver: str, rows: Sequence[Measurement]) -> str:
    good = [m for m in rows if m.counts]
    name = f"**{solver}**" if solver == ORBSOC else solver + ("†" if any(m.variant for m in good) else "")
    cells = [label, name, f"{len(good)} of {len(rows)}"]
    if good:
        cells += [
            f"{np.mean([m.iterations for m in good]):.1f}",
            f"{_median(m.solve.median for m in good):.0f} "
            f"({_median(m.solve.q1 for m in good):.0f}–{_median(m.solve.q3 for m in good):.0f})",
            f"{_median(m.setup.median for m in good):.0f}",
            f"{_median(m.total.median for m in good):.0f}",
            f"{max(m.verification.worst for m in good):.1e}",
        ]
    else:
        cells += ["–", f"{_why_no_time(rows)}, so no time", "–", "–", _worst(rows)]
    return f"| {' | '.join(cells)} |"


def _settings_notes(measurements: Sequence[Measurement]) -> list[str]:
    """For each solver that was not timed with its defaults, with what, and on how many problems."""
    notes: list[str] = []
    for solver, rows in by_solver(measurements).items():
        for variant in dict.fromkeys(m.variant for m in rows if m.variant):
            count = sum(m.variant == variant for m in rows)
            notes.append(
                f"† {solver} with `{variant}` on {count} of {len(rows)} problems, where its defaults fail."
            )
    return ["", *notes] if notes else []


def comparison_table(measurements: Sequence[Measurement]) -> str:
    """Peer by peer, over the problems that both solve: the ratio of its times to those of orbsoc."""
    lines = [
        "| against | problems both solve | its solve time over ours, geometric mean (least, most) "
        "| its set-up and solve over ours | our iterations over its, ratio of means | ours faster on |",
        "|---|--:|--:|--:|--:|--:|",
    ]
    own = {m.problem: m for m in measurements if m.solver == ORBSOC and m.counts}
    for peer, rows in by_solver(measurements).items():
        pairs = [(own[m.problem], m) for m in rows if m.counts and m.problem in own]
        if peer == ORBSOC or not pairs:
            continue
        ratios = [theirs.solve.median / mine.solve.median for mine, theirs in pairs]
        totals = [theirs.total.median / mine.total.median for mine, theirs in pairs]
        iterations = sum(mine.iterations for mine, _ in pairs) / sum(theirs.iterations for _, theirs in pairs)
        lines.append(
            f"| {peer} | {len(pairs)} | {geometric_mean(ratios):.2f} ({min(ratios):.2f}–{max(ratios):.2f}) "
            f"| {geometric_mean(totals):.2f} | {iterations:.2f} | {sum(r > 1.0 for r in ratios)} of {len(ratios)} |"
        )
    return "\n".join(lines)


def residual_table(measurements: Sequence[Measurement]) -> str:
    """Verified residuals over all problems that count: median and worst, a row each solver."""
    lines = ["| solver | verified residual, median | worst |", "|---|--:|--:|"]
    for solver, rows in by_solver(measurements).items():
        values = [m.verification.worst for m in rows if m.counts]
        if values:
            lines.append(f"| {solver} | {np.median(values):.1e} | {max(values):.1e} |")
    return "\n".join(lines)


def by_group(measurements: Iterable[Measurement]) -> dict[str, list[Measurement]]:
    """Measurements by the group of their problem, in order of appearance."""
    return _sorted_into(measurements, lambda m: m.group)


def by_solver(measurements: Iterable[Measurement]) -> dict[str, list[Measurement]]:
    """Measurements by solver, in order of appearance."""
    return _sorted_into(measurements, lambda m: m.solver)


def by_problem(measurements: Iterable[Measurement]) -> dict[str, list[Measurement]]:
    """Measurements by problem, in order of appearance."""
    return _sorted_into(measurements, lambda m: m.problem)


def _sorted_into(
    measurements: Iterable[Measurement], key: Callable[[Measurement], str]
) -> dict[str, list[Measurement]]:
    groups: dict[str, list[Measurement]] = {}
    for m in measurements:
        groups.setdefault(key(m), []).append(m)
    return groups


def _median(values: Iterable[float]) -> float:
    return float(np.median(list(values)))


def _label(group: str, members: Sequence[Measurement]) -> str:
    first = members[0]
    count = len({m.problem for m in members})
    return f"{group}: {count} of {first.n} / {first.p} / {first.m}"


def _why_no_time(rows: Sequence[Measurement]) -> str:
    said = ", ".join(sorted({m.status for m in rows}))
    finite = all(math.isfinite(m.verification.worst) for m in rows)
    return f"not verified (says: {said})" if finite else f"failed ({said})"


def _worst(rows: Sequence[Measurement]) -> str:
    worst = max(m.verification.worst for m in rows)
    return f"{worst:.1e}" if math.isfinite(worst) else "not finite"
