"""The results page: requirements first, then every table they rest on, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks import batch_measure, folder_report, peer_comparison, requirements, warm
from benchmarks.families import FAMILIES
from benchmarks.measure import Measurement, geometric_mean
from benchmarks.peer_comparison import REFERENCE, median_residual
from benchmarks.phases import Results
from benchmarks.profile_figure import profile_figure
from benchmarks.requirements import CONIC, PEERS, QP, SCP
from benchmarks.tables import ORBSOC, environment_line

QUICK = "**A quick run**: two problems of each size, few repetitions, some batches only. For figures to quote, a full one."
PROFILES = {
    "scp": ("SCP-type SOCPs", SCP),
    "qp": ("quadratic programmes", QP),
    "socp": ("other SOCPs", ("group_lasso", "robust_kalman", "large_cones")),
}
"""Figures: file name, title, families."""


def page(results: Results, figures: Mapping[str, str]) -> str:
    """The whole page; `figures` are the paths of the performance profiles, as links see them, by title."""
    sections = [
        "# Results",
        "Written by `python -m benchmarks.results`; how it is measured: [benchmarks.md](benchmarks.md).",
        environment_line(results.header),
        QUICK if results.header.get("effort") == "quick" else "",
        "## What is required, and what comes out",
        requirements.table(requirements.requirements(results)),
        *(f"![Performance profiles, {title}]({path})" for title, path in figures.items()),
        "## Single problems, by size",
        peer_comparison.__doc__ or "",
        *_families(results.families),
        "## Every peer, by family",
        ratio_table(results.families),
        "## Iterations and residuals, by family",
        family_table(results.families),
    ]
    if results.batches:
        about = (
            "orbsoc's time is the wall clock of the whole batch (loading, scaling, certificates), the peers' that of "
            "their solves; the last column counts set-ups, the peers' for each problem, orbsoc's once a batch."
        )
        sections += ["## Batches", about, batch_measure.table(results.batches)]
    if results.warm:
        sections += ["## Warm starts", warm.table(results.warm)]
    if results.sets:
        sections += ["## Public sets", folder_report.report(results.sets)]
    return "\n\n".join(section.strip() for section in sections if section.strip()) + "\n"


def figures(results: Results, folder: Path) -> dict[str, str]:
    """Draw the performance profiles into `folder`; file names by title."""
    drawn: dict[str, str] = {}
    for name, (title, families) in PROFILES.items():
        chosen = [m for family in families for m in results.families.get(family, [])]
        chosen = [m for m in chosen if m.solver in _everywhere(chosen)]
        if chosen:
            folder.mkdir(parents=True, exist_ok=True)
            profile_figure(chosen, results.header, title, folder / f"profile_{name}.png")
            drawn[title] = f"profile_{name}.png"
    return drawn


def _everywhere(measurements: Sequence[Measurement]) -> set[str]:
    """Solvers that were asked for at least half of the problems: a profile of others says nothing."""
    problems = {m.problem for m in measurements}
    asked = dict.fromkeys({m.solver for m in measurements}, 0)
    for m in measurements:
        asked[m.solver] += 1
    return {solver for solver, count in asked.items() if 2 * count >= len(problems)}


def _families(families: Mapping[str, Sequence[Measurement]]) -> list[str]:
    found: list[str] = []
    for name, measured in families.items():
        peers = PEERS.get(name, CONIC)
        rows = peer_comparison.comparisons(measured, peers)
        mean = geometric_mean([row.ratio for row in rows if row.ratio == row.ratio])
        found += [
            f"### {name}: {FAMILIES[name].about}",
            f"Best of {', '.join(peers)}; geometric mean {mean:.2f} ×.",
            peer_comparison.table(rows),
        ]
    return found


def ratio_table(families: Mapping[str, Sequence[Measurement]]) -> str:
    """Geometric means of a peer's solve time over that of orbsoc (least), problem by problem, where both answers verify."""
    peers = list(
        dict.fromkeys(m.solver for measured in families.values() for m in measured if m.solver != ORBSOC)
    )
    lines = [f"| its solve time over ours | {' | '.join(peers)} |", f"|---|{'--:|' * len(peers)}"]
    for name, measured in families.items():
        counted = {(m.problem, m.solver): m.solve.median for m in measured if m.counts}
        cells: list[str] = []
        for peer in peers:
            ratios = [
                counted[problem, peer] / own
                for (problem, solver), own in counted.items()
                if solver == ORBSOC and (problem, peer) in counted
            ]
            cells.append(f"{geometric_mean(ratios):.2f} ({min(ratios):.2f})" if ratios else "–")
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def family_table(families: Mapping[str, Sequence[Measurement]]) -> str:
    """Solved, mean iterations beside the reference's, and residuals beside the median peer's, a row each family."""
    lines = [
        f"| family | verified | iterations, mean | {REFERENCE}'s | ratio | worst residual | median peer's worst |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    for name, measured in families.items():
        own = [m for m in measured if m.solver == ORBSOC]
        reference = {m.problem: m.iterations for m in measured if m.solver == REFERENCE and m.counts}
        pairs = [(m.iterations, reference[m.problem]) for m in own if m.counts and m.problem in reference]
        mine, theirs = (
            (float(np.mean(column)) for column in zip(*pairs, strict=True)) if pairs else (np.nan,) * 2
        )
        peers = sorted({m.solver for m in measured} - {ORBSOC})
        lines.append(
            f"| {name} | {sum(m.counts for m in own)} of {len(own)} | {mine:.2f} | {theirs:.2f} | {mine / theirs:.3f} "
            f"| {max(m.verification.worst for m in own):.1e} | {median_residual(measured, peers):.1e} |"
        )
    return "\n".join(lines)
