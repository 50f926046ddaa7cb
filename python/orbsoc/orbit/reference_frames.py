"""Rotations between the inertial axes that messages and catalogues use: EME2000, GCRF and TEME at an instant.

GCRF and EME2000 differ by the frame bias (23 milliarcseconds). TEME, the axes of two-line elements, are the true equator
and the mean equinox of date. Sources: IERS Conventions 2010, section 5; Vallado et al., AIAA 2006-6753, appendix C, for TEME.
The Earth's precession and nutation are IAU 2006/2000A of ERFA, which is imported when first needed.
"""

from __future__ import annotations

import warnings
from datetime import UTC, datetime
from typing import Final, Literal

import numpy as np

from .array import Array

FrameName = Literal["EME2000", "GCRF", "TEME"]
FRAMES: Final[tuple[FrameName, ...]] = ("EME2000", "GCRF", "TEME")


def frame_rotation(
    source: FrameName, source_utc: datetime, wanted: FrameName, wanted_utc: datetime | None = None
) -> Array:
    """Matrix (3, 3) that takes components in `source` to those in `wanted`.

    The instants matter for TEME alone: its axes are frozen at them; `wanted_utc` is `source_utc` where it is not given.
    """
    if source == wanted and (source != "TEME" or wanted_utc in (None, source_utc)):
        return np.eye(3)
    to_gcrf = _from_gcrf(source, source_utc).T
    return np.asarray(_from_gcrf(wanted, wanted_utc or source_utc) @ to_gcrf)


def _from_gcrf(name: FrameName, utc: datetime) -> Array:
    """Matrix (3, 3) from GCRF to a frame."""
    if name == "GCRF":
        return np.eye(3)
    import erfa

    if name == "EME2000":
        bias, _, _ = erfa.bp06(erfa.DJ00, 0.0)
        return np.asarray(bias, np.float64)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", erfa.ErfaWarning)  # of years whose leap seconds are not known yet
        day, part = _julian(utc)
        tt = erfa.taitt(*erfa.utctai(day, part))
    # UT1 is taken for UTC: both sidereal times move alike with it, and their difference alone counts.
    equinox = erfa.gmst82(day, part) - erfa.gst06a(day, part, *tt)
    return np.asarray(erfa.rz(-equinox, erfa.pnm06a(*tt)), np.float64)


def _julian(utc: datetime) -> tuple[float, float]:
    """Two-part Julian date of ERFA, UTC."""
    import erfa

    at = utc.astimezone(UTC)
    seconds = at.second + 1e-6 * at.microsecond
    day, part = erfa.dtf2d("UTC", at.year, at.month, at.day, at.hour, at.minute, seconds)
    return float(day), float(part)


def below_deg(frame: FrameName, utc: datetime, after_s: Array, positions_m: Array) -> tuple[Array, Array]:
    """Geocentric latitude and longitude (K,), degrees, of the points on the Earth below positions (K, 3) in a frame.

    `after_s` (K,) count from `utc`. UT1 is taken for UTC, which shifts the longitude by less than 0.004°.
    """
    import erfa

    teme = np.asarray(positions_m) @ frame_rotation(frame, utc, "TEME").T
    day, part = _julian(utc)
    turned = np.arctan2(teme[:, 1], teme[:, 0]) - erfa.gmst82(day, part + np.asarray(after_s) / 86400.0)
    latitude = np.arctan2(teme[:, 2], np.hypot(teme[:, 0], teme[:, 1]))
    return np.rad2deg(latitude), (np.rad2deg(turned) + 180.0) % 360.0 - 180.0
