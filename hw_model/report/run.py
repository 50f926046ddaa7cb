"""One run of a trace with all that it takes: the loads of programs among it, which follow from what the device holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from hw_model.area.budget import budget
from hw_model.errors import NoSuchEngineError
from hw_model.timing.actions import actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.programs import NONE
from hw_model.timing.stage_cycles import StageCycles, estimated
from hw_model.timing.timeline import Timeline, as_partition, as_platform, lay_out
from hw_model.timing.trace import parse_trace

if TYPE_CHECKING:
    from pathlib import Path

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Trace


def durations_of(trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles) -> Durations:
    """How long each piece of work takes, the loads of the programs that the device cannot hold together among it.

    An engine that rtl/ has not has no area, so that nothing is known of what it holds: its programs take no time.
    """
    try:
        loaded = budget(trace, platform, partition, cycles).programs
    except NoSuchEngineError:
        loaded = NONE
    return Durations(trace, platform, partition, cycles, loaded)


def simulate(
    trace: Mapping[str, Any] | Trace,
    platform: Platform | str | Path,
    partition: Partition | str | Path,
    cycles: StageCycles = estimated,
) -> Timeline:
    """The timeline of `trace` on `platform` under `partition` (objects, names or paths).

    `cycles`: where the cycles of a stage on the PL come from. Raises TraceError, PlatformError or PartitionError.
    """
    trace, platform, partition = parse_trace(trace), as_platform(platform), as_partition(partition)
    durations = durations_of(trace, platform, partition, cycles)
    return lay_out(actions_of(trace, partition), durations, partition.name)
