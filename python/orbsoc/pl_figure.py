"""How busy each unit of the PL engine is, over the cycles of a segment."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from orbsoc.orbit.array import Array
from orbsoc.pl_program import PlProgram

BINS = 120


def busy_shares(program: PlProgram, stage: str, bins: int = BINS) -> tuple[Array, Array]:
    """Cycles at the bins' edges, shape (bins + 1,), and the share of each bin in which each unit was busy.

    Shape (lanes + dividers, bins); a divider is busy from an issue until it takes the next.
    """
    cycles, units = program.core.issues(stage)
    engine, segment = program.engine, program.segments[stage]
    edges = np.linspace(0.0, max(segment.words, 1), bins + 1)
    shares = np.zeros((engine.lanes + engine.dividers, bins))
    width = edges[1] - edges[0]
    for unit in range(engine.lanes + engine.dividers):
        began = np.sort(cycles[units == unit].astype(float))
        length = 1.0 if unit < engine.lanes else float(divider_cycles(began))
        # Busy time up to each edge: whole operations before it, and the part of one that straddles it.
        done = [np.clip(edge - began, 0.0, length).sum() for edge in edges]
        shares[unit] = np.diff(done) / width
    return edges, shares


def divider_cycles(began: Array) -> float:
    """Cycles that a divider is held: the shortest distance of two of its issues, or 1."""
    return float(np.diff(began).min()) if len(began) > 1 else 1.0


def utilisation_figure(program: PlProgram, path: Path) -> None:
    """Factorization and the pair of solves, or the one stream of a program, unit by unit, as an image."""
    from matplotlib.figure import Figure

    stages = [name for name in ("factorize", "solve_pair") if name in program.segments] or [*program.segments]
    lanes = program.engine.lanes
    figure = Figure(figsize=(8.0, 2.2 * len(stages) + 0.6), layout="constrained")
    axes = figure.subplots(len(stages), 1, squeeze=False)[:, 0]
    for axis, stage in zip(axes, stages, strict=True):
        edges, shares = busy_shares(program, stage)
        segment = program.segments[stage]
        image = axis.pcolormesh(
            edges, np.arange(len(shares) + 1), shares, vmin=0.0, vmax=1.0, cmap="viridis", rasterized=True
        )
        names = [f"lane {k}" for k in range(lanes)] + [f"divider {k}" for k in range(len(shares) - lanes)]
        axis.set_yticks(np.arange(len(names)) + 0.5, names)
        axis.invert_yaxis()
        axis.set_xlabel("PL cycle")
        axis.set_title(f"{stage}: {segment.cycles} cycles, lanes busy {100 * segment.utilisation:.0f} %")
        figure.colorbar(image, ax=axis, label="share busy")
    figure.savefig(path, dpi=150)
