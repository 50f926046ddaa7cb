"""Many configurations of one trace: their times and areas, and the Pareto front."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hw_model.area.budget import Budget, budget
from hw_model.area.fabric import KINDS
from hw_model.energy.joules import EnergyUse, counter_of, energy_use
from hw_model.platform.partition import on_pl
from hw_model.timing.actions import Action, Work, actions_of
from hw_model.timing.control_program import streams_of
from hw_model.timing.durations import Durations
from hw_model.timing.programs import NONE, Programs
from hw_model.timing.stage_cycles import PlCycles, StageCycles, estimated, of_program
from hw_model.timing.timeline import makespan_picoseconds, tally_of
from hw_model.vocabulary import PICOSECONDS_PER_MS

from .bands import Band, band_of, corners_of
from .loading import Loading, loading

if TYPE_CHECKING:
    from hw_model.energy.actions import StageCounts
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Trace


@dataclass(frozen=True, slots=True)
class Point:
    """One configuration: modelled times over the corners of the assumed bands (the first is nominal), and area."""

    device: str
    partition: str
    lanes: int
    pl_clock_mhz: float
    settings: dict[str, Any]
    """What else was set for this point."""
    times_ms: tuple[float, ...]
    baselines_ms: tuple[float, ...]
    worst_case_ms: float
    budget: Budget
    energy: EnergyUse
    loading: Loading

    @property
    def time_ms(self) -> Band:
        return band_of(self.times_ms)

    @property
    def speedup(self) -> Band:
        return band_of([base / time for base, time in zip(self.baselines_ms, self.times_ms, strict=True)])

    @property
    def area_share(self) -> float:
        """Share of the ceiling that the tightest resource takes: above 1, the engine does not fit; 1e6 of none at all."""
        return min(1e6, self.budget.tightest.share / self.budget.tightest.ceiling)

    def row(self) -> dict[str, Any]:
        """Flat, for a table."""
        uses: dict[str, Any] = {kind: self.budget.of(kind).used for kind in KINDS}
        time, ratio = self.time_ms, self.speedup
        return {
            "device": self.device, "partition": self.partition, "lanes": self.lanes,
            "pl_clock_mhz": self.pl_clock_mhz, **self.settings,
            "time_ms": time.nominal, "time_low_ms": time.low, "time_high_ms": time.high,
            "worst_case_ms": self.worst_case_ms,
            "speedup": ratio.nominal, "speedup_low": ratio.low, "speedup_high": ratio.high,
            "energy_mj": self.energy.nominal_mj, "energy_low_mj": self.energy.low_mj,
            "energy_high_mj": self.energy.high_mj, **uses, "storage_words": self.budget.storage_words,
            "area_share": self.area_share, "tightest": self.budget.tightest.kind, "fits": self.budget.fits,
            **self.loading.row(),
        }  # fmt: skip

    def beats(self, other: Point, *, everywhere: bool = False) -> bool:
        """Whether this one is as fast with no more of any resource, and better in one of them.

        With `everywhere`, as fast at every corner of the bands, not only nominally.
        """
        times = list(zip(self.times_ms, other.times_ms, strict=True))[: None if everywhere else 1]
        uses = [(self.budget.of(kind).used, other.budget.of(kind).used) for kind in KINDS]
        pairs = [*times, *uses]
        return all(mine <= theirs for mine, theirs in pairs) and any(mine < theirs for mine, theirs in pairs)

    def equals(self, other: Point) -> bool:
        """Whether nothing that `beats` compares tells the two apart."""
        return self.times_ms[0] == other.times_ms[0] and self.budget.uses == other.budget.uses


class Study:
    """Evaluates points of one trace; the actions of each partition are made once, whatever the number of platforms."""

    def __init__(self, trace: Trace, cycles: StageCycles = estimated) -> None:
        self.trace = trace
        self.cycles = cycles
        self._actions: dict[tuple[str, ...], tuple[list[Action], Counter[Work]]] = {}
        self._stage_counts: StageCounts = {}

    def points(
        self, platform: Platform, partitions: Iterable[Partition], settings: dict[str, Any] | None = None
    ) -> list[Point]:
        """A point per partition on one platform; `settings` is carried along. The baseline is all on the PS."""
        known: dict[tuple[bool, tuple[str, ...]], list[Durations]] = {}
        cycles = _Remembered(self.cycles)

        # corners_of begins with the nominal platform and the slowest one.
        def at_corners(partition: Partition, loaded: Programs) -> list[Durations]:
            key = partition.uses_pl, streams_of(self.trace, partition)
            if key not in known:
                known[key] = [
                    Durations(self.trace, corner, partition, self.cycles) for corner in corners_of(platform)
                ]
            return [durations.with_programs(loaded) for durations in known[key]]

        def times_ms(partition: Partition, corners: Sequence[Durations]) -> tuple[float, ...]:
            return tuple(self._ms(partition, durations) for durations in corners)

        alone = on_pl()
        baselines = times_ms(alone, at_corners(alone, NONE))
        points: list[Point] = []
        for partition in partitions:
            area = budget(self.trace, platform, partition, cycles)
            corners = at_corners(partition, area.programs)
            points.append(
                Point(
                    device=platform.name,
                    partition=partition.name,
                    lanes=platform.pl.lanes.value,
                    pl_clock_mhz=platform.pl.clock_mhz.value,
                    settings=settings or {},
                    times_ms=times_ms(partition, corners),
                    baselines_ms=baselines,
                    worst_case_ms=self._ms(partition, corners[1], worst=True),
                    budget=area,
                    energy=self._energy(partition, corners),
                    loading=loading(platform, area.programs),
                )
            )
        return points

    def _done(self, partition: Partition) -> tuple[list[Action], Counter[Work]]:
        key = partition.key
        if key not in self._actions:
            actions = actions_of(self.trace, partition)
            self._actions[key] = actions, tally_of(actions)
        return self._actions[key]

    def _energy(self, partition: Partition, corners: Sequence[Durations]) -> EnergyUse:
        actions, tally = self._done(partition)
        return energy_use(corners, counter_of(actions, partition, tally, self._stage_counts))

    def _ms(self, partition: Partition, durations: Durations, *, worst: bool = False) -> float:
        actions, tally = self._done(partition)
        return makespan_picoseconds(actions, durations, worst=worst, tally=tally) / PICOSECONDS_PER_MS


def pareto(points: Sequence[Point]) -> list[Point]:
    """The points that fit and that no other point that fits on the same device beats, fastest first."""
    fitting = sorted((point for point in points if point.budget.fits), key=lambda point: point.times_ms[0])
    front: list[Point] = []
    for point in fitting:  # only a faster point, or an equally fast one, can beat it
        same = [other for other in front if other.device == point.device]
        if not any(other.beats(point) or other.equals(point) for other in same):
            front = [other for other in front if other.device != point.device or not point.beats(other)]
            front.append(point)
    return front


class _Remembered:
    """The same for one platform, each segment asked for once."""

    def __init__(self, cycles: StageCycles) -> None:
        self._cycles = cycles
        self._known: dict[tuple[int, str], PlCycles] = {}
        self._programs: dict[tuple[str, ...], _Remembered] = {}

    def __call__(self, trace: Trace, platform: Platform, pattern: int, stage: str) -> PlCycles:
        if (pattern, stage) not in self._known:
            self._known[pattern, stage] = self._cycles(trace, platform, pattern, stage)
        return self._known[pattern, stage]

    def of_program(self, streams: tuple[str, ...]) -> _Remembered:
        if streams not in self._programs:
            self._programs[streams] = _Remembered(of_program(self._cycles, streams))
        return self._programs[streams]
