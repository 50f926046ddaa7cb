"""Vehicles and launch sites by name, from presets.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from math import atan, degrees, radians, tan
from pathlib import Path
from typing import Any

from orbsoc.files.nearest import did_you_mean

from .scenario_file import refused

FLATTENING = 1.0 / 298.257223563
"""Of the Earth: WGS 84."""
FLOWS = ("isp_s", "mass_flow_kg_s")
"""Two ways to say the same: a scenario's own key takes the place of either."""


@cache
def presets(kind: str) -> Mapping[str, Mapping[str, Any]]:
    """All presets of a kind, "vehicle" or "site": the keys of the file by name."""
    text = (Path(__file__).parent / "presets.toml").read_text(encoding="utf-8")
    found: Mapping[str, Mapping[str, Any]] = tomllib.loads(text)[kind]
    return found


def vehicle_with_preset(given: Mapping[str, Any]) -> dict[str, Any]:
    """A vehicle's table with what its preset says; own keys win. For a validator: refuses an unknown name."""
    own = dict(given)
    base = dict(_preset("vehicle", "vehicle", own.pop("preset")))
    for key in ("what", "source", *(FLOWS if set(FLOWS) & set(own) else ())):
        base.pop(key, None)
    return base | own


def site_with_preset(given: Mapping[str, Any]) -> dict[str, Any]:
    """A launch site's table with what its preset says; own keys win. For a validator: refuses an unknown name.

    The geocentric latitude is that of the ellipsoid; the longitude is counted from Greenwich at the launch.
    """
    own = dict(given)
    site = _preset("site", "launch_site", own.pop("preset"))
    latitude = degrees(atan((1.0 - FLATTENING) ** 2 * tan(radians(site["latitude_deg"]))))
    return {"geocentric_latitude_deg": latitude, "inertial_longitude_deg": site["longitude_deg"]} | own


def _preset(kind: str, table: str, name: object) -> Mapping[str, Any]:
    known = presets(kind)
    if not isinstance(name, str) or name not in known:
        allowed = f"no such {kind}; allowed: {', '.join(known)}.{did_you_mean(name, known)}"
        raise refused(f"{table}.preset", repr(name), allowed)
    return known[name]
