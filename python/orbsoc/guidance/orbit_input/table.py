"""The table of a scenario file that names an orbit and a place on it."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PrivateAttr, Strict, model_validator

from orbsoc.guidance.scenario_file import Table, refused
from orbsoc.guidance.vehicle import Vector
from orbsoc.orbit import EARTH, ConstantsSet, Elements, rotate_state, state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.reference_frames import FRAMES, FrameName, frame_rotation

from .catalogue import DatedState, from_oem, from_omm, from_tle, parse_utc
from .elements import ELEMENTS, elements_of, semi_major_axis_m, shape

STATE = ("position_m", "velocity_m_s")
FILES = ("tle", "omm", "oem")
FORMS = "position_m and velocity_m_s, or elements, or tle, omm, or oem with epoch_utc"
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]


class Orbit(Table):
    """A state; or two numbers of the shape, three angles and an anomaly; or a TLE, an OMM, or an instant of an OEM.

    What a catalogue or a file gives is turned to a state with a date when it is read; the scenario then holds that alone.
    """

    position_m: Vector | None = None
    velocity_m_s: Vector | None = None
    sma_km: float | None = Field(default=None, description="negative on a hyperbola")
    ecc: float | None = Field(default=None, ge=0.0)
    perigee_height_km: float | None = Field(default=None, gt=0.0, le=1.0e5)
    apogee_height_km: float | None = Field(default=None, gt=0.0, le=1.0e7)
    c3_km2_s2: float | None = Field(default=None, description="2 × energy: v∞² of an escape")
    v_infinity_m_s: float | None = Field(default=None, gt=0.0, le=5.0e4)
    mean_motion_rad_s: float | None = Field(default=None, gt=0.0, le=1.3e-3)
    period_s: float | None = Field(default=None, gt=0.0, le=1.0e8)
    inc_deg: float | None = Field(default=None, ge=0.0, le=180.0)
    raan_deg: Degrees | None = None
    argp_deg: Degrees | None = None
    true_anomaly_deg: float | None = None
    mean_anomaly_deg: float | None = None
    eccentric_anomaly_deg: float | None = Field(default=None, description="of a hyperbola the hyperbolic one")
    latitude_argument_deg: float | None = Field(default=None, description="from the node: ω + ν")
    tle: Annotated[tuple[str, str], Strict(False)] | None = Field(
        default=None, description="two lines; SGP4 gives the osculating state at their epoch"
    )
    omm: str | None = Field(default=None, description="file, key = value; as tle")
    oem: str | None = Field(default=None, description="file, key = value; interpolated at epoch_utc")
    epoch_utc: str | None = Field(default=None, description="ISO 8601; of a TLE or an OMM it is theirs")
    frame: FrameName | None = Field(
        default=None, description="of what stands here; EME2000 where there is a date"
    )
    source: str | None = Field(default=None, description="written when a TLE or a file is read")

    @model_validator(mode="before")
    @classmethod
    def _read(cls, given: Any) -> Any:
        return as_state(given) if isinstance(given, dict) else given

    _about: ConstantsSet = PrivateAttr(default=EARTH)
    """The body that is orbited, told by the scenario that has the table."""

    @property
    def by_elements(self) -> bool:
        """Whether the table gives elements, which are in ECI."""
        return self.position_m is None and self.velocity_m_s is None

    @property
    def dated(self) -> bool:
        return self.epoch_utc is not None

    @property
    def epoch(self) -> datetime | None:
        """The instant of the state, UTC."""
        return None if self.epoch_utc is None else parse_utc(self.epoch_utc)

    @property
    def axes_name(self) -> FrameName | None:
        """The frame of state and elements; None where the scenario names none."""
        return self.frame or ("EME2000" if self.dated else None)

    def vector(self) -> Array:
        """[r_m, v_m_s] (6,): in the frame of the table, in ECI if given by elements, else in the scenario's axes."""
        if self.position_m is not None and self.velocity_m_s is not None:
            return np.array([*self.position_m, *self.velocity_m_s])
        return np.concatenate(state_from_elements(self.elements()))

    def vector_in(self, frame: FrameName | None, at: datetime | None) -> Array:
        """The state turned to a frame, TEME at an instant; as it is where one of the two frames is not named."""
        own = self.axes_name
        if own is None or frame is None:
            return self.vector()
        here = self.epoch or at or parse_utc("2000-01-01T12:00:00")
        return rotate_state(frame_rotation(own, here, frame, at or here), self.vector())

    def elements(self) -> Elements:
        """Osculating elements, of a table that gives them."""
        return elements_of(dict(self), self._about)

    def semi_major_axis_m(self) -> float | None:
        """From the key that gives the energy, if one does."""
        return semi_major_axis_m(dict(self), self._about)

    def shape(self) -> tuple[float, float]:
        """Semi-major axis (m) and eccentricity from the two keys that are given."""
        return shape(dict(self), self._about)


def as_state(given: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a table with what a TLE or a file says in its place; a date as text. Refuses what cannot be read."""
    keys = dict(given)
    if isinstance(keys.get("epoch_utc"), datetime):
        keys["epoch_utc"] = keys["epoch_utc"].isoformat()
    epoch = keys.get("epoch_utc")
    if isinstance(epoch, str):
        try:
            parse_utc(epoch)
        except ValueError:
            words = "must be a date and time, as 2026-03-01T12:00:00Z"
            raise refused(".epoch_utc", repr(epoch), words) from None
    named = [key for key in FILES if keys.get(key) is not None]
    if not named:
        return keys
    key, value = named[0], keys[named[0]]
    for each in (*STATE, *ELEMENTS, *named[1:]):
        if keys.get(each) is not None:
            words = f"{key} gives the orbit already; must be one of the two"
            raise refused(f".{each}", str(keys[each]), words)
    if key != "oem" and epoch is not None:
        raise refused(".epoch_utc", repr(epoch), f"{key} has an epoch of its own; leave this out")
    if key == "oem" and not isinstance(epoch, str):
        raise refused(".epoch_utc", "nothing", "is missing, and oem needs an instant inside its span")
    frame = keys.get("frame") or "EME2000"
    if frame not in FRAMES:
        return keys  # the field refuses it
    try:
        found = _read_from(key, value, epoch)
    except (ValueError, OSError, TypeError) as error:
        shown = "two lines" if key == "tle" else repr(value)
        raise refused(f".{key}", shown, f"cannot be read: {error}") from error
    state = rotate_state(frame_rotation(found.frame, found.epoch, frame), found.vector)
    for each in FILES:
        keys.pop(each, None)
    what = {"tle": "a TLE, by SGP4", "omm": f"{value}, by SGP4", "oem": f"{value}, interpolated"}[key]
    return {
        **keys,
        "position_m": tuple(state[:3].tolist()),
        "velocity_m_s": tuple(state[3:].tolist()),
        "epoch_utc": found.epoch.isoformat(),
        "frame": frame,
        "source": what,
    }


def _read_from(key: str, value: Any, epoch: str | None) -> DatedState:
    if key == "tle":
        first, second = value
        return from_tle((first, second))
    return from_omm(value) if key == "omm" else from_oem(value, parse_utc(str(epoch)))
