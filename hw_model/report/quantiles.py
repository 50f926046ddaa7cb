"""A speedup as quantiles of drawn parameters, beside the corners of bands.py.

Prior: every banded parameter of PS, PL, link and runtime lies anywhere in its band, each by itself, evenly in logarithms (evenly, where
a band touches zero). Run and baseline share each draw. A corner takes the slow end of everything at once; a draw does not.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING, Any

from hw_model.platform.parameter import Parameter
from hw_model.platform.partition import load_partition
from hw_model.timing.actions import actions_of
from hw_model.timing.stage_cycles import StageCycles, estimated
from hw_model.timing.timeline import makespan_picoseconds

from .bands import Band
from .run import durations_of

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Trace

SECTIONS = ("ps", "pl", "link", "runtime")


def drawn(platform: Platform, source: random.Random) -> Platform:
    """The platform with a draw from each band."""
    moved: dict[str, Any] = {}
    for name in SECTIONS:
        section = getattr(platform, name)
        update = {
            key: row.model_copy(update={"value": _draw(row, source)}) for key, row in section.own_parameters()
        }
        moved[name] = section.model_copy(update=update)
    return platform.model_copy(update=moved)


def _draw(row: Parameter[Any], source: random.Random) -> Any:
    if row.low is None or row.high is None or isinstance(row.value, int | str):
        return row.value
    if row.low <= 0.0:
        return source.uniform(row.low, row.high)
    return math.exp(source.uniform(math.log(row.low), math.log(row.high)))


def speedup_quantiles(
    trace: Trace,
    platform: Platform,
    partition: Partition,
    *,
    cycles: StageCycles = estimated,
    draws: int = 1000,
    seed: int = 1,
) -> Band:
    """The speedup's 5 %, 50 % and 95 % quantiles over `draws` platforms, at the platform's price of the PS's work."""
    split, alone = partition, load_partition("all_ps")
    runs = [(actions_of(trace, each), durations_of(trace, platform, each, cycles)) for each in (alone, split)]
    source = random.Random(seed)
    found: list[float] = []
    for _ in range(draws):
        computer = drawn(platform, source)
        before, after = (makespan_picoseconds(actions, durations.on(computer)) for actions, durations in runs)
        found.append(before / after)
    found.sort()
    return Band(*(found[round(share * (draws - 1))] for share in (0.05, 0.5, 0.95)))
