"""What a scenario file of this mission may say, and the physics it must not contradict.

Angles are the paper's: yaw counter-clockwise with the target's motion to the right and the Earth below; `phase_deg` is 0
where the platform is below the target on its fly-around ellipse. Source of the quantities: the paper, table 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import atan2, cos, pi, radians, sin
from os import PathLike
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, Strict, model_validator

from orbsoc.guidance.in_flight import BurnCycle
from orbsoc.guidance.orbit_input.beside import LeftOut, circle_keys, circle_words, named_orbit
from orbsoc.guidance.scenario_file import BaseScenario, Complaint, Table, load, refuse, refused
from orbsoc.orbit import EARTH, ConstantsSet, Elements, state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire

from .model.launch import LaunchError, Pair
from .model.rack import Rack, Slot
from .model.separation import Separation, separated
from .model.transfer import singularity

PAPER_EARTH = ConstantsSet(
    "paper_002", 6.67e-11 * 5.965e24, 6.371e6, "table 1 of the paper: G mₑ, 3.978655e14, and the mean radius"
)
FARTHEST = 0.01
"""Of the orbit's radius: farther away the linear motion is off by a percent of the distance."""
SINGULAR = 1e-4
"""Of `transfer.singularity`, below which two impulses are refused."""
LONGEST_S = 1e6
LEAST_SHARE = 1.0 - 1e-9
"""Of the stroke, that a server must have slid at the time that a scenario gives."""
LATEST_S = 0.05
"""After the end of the stroke, the latest time to leave: the paper's simulation ends at the step of 0.05 s that comes next."""
Length = Annotated[float, Field(gt=0.0, le=100.0)]
Index = Annotated[int, Field(ge=1, le=20)]
Place = Annotated[tuple[Index, Index], Strict(False)]


def _duration(value: Any) -> Any:
    """Refuse what is neither "free" nor a time, in one sentence."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool) and 0.0 < value <= LONGEST_S
    if not (number or value == "free"):
        allowed = f"must be 'free' or a time, above 0 and up to {LONGEST_S:g}"
        raise refused("rendezvous.duration_s", repr(value), allowed)
    return value


Duration = Annotated[Literal["free"] | float, BeforeValidator(_duration)]


class Platform(Table):
    """The platform without servers, and its rack; `missing` are slots whose servers are gone, [column, row] from 1."""

    columns: Index
    rows: Index
    server_length_m: Length
    server_cm_m: Length = Field(description="from a server's bottom to its centre of mass")
    server_diameter_m: Length
    wall_m: float = Field(ge=0.0, le=10.0)
    gap_m: float = Field(ge=0.0, le=10.0, description="below a server")
    mass_kg: float = Field(gt=0.0, le=1e6)
    inertia_kg_m2: float = Field(gt=0.0, le=1e9)
    missing: tuple[Place, ...] = Field(default=(), strict=False)
    thrust_n: Annotated[tuple[float, float], Strict(False)] = Field(
        default=(0.0, 0.0), description="during the launch, across and along the tubes"
    )
    torque_n_m: float = 0.0


class Server(Table):
    """One of the servers, which are alike."""

    mass_kg: float = Field(gt=0.0, le=1e5)
    inertia_kg_m2: float = Field(gt=0.0, le=1e7)


class Orbit(Table):
    """The target's circular orbit, and the platform's fly-around ellipse about it, twice as long as high.

    `[target]` in any form of the orbit table gives the first four, with the constants "wgs84".
    """

    altitude_km: float = Field(gt=0.0, le=50_000.0, description="over the radius of the constants")
    semi_minor_m: float = Field(gt=0.0)
    raan_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    inc_deg: float = Field(default=0.0, ge=0.0, le=180.0)
    latitude_argument_deg: float = Field(
        default=60.0, ge=-360.0, le=360.0, description="of the target at the launch"
    )
    constants: Literal["paper", "wgs84"] = Field(
        default="paper", description="gravitational parameter and radius"
    )
    epoch_utc: str | None = Field(default=None, description="ISO 8601; of the launch")
    frame: Literal["TEME"] | None = Field(default=None, description="of a date; any other is turned to it")
    source: str | None = Field(default=None, description="written when a TLE or a file is read")
    ecc_left_out: LeftOut = None


class Rendezvous(Table):
    """How the server comes to the target: what is least, with how many impulses, within what time."""

    cost: Literal["squares", "norms"] = Field(default="squares", description="Σ‖Δv‖² or Σ‖Δv‖")
    impulses: Literal[2, "generated"] = 2
    longest_orbits: float = Field(default=5.0, gt=0.05, le=20.0, description="of a free time of flight")
    duration_s: Duration = Field(default="free", description='"free" or a time')
    hold_m: float = Field(
        default=50.0, gt=0.0, le=1e4, description="of the hold point on the V-bar that the audits price"
    )


class Uncertainty(Table):
    """Standard deviations of a launch and of the impulses, and how many flights are drawn."""

    force_share: float = Field(default=0.02, ge=0.0, le=0.3)
    yaw_deg: float = Field(default=0.5, ge=0.0, le=30.0)
    execution_share: float = Field(default=0.01, ge=0.0, le=0.3, description="of an impulse's size")
    position_m: float = Field(
        default=0.3,
        ge=0.0,
        le=1e4,
        description="of navigation at a correction, by axis; of `orbsoc fly` alone",
    )
    velocity_m_s: float = Field(default=2e-3, ge=0.0, le=10.0, description="the same")
    runs: int = Field(default=400, ge=1, le=100_000)
    seed: int = Field(default=0, ge=0)


class Corrections(BurnCycle):
    """Corrections of a flight, equally apart between its beginning and its end, and what counts as reached."""

    corrections: int = Field(default=3, ge=0, le=20, description="from the separation to the meeting")


class Scenario(BaseScenario):
    """One launch of one server, and its rendezvous."""

    mission: Literal["platform_launch"]
    slot: Place = Field(description="column and row of the server, [column, row]")
    force_n: float = Field(gt=0.0, le=1e7, description="of the tube on the server, along the tube")
    stop: Literal["stroke", "time"] = Field(
        default="stroke", description="the server leaves when its bottom passes the mouth, or at stop_s"
    )
    stop_s: float | None = Field(default=None, gt=0.0, le=1e4)
    phase_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    yaw_bias_deg: float = Field(
        default=0.0, ge=-180.0, le=180.0, description="of the tube from the direction to the target"
    )
    platform: Platform
    server: Server
    orbit: Orbit
    rendezvous: Rendezvous = Rendezvous()
    uncertainty: Uncertainty | None = None
    guidance: Corrections = Corrections()

    @model_validator(mode="before")
    @classmethod
    def _target(cls, given: Any) -> Any:
        return _in_own_keys(given) if isinstance(given, dict) else given

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(physical_complaints(self))
        return self

    @property
    def assumptions(self) -> list[str]:
        """What holds though the file says otherwise, in words."""
        return circle_words(self.orbit.altitude_km, self.orbit.ecc_left_out)

    @property
    def constants(self) -> ConstantsSet:
        return PAPER_EARTH if self.orbit.constants == "paper" else EARTH

    @property
    def motion(self) -> ClohessyWiltshire:
        return ClohessyWiltshire.at_altitude(1e3 * self.orbit.altitude_km, self.constants)

    @property
    def longest_s(self) -> float:
        """Up to which a free time of flight is sought."""
        return self.rendezvous.longest_orbits * self.motion.period_s

    @property
    def rack(self) -> Rack:
        table = self.platform
        return Rack(
            table.columns, table.rows, table.server_length_m, table.server_cm_m, table.server_diameter_m,
            table.wall_m, table.gap_m, table.mass_kg, table.inertia_kg_m2,
            self.server.mass_kg, self.server.inertia_kg_m2, frozenset(table.missing),
        )  # fmt: skip

    def platform_state(self, after_s: float = 0.0) -> Array:
        """x along the target's motion and z outward, and rates, (4,), of the platform on its ellipse without a launch."""
        n, b = self.motion.mean_motion_rad_s, self.orbit.semi_minor_m
        angle = radians(self.phase_deg) + n * after_s
        x, z = 2.0 * b * sin(angle), -b * cos(angle)
        return np.array([x, z, -2.0 * n * z, 0.5 * n * x])

    def sight(self, after_s: float = 0.0) -> tuple[float, float]:
        """Yaw at which the tube points to the target, rad, and its rate, rad/s."""
        x, z, vx, vz = self.platform_state(after_s)
        return atan2(x, -z), float((x * vz - z * vx) / (x * x + z * z))

    def pair(self, rack: Rack | None = None, slot: Slot | None = None) -> Pair:
        """The launch as two bodies; with a rack and a slot, that of another server."""
        yaw, rate = self.sight()
        return Pair.of(
            rack or self.rack, slot or self.slot, self.force_n,
            yaw_rad=yaw + radians(self.yaw_bias_deg), yaw_rate_rad_s=rate,
            thrust_n=self.platform.thrust_n, torque_n_m=self.platform.torque_n_m,
        )  # fmt: skip

    def separation(self) -> Separation:
        """Where the server is when it leaves its tube. Raises LaunchError."""
        stop_s = self.stop_s if self.stop == "time" else None
        return separated(self.pair(), self.rack.stroke_m(self.slot), stop_s, self.platform_state())

    def target_state(self) -> Array:
        """Of the target at the launch, inertial, (6,)."""
        table, to = self.orbit, pi / 180.0
        radius = self.constants.earth_radius_m + 1e3 * table.altitude_km
        angles = (table.inc_deg * to, table.raan_deg * to, 0.0, table.latitude_argument_deg * to)
        return np.concatenate(state_from_elements(Elements(radius, 0.0, *angles, constants=self.constants)))


def load_scenario(path: str | PathLike[str], settings: Mapping[str, Any] | None = None) -> Scenario:
    """Read and check a scenario file; `settings` override keys. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path, settings)


def _in_own_keys(given: Mapping[str, Any]) -> dict[str, Any]:
    """The document with a `[target]` of the orbit table turned to keys of `[orbit]`."""
    table, orbit_table = given.get("target"), given.get("orbit", {})
    if not isinstance(table, Mapping) or not isinstance(orbit_table, Mapping):
        return dict(given)
    orbit = named_orbit("target", table, ())
    if orbit is None:
        allowed = "names no orbit; must be state, elements, tle, omm or oem"
        raise refused("target", repr(dict(table)), allowed)
    for key in ("altitude_km", "raan_deg", "inc_deg", "latitude_argument_deg"):
        if key in orbit_table:
            allowed = "[target] gives the orbit already; must be one of the two"
            raise refused(f"orbit.{key}", repr(orbit_table[key]), allowed)
    if orbit_table.get("constants", "wgs84") != "wgs84":
        raise refused("orbit.constants", repr(orbit_table["constants"]), "with [target] must be 'wgs84'")
    return {
        **{key: value for key, value in given.items() if key != "target"},
        "orbit": {**orbit_table, **circle_keys("target", orbit), "constants": "wgs84"},
    }


def physical_complaints(scenario: Scenario) -> Iterator[Complaint]:
    """What contradicts physics or itself, most basic first: the first one is told."""
    yield from _rack_complaints(scenario)
    yield from _orbit_complaints(scenario)
    yield from _launch_complaints(scenario)
    yield from _rendezvous_complaints(scenario)


def _rack_complaints(scenario: Scenario) -> Iterator[Complaint]:
    table, (column, row) = scenario.platform, scenario.slot
    size = f"{table.columns} columns and {table.rows} rows"
    for key, place in (("slot", scenario.slot), *(("platform.missing", each) for each in table.missing)):
        if place[0] > table.columns or place[1] > table.rows:
            yield Complaint(key, str(list(place)), f"must be a column and a row of the rack, {size}")
    if len(set(table.missing)) < len(table.missing):
        yield Complaint("platform.missing", str([*map(list, table.missing)]), "must name every slot once")
    if scenario.slot in table.missing:
        there = ", ".join(str(list(each)) for each in scenario.rack.ready()) or "none"
        allowed = f"its server is in platform.missing; must be one that is there and can leave: {there}"
        yield Complaint("slot", str([column, row]), allowed)
    above = [[column, k] for k in range(row + 1, table.rows + 1) if (column, k) not in table.missing]
    if above:
        allowed = f"the server {above[0]} stands above it in the tube; must be launched first, or be missing"
        yield Complaint("slot", str([column, row]), allowed)
    if table.server_cm_m >= table.server_length_m:
        allowed = f"must be below server_length_m = {table.server_length_m:g}"
        yield Complaint("platform.server_cm_m", f"{table.server_cm_m:g}", allowed)


def _orbit_complaints(scenario: Scenario) -> Iterator[Complaint]:
    table = scenario.orbit
    radius = scenario.constants.earth_radius_m + 1e3 * table.altitude_km
    if table.semi_minor_m >= 1e3 * table.altitude_km:
        allowed = f"the platform's orbit meets the ground; must be below the altitude, {1e3 * table.altitude_km:g} m"
        yield Complaint("orbit.semi_minor_m", f"{table.semi_minor_m:g}", allowed)
    if 2.0 * table.semi_minor_m > FARTHEST * radius:
        allowed = f"must be at most {0.5 * FARTHEST * radius:.0f}, half a hundredth of the orbit's radius"
        yield Complaint("orbit.semi_minor_m", f"{table.semi_minor_m:g}", allowed)


def _launch_complaints(scenario: Scenario) -> Iterator[Complaint]:
    if (scenario.stop == "time") is (scenario.stop_s is None):
        allowed = (
            "is missing; stop = 'time' needs it" if scenario.stop_s is None else "stop = 'stroke' takes none"
        )
        yield Complaint("stop_s", str(scenario.stop_s), allowed)
        return
    try:
        found = scenario.separation()
        stroke = scenario.rack.stroke_m(scenario.slot)
        if scenario.stop_s is None:
            return
        least = separated(scenario.pair(), stroke, None, scenario.platform_state()).time_s
        if found.q[3] < LEAST_SHARE * stroke or scenario.stop_s > least + LATEST_S:
            slid = f"the server has slid {found.q[3]:.4g} m of {stroke:g} m by then"
            allowed = f"{slid}; must be at least {least:.6g} and at most {least + LATEST_S:.6g}"
            yield Complaint("stop_s", f"{scenario.stop_s:g}", allowed)
    except LaunchError as error:
        key, _, rest = str(error).partition(" = ")
        value, _, allowed = rest.partition(": ")
        yield Complaint(key, value, allowed)


def _rendezvous_complaints(scenario: Scenario) -> Iterator[Complaint]:
    table = scenario.rendezvous
    if table.impulses == "generated" and table.cost == "squares":
        allowed = "every further impulse lowers Σ‖Δv‖², there is no last one; with impulses = 'generated' must be 'norms'"
        yield Complaint("rendezvous.cost", "'squares'", allowed)
    singular = isinstance(table.duration_s, float) and table.impulses == 2
    if singular and abs(singularity(scenario.motion, float(table.duration_s))) < SINGULAR:
        orbits = float(table.duration_s) / scenario.motion.period_s
        allowed = (
            f"after {orbits:.4f} orbits two positions determine no flight (a whole revolution, or"
            " tan(τ/2) = 3τ/8); must be another time, or impulses = 'generated'"
        )
        yield Complaint("rendezvous.duration_s", f"{table.duration_s:g}", allowed)
