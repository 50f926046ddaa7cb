"""What a scenario file of this mission may say, and the physics it must not contradict.

Axes are the paper's: x along the target's motion, y against its angular momentum, z to the nadir; the ellipse's own are
x and z along its semi-axes. Source of the quantities: the paper, section 3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from os import PathLike
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, Strict, model_validator

from orbsoc.guidance.in_flight import BurnCycle
from orbsoc.guidance.orbit_input.beside import (
    LeftOut,
    circle_keys,
    circle_words,
    named_axes,
    named_orbit,
    read_table,
)
from orbsoc.guidance.relative_flight import BALLISTIC_M2_KG
from orbsoc.guidance.scenario_file import BaseScenario, Complaint, Table, load, refuse
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.guidance.vehicle import Vector
from orbsoc.orbit.array import Array
from orbsoc.orbit.constants import EARTH
from orbsoc.orbit.relative import LVLH, ClohessyWiltshire

from .model.ellipse import Ellipse, ellipse_axes
from .model.flight import Flight
from .model.waypoints import counts_by_rule

WAYS = ("fewest", "adaptive", "equal")
MOST_PULSES = 400
FARTHEST = 0.01
"""Of the orbit's radius: farther away the linear motion is off by a percent of the distance."""


def _asked(value: Any) -> Any:
    """Refuse what is neither a way nor a number of pulses, in one sentence."""
    number = isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= MOST_PULSES
    if not (number or value in WAYS):
        allowed = f"must be {', '.join(map(repr, WAYS))} or a number of pulses, 1 to {MOST_PULSES}"
        refuse([Complaint("impulses", repr(value), allowed)])
    return value


Asked = Annotated[Literal["fewest", "adaptive", "equal"] | int, BeforeValidator(_asked)]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]


class Target(Table):
    """A circular orbit. Any form of the orbit table is turned to these keys, and a small eccentricity left out."""

    altitude_km: float = Field(ge=150.0, le=50_000.0, description="over the equatorial radius")
    inc_deg: float = Field(
        default=30.0,
        ge=0.0,
        le=180.0,
        description="of the orbit that the plan is flown again on; with J2 it matters",
    )
    raan_deg: Degrees = 0.0
    latitude_argument_deg: Degrees = Field(default=0.0, description="of the target at time 0")
    epoch_utc: str | None = Field(default=None, description="ISO 8601; of time 0")
    frame: Literal["TEME"] | None = Field(default=None, description="of a date; any other is turned to it")
    source: str | None = Field(default=None, description="written when a TLE or a file is read")
    ecc_left_out: LeftOut = None


class EllipseTable(Table):
    """The path about the target."""

    semi_axes_m: Annotated[tuple[float, float], Strict(False)] = Field(
        description="along the ellipse's x and z"
    )
    angles_deg: Annotated[tuple[Degrees, Degrees, Degrees], Strict(False)] = Field(
        description="θx, θy and θz of the ellipse's axes: Cy(θy) Cx(θx) Cz(θz) takes the target's axes to them"
    )
    start_deg: Degrees = Field(default=0.0, description="eccentric angle at time 0")
    period_s: float = Field(gt=0.0, le=1e6)
    direction: Literal[1, -1] = Field(default=1, description="-1 for the other way round")


class Start(Table):
    """State at time 0 in the ellipse's axes; or `position_m`, `velocity_m_s` and `frame = "RTN"` or `"LVLH"`."""

    x_m: float
    y_m: float
    z_m: float
    vx_m_s: float = 0.0
    vy_m_s: float = 0.0
    vz_m_s: float = 0.0


class Disturbance(Table):
    """A constant acceleration of the chaser relative to the target, which the plan counts on."""

    acceleration_m_s2: Vector = Field(description="along the target's x, y, z")
    stands_for_j2_and_drag: bool = Field(
        default=False,
        description="an estimate of what the check's J2 and drag do; otherwise a force of its own, which the check adds",
    )


class Truth(Table):
    """The air drag of the flight that checks the plan: drag area times coefficient over mass."""

    ballistic_target_m2_kg: float = Field(default=BALLISTIC_M2_KG[0], ge=0.0, le=1.0)
    ballistic_chaser_m2_kg: float = Field(default=BALLISTIC_M2_KG[1], ge=0.0, le=1.0)
    excess_share: float = Field(
        default=0.0,
        ge=0.0,
        le=1.0,
        description="of the tolerance, that J2, drag and curvature may add to it; with 0 the plan leaves them room",
    )


class Scenario(BaseScenario):
    """One revolution of a fly-around: the path, how near to stay, and how many pulses."""

    mission: Literal["fly_around"]
    impulses: Asked = Field(description='"fewest", "adaptive", "equal" or a number')
    tolerance_m: float = Field(gt=0.0, description="largest distance from the path")
    front: tuple[Annotated[int, Field(ge=1, le=MOST_PULSES)], ...] = Field(
        default=(), strict=False, description="numbers of pulses to price beside the plan's"
    )
    target: Target
    ellipse: EllipseTable
    start: Start | None = None
    disturbance: Disturbance | None = None
    uncertainty: Uncertainty | None = None
    guidance: BurnCycle = BurnCycle()
    truth: Truth = Truth()

    @model_validator(mode="before")
    @classmethod
    def _orbit(cls, given: Any) -> Any:
        return _in_own_keys(given) if isinstance(given, dict) else given

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(physical_complaints(self))
        return self

    @property
    def assumptions(self) -> list[str]:
        """What holds though the file says otherwise, in words."""
        return circle_words(self.target.altitude_km, self.target.ecc_left_out)

    @property
    def allowed_m(self) -> float:
        """How far the flight of the check may stray."""
        return self.tolerance_m * (1.0 + self.truth.excess_share)

    @property
    def duration_s(self) -> float:
        """One revolution of the ellipse."""
        return self.ellipse.period_s

    @property
    def motion(self) -> ClohessyWiltshire:
        return ClohessyWiltshire.at_altitude(1e3 * self.target.altitude_km)

    @property
    def flight(self) -> Flight:
        """The path and the disturbance in the frame (R, T, N)."""
        table = self.ellipse
        path = Ellipse.of(
            table.semi_axes_m,
            np.deg2rad(table.angles_deg),
            float(np.deg2rad(table.start_deg)),
            table.period_s,
            table.direction,
            self.motion.mean_motion_rad_s,
        )
        pushed = np.zeros(3) if self.disturbance is None else np.array(self.disturbance.acceleration_m_s2)
        return Flight(path, LVLH.T @ pushed)

    @property
    def start_state(self) -> Array:
        """State (6,) at time 0, frame (R, T, N): at rest on the ellipse unless `start` says otherwise."""
        path = self.flight.ellipse
        if self.start is None:
            return np.concatenate([path.position(0.0), np.zeros(3)])
        s = self.start
        place, speed = np.array([s.x_m, s.y_m, s.z_m]), np.array([s.vx_m_s, s.vy_m_s, s.vz_m_s])
        return np.concatenate([path.frame.T @ place, path.frame.T @ speed])

    def with_start(self) -> Scenario:
        """The same scenario with its start written out."""
        if self.start is not None:
            return self
        a, b = self.ellipse.semi_axes_m
        angle = float(np.deg2rad(self.ellipse.start_deg))
        return self.with_changes(
            start={"x_m": a * float(np.cos(angle)), "y_m": 0.0, "z_m": -b * float(np.sin(angle))}
        )


def load_scenario(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> Scenario:
    """Read and check a scenario file; `settings` override keys. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path, settings)


def _in_own_keys(given: Mapping[str, Any]) -> dict[str, Any]:
    """The document with the target in this mission's keys, whatever form of the orbit table it takes."""
    given = {**given, **_start_in_own_axes(given)}
    table = given.get("target")
    own = tuple(Target.model_fields)
    orbit = named_orbit("target", table, own) if isinstance(table, Mapping) else None
    if orbit is None:
        return dict(given)
    return {**given, "target": circle_keys("target", orbit)}


def _start_in_own_axes(given: Mapping[str, Any]) -> dict[str, Any]:
    """`[start]` in the ellipse's axes, where it is given in RTN or LVLH."""
    start, table = given.get("start"), given.get("ellipse")
    if not isinstance(start, Mapping) or not isinstance(table, Mapping) or start.get("frame") is None:
        return {}
    beside = named_axes("start", start)
    angles = read_table("ellipse", EllipseTable, table).angles_deg
    place, speed = beside.reshape(2, 3) @ (ellipse_axes(np.deg2rad(angles)) @ LVLH).T
    keys = ("x_m", "y_m", "z_m", "vx_m_s", "vy_m_s", "vz_m_s")
    return {"start": dict(zip(keys, (*place.tolist(), *speed.tolist()), strict=True))}


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics, most basic first."""
    table = scenario.ellipse
    farthest = FARTHEST * (EARTH.earth_radius_m + 1e3 * scenario.target.altitude_km)
    for k, axis in enumerate(table.semi_axes_m):
        if not 0.0 < axis <= farthest:
            allowed = f"must be above 0 and at most {farthest:.0f}, a hundredth of the orbit's radius"
            yield Complaint(f"ellipse.semi_axes_m.{k}", f"{axis:g}", allowed)
            return
    shorter = min(table.semi_axes_m)
    if scenario.tolerance_m >= shorter:
        allowed = f"must be below the shorter semi-axis, {shorter:g}: the tube would hold the target"
        yield Complaint("tolerance_m", f"{scenario.tolerance_m:g}", allowed)
        return
    about = max(counts_by_rule(scenario.flight, scenario.duration_s, scenario.tolerance_m))
    if about > MOST_PULSES and not isinstance(scenario.impulses, int):
        least = scenario.tolerance_m * (about / MOST_PULSES) ** 2
        allowed = f"takes about {about:.0f} pulses, and at most {MOST_PULSES} are planned; must be at least {least:.3g}"
        yield Complaint("tolerance_m", f"{scenario.tolerance_m:g}", allowed)
        return
    away = float(np.linalg.norm(scenario.start_state[:3] - scenario.flight.ellipse.position(0.0)))
    if away > scenario.tolerance_m:
        allowed = (
            f"the start is {away:.6g} m from the ellipse's point at time 0; must be within"
            f" tolerance_m = {scenario.tolerance_m:g}"
        )
        s = scenario.start
        yield Complaint("start", repr((s.x_m, s.y_m, s.z_m)) if s else "", allowed)
