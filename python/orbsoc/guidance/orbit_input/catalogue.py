"""States from what catalogues and operators hand out: two-line elements, OMM and OEM files.

Sources: CCSDS 502.0-B-3 for OMM and OEM, both as key = value; SGP4 by the package `sgp4`, imported when first needed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import KroghInterpolator

from orbsoc.orbit.array import Array
from orbsoc.orbit.reference_frames import FRAMES, FrameName

if TYPE_CHECKING:
    from sgp4.api import Satrec

NEAREST = 6
"""States of an ephemeris that an interpolation takes: a Hermite polynomial of degree 11 in position and velocity."""
SAME_AXES = {"J2000": "EME2000", "ICRF": "GCRF"}
"""Names that messages use for frames of ours; ICRF and GCRF have the same axes."""


@dataclass(frozen=True, slots=True)
class DatedState:
    """A state (6,), SI, at an instant in a named frame about the Earth."""

    vector: Array
    epoch: datetime
    frame: FrameName


def parse_utc(text: str) -> datetime:
    """An instant of ISO 8601, UTC unless it names an offset. Raises ValueError."""
    found = datetime.fromisoformat(text)
    return found.astimezone(UTC) if found.tzinfo else found.replace(tzinfo=UTC)


def from_tle(lines: tuple[str, str]) -> DatedState:
    """The osculating state of SGP4 at the epoch of two-line elements, TEME. Raises ValueError."""
    from sgp4.api import WGS72, Satrec

    for number, line in enumerate(lines, 1):
        if len(line.rstrip()) != 69 or not line.startswith(f"{number} "):
            raise ValueError(f"line {number} must have 69 characters and begin with {number}")
        if line[68] != str(_checksum(line)):
            raise ValueError(f"line {number} ends with {line[68]}, but its checksum is {_checksum(line)}")
    return _at_epoch(Satrec.twoline2rv(*lines, WGS72))


def from_omm(path: str | PathLike[str]) -> DatedState:
    """The osculating state of SGP4 at the epoch of an Orbit Mean-elements Message, TEME. Raises ValueError, OSError."""
    from sgp4 import omm
    from sgp4.api import Satrec

    fields = dict(_pairs(Path(path).read_text().splitlines()))
    satellite = Satrec()
    defaults = {
        "EPHEMERIS_TYPE": "0",
        "CLASSIFICATION_TYPE": "U",
        "OBJECT_ID": "",
        "NORAD_CAT_ID": "0",
    } | dict.fromkeys(("ELEMENT_SET_NO", "REV_AT_EPOCH", "BSTAR", "MEAN_MOTION_DOT", "MEAN_MOTION_DDOT"), "0")
    try:
        omm.initialize(satellite, {**defaults, **fields})
    except KeyError as error:
        raise ValueError(f"{path}: no {error.args[0]}; an OMM as key = value is needed") from error
    return _at_epoch(satellite)


def from_oem(path: str | PathLike[str], at: datetime) -> DatedState:
    """A state of an Orbit Ephemeris Message, interpolated at an instant inside its span. Raises ValueError, OSError."""
    spans = []
    for segment in _segments(Path(path).read_text().splitlines()):
        first, last = segment.times[0], segment.times[-1]
        spans.append(f"{first:%Y-%m-%dT%H:%M:%S.%f} to {last:%Y-%m-%dT%H:%M:%S.%f}")
        if first <= at <= last:
            return DatedState(segment.state_at(at), at, segment.frame)
    raise ValueError(f"{path} spans {', '.join(spans) or 'no states'}")


@dataclass(frozen=True, slots=True)
class _Segment:
    """States (K, 6), SI, at K instants."""

    frame: FrameName
    times: tuple[datetime, ...]
    states: Array

    def state_at(self, at: datetime) -> Array:
        seconds = np.array([(each - at).total_seconds() for each in self.times])
        first = max(0, min(int(np.searchsorted(seconds, 0.0)) - NEAREST // 2, seconds.size - NEAREST))
        near = slice(first, first + NEAREST)
        exact = np.flatnonzero(seconds[near] == 0.0)
        if exact.size:
            return np.array(self.states[near][exact[-1]])
        # Krogh's interpolant takes a node twice as value and slope; times are scaled so that both are of one size.
        scale = float(np.ptp(seconds[near])) or 1.0
        nodes = np.repeat(seconds[near] / scale, 2)
        rows = np.stack([self.states[near, :3], scale * self.states[near, 3:]], axis=1).reshape(-1, 3)
        curve = KroghInterpolator(nodes, rows)
        return np.concatenate([curve(0.0), curve.derivative(0.0) / scale])


def _segments(lines: list[str]) -> Iterator[_Segment]:
    meta: dict[str, str] = {}
    times: list[datetime] = []
    rows: list[list[float]] = []
    inside = covariance = False
    for line in [*(each.strip() for each in lines), "META_START"]:
        if line == "META_START":
            if times:
                yield _segment(meta, times, rows)
            meta, times, rows, inside = {}, [], [], True
        elif line == "META_STOP":
            inside = False
        elif line in ("COVARIANCE_START", "COVARIANCE_STOP"):
            covariance = line.endswith("START")
        elif inside:
            meta |= dict(_pairs([line]))
        elif meta and line and not covariance and not line.startswith("COMMENT"):
            stamp, *numbers = line.split()
            times.append(parse_utc(stamp))
            rows.append([1e3 * float(each) for each in numbers[:6]])


def _segment(meta: dict[str, str], times: list[datetime], rows: list[list[float]]) -> _Segment:
    for key, allowed in (("CENTER_NAME", "EARTH"), ("TIME_SYSTEM", "UTC")):
        if meta.get(key, "").upper() != allowed:
            raise ValueError(f"{key} = {meta.get(key)}: must be {allowed}")
    name = meta.get("REF_FRAME", "")
    frame = next((each for each in FRAMES if each == SAME_AXES.get(name, name)), None)
    if frame is None:
        raise ValueError(f"REF_FRAME = {name}: must be one of {', '.join((*FRAMES, *SAME_AXES))}")
    states = np.array(rows, np.float64)
    if states.shape != (len(times), 6):
        raise ValueError("a line of the ephemeris must have a time, a position and a velocity")
    return _Segment(frame, tuple(times), states)


def _at_epoch(satellite: Satrec) -> DatedState:
    code, position, velocity = satellite.sgp4(satellite.jdsatepoch, satellite.jdsatepochF)
    if code:
        from sgp4.api import SGP4_ERRORS

        raise ValueError(f"SGP4: {SGP4_ERRORS[code]}")
    midnight = datetime(2000, 1, 1, tzinfo=UTC) + timedelta(days=satellite.jdsatepoch - 2451544.5)
    epoch = midnight + timedelta(days=satellite.jdsatepochF)
    return DatedState(1e3 * np.array([*position, *velocity]), epoch, "TEME")


def _pairs(lines: list[str]) -> Iterator[tuple[str, str]]:
    for line in lines:
        key, equals, value = line.partition("=")
        if equals and not line.startswith("COMMENT"):
            yield key.strip(), value.split("[")[0].strip()


def _checksum(line: str) -> int:
    return sum(int(each) if each.isdigit() else each == "-" for each in line[:68]) % 10
