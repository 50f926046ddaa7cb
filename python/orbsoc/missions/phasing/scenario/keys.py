"""The scenario file of a long approach by phasing. Lengths in km, angles in degrees, times in seconds or hours, as in the keys."""

from __future__ import annotations

from os import PathLike
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, PrivateAttr, Strict, model_validator

from orbsoc.guidance.body import central_body
from orbsoc.guidance.scenario_file import BaseScenario, Complaint, Table, load, refuse
from orbsoc.guidance.vehicle import Vector
from orbsoc.orbit import EARTH, ConstantsSet, Elements, elements_from_state, state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import J2, Drag, Force, PointMass

from .orbits import in_own_keys

GROUND_KM = 80.0
"""An orbit that comes lower is none."""
Revolutions = Annotated[int, Field(ge=1, le=500)]
LATEST_H = 720.0
"""Of a meeting after the first burn."""


class Body(Table):
    """Osculating elements in inertial axes at an epoch; or any form of the orbit table, which is turned to them when it is read."""

    sma_km: float = Field(gt=0.0, le=50_000.0)
    ecc: float = Field(ge=0.0, lt=1.0)
    inc_deg: float = Field(ge=0.0, le=180.0)
    raan_deg: float = Field(ge=-360.0, le=360.0)
    argp_deg: float = Field(ge=-360.0, le=360.0)
    true_anomaly_deg: float = Field(ge=-360.0, le=360.0)
    epoch_s: float
    epoch_utc: str | None = Field(default=None, description="ISO 8601; epoch_s then counts from the chaser's")
    frame: Literal["TEME"] | None = Field(
        default=None,
        description="of a date: TEME at the chaser's epoch once it is read; any other is turned to it",
    )
    source: str | None = Field(default=None, description="written when a TLE or a file is read")
    ballistic_m2_kg: float = Field(default=0.0, ge=0.0, le=1.0, description="C_D A/m, for the drag")
    motion: Literal["osculating", "mean_j2"] = Field(
        default="osculating",
        description="mean_j2: node and perigee turn at the secular rates of J2; of the chaser, until start_s",
    )

    _about: ConstantsSet = PrivateAttr(default=EARTH)
    """The scenario's body, which tells it."""

    @property
    def elements(self) -> Elements:
        angles = np.deg2rad([self.inc_deg, self.raan_deg, self.argp_deg, self.true_anomaly_deg])
        return Elements(1e3 * self.sma_km, self.ecc, *map(float, angles), constants=self._about)

    @property
    def state(self) -> Array:
        """[r_m, v_m_s], (6,), ECI, at the epoch."""
        return np.concatenate(state_from_elements(self.elements))

    def leaving(self, state: Array, at_s: float) -> Body:
        """On a state (6,) at a time, from which it coasts by the forces."""
        found = elements_from_state(state[:3], state[3:], self._about)
        inc, raan, argp, anomaly = np.rad2deg(
            [found.inc_rad, found.raan_rad, found.argp_rad, found.true_anomaly_rad]
        ).tolist()
        return self.model_copy(
            update={
                "sma_km": found.sma_m / 1e3, "ecc": found.ecc, "inc_deg": inc, "raan_deg": raan, "argp_deg": argp,
                "true_anomaly_deg": anomaly, "epoch_s": at_s, "motion": "osculating",
            }
        )  # fmt: skip


class Window(Table):
    """When the chaser may burn: the first burn turns the plane, the last one meets the target at its apogee."""

    start: int = Field(default=0, ge=0, le=40, description="revolutions of waiting between the first burns")
    revolutions: Revolutions | None = Field(
        default=None,
        description="of the chaser on the phasing orbit; looked for where start_s and end_s are given",
    )
    latest_h: float = Field(gt=0.0, le=LATEST_H, description="of the meeting, after the first burn")
    start_s: float | None = Field(default=None, description="of the first burn; else where the planes cross")
    phasing_s: float | None = Field(
        default=None, description="of the phasing burn; else where the chaser passes the target's apogee"
    )
    end_s: float | None = Field(default=None, description="of the meeting; else at the target's apogee")
    dates_h: float = Field(
        default=0.0,
        ge=0.0,
        le=24.0,
        description="by which start_s and end_s may move where revolutions are looked for",
    )
    node_s: float = Field(default=347.0, ge=30.0, le=3600.0, description="between instants of possible burns")
    normal_first: bool = Field(
        default=False, description="the paper's timing: until the phasing burn, out of the plane alone"
    )
    front: Annotated[tuple[Revolutions, ...], Strict(False)] = Field(
        default=(), description="other numbers of revolutions to price"
    )


class Limits(Table):
    """Of the orbits between burns."""

    perigee_height_km: float = Field(default=150.0, ge=0.0, le=2000.0)
    apogee_height_km: float = Field(default=3000.0, ge=0.0, le=40_000.0)


class Engine(Table):
    """For the finite burns that stand for the impulses: acceleration at the first ignition, speed of the exhaust."""

    acceleration_m_s2: float = Field(gt=0.0, le=100.0)
    exhaust_m_s: float = Field(gt=0.0, le=50_000.0)


class Surprise(Table):
    """What the target's drag really is, and when, before the meeting, the chaser learns of it and plans again."""

    ballistic_m2_kg: float = Field(ge=0.0, le=1.0)
    replans_h: Annotated[tuple[Annotated[float, Field(gt=0.0, le=LATEST_H)], ...], Strict(False)] = (
        12.5,
        8.3,
        4.2,
        0.8,
    )


class Errors(Table):
    """Standard deviations, an axis of (R, T, N): of what is known of the target at its epoch, and of the engine."""

    position_m: Vector = (200.0, 500.0, 200.0)
    velocity_m_s: Vector = (0.3, 0.2, 0.3)
    ballistic_m2_kg: float = Field(default=0.0015, ge=0.0, le=1.0, description="of the target")
    execution_share: float = Field(default=0.001, ge=0.0, le=0.3, description="of an impulse's size")
    execution_deg: float = Field(default=0.29, ge=0.0, le=10.0, description="of an impulse's direction")
    distance_km: float = Field(
        default=200.0, gt=0.0, le=5000.0, description="within which the meeting counts"
    )
    probability: float | None = Field(
        default=None, gt=0.5, lt=1.0, description="of the meeting, that the plan must have"
    )
    runs: int = Field(default=20_000, ge=0, le=1_000_000, description="of linear draws; 0 for none")
    seed: int = Field(default=0, ge=0)


class Tracking(Table):
    """When the target is tracked and the rest of the flight planned again; of `orbsoc fly` alone."""

    replans_h: Annotated[tuple[Annotated[float, Field(gt=0.0, le=LATEST_H)], ...], Strict(False)] = Field(
        default=(12.5, 8.3, 4.2, 0.8), description="before the meeting"
    )
    lead_s: float = Field(default=60.0, gt=0.0, le=1.0e4, description="that an answer has until its burns")


class Scenario(BaseScenario):
    """A long approach: from one orbit to a target on another, both about an oblate body, the Earth with air."""

    ABOUT_THE_EARTH: ClassVar[str] = ""

    mission: Literal["phasing"]
    scheme: Literal["paper", "socp"] = "socp"
    forces: Annotated[tuple[Literal["j2", "drag"], ...], Strict(False)] = Field(
        default=("j2", "drag"), description="about another body than the Earth j2 alone"
    )
    chaser: Body
    target: Body
    window: Window
    limits: Limits = Limits()
    engine: Engine | None = None
    surprise: Surprise | None = None
    uncertainty: Errors | None = None
    guidance: Tracking = Tracking()
    compare_with: float | None = Field(
        default=None, gt=0.0, description="Σ‖Δv‖, m/s, that it is known to have, for `orbsoc reproduce 003`"
    )

    def forces_on(self, ballistic_m2_kg: float) -> list[Force]:
        """On one body."""
        about = self.constants
        drag = [Drag(ballistic_m2_kg)] if "drag" in self.forces and ballistic_m2_kg else []
        return [PointMass(about), *([J2(about, about.j2)] if "j2" in self.forces else []), *drag]

    @model_validator(mode="before")
    @classmethod
    def _orbits(cls, given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        airless = "forces" not in given and central_body(given).name != "earth"
        return in_own_keys({**given, "forces": ("j2",)} if airless else given)

    @model_validator(mode="after")
    def _physics(self) -> Self:
        refuse(self._complaints())
        return self

    def _complaints(self) -> list[Complaint]:
        found: list[Complaint] = []
        about, ground_km = self.body.name, GROUND_KM
        if about != "earth":
            ground_km = 0.0
            if self.window.revolutions is None:
                allowed = f"must be given where body.name = {about!r}: the search over revolutions has the Earth's figures"
                found.append(Complaint("window.revolutions", "not given", allowed))
            if "drag" in self.forces:
                found.append(
                    Complaint("forces", f"{list(self.forces)}", "'drag' is of the Earth's air; leave it out")
                )
            for name, body in (("chaser", self.chaser), ("target", self.target)):
                if body.motion == "mean_j2":
                    allowed = f"has the Earth's figures; must be 'osculating' where body.name = {about!r}"
                    found.append(Complaint(f"{name}.motion", body.motion, allowed))
                if body.epoch_utc is not None:
                    allowed = f"is of the Earth's frames; leave it out where body.name = {about!r}, and give epoch_s"
                    found.append(Complaint(f"{name}.epoch_utc", body.epoch_utc, allowed))
        if self.limits.perigee_height_km < ground_km:
            allowed = f"must be {ground_km:g} or more"
            found.append(Complaint("limits.perigee_height_km", f"{self.limits.perigee_height_km:g}", allowed))
        for name, body in (("chaser", self.chaser), ("target", self.target)):
            perigee_km = body.elements.perigee_height_m() / 1e3
            if perigee_km < ground_km:
                allowed = f"with sma_km = {body.sma_km:g} the perigee is at {perigee_km:.1f} km: must be {ground_km:g} or higher"
                found.append(Complaint(f"{name}.ecc", f"{body.ecc:g}", allowed))
            if body.ballistic_m2_kg and "drag" not in self.forces:
                allowed = (
                    f"does nothing without 'drag' in forces = {list(self.forces)}; add it, or leave this out"
                )
                found.append(Complaint(f"{name}.ballistic_m2_kg", f"{body.ballistic_m2_kg:g}", allowed))
        if len(set(self.forces)) < len(self.forces):
            found.append(Complaint("forces", f"{list(self.forces)}", "each at most once"))
        if self.surprise is not None and "drag" not in self.forces:
            allowed = "does nothing without 'drag' in forces; add it"
            found.append(Complaint("surprise.ballistic_m2_kg", f"{self.surprise.ballistic_m2_kg:g}", allowed))
        found += self._window_complaints()
        low, high = self.limits.perigee_height_km, self.limits.apogee_height_km
        if low >= high:
            found.append(
                Complaint(
                    "limits.perigee_height_km", f"{low:g}", f"must be below apogee_height_km = {high:g}"
                )
            )
        return found

    def _window_complaints(self) -> list[Complaint]:
        found: list[Complaint] = []
        window = self.window
        start_s = self.chaser.epoch_s if window.start_s is None else window.start_s
        if start_s < self.chaser.epoch_s and self.chaser.motion == "osculating":
            allowed = f"must not be before chaser.epoch_s = {self.chaser.epoch_s:g}"
            found.append(Complaint("window.start_s", f"{start_s:g}", allowed))
        apart = abs(self.target.epoch_s - self.chaser.epoch_s)
        if apart > 10.0 * 86400.0 and not self.mean:
            allowed = f"must be within 10 days of chaser.epoch_s = {self.chaser.epoch_s:g}"
            found.append(Complaint("target.epoch_s", f"{self.target.epoch_s:g}", allowed))
        if window.phasing_s is not None and window.phasing_s <= start_s:
            allowed = f"must be after the first burn, {start_s:g}"
            found.append(Complaint("window.phasing_s", f"{window.phasing_s:g}", allowed))
        earliest_s = max(window.phasing_s or start_s, start_s)
        if self.target.motion == "osculating":
            earliest_s = max(earliest_s, self.target.epoch_s)
        if window.end_s is not None and window.end_s <= earliest_s:
            allowed = f"must be after the burns before it and target.epoch_s, {earliest_s:g}"
            found.append(Complaint("window.end_s", f"{window.end_s:g}", allowed))
        if (
            window.end_s is not None
            and window.end_s > start_s + 3600.0 * window.latest_h + self.chaser.elements.period_s()
        ):
            allowed = f"must be at most latest_h = {window.latest_h:g} after the first burn"
            found.append(Complaint("window.end_s", f"{window.end_s:g}", allowed))
        if window.revolutions is None:
            found += self._search_complaints()
        elif self.mean:
            allowed = "must be left out where a body has motion = 'mean_j2'"
            found.append(Complaint("window.revolutions", f"{window.revolutions}", allowed))
        elif window.dates_h:
            allowed = f"does nothing with revolutions = {window.revolutions}; leave that out"
            found.append(Complaint("window.dates_h", f"{window.dates_h:g}", allowed))
        return found

    def _search_complaints(self) -> list[Complaint]:
        """Of a scenario without a number of revolutions."""
        window, found = self.window, []
        for key in ("start_s", "end_s"):
            if getattr(window, key) is None:
                allowed = "must be given where revolutions is not, from which the planner looks for them"
                found.append(Complaint(f"window.{key}", "nothing", allowed))
        for key, given in (
            ("scheme", self.scheme != "socp" and self.scheme),
            ("forces", self.forces != ("j2",) and list(self.forces)),
            ("window.phasing_s", window.phasing_s),
            ("window.normal_first", window.normal_first),
            ("window.front", window.front),
            ("surprise", self.surprise and "given"),
            ("uncertainty", self.uncertainty and "given"),
        ):
            if given:
                allowed = {"scheme": "must be 'socp'", "forces": "must be ['j2']"}.get(
                    key, "must be left out"
                )
                found.append(Complaint(key, f"{given}", f"{allowed} where revolutions are looked for"))
        if window.start_s is not None and window.end_s is not None:
            apart_h = (window.end_s - window.start_s) / 3600.0
            if apart_h <= 2.0 * window.dates_h:
                allowed = f"must be less than half of the {apart_h:.4g} h from start_s to end_s"
                found.append(Complaint("window.dates_h", f"{window.dates_h:g}", allowed))
        return found

    @property
    def mean(self) -> bool:
        """Whether a body follows mean elements."""
        return "mean_j2" in {self.chaser.motion, self.target.motion}


def load_scenario(path: str | PathLike[str]) -> Scenario:
    """The scenario of a file, checked. Raises `orbsoc.guidance.scenario_file.ScenarioError`."""
    return load(Scenario, path)
