"""Joules of a run: counts (actions.py) times the platform's `[energy]` table, with the band of table and times.

Energy is linear in every entry of the table, so an entry's share of the total is also how much the total moves, in
per cent, when the entry moves by one per cent: the sensitivity.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import lcm
from typing import TYPE_CHECKING

from hw_model.area.budget import engine_shape
from hw_model.timing.timeline import makespan_picoseconds, tally_of

from .actions import DYNAMIC, ENERGY_ACTIONS, Counts, EnergyAction, StageCounts, run_counts, stage_counts

if TYPE_CHECKING:
    from hw_model.platform.parameter import End
    from hw_model.platform.partition import Partition
    from hw_model.platform.sections import Energy
    from hw_model.timing.actions import Action, Work
    from hw_model.timing.durations import Durations
    from hw_model.timing.trace import Stage
    from hw_model.vocabulary import Datapath

MJ_PER_PJ = 1e-9
ENDS: tuple[End, ...] = ("fast", "nominal", "slow")
"""Of the table's bands, the least energy first."""


@dataclass(frozen=True, slots=True)
class EnergyRow:
    """One action: how often (or picoseconds of it), and its millijoules at the ends of its own entry's band."""

    action: EnergyAction
    count: int
    low_mj: float
    nominal_mj: float
    high_mj: float
    share: float
    """Of the nominal total: also the sensitivity of the total to this entry."""


@dataclass(frozen=True, slots=True)
class EnergyUse:
    """A run's energy. `low_mj`, `high_mj`: every entry and every time at that end."""

    low_mj: float
    nominal_mj: float
    high_mj: float
    rows: tuple[EnergyRow, ...]

    @property
    def words(self) -> str:
        """The total and what most of it goes into."""
        most = max(self.rows, key=lambda row: row.nominal_mj)
        return (
            f"{self.nominal_mj:.2f} mJ ({self.low_mj:.2f}–{self.high_mj:.2f}), "
            f"{100 * most.share:.0f} % of it {most.action}"
        )


def picojoules(table: Energy, action: EnergyAction, end: End = "nominal") -> Fraction:
    """What one count of an action costs; a standing action's count is a picosecond, and 1 mW is 1e-3 pJ in it."""
    entry = getattr(table, f"{action}_pj" if action in DYNAMIC else f"{action}_mw").at(
        end, more_is_faster=False
    )
    value = Fraction(entry.value)
    return value if action in DYNAMIC else value / 1000


@lru_cache(maxsize=64)
def _prices(table: Energy, end: End) -> tuple[dict[EnergyAction, int], int]:
    """Picojoules of every action as whole numbers over one denominator: sums of them are exact and quick."""
    exact = {action: picojoules(table, action, end) for action in ENERGY_ACTIONS}
    denominator = lcm(*(price.denominator for price in exact.values()))
    return {action: int(price * denominator) for action, price in exact.items()}, denominator


def _sum_picojoules(
    counts: Mapping[EnergyAction, int], prices: tuple[dict[EnergyAction, int], int]
) -> Fraction:
    each, denominator = prices
    return Fraction(sum(count * each[action] for action, count in counts.items()), denominator)


def total_picojoules(counts: Mapping[EnergyAction, int], table: Energy, end: End = "nominal") -> Fraction:
    """Σ count · energy, exactly."""
    return _sum_picojoules(counts, _prices(table, end))


def _millijoules(counts: Mapping[EnergyAction, int], prices: tuple[dict[EnergyAction, int], int]) -> float:
    return float(_sum_picojoules(counts, prices)) * MJ_PER_PJ


def millijoules(counts: Mapping[EnergyAction, int], table: Energy, end: End = "nominal") -> float:
    """The same in millijoules."""
    return _millijoules(counts, _prices(table, end))


def energy_use(corners: Sequence[Durations], count: Callable[[Durations], Counts]) -> EnergyUse:
    """Energy from durations at the corners of their bands: the first nominal, the second slowest, the last fastest.

    No action grows rarer or shorter when something takes longer, so the extremes are at these two.
    """
    table = corners[0].platform.energy
    fast, typical_prices, slow = (_prices(table, end) for end in ENDS)
    counted = [count(durations) for durations in (corners[0], corners[1], corners[-1])]
    nominal = _millijoules(counted[0], typical_prices)
    rows: list[EnergyRow] = []
    for action in (action for action in ENERGY_ACTIONS if counted[0][action]):
        own = {action: counted[0][action]}
        low, typical, high = (_millijoules(own, prices) for prices in (fast, typical_prices, slow))
        share = typical / nominal if nominal else 0.0
        rows.append(EnergyRow(action, own[action], low, typical, high, share))
    least = min(_millijoules(found, fast) for found in counted)
    most = max(_millijoules(found, slow) for found in counted)
    return EnergyUse(least, nominal, most, tuple(rows))


def counter_of(
    actions: list[Action],
    partition: Partition,
    tally: Counter[Work] | None = None,
    stages: StageCounts | None = None,
) -> Callable[[Durations], Counts]:
    """Durations → actions of the run under `partition`. `tally`, `stages`: what the caller knows of them."""
    works = tally or tally_of(actions)
    known: StageCounts = {} if stages is None else stages

    def count(durations: Durations) -> Counts:
        bits = engine_shape(durations.trace, durations.platform, partition).microcode_bits
        makespan = makespan_picoseconds(actions, durations, tally=works)
        return run_counts(works, durations, makespan, bits, known, uses_pl=partition.uses_pl)

    return count


def segment_nanojoules(
    stage: Stage, datapath: Datapath, microcode_bits: int, table: Energy, problems: int = 1
) -> tuple[float, ...]:
    """Dynamic energy of one run of a stage on the PL for some problems, without clocks and leakage: low, nominal, high."""
    counts = Counter({action: problems * count for action, count in stage_counts(stage, datapath).items()})
    counts["microcode_bit"] += microcode_bits
    return tuple(float(total_picojoules(counts, table, end)) * 1e-3 for end in ENDS)
