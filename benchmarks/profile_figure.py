"""Performance profiles: the share of problems that a solver solves within a factor of the fastest on each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Measurement

Array = NDArray[np.float64]

COLOURS = {"orbsoc": "#c1121f", "Clarabel": "#1d3557", "ECOS": "#2a9d8f", "QOCO": "#e09f3e"}


def factors(measurements: Sequence[Measurement], *, kind: str = "solve") -> dict[str, Array]:
    """For each solver, its time over the best time on each problem; infinite where its time does not count.

    `kind` is "solve" or "total". Problems that no solver solves are left out. Source: Dolan & Moré 2002.
    """
    times: dict[str, dict[str, float]] = {}
    for m in measurements:
        spread = m.solve if kind == "solve" else m.total
        times.setdefault(m.solver, {})[m.problem] = spread.median if m.counts else np.inf
    names = list(dict.fromkeys(m.problem for m in measurements))
    table = np.array([[times[solver].get(name, np.inf) for name in names] for solver in times])
    best = table.min(axis=0)
    kept = np.isfinite(best)
    return {solver: np.sort(table[k, kept] / best[kept]) for k, solver in enumerate(times)}


def _ticks(reach: float) -> list[float]:
    """Factors to be named on an axis from 1 to `reach`: round ones first, others where there is room."""
    chosen: list[float] = []
    for tick in (1.0, 10.0, 2.0, 5.0, 20.0, 50.0, 100.0, 3.0, 7.0, 1.5):
        if tick <= reach and all(abs(np.log(tick / other)) >= 0.07 * np.log(reach) for other in chosen):
            chosen.append(tick)
    return sorted(chosen)


def profile_figure(
    measurements: Sequence[Measurement], header: Mapping[str, str], title: str, path: Path
) -> None:
    """Two panels, solve alone and set-up with solve, written to `path`."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    plt: Any = pyplot
    figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.9), sharey=True, layout="constrained")
    for axes, kind, name in zip(panels, ("solve", "total"), ("solve", "set-up and solve"), strict=True):
        curves = factors(measurements, kind=kind)
        finite = [f[np.isfinite(f)].max() for f in curves.values() if np.isfinite(f).any()]
        reach = 1.08 * max([1.5, *finite])
        for solver, found in curves.items():
            share = np.arange(1, found.size + 1) / found.size
            solved = np.isfinite(found)
            steps = np.concatenate([[1.0], found[solved], [reach]])
            heights = np.concatenate([[0.0], share[solved], [share[solved][-1] if solved.any() else 0.0]])
            own = solver == "orbsoc"
            label = solver if solved.any() else f"{solver} (none verified)"
            axes.step(
                steps, heights, where="post", label=label, color=COLOURS.get(solver), lw=2.4 if own else 1.5
            )
        axes.set(
            xscale="log",
            xlim=(1.0, reach),
            ylim=(0.0, 1.02),
            title=name,
            xlabel="time over the fastest solver's",
        )
        ticks = _ticks(reach)
        axes.set_xticks(ticks, [f"{t:g}×" for t in ticks])
        axes.minorticks_off()
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("share of problems")
    panels[1].legend(loc="lower right", framealpha=0.9)
    count = len({m.problem for m in measurements})
    figure.suptitle(f"{title}: {count} problems, {header['machine']}, {header['date']}", fontsize=11)
    figure.savefig(path, dpi=150)
    plt.close(figure)
