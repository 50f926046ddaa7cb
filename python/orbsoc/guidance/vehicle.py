"""Tables of a scenario file that describe a powered vehicle: its engine, its state, the axes of its launch.

Source of the quantities: Li et al. 2025, tables 1 and 3. The paper prints neither the launch site, which its orbital
elements and its frame need, nor the dry mass of its eq. 5; both are keys here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np
from pydantic import Field, Strict, model_validator

from orbsoc.orbit import EARTH, ConstantsSet, LaunchFrame, Thruster
from orbsoc.orbit.array import Array

from .presets import site_with_preset, vehicle_with_preset
from .scenario_file import Complaint, Table, missing_words, refused

STANDARD_GRAVITY_M_S2 = 9.80665
"""Of the definition of the specific impulse (CGPM 1901)."""
Vector = Annotated[tuple[float, float, float], Strict(False)]
Positive = Annotated[float, Field(gt=0.0)]

SPEED_RANGE_M_S = (1.0e2, 5.0e4)
"""Speeds a powered vehicle near the Earth can have; outside, the numbers are in another unit."""
HIGHEST_MASS_KG = 1.0e8
"""Twenty times the heaviest launcher flown (Starship, 5e6 kg); above, the number is in another unit."""
HIGHEST_THRUST_N = 1.0e9
"""Over ten times the strongest launcher flown (Starship, 7.4e7 N); above, the number is in another unit."""

DRY_SHARE = 0.1
"""Of the mass at ignition, that remains where the scenario gives no dry mass: upper stages have 7 to 12 %."""


class Vehicle(Table):
    """Constant thrust and mass flow."""

    preset: str | None = Field(
        default=None,
        description="a name of `orbsoc list vehicles`, whose numbers are taken when it is read; own keys win",
    )
    mass_kg: float = Field(gt=0.0, le=HIGHEST_MASS_KG, description="mass at ignition")
    dry_mass_kg: float = Field(
        default_factory=lambda given: DRY_SHARE * given["mass_kg"],
        ge=0.0,
        description="mass that must remain at cut-off; a tenth of mass_kg",
    )
    thrust_n: float = Field(gt=0.0, le=HIGHEST_THRUST_N, description="constant thrust")
    mass_flow_kg_s: Positive = Field(default=0.0, description="constant propellant flow; or isp_s")
    isp_s: Positive | None = Field(
        default=None, description="specific impulse, from which mass_flow_kg_s is worked out when it is read"
    )

    @model_validator(mode="before")
    @classmethod
    def _flow(cls, given: Any) -> Any:
        """The mass flow of an engine that is given by its specific impulse; the scenario then holds the flow alone."""
        if not isinstance(given, dict):
            return given
        if given.get("preset") is not None:
            given = vehicle_with_preset(given)
        impulse, thrust = given.get("isp_s"), given.get("thrust_n")
        if impulse is None:
            if "mass_flow_kg_s" not in given:
                allowed = f"{missing_words(cls, 'mass_flow_kg_s')}; or give vehicle.isp_s or a preset"
                raise refused("vehicle.mass_flow_kg_s", "", allowed)
            return given
        if "mass_flow_kg_s" in given:
            both = f"vehicle.mass_flow_kg_s = {given['mass_flow_kg_s']} says the same; must be one of the two"
            raise refused("vehicle.isp_s", f"{impulse}", both)
        if not all(isinstance(value, int | float) and value > 0.0 for value in (impulse, thrust)):
            return given | {"mass_flow_kg_s": 1.0}  # the fields refuse what is wrong
        flow = thrust / (STANDARD_GRAVITY_M_S2 * impulse)
        return {**given, "mass_flow_kg_s": flow, "isp_s": None}

    def thruster(self) -> Thruster:
        return Thruster(self.mass_kg, self.thrust_n, self.mass_flow_kg_s)

    @property
    def longest_burn_s(self) -> float:
        """Burn time that leaves exactly the dry mass."""
        return (self.mass_kg - self.dry_mass_kg) / self.mass_flow_kg_s


class LaunchSite(Table):
    """Where the launch-inertial axes pointed when they were frozen."""

    preset: str | None = Field(
        default=None,
        description="a name of `orbsoc list sites`, whose latitude and longitude are taken when it is read; own keys win",
    )
    geocentric_latitude_deg: float = Field(ge=-90.0, le=90.0)
    azimuth_deg: float = Field(ge=-360.0, le=360.0, description="of the x axis, from north over east")
    inertial_longitude_deg: float = Field(ge=-360.0, le=360.0, description="from the x axis of ECI")

    @model_validator(mode="before")
    @classmethod
    def _preset(cls, given: Any) -> Any:
        """The place of a site by name; the scenario then holds the numbers alone."""
        if not isinstance(given, dict) or given.get("preset") is None:
            return given
        return site_with_preset(given)

    def frame(self) -> LaunchFrame:
        angles = (self.geocentric_latitude_deg, self.azimuth_deg, self.inertial_longitude_deg)
        return LaunchFrame(*(float(np.deg2rad(angle)) for angle in angles))


class State(Table):
    """Position and velocity, Earth-centred, in the scenario's axes."""

    position_m: Vector
    velocity_m_s: Vector

    def vector(self) -> Array:
        return np.array([*self.position_m, *self.velocity_m_s])


def state_complaints(key: str, state: State, about: ConstantsSet = EARTH) -> Iterator[Complaint]:
    """What no state of a vehicle above the ground can be; `key` is the table's."""
    x = state.vector()
    radius, speed = float(np.linalg.norm(x[:3])), float(np.linalg.norm(x[3:]))
    position, velocity = str(list(state.position_m)), str(list(state.velocity_m_s))
    if radius < about.earth_radius_m:
        least = f"must be at least {about.earth_radius_m:.0f} m (metres from the centre, not km, not height)"
        allowed = f"lies {radius:.6g} m from the centre, below the ground; {least}"
        yield Complaint(f"{key}.position_m", position, allowed)
    low, high = SPEED_RANGE_M_S
    if not low <= speed <= high:
        allowed = f"is a speed of {speed:.6g} m/s; must be within {low:.0f}…{high:.0f} m/s (m/s, not km/s)"
        yield Complaint(f"{key}.velocity_m_s", velocity, allowed)
    elif np.linalg.norm(np.cross(x[:3], x[3:])) <= 1e-6 * radius * speed:
        yield Complaint(f"{key}.velocity_m_s", velocity, "must not be parallel to the position")
