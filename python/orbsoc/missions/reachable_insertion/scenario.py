"""What a scenario file of this mission may say, and the physics it must not contradict.

Source of the quantities: Li et al. 2025, table 3. The paper prints neither the launch site, which its orbital
elements and its frame need, nor the dry mass of its eq. 5; both are keys here.
"""

from __future__ import annotations

from collections.abc import Iterator
from os import PathLike
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict, model_validator

from orbsoc.guidance.scenario_file import Complaint, Table, checked, read_toml, refuse
from orbsoc.orbit import EARTH, CanonicalUnits, LaunchFrame, Thruster, eci_from_launch_inertial, rotate_state

from .target import TargetOrbit

Array = NDArray[np.float64]
Vector = Annotated[tuple[float, float, float], Strict(False)]
Positive = Annotated[float, Field(gt=0.0)]
ProblemName = Literal["min_time", "max_energy"]
PerigeeDirection = Literal["fixed", "free"]
PaperCase = Literal["paper004_as_printed", "paper004_zf196", "paper004_rec1", "paper004_rec2"]

SPEED_RANGE_M_S = (1.0e2, 5.0e4)
"""Speeds a powered vehicle near the Earth can have; outside, the numbers are in another unit."""


HIGHEST_MASS_KG = 1.0e8
"""Twenty times the heaviest launcher flown (Starship, 5e6 kg); above, the number is in another unit."""
HIGHEST_THRUST_N = 1.0e9
"""Over ten times the strongest launcher flown (Starship, 7.4e7 N); above, the number is in another unit."""


class Vehicle(Table):
    """Constant thrust and mass flow."""

    mass_kg: float = Field(gt=0.0, le=HIGHEST_MASS_KG, description="mass at ignition")
    dry_mass_kg: float = Field(ge=0.0, description="mass that must remain at cut-off")
    thrust_n: float = Field(gt=0.0, le=HIGHEST_THRUST_N, description="constant thrust")
    mass_flow_kg_s: Positive = Field(description="constant propellant flow")

    def thruster(self) -> Thruster:
        return Thruster(self.mass_kg, self.thrust_n, self.mass_flow_kg_s)

    @property
    def longest_burn_s(self) -> float:
        """Burn time that leaves exactly the dry mass."""
        return (self.mass_kg - self.dry_mass_kg) / self.mass_flow_kg_s


class LaunchSite(Table):
    """Where the launch-inertial axes pointed when they were frozen."""

    geocentric_latitude_deg: float = Field(ge=-90.0, le=90.0)
    azimuth_deg: float = Field(ge=-360.0, le=360.0, description="of the x axis, from north over east")
    inertial_longitude_deg: float = Field(ge=-360.0, le=360.0, description="from the x axis of ECI")

    def frame(self) -> LaunchFrame:
        angles = (self.geocentric_latitude_deg, self.azimuth_deg, self.inertial_longitude_deg)
        return LaunchFrame(*(float(np.deg2rad(angle)) for angle in angles))


class State(Table):
    """Position and velocity, Earth-centred, in the scenario's axes."""

    position_m: Vector
    velocity_m_s: Vector

    def vector(self) -> Array:
        return np.array([*self.position_m, *self.velocity_m_s])


class Target(State):
    """The target orbit, by a state on it; for `max_energy` its plane and perigee direction, and a perigee height."""

    perigee_height_km: float | None = Field(default=None, gt=0.0, le=1.0e5)
    perigee_direction: PerigeeDirection = "fixed"


class BurnTime(Table):
    """Burn time: the first guess of `min_time`, the given time of `max_energy`."""

    duration_s: Positive


class Method(Table):
    """How to solve; the defaults are those of the acceptance tests."""

    nodes: int = Field(default=12, ge=2, le=128, description="Legendre–Gauss nodes")
    max_nodes: int = Field(
        default=48, ge=2, le=128, description="finest grid an unverified plan is refined to"
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


class Scenario(Table):
    """One insertion: vehicle, initial state, target orbit, burn time, and how to solve and judge it."""

    mission: Literal["reachable_insertion"]
    name: str = Field(min_length=1)
    problem: ProblemName
    axes: Literal["launch_inertial", "eci"] = "launch_inertial"
    compare_with: PaperCase | None = None
    vehicle: Vehicle
    launch_site: LaunchSite
    initial: State
    target: Target
    burn: BurnTime
    method: Method = Method()
    verification: Verification = Verification()

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(physical_complaints(self))
        return self

    def with_changes(
        self,
        *,
        problem: ProblemName | None = None,
        perigee_direction: PerigeeDirection | None = None,
        nodes: int | None = None,
    ) -> Scenario:
        """A checked copy; raises ScenarioError when the change contradicts the rest."""
        document = self.model_dump()
        if problem is not None:
            document["problem"] = problem
        if perigee_direction is not None:
            document["target"]["perigee_direction"] = perigee_direction
        if nodes is not None:
            document["method"]["nodes"] = nodes
            document["method"]["max_nodes"] = max(nodes, self.method.max_nodes)
        return checked(Scenario, document, source=self.name)

    def launch_inertial(self, state: State) -> Array:
        """A state of this scenario in launch-inertial axes, [r_m, v_m_s]."""
        if self.axes == "launch_inertial":
            return state.vector()
        return rotate_state(eci_from_launch_inertial(self.launch_site.frame()).T, state.vector())


def load_scenario(path: str | PathLike[str]) -> Scenario:
    """Read and check a scenario file. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return checked(Scenario, read_toml(path), source=str(path))


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics or the problem asked for, most basic first."""
    yield from _state_complaints("initial", scenario.initial)
    yield from _state_complaints("target", scenario.target)
    yield from _mass_complaints(scenario)
    yield from _problem_complaints(scenario)


def _state_complaints(key: str, state: State) -> Iterator[Complaint]:
    x = state.vector()
    radius, speed = float(np.linalg.norm(x[:3])), float(np.linalg.norm(x[3:]))
    if radius < EARTH.earth_radius_m:
        yield Complaint(
            f"{key}.position_m",
            str(list(state.position_m)),
            f"lies {radius:.6g} m from the Earth's centre, below the ground; must be at least"
            f" {EARTH.earth_radius_m:.0f} m (metres from the centre, not km, not height)",
        )
    low, high = SPEED_RANGE_M_S
    if not low <= speed <= high:
        yield Complaint(
            f"{key}.velocity_m_s",
            str(list(state.velocity_m_s)),
            f"is a speed of {speed:.6g} m/s; must be within {low:.0f}…{high:.0f} m/s (m/s, not km/s)",
        )
    elif np.linalg.norm(np.cross(x[:3], x[3:])) <= 1e-6 * radius * speed:
        yield Complaint(
            f"{key}.velocity_m_s", str(list(state.velocity_m_s)), "must not be parallel to the position"
        )


def _mass_complaints(scenario: Scenario) -> Iterator[Complaint]:
    vehicle, duration_s = scenario.vehicle, scenario.burn.duration_s
    if vehicle.dry_mass_kg >= vehicle.mass_kg:
        yield Complaint(
            "vehicle.dry_mass_kg",
            f"{vehicle.dry_mass_kg:g}",
            f"must be below vehicle.mass_kg = {vehicle.mass_kg:g}",
        )
    elif duration_s >= vehicle.longest_burn_s:
        left = vehicle.mass_kg - vehicle.mass_flow_kg_s * duration_s
        yield Complaint(
            "burn.duration_s",
            f"{duration_s:g}",
            f"leaves {left:.6g} kg, not more than vehicle.dry_mass_kg = {vehicle.dry_mass_kg:g};"
            f" must be below {vehicle.longest_burn_s:.6g} s",
        )


def _problem_complaints(scenario: Scenario) -> Iterator[Complaint]:
    method, target = scenario.method, scenario.target
    if method.max_nodes < method.nodes:
        yield Complaint(
            "method.max_nodes", str(method.max_nodes), f"must be at least method.nodes = {method.nodes}"
        )
    if scenario.problem != "max_energy":
        return
    if target.perigee_height_km is None:
        yield Complaint("target.perigee_height_km", "", 'is missing, and problem = "max_energy" needs it')
    orbit = TargetOrbit.through(CanonicalUnits.of().state_from_si(target.vector()))
    if target.perigee_direction == "fixed" and orbit.is_circular:
        yield Complaint(
            "target.perigee_direction",
            "'fixed'",
            "the target orbit is circular and has no perigee direction; must be 'free'",
        )
