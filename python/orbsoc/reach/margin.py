"""Whether an orbit is within reach, by how much, and how sure that is."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Margin:
    """How far inside the domain an orbit lies; positive is inside.

    `tilt_deg` is what is left of the furthest tilt at the orbit's azimuth and perigee height, `sma_km` what is left of
    the largest semi-major axis on its plane; each with the error it may have. NaN is unknown. `exact` says that the
    point was solved instead of interpolated. `inside_box`: whether its plane lies within the search box of the grid.
    """

    tilt_deg: float
    tilt_error_deg: float
    sma_km: float
    sma_error_km: float
    inside_box: bool
    exact: bool

    @property
    def verdict(self) -> str:
        """ "within reach", "beyond reach" or "too close to tell"."""
        parts = ((self.tilt_deg, self.tilt_error_deg), (self.sma_km, self.sma_error_km))
        if any(value < -error for value, error in parts):
            return "beyond reach"
        if all(value > error for value, error in parts):
            return "within reach"
        return "too close to tell"

    @property
    def words(self) -> str:
        """The margin in a sentence."""
        how = "solved" if self.exact else "interpolated"
        box = "" if self.inside_box else "; its plane lies outside the search box of the grid"
        if not self.exact and self.verdict == "too close to tell":
            box += "; ask again with exact=True"
        return (
            f"{self.verdict}: {self.tilt_deg:+.3f} degrees (± {self.tilt_error_deg:.3f}) inside the furthest tilt of"
            f" planes at its perigee height, {self.sma_km:+.1f} km (± {self.sma_error_km:.1f}) inside the largest"
            f" semi-major axis on its plane, {how}{box}"
        )
