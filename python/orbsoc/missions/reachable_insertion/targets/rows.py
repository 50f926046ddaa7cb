"""The names of terminal rows, as reports have them."""

from __future__ import annotations

import enum


class Row(enum.Enum):
    """What a terminal row holds; the value is its name in reports."""

    LEAN_TO_PERIGEE = "orbit plane, lean towards the perigee"
    LEAN_ACROSS = "orbit plane, lean across the perigee line"
    MOMENTUM = "size of the angular momentum"
    ECCENTRICITY = "eccentricity"
    PERIGEE_DIRECTION = "perigee direction"
    PERIGEE_RADIUS = "perigee radius"
    APOGEE_RADIUS = "apogee radius"
    ENERGY = "energy"
    INCLINATION = "inclination"
    RADIAL_VELOCITY = "radial velocity"
    """Of a circular orbit."""
    ATTITUDE_RATE = "attitude rate"
    """Of the way there, and no terminal row; as is"""
    COAST_ALTITUDE = "altitude of a coast"


PLANE_ROWS = (Row.LEAN_TO_PERIGEE, Row.LEAN_ACROSS)
TERMINAL_ROWS = (*PLANE_ROWS, Row.MOMENTUM, Row.ECCENTRICITY, Row.PERIGEE_DIRECTION)
"""The five rows l·H, q·H, n·H, l·L, q·L in their order."""
