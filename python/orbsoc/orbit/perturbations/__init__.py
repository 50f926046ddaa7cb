"""Coasting about the Earth with oblateness and drag, many states at once, with transition matrices."""

from ..constants import EARTH_J2
from .atmosphere import density_kg_m3
from .coast import coast, coast_with_transitions
from .compiled import SteeredBurn, fast_burn, fast_coast, fast_coast_with_transitions
from .forces import J2, Drag, Force, PointMass

__all__ = [
    "EARTH_J2",
    "J2",
    "Drag",
    "Force",
    "PointMass",
    "SteeredBurn",
    "coast",
    "coast_with_transitions",
    "density_kg_m3",
    "fast_burn",
    "fast_coast",
    "fast_coast_with_transitions",
]
