"""A target on any closed orbit and a chaser beside it, in the keys of a mission of relative motion about it.

Axes of the file: x along the target's velocity, y against its angular momentum, z to the nadir.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import degrees, radians
from typing import Any, Literal

import numpy as np
from pydantic import Field

from orbsoc.guidance.scenario_file import Complaint, Table, checked
from orbsoc.orbit import EARTH, Elements, state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LVLH, ClohessyWiltshire

from .beside import dated_keys, named_orbit, polar_elements, start_beside
from .catalogue import parse_utc
from .table import Orbit

LONGEST_M = 5e4
"""Up to which the linear model is taken, as in the paper."""


class Target(Table):
    """The target's orbit: its mean motion, or the height of its semi-major axis; its eccentricity and where it is.

    Any form of the orbit table is turned to these keys when it is read.
    """

    mean_motion_rad_s: float | None = Field(default=None, ge=1e-6, le=1.3e-3)
    altitude_km: float | None = Field(default=None, ge=100.0, le=4e5)
    eccentricity: float = Field(default=0.0, ge=0.0, le=0.8)
    true_anomaly_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    motion: Literal["elliptic", "circular"] | None = Field(
        default=None, description="the linear model about an eccentric target; elliptic"
    )
    inclination_deg: float = Field(
        default=45.0, ge=0.0, le=180.0, description="of the flights with J2 and drag"
    )
    raan_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    argp_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    epoch_utc: str | None = Field(default=None, description="ISO 8601; of time 0")
    frame: Literal["TEME"] | None = Field(default=None, description="of a date; any other is turned to it")
    source: str | None = Field(default=None, description="written when a TLE or a file is read")

    @property
    def elliptic(self) -> bool:
        """Whether the model is that of an eccentric orbit."""
        return self.eccentricity > 0.0 and self.motion != "circular"

    @property
    def elements(self) -> Elements:
        """At time 0."""
        angles = map(radians, (self.inclination_deg, self.raan_deg, self.argp_deg, self.true_anomaly_deg))
        sma_m = float(np.cbrt(EARTH.mu_m3_s2 / self.mean_motion() ** 2))
        return Elements(sma_m, self.eccentricity, *angles)

    def mean_motion(self) -> float:
        """rad/s."""
        if self.mean_motion_rad_s is not None:
            return self.mean_motion_rad_s
        assert self.altitude_km is not None  # the scenario checks it
        return ClohessyWiltshire.at_altitude(1e3 * self.altitude_km).mean_motion_rad_s


class Start(Table):
    """Position and velocity at the first impulse.

    Also `position_m`, `velocity_m_s` and `frame = "RTN"` or `"LVLH"`, or the chaser's own orbit at the target's date.
    """

    x_m: float = Field(ge=-LONGEST_M, le=LONGEST_M)
    z_m: float = Field(default=0.0, ge=-LONGEST_M, le=LONGEST_M)
    y_m: float = Field(default=0.0, ge=-LONGEST_M, le=LONGEST_M)
    vx_m_s: float = Field(default=0.0, ge=-100.0, le=100.0)
    vy_m_s: float = Field(default=0.0, ge=-100.0, le=100.0)
    vz_m_s: float = Field(default=0.0, ge=-100.0, le=100.0)

    def state(self) -> Array:
        """(6,), frame (R, T, N)."""
        position = LVLH.T @ np.array([self.x_m, self.y_m, self.z_m])
        velocity = LVLH.T @ np.array([self.vx_m_s, self.vy_m_s, self.vz_m_s])
        return np.concatenate([position, velocity])


def in_own_keys(given: Mapping[str, Any]) -> dict[str, Any]:
    """The document with target and start in this mission's keys, whatever form of the orbit table they take."""
    found = dict(given)
    if not isinstance(table := found.get("target"), Mapping):
        return found
    if (orbit := _named(table)) is not None:
        at = polar_elements("target", orbit)
        circular = at.ecc == 0.0
        found["target"] = {
            "mean_motion_rad_s": float(np.sqrt(EARTH.mu_m3_s2 / at.sma_m**3)),
            "eccentricity": at.ecc,
            "inclination_deg": degrees(at.inc_rad),
            "raan_deg": degrees(at.raan_rad),
            "argp_deg": degrees(at.true_anomaly_rad if circular else at.argp_rad),
            "true_anomaly_deg": 0.0 if circular else degrees(at.true_anomaly_rad),
            **dated_keys(orbit),
            **{key: table[key] for key in ("motion",) if key in table},
        }
    start = found.get("start")
    if not isinstance(start, Mapping) or not ({*start} - {*Start.model_fields}):
        return found
    target = checked(Target, found["target"], source="target")
    if (target.mean_motion_rad_s is None) is (target.altitude_km is None):
        return found  # the scenario refuses it
    state = np.concatenate(state_from_elements(target.elements))
    date = parse_utc(target.epoch_utc) if target.epoch_utc else None
    beside = start_beside("start", start, tuple(Start.model_fields), state, date)
    if beside is not None:
        keys = ("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s")
        numbers = (beside.reshape(2, 3) @ LVLH.T).reshape(-1).tolist()
        found["start"] = dict(zip(keys, numbers, strict=True))
    return found


def _named(table: Mapping[str, Any]) -> Orbit | None:
    rest = {key: value for key, value in table.items() if key != "motion"}
    return named_orbit("target", rest, tuple(Target.model_fields))


def target_complaints(target: Target) -> Iterator[Complaint]:
    """What contradicts physics or itself in a target's keys."""
    if target.mean_motion_rad_s is None and target.altitude_km is None:
        yield Complaint("target.mean_motion_rad_s", "", "is missing; give it or target.altitude_km")
        return
    if target.mean_motion_rad_s is not None and target.altitude_km is not None:
        allowed = "target.mean_motion_rad_s is given too; give one of them"
        yield Complaint("target.altitude_km", f"{target.altitude_km:g}", allowed)
        return
    sma_m = (EARTH.mu_m3_s2 / target.mean_motion() ** 2) ** (1 / 3)
    most = 1.0 - EARTH.earth_radius_m / sma_m
    if target.eccentricity >= most:
        allowed = f"the perigee is in the ground; must be below {most:.4f}"
        yield Complaint("target.eccentricity", f"{target.eccentricity:g}", allowed)
    if target.motion is not None and not target.eccentricity:
        yield Complaint("target.motion", repr(target.motion), "a circular target has one model; leave it out")
    if target.true_anomaly_deg and not target.eccentricity:
        allowed = "a circular target has none; leave it out"
        yield Complaint("target.true_anomaly_deg", f"{target.true_anomaly_deg:g}", allowed)
