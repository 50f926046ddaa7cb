"""Whether an orbit, an ellipse above the ground, is within reach, by how much, and how sure that is."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass

from orbsoc.orbit import Elements

from ..continuation.table import PointStatus
from .shortest_burn import ShortestBurn

TURN = 2.0 * math.pi
HALF = math.pi * (1.0 + 1e-12)


class OrbitError(ValueError):
    """An orbit that cannot be asked about: the field, its value, what is allowed."""

    def __init__(self, field: str, value: float, allowed: str) -> None:
        self.field, self.value, self.allowed = field, value, allowed
        super().__init__(f"orbit.{field} = {value:.9g}: {allowed}")


def check_orbit(orbit: Elements) -> None:
    """Raises OrbitError for the first field that is wrong, most basic first."""
    for field in ("sma_m", "ecc", "inc_rad", "raan_rad", "argp_rad", "true_anomaly_rad"):
        value = float(getattr(orbit, field))
        if not math.isfinite(value):
            raise OrbitError(field, value, "must be a finite number")
    if orbit.sma_m <= 0.0:
        raise OrbitError("sma_m", orbit.sma_m, "must be an ellipse, above 0")
    if not 0.0 <= orbit.ecc < 1.0:
        raise OrbitError("ecc", orbit.ecc, "must be an ellipse, within 0…1, 1 not included")
    height_km = orbit.perigee_height_m() / 1e3
    if height_km <= 0.0:
        raise OrbitError(
            "sma_m", orbit.sma_m, f"its perigee lies {-height_km:.3f} km below the surface; must be above it"
        )
    if not 0.0 <= orbit.inc_rad <= HALF:
        raise OrbitError("inc_rad", orbit.inc_rad, "must be within 0…π (radians, not degrees)")
    for field in ("raan_rad", "argp_rad"):
        if abs(getattr(orbit, field)) > TURN * (1.0 + 1e-12):
            raise OrbitError(field, getattr(orbit, field), "must be within ±2π (radians, not degrees)")


class Verdict(enum.StrEnum):
    """What is known of an orbit. Only WITHIN is a promise, and only a burn that was flown onto the orbit makes it."""

    WITHIN = "within reach"
    BEYOND = "beyond reach"
    TOO_CLOSE = "too close to tell"
    NOT_RULED_OUT = "undecided: nothing in the tables rules it out"
    NOT_IN_TABLES = "not in the tables"
    NOT_FLOWN = "undecided: a burn short enough was found, but its flight breaks a condition"
    NOT_FOUND = "undecided: no burn to this orbit was found, and nothing rules it out"
    OUTSIDE = PointStatus.OUTSIDE.value


@dataclass(frozen=True, slots=True)
class Margin:
    """What is left of the domain beyond an orbit; a margin that is clearly negative rules the orbit out.

    `tilt_deg` is what is left of the largest tilt at the orbit's azimuth and perigee height, `sma_km` what is left of
    the largest semi-major axis on its plane, both with the perigee where it suits best; each with the error it may have.
    NaN is unknown; `sma_km` is +inf where the plane's largest orbit is a hyperbola, which is larger than any ellipse, and
    −inf where there is none. `over_floor_km` is the orbit's apogee over the least altitude that the burn may pass, inf
    without a bound. `inside_box`: whether its plane lies within the search box of the grid. `exact` says that the plane
    was solved instead of interpolated, and `burn` is the shortest burn then sought onto the very orbit, its perigee's
    height and direction included: the only thing that promises. `not_in_tables` says why the tables cannot be asked.
    """

    tilt_deg: float
    tilt_error_deg: float
    sma_km: float
    sma_error_km: float
    over_floor_km: float
    inside_box: bool
    exact: bool
    not_in_tables: str = ""
    burn: ShortestBurn | None = None

    @property
    def verdict(self) -> Verdict:
        """What follows: tables and solved planes only rule out; a flown burn promises."""
        parts = ((self.tilt_deg, self.tilt_error_deg), (self.sma_km, self.sma_error_km))
        if self.over_floor_km < 0.0 or any(value < -error for value, error in parts):
            return Verdict.BEYOND
        if self.burn is not None:
            return self._by_burn(self.burn)
        if not self.inside_box:
            return Verdict.OUTSIDE
        if self.not_in_tables:
            return Verdict.NOT_IN_TABLES
        return Verdict.NOT_RULED_OUT if all(value > error for value, error in parts) else Verdict.TOO_CLOSE

    @staticmethod
    def _by_burn(burn: ShortestBurn) -> Verdict:
        if not burn.converged:
            return Verdict.NOT_FOUND
        if burn.left_s < 0.0:
            return Verdict.BEYOND if burn.left_s < -burn.error_s else Verdict.TOO_CLOSE
        return Verdict.WITHIN if burn.verified else Verdict.NOT_FLOWN

    @property
    def words(self) -> str:
        """The margin in a sentence."""
        verdict = self.verdict
        if self.over_floor_km < 0.0:
            below = f"the whole orbit lies {-self.over_floor_km:.3f} km or more below the least altitude of the burn"
            return f"{verdict}: {below}, so cut-off would break the bound"
        text = f"{verdict}: {self._parts()}, {'solved' if self.exact else 'interpolated'}"
        if self.not_in_tables and not self.exact:
            text += f"; {self.not_in_tables}"
        if self.burn is not None:
            text += f"; {self.burn.words}"
        if not self.inside_box:
            text += "; its plane lies outside the search box of the grid"
        if not self.exact and verdict is not Verdict.BEYOND:
            text += "; only a burn that is flown decides: ask again with exact=True"
        return text

    def _parts(self) -> str:
        """What is left of the domain, its perigee where it suits best."""
        side = "inside" if self.tilt_deg >= 0.0 else "beyond"
        tilt = f"{abs(self.tilt_deg):.3f} degrees (± {self.tilt_error_deg:.3f}) {side} the furthest tilt at its perigee height"
        if math.isnan(self.tilt_deg):
            tilt = "no furthest tilt known at its perigee height"
        return f"{tilt}, {self._largest()}"

    def _largest(self) -> str:
        if math.isnan(self.sma_km):
            return "no largest semi-major axis known of its plane"
        if self.sma_km == -math.inf:
            return "no orbit reached on its plane"
        if self.sma_km == math.inf:
            sure = "hyperbolas" if self.sma_error_km == 0.0 else "perhaps hyperbolas"
            return f"{sure} reached on its plane, larger than any ellipse"
        error = "± unknown" if math.isinf(self.sma_error_km) else f"± {self.sma_error_km:.1f}"
        side = "inside" if self.sma_km >= 0.0 else "beyond"
        return f"{abs(self.sma_km):.1f} km ({error}) {side} the largest semi-major axis of its plane"
