"""How busy each unit of the PL engine is, over the cycles of a segment."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .schedules import PlProgram

Array = NDArray[np.float64]

BINS = 120


def busy_shares(program: PlProgram, stage: str, bins: int = BINS) -> tuple[Array, Array]:
    """Cycles at the bins' edges, shape (bins + 1,), and the share of each bin in which each unit was busy.

    Shape (lanes + dividers, bins); a divider is busy from an issue until it takes the next.
    """
    cycles, units, operations = program.core.issues(stage)
    held = _held_cycles(program)[operations]
    engine, segment = program.engine, program.segments[stage]
    edges = np.linspace(0.0, max(segment.words, 1), bins + 1)
    shares = np.zeros((engine.lanes + engine.dividers, bins))
    width = edges[1] - edges[0]
    for unit in range(engine.lanes + engine.dividers):
        began, length = cycles[units == unit].astype(float), held[units == unit]
        # Busy time up to each edge: whole operations before it, and the part of one that straddles it.
        done = [np.clip(edge - began, 0.0, length).sum() for edge in edges]
        shares[unit] = np.diff(done) / width
    return edges, shares


def _held_cycles(program: PlProgram) -> Array:
    """Cycles for which each operation, in the order of `operation_names`, holds its unit."""
    from hw_model.platform.rtl_latency import rtl_latencies

    units = rtl_latencies()["f64" if program.engine.fp == 64 else "f32"]
    on_divider = {name: units[f"{name}_interval_cycles"]["value"] for name in ("div", "sqrt")}
    return np.array([float(on_divider.get(name, 1)) for name in program.core.operation_names()])


def utilisation_figure(panels: Sequence[tuple[PlProgram, str]], path: Path) -> None:
    """Segments of programs, by name, unit by unit, one under the other as an image."""
    from matplotlib.figure import Figure

    units = [program.engine.lanes + program.engine.dividers for program, _ in panels]
    figure = Figure(figsize=(8.0, sum(1.0 + 0.25 * count for count in units)), layout="constrained")
    axes = figure.subplots(len(panels), 1, squeeze=False, height_ratios=units)[:, 0]
    for axis, (program, stage) in zip(axes, panels, strict=True):
        edges, shares = busy_shares(program, stage)
        segment, lanes = program.segments[stage], program.engine.lanes
        image = axis.pcolormesh(
            edges, np.arange(len(shares) + 1), shares, vmin=0.0, vmax=1.0, cmap="viridis", rasterized=True
        )
        names = [f"lane {k}" for k in range(lanes)] + [f"divider {k}" for k in range(len(shares) - lanes)]
        axis.set_yticks(np.arange(len(names)) + 0.5, names)
        axis.invert_yaxis()
        axis.set_xlabel("PL cycle")
        axis.set_title(f"{stage}: {segment.cycles} cycles, lanes busy {100 * segment.utilisation:.1f} %")
        figure.colorbar(image, ax=axis, label="share busy")
    figure.savefig(path, dpi=150)
