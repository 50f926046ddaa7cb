"""Sets of engines for many problems of one pattern: what each makes a second, beside all cores, and whether the device holds it.

Every engine of a set has microcode, words and control of its own, and one group of interleaved problems at a time: that is
what rtl/ has. The PS generates and judges meanwhile, on every core a problem without a place on the PL. Cores of the
baseline have NEON within a solve where the platform's price has it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

from hw_model.area.budget import Taken, Use, budget
from hw_model.area.engine import require_buildable
from hw_model.errors import HwModelError
from hw_model.timing.queue import Line
from hw_model.vocabulary import count_of

from .bands import Band, band_of, corners_of
from .loading import Loading, loading
from .prices import at_each_price
from .throughput import Throughput, throughputs

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace

KEYS = ("pl.lanes", "pl.dividers", "pl.banks", "pl.clusters")
"""What a shape is, in this order."""
SHAPES = ((2, 1, 16, 1), (4, 1, 16, 1), (8, 2, 32, 1), (16, 4, 32, 8))
COPIES = (1, 2, 4, 8, 16)
ENGINES = (1, 2, 3, 4)


@dataclass(frozen=True, slots=True)
class EngineSet(Taken):
    """Engines of one shape with `copies` problems interleaved in each. `uses`: of all of them together."""

    shape: tuple[int, int, int, int]
    copies: int
    found: Throughput
    uses: tuple[Use, ...]
    loading: Loading
    """Of one engine's programs."""
    storage_words: int
    """Of one engine, of one replica."""

    @property
    def words(self) -> str:
        """The set in a phrase."""
        lanes, dividers, banks, clusters = self.shape
        return (
            f"{count_of(self.found.engines, 'engine')} of {count_of(lanes, 'lane')}, {count_of(dividers, 'divider')},"
            f" {banks} banks, {count_of(clusters, 'cluster')}, {self.copies} interleaved"
        )

    def row(self) -> dict[str, Any]:
        """As a table has it."""
        names = (key.removeprefix("pl.") for key in KEYS)
        return {
            "engines": self.found.engines,
            **dict(zip(names, self.shape, strict=True)),
            "interleaved": self.copies,
            "solves_per_s": self.found.solves_per_s,
            "most_per_s": self.found.most_per_s,
            "busiest": self.found.busiest,
            "baseline_per_s": self.found.baseline_per_s,
            "gain": self.found.gain,
            "fits": self.fits,
            "tightest": self.tightest.kind,
            "share": min(1e6, self.tightest.share),
            "ceiling": self.tightest.ceiling,
            **{use.kind: use.used for use in self.uses},
            "storage_words": self.storage_words,
            **self.loading.row(),
        }


@dataclass(frozen=True, slots=True)
class Question:
    """A trace of independent problems, the computer that they are for, and where cycles come from."""

    trace: Trace
    platform: Platform
    partition: Partition
    base: Partition
    cycles: StageCycles

    def sets(
        self,
        shapes: Sequence[tuple[int, int, int, int]] = SHAPES,
        copies: Sequence[int] = COPIES,
        engines: Sequence[int] = ENGINES,
    ) -> Iterator[EngineSet]:
        """Every set of the grid. Raises HwModelError as `throughputs` and `budget` do."""
        _require_on_chip(self.platform)
        for shape, count in product(shapes, copies):
            platform = self._computer(shape, count)
            area = budget(self.trace, platform, self.partition, self.cycles)
            loads = loading(platform, area.programs)
            for found in self._priced(platform, engines):
                uses = tuple(replace(use, used=found.engines * use.used) for use in area.uses)
                yield EngineSet(shape, count, found, uses, loads, area.storage_words)

    def gains(self, of: EngineSet) -> list[tuple[Platform, Band]]:
        """At each price of the PS's work: solves a second over those of all cores, with the ends of the platform's bands."""
        found: list[tuple[Platform, Band]] = []
        for priced in at_each_price(self._computer(of.shape, of.copies), self.trace):
            rows = [self._priced(corner, [of.found.engines])[0] for corner in corners_of(priced)]
            found.append((priced, band_of([row.gain for row in rows])))
        return found

    def _computer(self, shape: tuple[int, int, int, int], copies: int) -> Platform:
        values = dict(zip(KEYS, shape, strict=True)) | {"pl.interleaved": copies}
        platform = self.platform.with_values(values)
        require_buildable(platform.pl)
        return platform

    def _priced(self, platform: Platform, engines: Sequence[int]) -> list[Throughput]:
        lines = [Line(count, count, platform.ps.cores.value) for count in engines]
        return throughputs(self.trace, platform, self.partition, self.base, self.cycles, lines)


def best_of(sets: Iterable[EngineSet]) -> EngineSet | None:
    """The set that fits with the most solves a second; of equals the one that takes the least."""
    fitting = [each for each in sets if each.fits]
    return max(fitting, key=lambda each: (each.found.solves_per_s, -each.tightest.share), default=None)


def _require_on_chip(platform: Platform) -> None:
    memory = platform.pl.microcode_memory.value
    if memory.startswith("streamed"):
        raise HwModelError(
            f"`pl.microcode_memory` = {memory!r}: engines side by side do not share a stream; allowed: block_ram, ultra_ram"
        )
