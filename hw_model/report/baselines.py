"""A run beside the processor alone, in one table: one core and all cores, with the PL there and without.

All cores work on a run each, so that the ratio is one of runs a second, not of one run's time. Without a PL nothing of it
draws power; with each core busy, what PS and memory draw all the time is shared by as many runs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from hw_model.energy.joules import EnergyUse, counter_of, energy_use
from hw_model.timing.ps import price_words

from .bands import Band, corners_of
from .prices import at_each_price
from .throughput import throughputs

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.actions import Action
    from hw_model.timing.durations import Durations
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace

SHARED = ("ps_static", "memory_static")
"""What all runs that are under way share."""
OF_ALL_CORES = ("core_waiting", "core_idle")
"""What cores draw that do nothing: none does where each has a run."""


@dataclass(frozen=True, slots=True)
class Beside:
    """One way to do without this partition, and what the partition gains over it."""

    what: str
    gains: tuple[tuple[str, float], ...]
    """Of each price of the PS's work: times as fast, of one run; of all cores, times as many runs a second."""
    energy_mj: Band
    """Of a run."""


def without_pl(actions: list[Action], durations: Durations, partition: Partition) -> EnergyUse:
    """The energy of a run of the PS where there is no PL to draw any."""
    bare = durations.on(durations.platform.with_value("energy.pl_static_mw", 0.0))
    corners = [bare.on(corner) for corner in corners_of(bare.platform)]
    return energy_use(corners, counter_of(actions, partition))


def baselines(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    base: Partition,
    cycles: StageCycles,
    *,
    speedups: Sequence[tuple[str, float]],
    energies: tuple[EnergyUse, EnergyUse],
) -> tuple[Beside, ...]:
    """One core with and without a PL, and all cores with one run of the partition in flight and with two.

    `speedups`: over one core, at each price; `energies`: of a run of one core with the PL, and without.
    """
    with_pl, bare = energies
    cores = platform.ps.cores.value
    found = [
        Beside("one core", tuple(speedups), _band(with_pl)),
        Beside("one core of a chip without a PL", tuple(speedups), _band(bare)),
    ]
    gains: dict[int, list[tuple[str, float]]] = {}
    for priced in at_each_price(platform, trace):
        for row in throughputs(trace, priced, partition, base, cycles):
            gains.setdefault(row.in_flight, []).append((price_words(priced.ps), row.gain))
    for in_flight in sorted(gains)[:2]:
        runs = "1 run" if in_flight == 1 else f"{in_flight} runs"
        what = f"{cores} cores of a chip without a PL, a run each, against {runs} in flight"
        found.append(Beside(what, tuple(gains[in_flight]), _each_of(bare, cores)))
    return tuple(found)


def _band(use: EnergyUse) -> Band:
    return Band(use.low_mj, use.nominal_mj, use.high_mj)


def _each_of(bare: EnergyUse, cores: int) -> Band:
    """A run's share where every core has one; the ends of its band in the same proportion."""
    left = {row.action: 1.0 / cores for row in bare.rows if row.action in SHARED}
    left |= {row.action: 0.0 for row in bare.rows if row.action in OF_ALL_CORES}
    nominal = sum(left.get(row.action, 1.0) * row.nominal_mj for row in bare.rows)
    share = nominal / bare.nominal_mj if bare.nominal_mj else 1.0
    return Band(share * bare.low_mj, nominal, share * bare.high_mj)
