"""Whether an orbit is within reach, by how much, and how sure that is."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from orbsoc.missions.reachable_domain.table import PointStatus

from .shortest import ShortestBurn


class Verdict(enum.StrEnum):
    """What is known of an orbit. Only WITHIN is a promise."""

    WITHIN = "within reach"
    BEYOND = "beyond reach"
    TOO_CLOSE = "too close to tell"
    PERIGEE_FREE = "undecided: within reach with its perigee in some direction, its own was not looked at"
    NOT_FLOWN = "undecided: a burn short enough was found, but its flight does not meet the orbit"
    NOT_FOUND = "undecided: no burn to this orbit was found, and nothing rules it out"
    OUTSIDE = PointStatus.OUTSIDE.value


@dataclass(frozen=True, slots=True)
class Margin:
    """How far inside the domain an orbit lies; positive is inside.

    `tilt_deg` is what is left of the furthest tilt at the orbit's azimuth and perigee height, `sma_km` what is left of
    the largest semi-major axis on its plane, both with the perigee where it suits best; each with the error it may have.
    NaN is unknown. `exact` says that the point was solved instead of interpolated. `circular` orbits have no perigee
    direction, `argp_in_table` says that the tables were made for the orbit's; of other orbits only `burn`, the shortest
    burn onto the very orbit, makes a promise. `inside_box`: whether its plane lies within the search box of the grid.
    """

    tilt_deg: float
    tilt_error_deg: float
    sma_km: float
    sma_error_km: float
    inside_box: bool
    exact: bool
    circular: bool
    argp_in_table: bool = False
    burn: ShortestBurn | None = None

    @property
    def verdict(self) -> Verdict:
        """What follows: the domain with the perigee free rules orbits out, and promises only circular ones."""
        parts = ((self.tilt_deg, self.tilt_error_deg), (self.sma_km, self.sma_error_km))
        if any(value < -error for value, error in parts):
            return Verdict.BEYOND
        if self.burn is not None:
            return self._by_burn(self.burn)
        if not self.exact and not self.inside_box:
            return Verdict.OUTSIDE
        if not all(value > error for value, error in parts):
            return Verdict.TOO_CLOSE
        return Verdict.WITHIN if self.circular or self.argp_in_table else Verdict.PERIGEE_FREE

    @staticmethod
    def _by_burn(burn: ShortestBurn) -> Verdict:
        if not burn.converged:
            return Verdict.NOT_FOUND
        if burn.left_s < 0.0:
            return Verdict.BEYOND
        return Verdict.WITHIN if burn.verified else Verdict.NOT_FLOWN

    @property
    def words(self) -> str:
        """The margin in a sentence."""
        verdict = self.verdict
        text = f"{verdict}: {self._parts()}, {'solved' if self.exact else 'interpolated'}"
        if self.burn is not None:
            text += f"; {self.burn.words}"
        if not self.inside_box:
            text += "; its plane lies outside the search box of the grid"
        if not self.exact and verdict not in (Verdict.WITHIN, Verdict.BEYOND):
            text += "; ask again with exact=True"
        return text

    def _parts(self) -> str:
        """What is left of the domain, its perigee where it suits best."""
        tilt = f"{self.tilt_deg:+.3f} degrees (± {self.tilt_error_deg:.3f}) inside the furthest tilt at its perigee height"
        if math.isnan(self.tilt_deg):
            tilt = "no furthest tilt known at its perigee height"
        largest = f"{self.sma_km:+.1f} km (± {self.sma_error_km:.1f}) inside the largest semi-major axis of its plane"
        if math.isnan(self.sma_km):
            largest = "no largest semi-major axis known of its plane"
        elif math.isinf(self.sma_km):
            largest = "no orbit reached on its plane"
        return f"{tilt}, {largest}"
