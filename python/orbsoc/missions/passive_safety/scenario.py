"""What a scenario file of this mission may say, and the physics it must not contradict.

Axes of the file, as in Xu & Meng: x along the target's velocity, y against its angular momentum, z to the nadir.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi
from os import PathLike
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from orbsoc.guidance.in_flight import BurnCycle
from orbsoc.guidance.orbit_input.relative import LONGEST_M, Start, Target, in_own_keys, target_complaints
from orbsoc.guidance.scenario_file import BaseScenario, Complaint, Table, load, refuse
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.guidance.vehicle import Positive
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import LVLH

DEFAULT_SAMPLES = 36
DEFAULT_COUNT = {"equal": 4, "free": 2}


class Capture(Table):
    """Where the chaser is at the end, and with which velocity if an impulse at the end is to match one."""

    x_m: float = Field(ge=-LONGEST_M, le=LONGEST_M)
    z_m: float = Field(ge=-LONGEST_M, le=LONGEST_M)
    y_m: float = Field(default=0.0, ge=-LONGEST_M, le=LONGEST_M)
    vx_m_s: float | None = Field(default=None, ge=-100.0, le=100.0)
    vy_m_s: float | None = Field(default=None, ge=-100.0, le=100.0)
    vz_m_s: float | None = Field(default=None, ge=-100.0, le=100.0)

    def position(self) -> Array:
        """(3,), frame (R, T, N)."""
        return np.asarray(LVLH.T @ np.array([self.x_m, self.y_m, self.z_m]))

    def velocity(self) -> Array | None:
        """(3,), frame (R, T, N); components that are not given are 0. None where none is given."""
        given = (self.vx_m_s, self.vy_m_s, self.vz_m_s)
        if given == (None, None, None):
            return None
        return np.asarray(LVLH.T @ np.array([each or 0.0 for each in given]))


class ImpulseTimes(Table):
    """How many impulses there are, and when: equally spaced, the second one's time free, or as many as pay."""

    count: int | None = Field(default=None, ge=2, le=64, description="4 for equal, 2 for free timing")
    timing: Literal["equal", "free", "generated"] = "equal"


class Scenario(BaseScenario):
    """One approach that stays safe without engines: target, start, capture point, keep-out, timing, cost."""

    mission: Literal["passive_safety"]
    compare_with: str | None = Field(
        default=None,
        pattern="^row[1-8](_printed)?$",
        description="a row of the paper's tables and its constants",
    )
    target: Target
    start: Start
    capture: Capture
    capture_box_m: float = Field(default=0.0, ge=0.0, le=1e3, description="by axis, half a side")
    keep_out_m: float = Field(
        ge=0.0,
        le=LONGEST_M,
        description="half the height of the band along the V-bar that is kept out of; not a sphere",
    )
    duration_s: Positive = Field(le=1e6)
    impulses: ImpulseTimes = ImpulseTimes()
    condition: Literal["short", "beyond", "none"] = Field(
        description="of the first drift, from rest on the V-bar: it ends short of the target or passes beyond; none for any other start"
    )
    safety: Literal["cone", "samples"] = "cone"
    samples: int | None = Field(default=None, ge=8, le=1000, description="an orbit; 36")
    interruption_orbits: Literal[0, 1, 2] = 0
    cost: Literal["norms", "absolutes"] = "norms"
    uncertainty: Uncertainty | None = None
    guidance: BurnCycle = BurnCycle()

    @model_validator(mode="before")
    @classmethod
    def _orbits(cls, given: Any) -> Any:
        return in_own_keys(given) if isinstance(given, dict) else given

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(physical_complaints(self))
        return self


def load_scenario(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> Scenario:
    """Read and check a scenario file; `settings` override keys. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path, settings)


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics or itself, most basic first."""
    yield from _target_complaints(scenario)
    yield from _keep_out_complaints(scenario)
    yield from _condition_complaints(scenario)
    yield from _timing_complaints(scenario)
    yield from _ignored_complaints(scenario)


def _target_complaints(scenario: Scenario) -> Iterator[Complaint]:
    target = scenario.target
    yield from target_complaints(target)
    if target.elliptic and scenario.safety == "cone":
        allowed = (
            "for all time only about a circular target, for its cone is of Clohessy–Wiltshire;"
            f" with target.eccentricity = {target.eccentricity:g} must be 'samples'"
        )
        yield Complaint("safety", "'cone'", allowed)


def _keep_out_complaints(scenario: Scenario) -> Iterator[Complaint]:
    keep_out_m = scenario.keep_out_m
    if keep_out_m == 0.0:
        if scenario.condition != "none":
            yield Complaint("condition", repr(scenario.condition), "without keep_out_m must be 'none'")
        return
    away = float(np.linalg.norm(scenario.start.state()[:3]))
    if away <= keep_out_m:
        value = f"{scenario.start.x_m:g}"
        yield Complaint(
            "start.x_m", value, f"{away:.6g} m from the target, inside keep_out_m = {keep_out_m:g}"
        )
    if abs(scenario.capture.z_m) < keep_out_m:
        value = f"{scenario.capture.z_m:g}"
        allowed = (
            f"the keep-out is a band along the V-bar: must be at least {keep_out_m:g} below the target, or above it;"
            " for a keep-out sphere and a point on the V-bar take mission = 'approach'"
        )
        yield Complaint("capture.z_m", value, allowed)


def _condition_complaints(scenario: Scenario) -> Iterator[Complaint]:
    start = scenario.start
    if scenario.condition == "none":
        if scenario.keep_out_m and start.x_m == 0.0:
            yield Complaint("start.x_m", "0", "must be ahead of the target or behind it")
        return
    moving = {key: getattr(start, key) for key in ("z_m", "vx_m_s", "vz_m_s")}
    for key, value in moving.items():
        if value != 0.0:
            allowed = (
                f"condition = {scenario.condition!r} starts at rest on the V-bar or beside it, so must be 0;"
                " with condition = 'none' any start is taken"
            )
            yield Complaint(f"start.{key}", f"{value:g}", allowed)
    if scenario.condition == "beyond" and scenario.target.elliptic:
        yield Complaint("condition", "'beyond'", "about an eccentric target must be 'short' or 'none'")


def _timing_complaints(scenario: Scenario) -> Iterator[Complaint]:
    half_s = pi / scenario.target.mean_motion()
    count = scenario.impulses.count or DEFAULT_COUNT.get(scenario.impulses.timing, 2)
    if scenario.impulses.timing == "equal" and scenario.keep_out_m:
        last = count - (scenario.capture.velocity() is not None)
        if scenario.duration_s / last >= half_s:
            allowed = (
                f"impulse 2 at {scenario.duration_s / last:.6g} s comes half an orbit or more after the first, when its"
                f" drift is back on the other side of the V-bar; must be below {last * half_s:.6g} with {count} impulses"
            )
            yield Complaint("duration_s", f"{scenario.duration_s:g}", allowed)
    if (
        scenario.impulses.timing == "free"
        and scenario.capture.velocity() is not None
        and scenario.impulses.count == 2
    ):
        allowed = (
            "one at the start, one whose time is free and one that matches the velocity: must be 3 or more"
        )
        yield Complaint("impulses.count", "2", allowed)
    if scenario.interruption_orbits:
        orbits = str(scenario.interruption_orbits)
        if scenario.condition != "short":
            allowed = f"condition = {scenario.condition!r} cannot be made so; must be 0 unless it is 'short'"
            yield Complaint("interruption_orbits", orbits, allowed)
        if scenario.impulses.timing != "generated":
            allowed = "two impulses cannot be made so; needs impulses.timing = 'generated'"
            yield Complaint("interruption_orbits", orbits, allowed)


def _ignored_complaints(scenario: Scenario) -> Iterator[Complaint]:
    impulses = scenario.impulses
    if impulses.count is not None and impulses.timing == "generated":
        allowed = "timing = 'generated' takes as many as pay; leave it out"
        yield Complaint("impulses.count", str(impulses.count), allowed)
    if scenario.samples is not None and scenario.safety == "cone":
        yield Complaint("samples", str(scenario.samples), "safety = 'cone' takes no samples; leave it out")
    if scenario.uncertainty is not None and scenario.safety == "samples":
        yield Complaint("safety", "'samples'", "with [uncertainty] must be 'cone', whose margins are exact")
    if scenario.uncertainty is not None and not scenario.keep_out_m:
        yield Complaint("keep_out_m", "0", "there is nothing to keep a margin from; leave [uncertainty] out")
