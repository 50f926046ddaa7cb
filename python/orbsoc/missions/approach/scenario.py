"""What a scenario file of this mission may say, and what it must not contradict.

Axes of the file: x along the target's velocity (V-bar), y against its angular momentum, z to the nadir (R-bar).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import log, radians, tan
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

Axis = Literal["+V-bar", "-V-bar", "+R-bar", "-R-bar", "+H-bar", "-H-bar"]
AXES: Mapping[str, tuple[float, float, float]] = {
    "V-bar": (1.0, 0.0, 0.0), "H-bar": (0.0, 1.0, 0.0), "R-bar": (0.0, 0.0, 1.0)
}  # fmt: skip
"""Along x, y and z."""
MOST_IMPULSES = 64
"""On the way to a point, or of its hold."""
Coordinate = Field(default=0.0, ge=-LONGEST_M, le=LONGEST_M)
Component = Field(default=None, ge=-100.0, le=100.0)


class Point(Table):
    """A place on the way, its time of arrival, how long to hold there, and impulses on the way to it."""

    x_m: float = Coordinate
    y_m: float = Coordinate
    z_m: float = Coordinate
    vx_m_s: float | None = Component
    vy_m_s: float | None = Component
    vz_m_s: float | None = Component
    arrive_s: Positive = Field(le=1e6, description="after the start")
    hold_s: float = Field(default=0.0, ge=0.0, le=1e6, description="from the arrival on")
    hold_within_m: Positive = Field(default=1.0, le=1e4, description="distance from the point while holding")
    impulses: int = Field(
        default=4,
        ge=1,
        le=MOST_IMPULSES,
        description="on the way to it, equally spaced from its beginning on",
    )
    hold_impulses: int = Field(
        default=1, ge=1, le=MOST_IMPULSES, description="of the hold, the first at the arrival"
    )

    @property
    def leave_s(self) -> float:
        """When the way to the next point begins."""
        return self.arrive_s + self.hold_s

    def position(self) -> Array:
        """(3,), frame (R, T, N)."""
        return np.asarray(LVLH.T @ np.array([self.x_m, self.y_m, self.z_m]))

    def velocity(self) -> Array | None:
        """(3,), frame (R, T, N); components that are not given are 0. None where none is given."""
        given = (self.vx_m_s, self.vy_m_s, self.vz_m_s)
        if given == (None, None, None):
            return None
        return np.asarray(LVLH.T @ np.array([each or 0.0 for each in given]))


class KeepOut(Table):
    """What the chaser stays out of until it leaves a point: a sphere, or an ellipsoid along x, y and z."""

    radius_m: float | None = Field(default=None, gt=0.0, le=LONGEST_M)
    semi_axes_m: tuple[Positive, Positive, Positive] | None = Field(default=None, strict=False)
    until: str = Field(description="name of the point that it leaves into the corridor")
    margin_m: float = Field(
        default=0.0, ge=0.0, le=1e4, description="that the plan leaves, for J2, drag and errors"
    )
    body_m: float = Field(
        default=0.0, ge=0.0, le=1e4, description="radius of the target's body, which a drift must not touch"
    )

    def semi_axes(self) -> Array:
        """Along R, T and N, (3,)."""
        if self.semi_axes_m is None:
            assert self.radius_m is not None  # the scenario checks it
            return np.full(3, self.radius_m)
        x, y, z = self.semi_axes_m
        return np.array([z, x, y])


class Corridor(Table):
    """The cone that the chaser stays in once it has left the last point before it."""

    axis: Axis = Field(description="from the apex outward")
    half_angle_deg: float = Field(gt=0.0, lt=80.0)
    apex_m: float = Field(
        default=0.0, ge=-1e3, le=1e3, description="of the cone, from the target along the axis"
    )
    margin_m: float = Field(
        default=0.0, ge=0.0, le=100.0, description="distance from its side that the plan leaves"
    )

    def direction(self) -> Array:
        """(3,), frame (R, T, N)."""
        sign = 1.0 if self.axis[0] == "+" else -1.0
        return np.asarray(sign * LVLH.T @ np.array(AXES[self.axis[1:]]))

    def depth(self, positions: Array) -> Array:
        """How far inside the cone positions (..., 3) are, m; negative outside."""
        from_apex = positions - self.apex_m * self.direction()
        along = from_apex @ self.direction()
        across = np.linalg.norm(from_apex - along[..., None] * self.direction(), axis=-1)
        angle = radians(self.half_angle_deg)
        return np.asarray(np.cos(angle) * (along * tan(angle) - across))


class HalfSpace(Table):
    """A plane through which the chaser does not go: it stays where a camera or the sun's light wants it."""

    x: float = Field(default=0.0, description="of the direction in which it stays, of any length")
    y: float = 0.0
    z: float = 0.0
    at_least_m: float = Field(default=0.0, ge=-LONGEST_M, le=LONGEST_M, description="along the direction")
    after: str | None = Field(default=None, description="point from whose arrival on; from the start on")

    def direction(self) -> Array:
        """(3,), frame (R, T, N)."""
        given = LVLH.T @ np.array([self.x, self.y, self.z])
        return np.asarray(given / np.linalg.norm(given))

    def depth(self, positions: Array) -> Array:
        """How far on this side of the plane positions (..., 3) are, m."""
        return np.asarray(positions @ self.direction() - self.at_least_m)


class Speed(Table):
    """The speed that is allowed at a range: a number, and a share of the range."""

    at_target_m_s: float = Field(ge=0.0, le=100.0, description="allowed at range 0")
    by_range_per_s: float = Field(default=0.0, ge=0.0, le=1.0, description="what a metre of range adds")

    def limit(self, ranges: Array | float) -> Any:
        """m/s at ranges in m."""
        return self.at_target_m_s + self.by_range_per_s * ranges


class Engine(Table):
    """How it fires, what an impulse or an acceleration may be, and what is counted."""

    thrust: Literal["impulses", "held"] = Field(
        default="impulses", description="or an acceleration in R, T and N, held from instant to instant"
    )
    largest_m_s: Positive = Field(default=10.0, le=1e3, description="of an impulse")
    largest_m_s2: Positive | None = Field(
        default=None, le=100.0, description="of an acceleration that is held"
    )
    limit: Literal["norm", "axes"] = Field(default="norm", description="of the whole of it, or by axis")
    cost: Literal["norms", "absolutes"] = "norms"


class Model(Table):
    """What the linear model of the plan knows."""

    j2: bool = Field(
        default=False,
        description="the Earth's oblateness along the target's orbit; drifts are then judged at samples",
    )


class Safety(Table):
    """For how long the drift after every impulse before the corridor stays out of the keep-out, and abort impulses."""

    orbits: float = Field(
        default=2.0, ge=0.0, le=50.0, description="after a burn, whole or cut; 0: not asked for"
    )
    all_time: bool = Field(
        default=False, description="about a circular target, instead of a number of orbits"
    )
    cut_burns: bool = Field(default=True, description="whether it holds wherever a burn stops, too")
    abort_m_s: Positive = Field(default=1.0, le=100.0, description="largest impulse of an abort")
    abort_every_s: Positive = Field(default=60.0, le=1e5, description="instants with an abort of their own")


class Scenario(BaseScenario):
    """An approach like a station's: keep-out sphere, approach cone, hold points, safe drifts, abort impulses."""

    mission: Literal["approach"]
    target: Target
    start: Start
    points: dict[str, Point] = Field(min_length=1, description="in the order in which they are flown")
    keep_out: KeepOut
    corridor: Corridor | None = None
    half_space: HalfSpace | None = None
    speed: Speed | None = None
    engine: Engine = Engine()
    safety: Safety = Safety()
    model: Model = Model()
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

    @property
    def gate(self) -> Point:
        """The point at which the keep-out ends and the corridor begins."""
        return self.points[self.keep_out.until]

    @property
    def half_space_s(self) -> float:
        """From when on the half-space is kept."""
        named = self.half_space.after if self.half_space else None
        return 0.0 if named is None else self.points[named].arrive_s

    @property
    def duration_s(self) -> float:
        return list(self.points.values())[-1].leave_s


def load_scenario(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> Scenario:
    """Read and check a scenario file; `settings` override keys. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path, settings)


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics or itself, most basic first."""
    target = scenario.target
    yield from target_complaints(target)
    if target.eccentricity and target.motion == "circular":
        allowed = "this mission takes the eccentricity as it is; leave it out"
        yield Complaint("target.motion", "'circular'", allowed)
    if target.elliptic and scenario.safety.all_time:
        yield Complaint("safety.all_time", "true", "for all time only about a circular target; give orbits")
    if scenario.keep_out.semi_axes_m is not None and scenario.safety.all_time:
        yield Complaint("safety.all_time", "true", "for all time only with a keep-out sphere; give orbits")
    if scenario.model.j2 and scenario.safety.all_time:
        yield Complaint("safety.all_time", "true", "for all time only without J2 in the model; give orbits")
    if scenario.model.j2 and scenario.engine.thrust == "held":
        allowed = "is planned without it; leave it out, or give engine.thrust = 'impulses'"
        yield Complaint("model.j2", "true", f"thrust that is held {allowed}")
    yield from _thrust_complaints(scenario)
    yield from _time_complaints(scenario)
    yield from _keep_out_complaints(scenario)
    yield from _corridor_complaints(scenario)
    yield from _half_space_complaints(scenario)
    yield from _speed_complaints(scenario)


def _thrust_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What does not go with the thrust."""
    engine, target, safety = scenario.engine, scenario.target, scenario.safety
    if engine.thrust == "impulses":
        if engine.largest_m_s2 is not None:
            allowed = "impulses have a size in m/s; leave it out, or give engine.thrust = 'held'"
            yield Complaint("engine.largest_m_s2", f"{engine.largest_m_s2:g}", allowed)
        return
    if engine.largest_m_s2 is None:
        yield Complaint("engine.largest_m_s2", "", "must be given with engine.thrust = 'held'")
    if "largest_m_s" in engine.model_fields_set:
        allowed = "thrust that is held has a limit in m/s²; give engine.largest_m_s2 instead"
        yield Complaint("engine.largest_m_s", f"{engine.largest_m_s:g}", allowed)
    if target.elliptic:
        allowed = "is planned about a circular target alone; give no eccentricity, or 'impulses'"
        yield Complaint("engine.thrust", "'held'", allowed)
    if safety.all_time:
        yield Complaint(
            "safety.all_time", "true", "thrust that is held is judged for some orbits; give orbits"
        )
    if scenario.uncertainty is not None:
        allowed = "errors of impulses alone are known; leave it out, or give engine.thrust = 'impulses'"
        yield Complaint("uncertainty", "", allowed)
    if "abort_m_s" in safety.model_fields_set:
        allowed = "an abort is an impulse; leave it out, or give engine.thrust = 'impulses'"
        yield Complaint("safety.abort_m_s", f"{safety.abort_m_s:g}", allowed)


def _time_complaints(scenario: Scenario) -> Iterator[Complaint]:
    before_s, name = 0.0, "the start"
    for key, point in scenario.points.items():
        if not point.arrive_s > before_s:
            allowed = f"{name} is left at {before_s:g} s; must be later"
            yield Complaint(f"points.{key}.arrive_s", f"{point.arrive_s:g}", allowed)
        if point.hold_impulses > 1 and not point.hold_s:
            allowed = "there is no hold; leave it out, or give hold_s"
            yield Complaint(f"points.{key}.hold_impulses", str(point.hold_impulses), allowed)
        before_s, name = point.leave_s, key
    last, point = list(scenario.points.items())[-1]
    if point.hold_s:
        yield Complaint(
            f"points.{last}.hold_s", f"{point.hold_s:g}", "the flight ends at the last point; must be 0"
        )


def _keep_out_complaints(scenario: Scenario) -> Iterator[Complaint]:
    keep_out = scenario.keep_out
    if (keep_out.radius_m is None) is (keep_out.semi_axes_m is None):
        yield Complaint("keep_out.radius_m", "", "must be given, or keep_out.semi_axes_m instead")
        return
    if keep_out.until not in scenario.points:
        allowed = f"no such point; must be one of {', '.join(scenario.points)}"
        yield Complaint("keep_out.until", repr(keep_out.until), allowed)
        return
    axes, margin = keep_out.semi_axes(), keep_out.margin_m
    if keep_out.body_m >= axes.min():
        allowed = f"must be below {axes.min():g}, the least of the keep-out"
        yield Complaint("keep_out.body_m", f"{keep_out.body_m:g}", allowed)
    places = {"start": scenario.start.state()[:3]}
    for key, point in scenario.points.items():
        places[f"points.{key}"] = point.position()
        if key == keep_out.until:
            break
    for key, place in places.items():
        if np.linalg.norm(place / (axes + margin)) < 1.0:
            away, depth = float(np.linalg.norm(place)), float(np.linalg.norm(place / (axes + margin)))
            allowed = (
                f"{away:g} m from the target, inside the keep-out with its margin; must be at least {away / depth:g} m"
                f" away in this direction, or come after {keep_out.until}"
            )
            yield Complaint(key, f"({', '.join(f'{each:g}' for each in LVLH @ place)})", allowed)


def _corridor_complaints(scenario: Scenario) -> Iterator[Complaint]:
    corridor = scenario.corridor
    if corridor is None:
        return
    names = list(scenario.points)
    for key in names[names.index(scenario.keep_out.until) :]:
        place = scenario.points[key].position()
        depth = float(corridor.depth(place)) - corridor.margin_m
        if depth < -1e-9:
            what = "the gate of the keep-out" if key == scenario.keep_out.until else "a point of the corridor"
            allowed = (
                f"{what} is {-depth:.3g} m outside the corridor about {corridor.axis} of"
                f" {corridor.half_angle_deg:g}° less its margin; must be inside"
            )
            yield Complaint(f"points.{key}", f"({', '.join(f'{each:g}' for each in LVLH @ place)})", allowed)
    held = scenario.gate
    reach = held.hold_within_m if held.hold_s else 0.0
    room = float(corridor.depth(held.position())) - corridor.margin_m
    if reach > room:
        allowed = f"the corridor begins there and is {room:.3g} m away at its side; must be at most that"
        yield Complaint(f"points.{scenario.keep_out.until}.hold_within_m", f"{reach:g}", allowed)


def _half_space_complaints(scenario: Scenario) -> Iterator[Complaint]:
    half_space = scenario.half_space
    if half_space is None:
        return
    if not any((half_space.x, half_space.y, half_space.z)):
        yield Complaint("half_space.x", "0", "a direction has a component that is not 0; give x, y or z")
        return
    if half_space.after is not None and half_space.after not in scenario.points:
        allowed = f"no such point; must be one of {', '.join(scenario.points)}"
        yield Complaint("half_space.after", repr(half_space.after), allowed)
        return
    places = {"start": scenario.start.state()[:3]} if half_space.after is None else {}
    for key, point in scenario.points.items():
        if point.arrive_s >= scenario.half_space_s:
            places[f"points.{key}"] = point.position()
    for key, place in places.items():
        depth = float(half_space.depth(place))
        if depth < -1e-9:
            allowed = f"{-depth:.3g} m beyond the plane of half_space; must be on its side"
            yield Complaint(key, f"({', '.join(f'{each:g}' for each in LVLH @ place)})", allowed)


def _speed_complaints(scenario: Scenario) -> Iterator[Complaint]:
    speed = scenario.speed
    if speed is None:
        return
    before_s, place = 0.0, scenario.start.state()[:3]
    for key, point in scenario.points.items():
        velocity = point.velocity()
        range_m = float(np.linalg.norm(point.position()))
        limit = float(speed.limit(range_m))
        if velocity is not None and float(np.linalg.norm(velocity)) > limit:
            allowed = f"at {range_m:g} m the speed is at most {limit:.4g} m/s"
            yield Complaint(f"points.{key}", f"{np.linalg.norm(velocity):.4g} m/s", allowed)
        far, near = float(np.linalg.norm(place)), range_m
        needs = _quickest_s(speed, max(far, near), abs(far - near))
        if needs > point.arrive_s - before_s:
            allowed = (
                f"from {far:g} to {near:g} m within the speed limit takes at least {needs:.0f} s; must be at least"
                f" {before_s + needs:.0f}"
            )
            yield Complaint(f"points.{key}.arrive_s", f"{point.arrive_s:g}", allowed)
        before_s, place = point.leave_s, point.position()


def _quickest_s(speed: Speed, farthest_m: float, change_m: float) -> float:
    """To change the range by so much at the speed limit, from the farthest or to it."""
    if not speed.by_range_per_s:
        return change_m / speed.at_target_m_s if speed.at_target_m_s else float("inf")
    fast, slow = float(speed.limit(farthest_m)), float(speed.limit(farthest_m - change_m))
    return log(fast / slow) / speed.by_range_per_s if slow > 0.0 else float("inf")
