"""What would hold an engine that does not fit: other memories, other depths, or fewer modules on the PL."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

from hw_model.area.budget import Budget, budget
from hw_model.errors import HwModelError

from .best import best_partition
from .study import Study

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace

MEMORIES: dict[str, tuple[str, ...]] = {
    "pl.microcode_memory": ("block_ram", "streamed_start", "streamed", "ultra_ram"),
    "pl.storage_memory": ("block_ram", "ultra_ram"),
    "pl.storage_depth": ("power_of_two", "exact"),
}
"""Settings that move memory about without another schedule."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """What to change, and the modelled time and the tightest resource then."""

    settings: dict[str, str]
    partition: str
    time_ms: float
    budget: Budget

    @property
    def words(self) -> str:
        """The remedy in a phrase."""
        what = " and ".join(f"{key}={value}" for key, value in self.settings.items()) or (
            f"the partition {self.partition}"
        )
        use = self.budget.tightest
        return f"{what}: {self.time_ms:.3f} ms, {use.kind} at {100 * use.share / use.ceiling:.0f} % of its ceiling"


def remedies(trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles) -> list[Remedy]:
    """Ways to make an engine fit that changes no schedule, those with the fewest changes first; and last the fastest
    partition that fits as the platform is. Empty where it fits, and where problems are interleaved: such a run has no time
    by which to choose."""
    if platform.pl.interleaved.value > 1 or budget(trace, platform, partition, cycles).fits:
        return []
    study, found = Study(trace, cycles), list[Remedy]()
    for values in product(*MEMORIES.values()):
        wanted = dict(zip(MEMORIES, values, strict=True))
        settings = {key: value for key, value in wanted.items() if _value(platform, key) != value}
        if any(known.settings.items() <= settings.items() for known in found):
            continue
        try:
            (point,) = study.points(platform.with_values(settings), [partition])
        except HwModelError:  # an estimate cannot be streamed
            continue
        if point.budget.fits:
            found = [known for known in found if not settings.items() <= known.settings.items()]
            found.append(Remedy(settings, partition.name, point.time_ms.nominal, point.budget))
    found.sort(key=lambda remedy: (len(remedy.settings), remedy.time_ms))
    other = best_partition(trace, platform, cycles)
    (point,) = study.points(platform, [other])
    return [*found, Remedy({}, other.name, point.time_ms.nominal, point.budget)]


def _value(platform: Platform, key: str) -> object:
    return dict(platform.parameters())[key].value
