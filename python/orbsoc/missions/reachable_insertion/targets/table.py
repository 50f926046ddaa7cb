"""The `[target]` table: an orbit by a state on it, or by elements, or by heights or C3 in place of two of them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, Strict

from orbsoc.guidance.scenario_file import Complaint, Table
from orbsoc.guidance.vehicle import State, Vector, state_complaints
from orbsoc.orbit import EARTH, Elements, state_from_elements

Array = NDArray[np.float64]
PerigeeDirection = Literal["fixed", "free"]

STATE = ("position_m", "velocity_m_s")
SHAPE = ("sma_km", "ecc", "perigee_height_km", "apogee_height_km", "c3_km2_s2", "v_infinity_m_s")
ANGLES = ("inc_deg", "raan_deg", "argp_deg")
SIZES = ("sma_km", "c3_km2_s2", "v_infinity_m_s")
LEAST_C3 = 1e-6
"""km²/s², from a parabola, which has no semi-major axis."""


class Target(Table):
    """The target orbit; for `max_energy` its plane and perigee direction, and a perigee height.

    Either a state on it in the scenario's axes, or osculating elements in ECI: three angles and two of the shape's keys.
    """

    position_m: Vector | None = None
    velocity_m_s: Vector | None = None
    sma_km: float | None = Field(default=None, description="negative on a hyperbola")
    ecc: float | None = Field(default=None, ge=0.0)
    inc_deg: float | None = Field(default=None, ge=0.0, le=180.0)
    raan_deg: float | None = Field(default=None, ge=-360.0, le=360.0)
    argp_deg: float | None = Field(default=None, ge=-360.0, le=360.0)
    true_anomaly_deg: float = Field(
        default=0.0, description="of any point; the burn may end anywhere on the orbit"
    )
    perigee_height_km: float | None = Field(default=None, gt=0.0, le=1.0e5)
    apogee_height_km: float | None = Field(default=None, gt=0.0, le=1.0e7)
    c3_km2_s2: float | None = Field(default=None, description="2 × energy: v∞² of an escape")
    v_infinity_m_s: float | None = Field(default=None, gt=0.0, le=5.0e4)
    free: Annotated[tuple[Literal["inc_deg", "raan_deg", "argp_deg", "shape"], ...], Strict(False)] = Field(
        default=(),
        description="elements that may end as they like, of min_time; with shape, one number of the shape or none is given",
    )
    perigee_direction: PerigeeDirection = "fixed"

    @property
    def by_elements(self) -> bool:
        """Whether the table gives elements, which are in ECI."""
        return self.position_m is None and self.velocity_m_s is None

    def vector(self) -> Array:
        """A state (6,) on the orbit, SI: in ECI if given by elements, else in the scenario's axes."""
        if self.position_m is not None and self.velocity_m_s is not None:
            return np.array([*self.position_m, *self.velocity_m_s])
        return np.concatenate(state_from_elements(self._elements()))

    def _elements(self) -> Elements:
        sma, ecc = self.shape()
        inc, raan, argp = (float(np.deg2rad(getattr(self, key) or 0.0)) for key in ANGLES)
        return Elements(sma, ecc, inc, raan, argp, float(np.deg2rad(self.true_anomaly_deg)))

    def semi_major_axis_m(self) -> float | None:
        """From the key that gives the energy, if one does."""
        mu = EARTH.mu_m3_s2
        if self.v_infinity_m_s is not None:
            return -mu / self.v_infinity_m_s**2
        if self.c3_km2_s2 is not None:
            return -mu / (1e6 * self.c3_km2_s2)
        return self.sma_km and 1e3 * self.sma_km

    def shape(self) -> tuple[float, float]:
        """Semi-major axis (m) and eccentricity from the two keys that are given."""
        earth = EARTH.earth_radius_m
        sma, ecc = self.semi_major_axis_m(), self.ecc
        perigee, apogee = (
            None if height is None else earth + 1e3 * height
            for height in (self.perigee_height_km, self.apogee_height_km)
        )
        if sma is not None and ecc is not None:
            return sma, ecc
        if sma is not None and perigee is not None:
            return sma, 1.0 - perigee / sma
        if sma is not None and apogee is not None:
            return sma, apogee / sma - 1.0
        if perigee is not None and apogee is not None:
            return 0.5 * (perigee + apogee), (apogee - perigee) / (apogee + perigee)
        if ecc is not None and perigee is not None:
            return perigee / (1.0 - ecc), ecc
        assert ecc is not None
        assert apogee is not None
        return apogee / (1.0 + ecc), ecc


def target_complaints(target: Target, problem: str) -> Iterator[Complaint]:
    """What names no orbit, or two; then what no vehicle's state can be."""
    states = [key for key in STATE if getattr(target, key) is not None]
    if states:
        yield from _beside_a_state(target, states)
        position, velocity = target.position_m, target.velocity_m_s
        assert position is not None
        assert velocity is not None
        yield from state_complaints("target", State(position_m=position, velocity_m_s=velocity))
        return
    if problem == "max_energy":
        yield Complaint("target.position_m", "", 'is missing, and problem = "max_energy" needs a state')
    yield from _element_complaints(target)
    yield from _free_complaints(target)
    yield from _shape_complaints(target)


def idle_target_keys(target: Target, problem: str) -> dict[str, str]:
    """Dotted keys of the table that a plan does not depend on, each with the reason."""
    anywhere = "changes nothing: the burn may end anywhere on the orbit"
    idle = {"target.true_anomaly_deg": anywhere}
    if problem == "min_time":
        asked = 'changes nothing: problem = "min_time" takes the whole orbit from {}; it is of problem = "max_energy"'
        idle["target.perigee_direction"] = asked.format("the target")
        if not target.by_elements:
            idle["target.perigee_height_km"] = asked.format("the target's state")
    return idle


def _beside_a_state(target: Target, states: list[str]) -> Iterator[Complaint]:
    # perigee_height_km beside a state is what max_energy asks for
    elements = [*_given(target, (*SHAPE, *ANGLES)), *(["free"] if target.free else [])]
    extra = [key for key in elements if key != "perigee_height_km"]
    if extra:
        yield Complaint(
            f"target.{extra[0]}",
            f"{getattr(target, extra[0])}",
            "there is a state already; must be one of the two",
        )
    for key in STATE:
        if key not in states:
            yield Complaint(f"target.{key}", "", f"is missing, and target.{states[0]} needs it")


def _given(target: Target, keys: tuple[str, ...]) -> list[str]:
    return [key for key in keys if getattr(target, key) is not None]


def _element_complaints(target: Target) -> Iterator[Complaint]:
    """A key that is missing and not free, given and free, or one too many."""
    shape, angles = _given(target, SHAPE), _given(target, ANGLES)
    for key in ANGLES:
        if key in angles and key in target.free:
            yield Complaint(
                f"target.{key}", f"{getattr(target, key)}", "is in target.free; must be one of the two"
            )
        if key not in angles and key not in target.free:
            yield Complaint(
                f"target.{key}",
                "",
                "is missing; an orbit by elements needs it, or name it in target.free, or give position_m and velocity_m_s",
            )
    if "shape" in target.free:
        if len(shape) > 1:
            allowed = f'with "shape" in target.free must be one of {", ".join(SHAPE)}, or none'
            yield Complaint("target", ", ".join(shape), allowed)
    elif len(shape) != 2 or len(set(SIZES) & set(shape)) > 1:
        allowed = f"must be two of {', '.join(SHAPE)}, and only one of those that give the energy"
        yield Complaint("target", f"{', '.join(shape) or 'no shape'}", allowed)


def _free_complaints(target: Target) -> Iterator[Complaint]:
    """What says nothing without what is left free."""
    if not target.free:
        return
    if len(set(target.free)) < len(target.free):
        yield Complaint("target.free", f"{list(target.free)}", "each at most once")
    for key, reason in (
        ("raan_deg", "there is no node without an inclination"),
        ("argp_deg", "it counts from the node of a plane"),
    ):
        if getattr(target, key) is not None and target.inc_deg is None:
            yield Complaint(
                f"target.{key}",
                f"{getattr(target, key)}",
                f"needs target.inc_deg, for {reason}; or must be free",
            )
    if (
        target.argp_deg is not None
        and target.raan_deg is None
        and target.inc_deg is not None
        and abs(np.sin(np.deg2rad(target.inc_deg))) < 1e-9
    ):
        allowed = "needs target.raan_deg, for an equatorial orbit has no node; or must be free"
        yield Complaint("target.argp_deg", f"{target.argp_deg}", allowed)
    if not _given(target, (*SHAPE, *ANGLES)):
        yield Complaint(
            "target.free", f"{list(target.free)}", "leaves nothing to reach; must leave something out"
        )


def _shape_complaints(target: Target) -> Iterator[Complaint]:
    if target.c3_km2_s2 is not None and abs(target.c3_km2_s2) < LEAST_C3:
        yield Complaint(
            "target.c3_km2_s2", f"{target.c3_km2_s2:g}", f"a parabola; must be {LEAST_C3:g} or more from 0"
        )
    if "shape" in target.free:
        if target.sma_km == 0.0:
            yield Complaint("target.sma_km", "0", "names no orbit; must not be 0")
        return
    try:
        target.vector()
    except (ValueError, ZeroDivisionError) as error:
        yield Complaint("target", "its elements", f"name no orbit: {error}")
        return
    sma, ecc = target.shape()
    if sma * (1.0 - ecc) <= 0.0 or ecc < 0.0:
        yield Complaint(
            "target",
            f"a = {sma / 1e3:g} km, e = {ecc:g}",
            "name no orbit; must have e ≥ 0 and a perigee above 0",
        )
