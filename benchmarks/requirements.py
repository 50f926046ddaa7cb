"""What is required of the solver beside its peers, and whether it holds: one row a requirement."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.batch_measure import BatchTimes
from benchmarks.grading import LOOSE, TIGHT, Graded
from benchmarks.measure import COUNTS_BELOW, Measurement, geometric_mean
from benchmarks.overhead import Overhead
from benchmarks.peer_comparison import MOST_ITERATIONS, REFERENCE, Comparison, comparisons, median_residual
from benchmarks.phases import Results
from benchmarks.tables import ORBSOC
from benchmarks.warm import WarmStart

CONIC = ("Clarabel", "ECOS", "QOCO")
SCP = ("powered_descent", "orbit_insertion", "rendezvous", "six_dof", "quadrotor")
QP = ("portfolio", "lasso", "huber", "svm")
SINGLE_LEAST, SINGLE_MEAN = 1.5, 2.0
BATCH_MEAN = 6.0
LP_SINGLE, LP_BATCH = 1.5, 3.0
WARM_MOST, WARM_FALL_BACKS = 5, 0.10
OVERHEAD_US = 10.0
LINEAR = 1.1
"""Exponent of the time of an iteration in the cone's dimension that still counts as linear."""
PEERS = dict.fromkeys(SCP, CONIC) | {
    "small_lp": ("PIQP dense",),
    **dict.fromkeys(QP, ("PIQP sparse",)),
    "large_cones": ("Clarabel",),
}
"""The peers of each family; by default all conic solvers."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """`holds` is None where nothing was measured."""

    number: str
    measure: str
    required: str
    measured: str
    holds: bool | None


def requirements(results: Results) -> list[Requirement]:
    """All, in order."""
    rows = {
        name: comparisons(measured, PEERS.get(name, CONIC)) for name, measured in results.families.items()
    }
    return [
        *_single(rows),
        *_generated(results.families),
        *_batches(results.batches),
        *_small_lp(rows, results.batches),
        *_quadratic(rows),
        *_cones(rows),
        _iterations(results.families),
        _residuals(results.families),
        *_warm(results.warm),
        *_sets(results.sets),
        _overhead(results.overhead),
    ]


def table(rows: Iterable[Requirement]) -> str:
    """A Markdown table."""
    verdicts = {True: "holds", False: "**does not hold**", None: "not measured"}
    lines = ["| # | measure | required | measured | |", "|---|---|---|---|---|"]
    lines += [
        f"| {row.number} | {row.measure} | {row.required} | {row.measured} | {verdicts[row.holds]} |"
        for row in rows
    ]
    return "\n".join(lines)


def _single(rows: dict[str, list[Comparison]]) -> list[Requirement]:
    ratios = [(s.ratio, s.group) for name in SCP for s in rows.get(name, []) if s.ratio == s.ratio]
    title = f"one SCP-type SOCP against the best of {', '.join(CONIC)}, solve"
    if not ratios:
        return [Requirement("1", title, "", "", None)]
    least, where = min(ratios)
    mean = geometric_mean([ratio for ratio, _ in ratios])
    below = sum(ratio < SINGLE_LEAST for ratio, _ in ratios)
    each = f"least {least:.2f} × ({where}); {below} of {len(ratios)} below"
    return [
        Requirement("1", f"{title}, each size", f"≥ {SINGLE_LEAST:g} ×", each, least >= SINGLE_LEAST),
        Requirement("1", f"{title}, all", f"≥ {SINGLE_MEAN:g} ×", f"{mean:.2f} ×", mean >= SINGLE_MEAN),
    ]


def _generated(families: dict[str, list[Measurement]]) -> list[Requirement]:
    ratios = [ratio for name in SCP for ratio in _ratios(families.get(name, []), "QOCOGEN", by_total=False)]
    measured = f"{geometric_mean(ratios):.2f} × over {len(ratios)} problems" if ratios else ""
    holds = geometric_mean(ratios) >= 1.0 if ratios else None
    return [
        Requirement("1", "the same against generated code (QOCOGEN)", "parity, or why not", measured, holds)
    ]


def _ratios(measurements: Iterable[Measurement], peer: str, *, by_total: bool) -> list[float]:
    """The peer's time over that of orbsoc on every problem that both solve."""
    counted = {(m.problem, m.solver): m for m in measurements if m.counts}
    found: list[float] = []
    for (problem, solver), mine in counted.items():
        theirs = counted.get((problem, peer))
        if solver == ORBSOC and theirs is not None:
            pair = (theirs.total, mine.total) if by_total else (theirs.solve, mine.solve)
            found.append(pair[0].median / pair[1].median)
    return found


def _batches(batches: Sequence[BatchTimes]) -> list[Requirement]:
    title = "batch of 64 of one pattern, one thread, against the best peer's solves in a loop"
    chosen = [row for row in batches if row.kind != "lp" and row.best]
    if not chosen:
        return [Requirement("2", title, f"≥ {BATCH_MEAN:g} ×", "", None)]
    mean = geometric_mean([row.ratio for row in chosen])
    kinds = ", ".join(
        f"{kind.upper()} {geometric_mean([row.ratio for row in chosen if row.kind == kind]):.2f}"
        for kind in dict.fromkeys(row.kind for row in chosen)
    )
    total = geometric_mean([row.total_ratio for row in chosen])
    measured = f"{mean:.2f} × ({kinds}; with all set-ups {total:.2f})"
    return [Requirement("2", title, f"≥ {BATCH_MEAN:g} ×", measured, mean >= BATCH_MEAN)]


def _small_lp(rows: dict[str, list[Comparison]], batches: Sequence[BatchTimes]) -> list[Requirement]:
    ratios = [s.ratio for s in rows.get("small_lp", [])]
    lanes = [row.ratio for row in batches if row.kind == "lp" and row.best]
    return [
        _mean_at_least("3", "small LPs, 16 × 100–150, against PIQP dense", ratios, LP_SINGLE),
        _mean_at_least("3", "the same, batch of 64 on one thread", lanes, LP_BATCH),
    ]


def _quadratic(rows: dict[str, list[Comparison]]) -> list[Requirement]:
    return [
        _each_at_least(
            "4", f"{name.replace('_', ' ')} against PIQP sparse", [s.ratio for s in rows[name]], 1.0
        )
        for name in QP
        if name in rows
    ]


def _cones(rows: dict[str, list[Comparison]]) -> list[Requirement]:
    found = rows.get("large_cones", [])
    parity = _each_at_least(
        "4", "second-order cones of 61–2475 against Clarabel", [s.ratio for s in found], 1.0
    )
    one = [s for s in found if s.group.startswith("one cone of ")]
    title, required = "time of an iteration as a power of the cone's dimension", f"≤ {LINEAR:g}"
    if len(one) < 3:
        return [parity, Requirement("4", title, required, "", None)]
    dimensions = [float(s.group.rpartition(" ")[2]) for s in one]
    slope = float(np.polyfit(np.log(dimensions), np.log([s.orbsoc_us / s.iterations for s in one]), 1)[0])
    return [parity, Requirement("4", title, required, f"{slope:.2f}", slope <= LINEAR)]


def _each_at_least(number: str, title: str, ratios: Sequence[float], least: float) -> Requirement:
    """On every size: a mean would let one size make up for another."""
    finite = [ratio for ratio in ratios if ratio == ratio]
    if not finite:
        return Requirement(number, title, f"≥ {least:g} × on each size", "", None)
    measured = f"{min(finite):.2f}–{max(finite):.2f} ×, geometric mean {geometric_mean(finite):.2f}"
    return Requirement(number, title, f"≥ {least:g} × on each size", measured, min(finite) >= least)


def _mean_at_least(number: str, title: str, ratios: Sequence[float], least: float) -> Requirement:
    finite = [ratio for ratio in ratios if ratio == ratio]
    if not finite:
        return Requirement(number, title, f"≥ {least:g} ×", "", None)
    mean = geometric_mean(finite)
    measured = f"{mean:.2f} × ({min(finite):.2f}–{max(finite):.2f})"
    return Requirement(number, title, f"≥ {least:g} ×", measured, mean >= least)


def _iterations(families: dict[str, list[Measurement]]) -> Requirement:
    ratios: list[float] = []
    for measured in families.values():
        counted = {(m.problem, m.solver): m.iterations for m in measured if m.counts}
        pairs = [
            (mine, counted[problem, REFERENCE])
            for (problem, solver), mine in counted.items()
            if solver == ORBSOC and (problem, REFERENCE) in counted
        ]
        if pairs:
            ratios.append(sum(mine for mine, _ in pairs) / sum(theirs for _, theirs in pairs))
    title = f"mean iterations over {REFERENCE}'s, mean over the families"
    if not ratios:
        return Requirement("5", title, f"≤ {MOST_ITERATIONS:g}", "", None)
    mean = float(np.mean(ratios))
    text = f"{mean:.3f} (families {min(ratios):.2f}–{max(ratios):.2f})"
    return Requirement("5", title, f"≤ {MOST_ITERATIONS:g}", text, mean <= MOST_ITERATIONS)


def _residuals(families: dict[str, list[Measurement]]) -> Requirement:
    title = "worst verified residual by family, against the median peer's worst"
    required = f"no larger, and ≤ {COUNTS_BELOW:g}"
    worse: list[str] = []
    own: list[float] = []
    for name, measured in families.items():
        peers = sorted({m.solver for m in measured} - {ORBSOC})
        own.append(max(m.verification.worst for m in measured if m.solver == ORBSOC))
        theirs = median_residual(measured, peers)
        if not own[-1] <= min(theirs, COUNTS_BELOW):
            worse.append(f"{name} ({own[-1]:.1e}, median peer {theirs:.1e})")
    if not own:
        return Requirement("1–4", title, required, "", None)
    text = f"worst {max(own):.1e}; larger on {', '.join(worse) or 'none'}"
    return Requirement("1–4", title, required, text, not worse)


def _warm(rows: Sequence[WarmStart]) -> list[Requirement]:
    titles = {"sequence": "warm start along SCP sequences", "perturbed": "warm start after ≤ 1 % change"}
    required = f"≤ {WARM_MOST} iterations, never > cold + 1, fall-backs ≤ {WARM_FALL_BACKS:.0%}, all verified"
    found: list[Requirement] = []
    for kind, title in titles.items():
        chosen = [row for row in rows if row.kind == kind]
        if not chosen:
            found.append(Requirement("6", title, required, "", None))
            continue
        mean = float(np.mean([row.warm for row in chosen]))
        cold = float(np.mean([row.cold for row in chosen]))
        worse = sum(row.warm > row.cold + 1 for row in chosen)
        fell = sum(row.fell_back for row in chosen) / len(chosen)
        unverified = sum(not row.verified for row in chosen)
        text = (
            f"mean {mean:.1f} (cold {cold:.1f}), most {max(row.warm for row in chosen)}; worse on {worse}; "
            f"fall-backs {fell:.0%}; {unverified} not verified; {len(chosen)} solves"
        )
        holds = mean <= WARM_MOST and not worse and fell <= WARM_FALL_BACKS and not unverified
        found.append(Requirement("6", title, required, text, holds))
    return found


def _sets(rows: Sequence[Graded]) -> list[Requirement]:
    if not rows:
        return [Requirement("7–8", "public sets", "≥ the best peer on each; no false claim", "", None)]
    found: list[Requirement] = []
    for name in dict.fromkeys(row.set for row in rows):
        members = [row for row in rows if row.set == name]
        for tol in (LOOSE, TIGHT):
            counts = {
                label: sum(row.verified(tol) for row in members if row.label == label)
                for label in dict.fromkeys(row.label for row in members)
                if "other settings" not in label
            }
            own = counts.pop(ORBSOC, 0)
            best = max(counts, key=lambda label: counts[label], default="none")
            problems = len({row.problem for row in members})
            text = f"{own} of {problems}; {best} {counts.get(best, 0)}"
            title = f"{name}: verified at {tol:g}"
            found.append(Requirement("7", title, "≥ the best peer", text, own >= counts.get(best, 0)))
    false = [f"{row.set}/{row.problem}" for row in rows if row.solver == ORBSOC and row.falsehood()]
    text = f"{len(false)} {', '.join(false)}".strip()
    return [*found, Requirement("8", "false claims over the sets", "0", text, not false)]


def _overhead(row: Overhead | None) -> Requirement:
    if row is None:
        return Requirement("9", "Python over the native update and solve", f"≤ {OVERHEAD_US:g} µs", "", None)
    text = f"{row.both_us:.1f} µs (update {row.update_us:.1f}, solve {row.solve_us:.1f}; native {row.native_us:.0f})"
    title = f"Python over the native update and solve, {row.numbers} numbers"
    return Requirement("9", title, f"≤ {OVERHEAD_US:g} µs", text, row.both_us <= OVERHEAD_US)
