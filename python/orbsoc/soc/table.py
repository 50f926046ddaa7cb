"""Counted runs side by side: the core alone, and a partition with the engine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from .counted import Counted, StageCount

REST = "rest: certificate, calls, control"


@dataclass(frozen=True, slots=True)
class Comparison:
    """Sums over solves. `alone` and `split` are of the same problems."""

    alone: tuple[Counted, ...]
    split: tuple[Counted, ...]

    @property
    def same_bits(self) -> bool:
        """Whether every solve has the host's bits."""
        return all(run.same_bits for run in (*self.alone, *self.split))

    @property
    def loaded_cycles(self) -> int:
        """Core cycles of loading programs, once a pattern and not once a solve."""
        return sum(part.core_cycles for run in self.split for part in run.stages if part.name == "load")

    @property
    def speedup(self) -> float | None:
        """The core alone over the partition, without loading."""
        if not self.split:
            return None
        return _total(self.alone) / (_total(self.split) - self.loaded_cycles)


def _total(runs: Sequence[Counted]) -> int:
    return sum(run.core_cycles for run in runs)


def added(parts: Iterable[StageCount]) -> list[StageCount]:
    """Sums by name and place, in the order of the first."""
    sums: dict[tuple[str, str], list[int]] = {}
    for part in parts:
        row = sums.setdefault((part.name, part.where), [0, 0, 0, 0])
        for k, value in enumerate((part.runs, part.core_cycles, part.instructions, part.pl_cycles)):
            row[k] += value
    return [StageCount(name, where, *row) for (name, where), row in sums.items()]


def rest_of(runs: Sequence[Counted]) -> tuple[int, int]:
    """Core cycles and instructions of what is in no part."""
    parts = [part for run in runs for part in run.stages]
    instructions = sum(run.instructions for run in runs) - sum(part.instructions for part in parts)
    return _total(runs) - sum(part.core_cycles for part in parts), instructions


def summed(runs: Sequence[Counted]) -> list[StageCount]:
    """The parts of all runs; last what is in no part."""
    rows = added(part for run in runs for part in run.stages)
    return [*rows, StageCount(REST, "core", len(runs), *rest_of(runs))]


def table(runs: Sequence[Counted], title: str) -> list[str]:
    """Lines for a terminal: parts by their share, then the whole."""
    total = _total(runs)
    rows = sorted(summed(runs), key=lambda row: -row.core_cycles)
    lines = [
        f"{title}",
        f"{'part':34} {'where':5} {'runs':>6} {'core cycles':>13} {'PL cycles':>11} {'share':>7}",
    ]
    for row in rows:
        pl = f"{row.pl_cycles:11d}" if row.pl_cycles else " " * 11
        lines.append(
            f"{row.name:34} {row.where:5} {row.runs:6d} {row.core_cycles:13d} {pl} {100 * row.core_cycles / total:6.1f} %"
        )
    return [*lines, f"{'whole':34} {'':5} {len(runs):6d} {total:13d}"]
