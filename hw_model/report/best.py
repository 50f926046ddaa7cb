"""The partition "best": of all partitions whose engine fits the device, the one with the least nominal time of a run.

All on the PS is one of them and always fits, so the best is never slower than the PS alone.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from hw_model.platform.partition import BEST, Partition, all_partitions
from hw_model.timing.timeline import as_partition

from .study import Study

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.timing.trace import Trace


def chosen_partition(
    partition: Partition | str | Path, trace: Trace, platform: Platform, cycles: StageCycles
) -> Partition:
    """The partition as it is, loaded by name or path, or for "best" the best of this run on this platform.

    Of partitions that take equally long the one with the fewest modules on the PL is taken. Raises PartitionError.
    """
    return best_partition(trace, platform, cycles) if str(partition) == BEST else as_partition(partition)


def best_partition(trace: Trace, platform: Platform, cycles: StageCycles) -> Partition:
    """The fastest partition that fits, called "best (its name)"; streams and resident control where the trace has lists."""
    partitions = all_partitions(programs=trace.method is not None)
    points = Study(trace, cycles).points(platform, partitions)
    fitting = [pair for pair in zip(points, partitions, strict=True) if pair[0].budget.fits]
    _, found = min(fitting, key=lambda pair: (pair[0].times_ms[0], _modules_on_pl(pair[1])))
    return found.model_copy(update={"name": f"{BEST} ({found.name})"})


def _modules_on_pl(partition: Partition) -> int:
    return sum(side == "pl" for side in partition.modules.values())
