"""What routed engines say of the clock of a platform's engine, in words."""

from __future__ import annotations

from dataclasses import dataclass

from hw_model.platform.platform import Platform
from hw_model.platform.shape_clock import RoutedShape, clock_law
from hw_model.vocabulary import Datapath


@dataclass(frozen=True, slots=True)
class ClockOfShape:
    """By the law of the engines that were routed: `gain` is the clock of a shape over that of the slowest, which devices' clocks are of,
    `residual` the law's largest relative error, `reached` whether shapes were routed on both sides."""

    slowest: RoutedShape
    gain: float
    residual: float
    reached: bool

    @property
    def words(self) -> str:
        """A line of a report."""
        beyond = "" if self.reached else "; beyond what was routed"
        return (
            f"clock of this shape {self.gain:.2f} times that of the slowest routed ({self.slowest.words}), which the device's is"
            f" of, by the law of routed engines (within {100 * self.residual:.1f} % of them{beyond}); not in the times"
        )


def clock_of_shape(platform: Platform, datapath: Datapath) -> ClockOfShape | None:
    """Of a platform's engine; None where its clock does not come from routed engines."""
    pl = platform.pl
    if pl.clock_mhz.tag != "scaled":
        return None
    shape = RoutedShape(
        datapath, pl.lanes.value, pl.clusters.value, compressed=pl.microcode_format.value == "compressed"
    )
    law = clock_law()
    return ClockOfShape(law.slowest, law.gain(shape), law.residual, law.reaches(shape))
