"""Results as bands: their values at the nominal parameters and at the corners of the assumed ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hw_model.platform.parameter import End
    from hw_model.platform.platform import Platform


@dataclass(frozen=True, slots=True)
class Band:
    """A result at the nominal parameters, and its ends over the bands of the assumed ones."""

    low: float
    nominal: float
    high: float


def band_of(values: Sequence[float]) -> Band:
    """The band of values at `corners_of` a platform."""
    return Band(min(values), values[0], max(values))


def corners_of(platform: Platform) -> list[Platform]:
    """The platform itself, then every combination of the ends of its three sets of bands, the slowest first.

    Every makespan is monotonic in every banded parameter, so its extremes are at corners. So are the ratio's against
    an all-PS baseline: it falls as the PS gets faster, rises as the fabric does, and comes closer to 1 as the
    generation, which is the same in both, takes longer.
    """
    ends: tuple[End, End] = ("slow", "fast")
    return [
        platform,
        *(platform.corner(ps, fabric, build) for ps in ends for fabric in ends for build in ends),
    ]
