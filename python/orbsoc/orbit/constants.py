"""Constants of central bodies, each with its source. SI units.

Missions name the set they use in `plan.json`, so that a number can be traced to its constants.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class ConstantsSet:
    """A named body: gravitational parameter (m³/s²), equatorial radius (m), second zonal harmonic, and its CCSDS name."""

    name: str
    mu_m3_s2: float
    earth_radius_m: float
    source: str
    j2: float = 0.0
    center: str = "EARTH"

    def to_dict(self) -> dict[str, str | float]:
        return asdict(self)


EARTH_J2: Final = 1.08262668e-3
"""Second zonal harmonic, unnormalised: −√5 C̄₂₀ of EGM96 (NASA/TP-1998-206861)."""


EARTH: Final = ConstantsSet(
    name="earth_point_mass",
    mu_m3_s2=3.986004418e14,
    earth_radius_m=6378137.0,
    source=(
        "WGS 84 GM and semi-major axis (NIMA TR8350.2, 3rd ed., table 3.1); the radius is also what "
        "Li et al. 2025, table 3 implies: 6528137 m is a perigee height of 150 km"
    ),
    j2=EARTH_J2,
)
"""WGS 84 point mass: no oblateness, no atmosphere, no Earth rotation."""
MOON: Final = ConstantsSet(
    name="moon",
    mu_m3_s2=4.902800118e12,
    earth_radius_m=1738.0e3,
    source="GM of DE440 (Park et al., 2021); radius and J2 of GRAIL's GL0660B (Konopliv et al., 2013)",
    j2=2.0321e-4,
    center="MOON",
)
MARS: Final = ConstantsSet(
    name="mars",
    mu_m3_s2=4.2828375e13,
    earth_radius_m=3396.0e3,
    source="GM, radius and J2 of MRO120D (Konopliv, Park & Folkner, Icarus 274, 2016)",
    j2=1.9566e-3,
    center="MARS",
)
