"""Whether a partition is worth its resources: on each computer, is there another one that beats it?"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hw_model.vocabulary import count_of

if TYPE_CHECKING:
    from .study import Point


@dataclass(frozen=True, slots=True)
class Verdict:
    """One partition compared with all others on the same device, lanes and clock.

    `better`: the fastest that is no slower and takes no more of any resource; None when there is none.
    `robust`: it is so at every corner of the assumed bands, not only nominally.
    """

    point: Point
    better: Point | None
    robust: bool
    fastest: Point

    @property
    def optimal(self) -> bool:
        """Whether no other partition beats it nominally."""
        return self.better is None

    @property
    def words(self) -> str:
        """The verdict as a sentence."""
        lanes = count_of(self.point.lanes, "lane")
        here = f"{lanes} at {self.point.pl_clock_mhz:g} MHz on {self.point.device}"
        own = f"{self.point.partition} ({self.point.times_ms[0]:.3f} ms{_fitting(self.point)})"
        if self.better is None:
            return f"{here}: {own} is Pareto-optimal among all partitions"
        how = "over the whole band" if self.robust else "nominally, not over the whole band"
        return (
            f"{here}: {own} is NOT Pareto-optimal: {self.better.partition} ({self.better.times_ms[0]:.3f} ms"
            f"{_fitting(self.better)}) is no slower and takes no more of any resource, {how}"
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-able data."""
        better = self.better
        return {
            "device": self.point.device,
            "lanes": self.point.lanes,
            "pl_clock_mhz": self.point.pl_clock_mhz,
            "partition": self.point.partition,
            "time_ms": self.point.times_ms[0],
            "fits": self.point.budget.fits,
            "pareto_optimal": self.optimal,
            "better": None if better is None else better.partition,
            "better_time_ms": None if better is None else better.times_ms[0],
            "robust": self.robust,
            "fastest": self.fastest.partition,
            "fastest_time_ms": self.fastest.times_ms[0],
            "words": self.words,
        }


def _fitting(point: Point) -> str:
    return "" if point.budget.fits else ", does not fit"


def verdicts(points: Sequence[Point], partition: str = "paper") -> list[Verdict]:
    """A verdict on `partition` for every computer among `points`."""
    groups: defaultdict[tuple[str, int, float], list[Point]] = defaultdict(list)
    for point in points:
        groups[point.device, point.lanes, point.pl_clock_mhz].append(point)
    found: list[Verdict] = []
    for group in groups.values():
        own = next(point for point in group if point.partition == partition)
        better = [point for point in group if point.beats(own)]
        robust = [point for point in better if point.beats(own, everywhere=True)]
        best = min(robust or better, key=lambda point: point.times_ms[0], default=None)
        found.append(Verdict(own, best, bool(robust), min(group, key=lambda point: point.times_ms[0])))
    return found
