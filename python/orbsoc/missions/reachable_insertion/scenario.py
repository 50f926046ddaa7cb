"""What a scenario file of this mission may say, and the physics it must not contradict.

Source of the quantities: Li et al. 2025, table 3.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from math import acos, cos, exp, inf, isfinite, sqrt
from os import PathLike
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from orbsoc.guidance.in_flight import Cycle, ThrustLoss
from orbsoc.guidance.orbit_input import Orbit, vehicle_complaints
from orbsoc.guidance.scenario_file import BaseScenario, Complaint, Table, load, refuse
from orbsoc.guidance.vehicle import DRY_SHARE, LaunchSite, Positive, Vehicle
from orbsoc.orbit import (
    EARTH,
    CanonicalUnits,
    ConstantsSet,
    angular_momentum,
    eci_from_launch_inertial,
    elements_from_state,
    rotate_state,
)
from orbsoc.orbit.array import Array

from .targets.table import TargetTable, idle_target_keys, target_complaints
from .targets.target_orbit import TargetOrbit

ProblemName = Literal["min_time", "max_energy"]
PaperCase = Literal["paper004_as_printed", "paper004_zf196", "paper004_rec1", "paper004_rec2"]


MOST_SHARE = 0.9
"""Of the longest burn, that a guess takes at most."""
WITHOUT_SHAPE = 0.1
"""Of the longest burn, where the target's shape is free or an orbit is a parabola."""


class BurnTime(Table):
    """Burn time: the first guess of `min_time`, the given time of `max_energy`; how many burns, and when the first may begin."""

    duration_s: Positive | None = Field(
        default=None,
        description="first guess of min_time, by default from impulses; given time of max_energy; two burns need none",
    )
    count: Literal[1, 2] = Field(default=1, description="2: burn, coast, burn, of min_time")
    longest_coast_s: float | None = Field(
        default=None, gt=0.0, le=1.0e7, description="between two burns; as long as it takes by default"
    )
    ignition: Literal["now", "free"] = Field(
        default="now",
        description="free: after a coast on the first orbit, of the length that shortens the burn most",
    )
    latest_ignition_s: float | None = Field(
        default=None, gt=0.0, le=1.0e6, description="of ignition = free; one revolution by default"
    )
    coast_j2: bool = Field(
        default=False,
        description="of ignition = free or two burns: coasts feel the Earth's oblateness, burns do not",
    )

    @property
    def guess_s(self) -> float:
        """`duration_s`; 1 s of two burns without it, where only a vehicle on its target orbit is asked for a burn of any length."""
        return 1.0 if self.duration_s is None else self.duration_s


class Limits(Table):
    """What the vehicle cannot do, beside its thrust and its propellant."""

    attitude_rate_deg_s: Positive | None = Field(
        default=None,
        description="fastest turn of the thrust over a burn, any by default; a slew before an ignition is not modelled",
    )
    lowest_altitude_km: float = Field(
        default=100.0, ge=0.0, le=1.0e6, description="of coasts, over the equatorial radius"
    )


MOST_NODES = 128


class Method(Table):
    """How to solve; the defaults are those of the acceptance tests."""

    nodes: int = Field(default=12, ge=2, le=MOST_NODES, description="Legendre–Gauss nodes")
    max_nodes: int = Field(
        default=48, ge=2, le=MOST_NODES, description="finest grid an unverified plan is refined to"
    )
    max_iterations: int = Field(default=30, ge=1, le=1000, description="of the sequence, per grid")
    slack_weight: Positive = Field(default=100.0, description="L1 weight of terminal slack, canonical units")


class Verification(Table):
    """When the re-propagated plan counts as verified."""

    angular_momentum_rel: Positive = 1e-8
    laplace_rel: Positive = 1e-8
    plane_rad: Positive = 1e-6
    perigee_m: Positive = Field(default=1.0, description="perigee radius, of max_energy only")
    thrust_excess: Positive = Field(default=1e-4, description="of the raw control interpolant over 1")


class Scenario(BaseScenario):
    """One insertion: vehicle, initial state, target orbit, burn time, and how to solve and judge it."""

    ABOUT_THE_EARTH: ClassVar[str] = ""

    mission: Literal["reachable_insertion"]
    problem: ProblemName
    axes: Literal["launch_inertial", "eci", "velocity"] = "launch_inertial"
    """Of the states; with "velocity" they are ECI, and the attitude is told along and across the motion."""
    compare_with: PaperCase | None = None
    vehicle: Vehicle
    launch_site: LaunchSite | None = None
    initial: Orbit
    target: TargetTable
    burn: BurnTime = BurnTime()
    limits: Limits = Limits()
    method: Method = Method()
    verification: Verification = Verification()
    guidance: Cycle = Cycle()
    event: ThrustLoss | None = None

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(physical_complaints(self))
        if self.problem == "min_time" and self.burn.count == 1 and self.burn.duration_s is None:
            burn = self.burn.model_copy(update={"duration_s": self._guess_s()})
            object.__setattr__(self, "burn", burn)  # while it is made; frozen from then on
        return self

    @property
    def assumptions(self) -> list[str]:
        """What holds by default, in words."""
        found, burn = dry_mass_words(self.vehicle), self.burn
        if self.problem == "min_time" and burn.count == 1 and burn.duration_s == self._guess_s():
            found.append(
                f"burn.duration_s = {burn.duration_s:.6g}, guessed from impulses between the apsides"
            )
        return found

    def _guess_s(self) -> float:
        free = set(self.target.free)
        return guessed_duration_s(
            self.vehicle,
            self.launch_inertial(self.initial),
            None if "shape" in free else self.launch_inertial(self.target),
            plane_free=bool({"inc_deg", "raan_deg"} & free),
            about=self.constants,
        )

    @property
    def variant(self) -> str:
        """The problem: a file holds two."""
        return self.problem

    @property
    def idle_keys(self) -> Mapping[str, str]:
        found = idle_target_keys(self.target, self.problem)
        if not self.coasts:
            found["limits.lowest_altitude_km"] = "changes nothing: one burn from now has no coast"
        return found

    def launch_inertial(self, orbit: Orbit) -> Array:
        """A state of this scenario in launch-inertial axes, [r_m, v_m_s]; in ECI where there is no launch site.

        With a date, ECI is the frame of `[initial]`.
        """
        state = orbit.vector_in(self.initial.axes_name, self.initial.epoch)
        in_eci = self.axes != "launch_inertial" or orbit.by_elements
        return rotate_state(self.eci_rotation.T, state) if in_eci else state

    @property
    def eci_rotation(self) -> Array:
        """From the axes of plans, launch-inertial or else ECI, to ECI (3, 3)."""
        return np.eye(3) if self.launch_site is None else eci_from_launch_inertial(self.launch_site.frame())

    @property
    def coasts(self) -> bool:
        """Whether a plan may wait without thrust, before a burn or between two."""
        return self.burn.ignition == "free" or self.burn.count == 2

    @property
    def plan_axes(self) -> str:
        """The axes of plans and of their flights."""
        return "eci" if self.launch_site is None else "launch_inertial"


def load_scenario(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> Scenario:
    """Read and check a scenario file; `settings` override keys. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path, settings)


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics or the problem asked for, most basic first."""
    yield from vehicle_complaints("initial", scenario.initial)
    yield from target_complaints(scenario.target, scenario.problem)
    yield from _frame_complaints(scenario)
    if scenario.axes == "launch_inertial" and scenario.launch_site is None:
        yield Complaint("launch_site", "", 'is missing, and axes = "launch_inertial" needs it')
    yield from _mass_complaints(scenario)
    yield from _problem_complaints(scenario)


def _frame_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """Frames that cannot be turned into each other."""
    initial, target = scenario.initial, scenario.target
    if scenario.body.name != "earth":
        about = f"is the Earth's; leave it out where body.name = {scenario.body.name!r}"
        if scenario.launch_site is not None:
            yield Complaint("launch_site", "", about)
        for key, orbit in (("initial", initial), ("target", target)):
            if orbit.axes_name is not None:
                yield Complaint(f"{key}.{'epoch_utc' if orbit.dated else 'frame'}", "", about)
    for key, orbit in (("initial", initial), ("target", target)):
        if scenario.axes == "launch_inertial" and not orbit.by_elements and orbit.axes_name is not None:
            allowed = f"{key}.frame or a date says {orbit.axes_name}; with either must be 'eci' or 'velocity'"
            yield Complaint("axes", "'launch_inertial'", allowed)
    if target.axes_name is not None and initial.axes_name is None:
        allowed = "initial.frame is not given; give it too, or leave this out"
        yield Complaint("target.frame", repr(target.axes_name), allowed)
    if target.free and target.axes_name not in (None, initial.axes_name):
        allowed = f"with target.free must be {initial.axes_name!r}, that of [initial]"
        yield Complaint("target.frame", repr(target.axes_name), allowed)


def _mass_complaints(scenario: Scenario) -> Iterator[Complaint]:
    vehicle, duration_s = scenario.vehicle, scenario.burn.duration_s
    dry_kg = f"{vehicle.dry_mass_kg:g}"
    if vehicle.dry_mass_kg >= vehicle.mass_kg:
        yield Complaint("vehicle.dry_mass_kg", dry_kg, f"must be below vehicle.mass_kg = {vehicle.mass_kg:g}")
    elif duration_s is not None and duration_s >= vehicle.longest_burn_s:
        left = f"leaves {vehicle.mass_kg - vehicle.mass_flow_kg_s * duration_s:.6g} kg, not more than"
        allowed = f"{left} vehicle.dry_mass_kg = {dry_kg}; must be below {vehicle.longest_burn_s:.6g} s"
        yield Complaint("burn.duration_s", f"{duration_s:g}", allowed)


def _problem_complaints(scenario: Scenario) -> Iterator[Complaint]:
    method, target, burn = scenario.method, scenario.target, scenario.burn
    now, largest, problem = (
        burn.ignition == "now",
        scenario.problem == "max_energy",
        f"problem = {scenario.problem!r}",
    )
    lowest_km, missing = scenario.limits.lowest_altitude_km, 'is missing, and problem = "max_energy" needs it'
    altitude_km = (
        float(np.linalg.norm(scenario.initial.vector()[:3])) - scenario.constants.earth_radius_m
    ) / 1e3
    is_circular = (
        largest
        and target.perigee_direction == "fixed"
        and TargetOrbit.through(
            CanonicalUnits.of(scenario.constants).state_from_si(target.vector())
        ).is_circular
    )
    rules: tuple[tuple[bool, str, object, str], ...] = (
        (not now and altitude_km < lowest_km, "limits.lowest_altitude_km", lowest_km,
         f'with burn.ignition = "free" must be at most {altitude_km:.6g}, the altitude of [initial]'),
        (burn.latest_ignition_s is not None and now, "burn.latest_ignition_s", burn.latest_ignition_s,
         'needs burn.ignition = "free"'),
        (burn.coast_j2 and not scenario.coasts, "burn.coast_j2", "true",
         'needs burn.ignition = "free" or burn.count = 2; one burn from now has no coast'),
        (burn.duration_s is None and largest, "burn.duration_s", "", missing),
        (burn.longest_coast_s is not None and burn.count == 1, "burn.longest_coast_s", burn.longest_coast_s,
         "needs burn.count = 2"),
        (burn.count == 2 and largest, "burn.count", 2, f"{problem} has one burn; must be 1"),
        (not now and largest, "burn.ignition", "'free'", f"{problem} ignites now; must be 'now'"),
        (method.max_nodes < method.nodes, "method.max_nodes", method.max_nodes,
         f"must be at least method.nodes = {method.nodes}"),
        (target.perigee_height_km is None and largest, "target.perigee_height_km", "", missing),
        (is_circular, "target.perigee_direction", "'fixed'",
         "the target orbit is circular and has no perigee direction; must be 'free'"),
    )  # fmt: skip
    for is_wrong, key, value, allowed in rules:
        if is_wrong:
            yield Complaint(key, f"{value:g}" if isinstance(value, float) else f"{value}", allowed)


def guessed_duration_s(
    vehicle: Vehicle, start: Array, goal: Array | None, *, plane_free: bool, about: ConstantsSet = EARTH
) -> float:
    """The burn of the cheapest pair of impulses between an apsis of the first orbit and one of the target, by the rocket
    equation; the plane turns at the second. States (6,), SI, in the same axes; `goal` None where its shape is free."""
    longest = vehicle.longest_burn_s
    dv_m_s = inf if goal is None else _least_dv_m_s(start, goal, plane_free, about)
    if not isfinite(dv_m_s):
        return WITHOUT_SHAPE * longest
    exhaust_m_s = vehicle.thrust_n / vehicle.mass_flow_kg_s
    burn_s = vehicle.mass_kg / vehicle.mass_flow_kg_s * (1.0 - exp(-dv_m_s / exhaust_m_s))
    return min(max(burn_s, 1.0), MOST_SHARE * longest)


def dry_mass_words(vehicle: Vehicle) -> list[str]:
    """That the dry mass is the default, if it is."""
    if vehicle.dry_mass_kg != DRY_SHARE * vehicle.mass_kg:
        return []
    return [f"vehicle.dry_mass_kg = {vehicle.dry_mass_kg:g}, a tenth of mass_kg, the default"]


def _least_dv_m_s(start: Array, goal: Array, plane_free: bool, about: ConstantsSet) -> float:
    """Infinite where nothing can be said."""
    mu = about.mu_m3_s2
    try:
        first = elements_from_state(start[:3], start[3:], about)
        last = elements_from_state(goal[:3], goal[3:], about)
    except ValueError:
        return inf
    turn = 0.0
    if not plane_free:
        normals = [angular_momentum(each[:3], each[3:]) for each in (start, goal)]
        units = [each / np.linalg.norm(each) for each in normals]
        turn = acos(float(np.clip(units[0] @ units[1], -1.0, 1.0)))

    def speed(radius: float, sma: float) -> float:
        return sqrt(mu * max(2.0 / radius - 1.0 / sma, 0.0))

    def pair(low: float, high: float) -> float:
        sma = 0.5 * (low + high)
        leave = abs(speed(low, sma) - speed(low, first.sma_m))
        come, stay = speed(high, sma), speed(high, last.sma_m)
        return leave + sqrt(max(come**2 + stay**2 - 2.0 * come * stay * cos(turn), 0.0))

    apsides = [
        [each for each in (orbit.perigee_radius_m, orbit.apogee_radius_m) if isfinite(each)]
        for orbit in (first, last)
    ]
    return min(pair(a, b) for a, b in product(*apsides))
