"""What is required of our solver beside its peers, and whether it holds: sentences with numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.measure import COUNTS_BELOW, Measurement
from benchmarks.peer_comparison import MOST_ITERATIONS, REFERENCE, median_residual
from benchmarks.tables import ORBSOC, by_problem

LISTED = 6
"""Exceptions named at most; the files have them all."""


def verdict(measurements: Sequence[Measurement]) -> str:
    """A Markdown list: solved and verified, iterations, time, residual. Each line begins with whether it holds."""
    problems = [
        ({m.solver: m for m in rows if m.solver != ORBSOC and m.counts}, mine)
        for rows in by_problem(measurements).values()
        for mine in rows
        if mine.solver == ORBSOC
    ]
    lines = [
        _solved([mine for _, mine in problems]),
        _iterations(problems),
        _time(problems),
        _residual(measurements),
    ]
    return "\n".join(f"- {line}" for line in lines if line)


_Compared = tuple[dict[str, Measurement], Measurement]
"""The peers whose answers count on one problem, by name, and orbsoc's."""


def _solved(own: Sequence[Measurement]) -> str:
    failed = [f"{m.problem} ({m.failure})" for m in own if not m.counts]
    return f"{_holds(not failed)} solved and verified at {COUNTS_BELOW:g}: {len(own) - len(failed)} of {len(own)}{_but(failed)}"


def _iterations(problems: Sequence[_Compared]) -> str:
    pairs = [
        (mine.iterations, peers[REFERENCE].iterations)
        for peers, mine in problems
        if mine.counts and REFERENCE in peers
    ]
    if not pairs:
        return ""
    mine, reference = (float(np.mean(column)) for column in zip(*pairs, strict=True))
    return (
        f"{_holds(mine <= MOST_ITERATIONS * reference)} mean iterations at most {MOST_ITERATIONS:g} × {REFERENCE}'s: "
        f"{mine:.2f} against {reference:.2f}, {mine / reference:.2f} ×"
    )


def _time(problems: Sequence[_Compared]) -> str:
    pairs = [(mine, peer) for peers, mine in problems if mine.counts for peer in peers.values()]
    slower = [
        f"{mine.problem} ({mine.solve.median:.0f} µs, {peer.solver} {peer.solve.median:.0f} µs)"
        for mine, peer in pairs
        if not mine.solve.median < peer.solve.median
    ]
    if not pairs:
        return ""
    return f"{_holds(not slower)} solve time below each peer's, problem by problem: {len(pairs) - len(slower)} of {len(pairs)} pairs{_but(slower)}"


def _residual(measurements: Sequence[Measurement]) -> str:
    """Compared with the median of the peers' worst, all being asked for the same tolerance."""
    peers = sorted({m.solver for m in measurements} - {ORBSOC})
    own = [m.verification.worst for m in measurements if m.solver == ORBSOC and m.counts]
    theirs = median_residual(measurements, peers)
    if not own or theirs != theirs:
        return ""
    told = ", ".join(f"{name} {median_residual(measurements, [name]):.1e}" for name in peers)
    return f"{_holds(max(own) <= theirs)} worst verified residual no worse than the median peer's: {max(own):.1e}; {told}"


def _holds(holds: bool) -> str:
    return "holds:" if holds else "**does not hold**:"


def _but(exceptions: Sequence[str]) -> str:
    if not exceptions:
        return ""
    more = f" and {len(exceptions) - LISTED} more" if len(exceptions) > LISTED else ""
    return f"; not {', '.join(exceptions[:LISTED])}{more}"
