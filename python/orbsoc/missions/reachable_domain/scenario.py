"""What a scenario file of the reachable domain may say, and the physics it must not contradict.

Source of the quantities: Li et al. 2025, tables 1 and 2. The paper's axes are launch-inertial; ECI is also taken.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import prod
from os import PathLike
from typing import Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.orbit_input import Orbit, vehicle_complaints
from orbsoc.guidance.powered_flight import Burn, commanded
from orbsoc.guidance.scenario_file import BaseScenario, Complaint, Table, load, refuse
from orbsoc.guidance.vehicle import LaunchSite, Positive, Vehicle
from orbsoc.orbit import EARTH, CanonicalUnits, eci_from_launch_inertial, propagate_burn, rotate_state
from orbsoc.orbit.array import Array

MOST_POINTS = 10_000_000
"""Points of the largest grid that is taken; above, a step is in another unit."""


class Span(Table):
    """Values from `first` to `last`, both included, by `step`."""

    first: float
    last: float
    step: Positive

    def values(self) -> Array:
        """The values, (K,)."""
        return np.asarray(self.first + self.step * np.arange(self.count))

    @property
    def count(self) -> int:
        """How many; 0 when `last` lies before `first`."""
        return max(0, int(np.floor((self.last - self.first) / self.step * (1.0 + 1e-12) + 1e-9)) + 1)


class Grid(Table):
    """Planes and perigee heights to try: inclination × node × perigee height."""

    inclination_deg: Span
    raan_deg: Span
    perigee_height_km: Span


class Perigee(Table):
    """What the perigee radius must do, and whether its direction is free (and reported) or given."""

    condition: Literal["at_least", "equal"] = "at_least"
    argp_deg: float | None = Field(default=None, ge=-360.0, le=360.0, description="absent: free")


class BurnRules(Table):
    """The burn: its duration, and how low it may pass."""

    duration_s: Positive
    minimum_altitude_km: float | None = Field(default=None, ge=0.0, le=1.0e4, description="absent: no bound")


class Boundary(Table):
    """Where the boundary curve is sought: azimuths about the current plane, and perigee heights."""

    azimuths: int = Field(default=144, ge=8, le=3600, multiple_of=2, description="to begin with, all around")
    tolerance_deg: float = Field(
        default=0.01,
        ge=1e-3,
        le=10.0,
        description="of the tilt between azimuths; above it there are more of them",
    )
    most_azimuths: int = Field(default=1440, ge=8, le=14400, multiple_of=2)
    perigee_height_km: Span


class Method(Table):
    """How to solve; the defaults are those of the acceptance tests."""

    nodes: int = Field(default=12, ge=4, le=64, description="Legendre–Gauss nodes of the sequence")
    fine_nodes: int = Field(default=48, ge=4, le=64, description="nodes near the boundary")
    max_iterations: int = Field(default=30, ge=1, le=1000, description="of a sequence")
    continuation: Literal["wavefront", "none"] = "wavefront"
    planes_per_shard: int = Field(default=413, ge=1, le=100_000)


class Verification(Table):
    """When a flown plan counts: against its promise, its plane and its bounds."""

    sma_rel: Positive = 1e-6
    plane_rad: Positive = 1e-6
    bound_m: Positive = Field(default=1.0, description="perigee radius and minimum altitude")


class Scenario(BaseScenario):
    """One reachable domain: vehicle, state, burn, what is asked of the perigee, where to look."""

    mission: Literal["reachable_domain"]
    axes: Literal["launch_inertial", "eci"]
    vehicle: Vehicle
    launch_site: LaunchSite | None = None
    initial: Orbit
    burn: BurnRules
    perigee: Perigee = Perigee()
    grid: Grid
    boundary: Boundary
    method: Method = Method()
    verification: Verification = Verification()

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(physical_complaints(self))
        return self

    def initial_eci(self) -> Array:
        """The initial state in ECI, [r_m, v_m_s]."""
        if self.axes == "eci" or self.launch_site is None or self.initial.by_elements:
            return self.initial.vector()
        return rotate_state(eci_from_launch_inertial(self.launch_site.frame()), self.initial.vector())

    def canonical_burn(self) -> Burn:
        """The vehicle and its state in canonical units."""
        vehicle = self.vehicle
        return Burn.of(self.initial_eci(), vehicle.thruster(), vehicle.longest_burn_s, CanonicalUnits.of())

    def flown(self, programme: Array, times_s: Array) -> Array:
        """States (K, 6), ECI, SI, at times (K,) to cut-off, of the burn that an attitude programme (N, 3) commands, by SciPy's
        DOP853. Raises PropagationError."""
        steering = commanded(legendre_gauss(len(programme)), programme, float(times_s[-1]))
        return propagate_burn(self.initial_eci(), self.vehicle.thruster(), steering, times_s)

    @property
    def duration(self) -> float:
        """Burn time, canonical."""
        return self.burn.duration_s / CanonicalUnits.of().time_s


def load_scenario(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> Scenario:
    """Read and check a scenario file; `settings` override keys. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path, settings)


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics or itself, most basic first."""
    if scenario.axes == "launch_inertial" and scenario.launch_site is None:
        yield Complaint("launch_site", "", 'is missing, and axes = "launch_inertial" needs it')
    yield from vehicle_complaints("initial", scenario.initial)
    vehicle, duration_s = scenario.vehicle, scenario.burn.duration_s
    if vehicle.dry_mass_kg >= vehicle.mass_kg:
        allowed = f"leaves no propellant; must be below vehicle.mass_kg = {vehicle.mass_kg:g}"
        yield Complaint("vehicle.dry_mass_kg", f"{vehicle.dry_mass_kg:g}", allowed)
    elif duration_s >= vehicle.longest_burn_s:
        left = f"when vehicle.dry_mass_kg = {vehicle.dry_mass_kg:g} is left"
        allowed = f"burns more than there is; must be below {vehicle.longest_burn_s:.6g} s, {left}"
        yield Complaint("burn.duration_s", f"{duration_s:g}", allowed)
    lowest_km = scenario.burn.minimum_altitude_km
    start_km = (float(np.linalg.norm(scenario.initial.vector()[:3])) - EARTH.earth_radius_m) / 1e3
    if lowest_km is not None and lowest_km > start_km:
        allowed = (
            f"the burn begins below it; must be at most {start_km:.3f}, the height of initial.position_m"
        )
        yield Complaint("burn.minimum_altitude_km", f"{lowest_km:g}", allowed)
    yield from _grid_complaints(scenario)
    edge, method = scenario.boundary, scenario.method
    if edge.most_azimuths < edge.azimuths:
        allowed = f"must be at least boundary.azimuths = {edge.azimuths}"
        yield Complaint("boundary.most_azimuths", str(edge.most_azimuths), allowed)
    if method.fine_nodes < method.nodes:
        allowed = f"must be at least method.nodes = {method.nodes}"
        yield Complaint("method.fine_nodes", str(method.fine_nodes), allowed)


def _grid_complaints(scenario: Scenario) -> Iterator[Complaint]:
    grid, edge = scenario.grid, scenario.boundary
    spans = {f"grid.{key}": getattr(grid, key) for key in Grid.model_fields}
    spans["boundary.perigee_height_km"] = edge.perigee_height_km
    for key, span in spans.items():
        if span.count == 0:
            allowed = f"makes the grid empty; must be at least first = {span.first:g}"
            if key == "grid.raan_deg" and span.last + 360.0 > span.first:
                allowed += f" (to pass through 360, write last = {span.last + 360.0:g})"
            yield Complaint(f"{key}.last", f"{span.last:g}", allowed)
    points = prod(span.count for key, span in spans.items() if key.startswith("grid"))
    if points > MOST_POINTS:
        yield Complaint("grid", f"{points} points", f"must have at most {MOST_POINTS} points")
    low, high = grid.inclination_deg.first, grid.inclination_deg.values()[-1]
    if low < 0.0 or high > 180.0:
        yield Complaint("grid.inclination_deg", f"{low:g}…{high:g}", "must lie within 0…180")
    nodes = grid.raan_deg
    width = nodes.values()[-1] - nodes.first
    if width >= 360.0 - 1e-9:
        allowed = f"spans {width:g} degrees and holds planes twice; must span less than 360 (it may pass through 360)"
        yield Complaint("grid.raan_deg", f"{nodes.first:g}…{nodes.last:g}", allowed)
    for key in ("grid.perigee_height_km", "boundary.perigee_height_km"):
        first = spans[key].first
        if first <= 0.0:
            yield Complaint(f"{key}.first", f"{first:g}", "lies at or below the surface; must be above 0")
