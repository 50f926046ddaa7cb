"""Earth constants, each with its source. SI units.

Missions name the set they use in `plan.json`, so that a number can be traced to its constants.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class ConstantsSet:
    """A named point-mass Earth: gravitational parameter (m³/s²) and equatorial radius (m)."""

    name: str
    mu_m3_s2: float
    earth_radius_m: float
    source: str

    def to_dict(self) -> dict[str, str | float]:
        return asdict(self)


EARTH: Final = ConstantsSet(
    name="earth_point_mass",
    mu_m3_s2=3.986004418e14,
    earth_radius_m=6378137.0,
    source=(
        "WGS 84 GM and semi-major axis (NIMA TR8350.2, 3rd ed., table 3.1); the radius is also what "
        "Li et al. 2025, table 3 implies: 6528137 m is a perigee height of 150 km"
    ),
)
"""WGS 84 point mass: no oblateness, no atmosphere, no Earth rotation."""
