"""Where orbsoc stands beside its peers, group by group: the figures of the speed requirements.

A time is a problem's median over the repetitions; a group's figure is the median over its problems of the ratio
best peer / orbsoc, both on the same problem. Only times of verified answers count.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.measure import Measurement
from benchmarks.tables import ORBSOC, by_group, by_problem

REFERENCE = "Clarabel"
"""The solver with which the iterations of orbsoc are compared."""
MOST_ITERATIONS = 1.15
"""The largest ratio of the mean iterations of orbsoc to those of the reference."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """One group. Times in µs, NaN where there is none; `ratio` is the best peer's solve time over that of orbsoc."""

    group: str
    problems: int
    verified: int
    orbsoc_us: float
    best_us: float
    best: str
    ratio: float
    total_ratio: float
    """The same with set-up and solve on both sides."""
    iterations: float
    reference_iterations: float
    residual: float
    """The worst of orbsoc, verified."""
    peers_residual: float
    """The median over the peers of each one's worst."""

    @property
    def iteration_ratio(self) -> float:
        return self.iterations / self.reference_iterations


def comparisons(measurements: Iterable[Measurement], peers: Sequence[str]) -> list[Comparison]:
    """One for each group, in order; `peers` names those whose best time orbsoc is compared with."""
    return [_comparison(group, members, peers) for group, members in by_group(measurements).items()]


def _comparison(group: str, members: Sequence[Measurement], peers: Sequence[str]) -> Comparison:
    rows = list(by_problem(members).values())
    own = [m for m in members if m.solver == ORBSOC]
    pairs: list[tuple[Measurement, Measurement]] = []
    totals: list[float] = []
    iterations: list[tuple[int, int]] = []
    for row in rows:
        counted = {m.solver: m for m in row if m.counts}
        mine = counted.get(ORBSOC)
        rivals = [counted[name] for name in peers if name in counted]
        if mine is None or not rivals:
            continue
        pairs.append((mine, min(rivals, key=lambda m: m.solve.median)))
        totals.append(min(m.total.median for m in rivals) / mine.total.median)
        if REFERENCE in counted:
            iterations.append((mine.iterations, counted[REFERENCE].iterations))
    winners = [best.solver for _, best in pairs]
    means = [float(np.mean(column)) for column in zip(*iterations, strict=True)] or [float("nan")] * 2
    return Comparison(
        group=group,
        problems=len(rows),
        verified=sum(m.counts for m in own),
        orbsoc_us=_median([m.solve.median for m, _ in pairs]),
        best_us=_median([best.solve.median for _, best in pairs]),
        best=max(dict.fromkeys(winners), key=winners.count) if winners else "",
        ratio=_median([best.solve.median / m.solve.median for m, best in pairs]),
        total_ratio=_median(totals),
        iterations=means[0],
        reference_iterations=means[1],
        residual=max((m.verification.worst for m in own), default=float("nan")),
        peers_residual=median_residual(members, peers),
    )


def median_residual(measurements: Iterable[Measurement], peers: Sequence[str]) -> float:
    """The median over the peers of each one's worst verified residual, over the problems that it solves."""
    worst: dict[str, float] = {}
    for m in measurements:
        if m.counts and m.solver in peers:
            worst[m.solver] = max(worst.get(m.solver, 0.0), m.verification.worst)
    return _median(list(worst.values()))


def table(rows: Sequence[Comparison]) -> str:
    """A Markdown table, a row each group."""
    lines = [
        "| problems | verified | orbsoc, µs | best peer, µs | its time over ours | with set-up | iterations | Clarabel's "
        "| worst residual | median peer's |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for s in rows:
        lines.append(
            f"| {s.group} | {s.verified} of {s.problems} | {s.orbsoc_us:.0f} | {s.best_us:.0f} ({s.best}) "
            f"| {s.ratio:.2f} | {s.total_ratio:.2f} | {s.iterations:.1f} | {s.reference_iterations:.1f} "
            f"| {s.residual:.1e} | {s.peers_residual:.1e} |"
        )
    return "\n".join(lines)


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if len(values) else float("nan")
