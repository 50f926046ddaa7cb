"""Run-to-run variation: makespans of many seeded runs, and the bound that none of them exceeds.

Each piece of work lasts its nominal time plus a draw between 0 and its own bound; segments on the PL have none. The
bound of a run is not drawn but computed: every piece at its bound.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from hw_model.errors import HwModelError

from .actions import actions_of
from .durations import Durations
from .programs import NONE, Programs
from .stage_cycles import StageCycles, estimated
from .timeline import as_partition, as_platform, makespan_picoseconds, precedence_of
from .trace import parse_trace

if TYPE_CHECKING:
    from pathlib import Path

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform

    from .trace import Trace

Draw = Callable[[tuple[int, int]], NDArray[np.float64]]
"""A shape → that many numbers in [0, 1]."""

_AT_ONCE = 2**22
"""Draws held in memory at a time."""
_LONGEST_PICOSECONDS = 2**53
"""Two and a half hours: up to here every sum and every fraction of times is exact."""


@dataclass(frozen=True, slots=True, eq=False)
class Distribution:
    """Makespans of `runs` seeded runs at the nominal parameters, ascending, and what bounds them."""

    runs: int
    seed: int
    picoseconds: NDArray[np.int64]
    nominal_picoseconds: int
    bound_picoseconds: int

    def quantile_ms(self, share: float) -> float:
        """The makespan that `share` of the runs stay below or meet, in ms."""
        return float(np.quantile(self.picoseconds, share, method="higher")) / 1e9

    def to_dict(self) -> dict[str, Any]:
        """Nominal, quantiles, maximum and bound in ms, as JSON-able data."""
        shares = {"p50_ms": 0.5, "p95_ms": 0.95, "p99_ms": 0.99, "max_ms": 1.0}
        return {
            "runs": self.runs,
            "seed": self.seed,
            "nominal_ms": self.nominal_picoseconds / 1e9,
            **{name: self.quantile_ms(share) for name, share in shares.items()},
            "bound_ms": self.bound_picoseconds / 1e9,
        }


def distribution(
    trace: Mapping[str, Any] | Trace,
    platform: Platform | str | Path,
    partition: Partition | str | Path,
    *,
    runs: int = 10_000,
    seed: int = 0,
    cycles: StageCycles = estimated,
    draw: Draw | None = None,
    loaded: Programs = NONE,
) -> Distribution:
    """Makespans of `runs` ≥ 1 runs that differ in their jitter; the same seed gives the same runs.

    `draw` replaces the random numbers. `loaded`: programs, as a budget has them; without, all are there. Raises HwModelError for an impossible number of runs, and what `simulate`
    raises.
    """
    if runs < 1:
        raise HwModelError(f"`runs` = {runs!r}: must be at least 1")
    trace, platform, partition = parse_trace(trace), as_platform(platform), as_partition(partition)
    durations = Durations(trace, platform, partition, cycles, loaded)
    actions = actions_of(trace, partition)
    bound = makespan_picoseconds(actions, durations, worst=True)
    if bound > _LONGEST_PICOSECONDS:
        raise HwModelError(
            f"a run of {bound / 1e12:.3g} s: at most {_LONGEST_PICOSECONDS / 1e12:.0f} s can be drawn run by run"
        )
    nominal = np.array([durations.picoseconds(action.work) for action in actions], dtype=np.int64)
    bounds = np.array([durations.jitter_picoseconds(action.work) for action in actions], dtype=np.int64)
    precedence = precedence_of(actions, durations)
    one_after_another = platform.runtime.schedule.value == "serial"
    sample = draw or _random(seed, platform.runtime.jitter_exponent.value)
    found: list[NDArray[np.int64]] = []
    step = max(1, _AT_ONCE // max(1, len(actions)))
    for first in range(0, runs, step):
        extra = sample((len(actions), min(step, runs - first))) * bounds[:, None]
        times = nominal[:, None] + np.floor(extra).astype(np.int64)
        if one_after_another:
            found.append(times.sum(axis=0))
        else:
            found.append(np.maximum.reduce(precedence.ends(list(times), np.maximum)))
    return Distribution(
        runs,
        seed,
        np.sort(np.concatenate(found)),
        makespan_picoseconds(actions, durations),
        bound,
    )


def _random(seed: int, exponent: float) -> Draw:
    generator = np.random.default_rng(seed)
    return lambda shape: generator.random(shape) ** exponent
