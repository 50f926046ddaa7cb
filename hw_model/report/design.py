"""Designs of one workload on one device: the front of time against area, and where the paper's design lies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hw_model.vocabulary import count_of

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

    from .study import Point

PAPER = "paper"


@dataclass(frozen=True, slots=True)
class Row:
    """A priced design. `area_share`: of the ceiling of its tightest resource; above 1 it does not fit."""

    ordering: str
    lanes: int
    dividers: int
    banks: int
    clusters: int
    pl_clock_mhz: float
    microcode_memory: str
    partition: str
    time_ms: float
    time_low_ms: float
    time_high_ms: float
    baseline_ms: float
    energy_mj: float
    energy_low_mj: float
    energy_high_mj: float
    area_share: float
    tightest: str
    lut: int
    ff: int
    dsp: int
    bram36: int
    uram: int

    @classmethod
    def of(cls, point: Point, ordering: str, platform: Platform) -> Row:
        """Of a priced point."""
        pl, time, budget, energy = platform.pl, point.time_ms, point.budget, point.energy
        return cls(
            ordering=ordering, lanes=pl.lanes.value, dividers=pl.dividers.value, banks=pl.banks.value,
            clusters=pl.clusters.value, pl_clock_mhz=pl.clock_mhz.value, microcode_memory=pl.microcode_memory.value,
            partition=point.partition, time_ms=time.nominal, time_low_ms=time.low, time_high_ms=time.high,
            baseline_ms=point.baselines_ms[0], energy_mj=energy.nominal_mj, energy_low_mj=energy.low_mj,
            energy_high_mj=energy.high_mj, area_share=point.area_share, tightest=budget.tightest.kind,
            lut=budget.of("lut").used, ff=budget.of("ff").used, dsp=budget.of("dsp").used,
            bram36=budget.of("bram36").used, uram=budget.of("uram").used,
        )  # fmt: skip

    @property
    def fits(self) -> bool:
        """Whether every resource stays within its ceiling."""
        return self.area_share <= 1.0

    @property
    def words(self) -> str:
        """The design in a phrase."""
        return (
            f"{count_of(self.lanes, 'lane')}, {count_of(self.dividers, 'divider')}, {self.banks} banks,"
            f" {count_of(self.clusters, 'cluster')},"
            f" {self.pl_clock_mhz:g} MHz, {self.ordering}, microcode {self.microcode_memory}, {self.partition}:"
            f" {self.time_ms:.3f} ms ({self.baseline_ms / self.time_ms:.2f}×), {self.energy_mj:.2f} mJ, {self.tightest} at"
            f" {100 * self.area_share:.0f} % of its ceiling"
        )


def front_of(rows: Sequence[Row]) -> list[Row]:
    """The designs that fit and that no other is both faster and smaller than, fastest first.

    The PS alone takes no area, so that a design that is not faster is beaten by none at all.
    """
    front: list[Row] = []
    worth = (row for row in rows if row.fits and row.time_ms < row.baseline_ms)
    for row in sorted(worth, key=lambda row: (row.time_ms, row.area_share)):
        if not front or row.area_share < front[-1].area_share:
            front.append(row)
    return front


@dataclass(frozen=True, slots=True)
class Standing:
    """Where the paper's design lies among all. `fastest`: of those with no more area; `smallest`: of those as fast."""

    paper: Row
    on_the_front: bool
    fastest: Row | None
    smallest: Row | None

    @classmethod
    def of(cls, paper: Row, front: Sequence[Row]) -> Standing:
        """Of the paper's design against a front of time and area."""
        no_larger = [row for row in front if row.area_share <= paper.area_share]
        as_fast = [row for row in front if row.time_ms <= paper.time_ms]
        beaten = any(
            row.time_ms <= paper.time_ms
            and row.area_share <= paper.area_share
            and (row.time_ms, row.area_share) != (paper.time_ms, paper.area_share)
            for row in front
        )
        fastest = min(no_larger, key=lambda row: row.time_ms, default=None)
        smallest = min(as_fast, key=lambda row: row.area_share, default=None)
        worth = paper.fits and paper.time_ms < paper.baseline_ms
        return cls(paper, worth and not beaten, fastest, smallest)

    @property
    def words(self) -> str:
        """Where it lies, in a sentence."""
        paper = self.paper
        text = (
            f"the paper's design takes {paper.time_ms:.3f} ms ({paper.baseline_ms / paper.time_ms:.2f}×) at"
            f" {100 * paper.area_share:.0f} % of the {paper.tightest} ceiling"
        )
        if not paper.fits:
            text += ", so that it does NOT FIT"
        if paper.time_ms >= paper.baseline_ms:
            text += f", SLOWER than the PS alone ({paper.baseline_ms:.3f} ms)"
        if self.on_the_front:
            return f"{text}: on the front"
        if self.fastest is not None and self.fastest.time_ms < paper.time_ms:
            text += f"; with no more area {self.fastest.time_ms:.3f} ms are possible"
        if self.smallest is not None and self.smallest.area_share < paper.area_share:
            text += f"; as fast with {100 * self.smallest.area_share:.0f} %"
        return text

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        from dataclasses import asdict

        return asdict(self) | {"words": self.words}
