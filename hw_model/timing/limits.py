"""Limits of acceleration (Amdahl): what remains when the PL, and then the link too, cost nothing; and the roofline.

Both come from one modelled run: its causes by module, the operations of its stages and the bytes that it moves.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hw_model.platform.partition import on_pl
from hw_model.vocabulary import ACCOUNTS, PL_CAUSES, Cause, Module

from .actions import actions_of
from .durations import Durations
from .groups import require_one_problem
from .programs import NONE, Programs
from .stage_cycles import StageCycles, estimated
from .timeline import lay_out

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform

    from .trace import Trace


@dataclass(frozen=True, slots=True)
class Limits:
    """Speedups over all on the PS, at the nominal parameters, of a serial run: ours, and as costs vanish one by one."""

    speedup: float
    free_pl: float
    """Every segment takes no time; link and interrupts stay."""
    free_pl_and_link: float
    """Only the PS's own time stays: Amdahl's limit of this partition."""


@dataclass(frozen=True, slots=True)
class Roof:
    """One module on the PL: operations a byte that crosses, and operations a nanosecond achieved."""

    module: Module
    operations: int
    link_bytes: int
    computing_ns: float
    total_ns: float

    @property
    def intensity(self) -> float:
        """Operations per byte across the link; infinite when nothing crosses."""
        return self.operations / self.link_bytes if self.link_bytes else float("inf")

    @property
    def gops(self) -> float:
        """Giga-operations a second while computing."""
        return self.operations / self.computing_ns

    @property
    def gops_with_link(self) -> float:
        """The same with the copies, launches and interrupts that the module causes."""
        return self.operations / self.total_ns


def limits(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    cycles: StageCycles = estimated,
    loaded: Programs = NONE,
) -> Limits:
    """Amdahl's limits of `partition`; the platform's schedule must be serial, where causes add. `loaded`: the programs."""
    causes = _causes(trace, platform, partition, cycles, loaded)
    base = sum(_causes(trace, platform, on_pl(), cycles).values())
    total, ours = sum(causes.values()), causes["ps"]
    computing = sum(causes[cause] for cause in PL_CAUSES)
    return Limits(base / total, base / (total - computing), base / ours)


def roofs(
    trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles = estimated
) -> list[Roof]:
    """A row per module on the PL that runs."""
    durations = Durations(trace, platform, partition, cycles)
    actions = actions_of(trace, partition)
    work: Counter[str] = Counter()
    sizes: Counter[str] = Counter()
    for action in actions:
        if action.work.kind == "compute" and action.work.side == "pl":
            stage = trace.patterns[action.work.pattern].stage(action.work.what)
            work[action.module] += sum(stage.operations.values())
        elif action.work.kind == "copy":
            sizes[action.module] += durations.size_bytes(action.work)
    totals = lay_out(actions, durations, partition.name).totals("module", "cause")
    rows: list[Roof] = []
    for module in ACCOUNTS[1:]:
        side = partition.side(module)
        own = {cause: picoseconds for (name, cause), picoseconds in totals.items() if name == module}
        computing = sum(own.get(cause, 0) for cause in PL_CAUSES)
        if side == "pl" and computing and work[module]:
            total = sum(own.values())
            rows.append(Roof(module, work[module], sizes[module], computing / 1e3, total / 1e3))
    return rows


def _causes(
    trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles, loaded: Programs = NONE
) -> Counter[Cause]:
    require_one_problem(platform)
    durations = Durations(trace, platform, partition, cycles, loaded)
    found: Counter[Cause] = Counter()
    for action in actions_of(trace, partition):
        for part in durations.parts(action.work):
            found[part.cause] += part.picoseconds
    return found
