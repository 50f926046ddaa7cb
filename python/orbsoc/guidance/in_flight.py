"""Tables of a scenario file for a flight in a closed loop: the guidance cycle, the errors of the flight, a fault of the engine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf
from typing import Annotated, Literal

from pydantic import Field, Strict

from .scenario_file import Complaint, Table

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Instead = Literal["shape", "energy", "perigee"]


class Cycle(Table):
    """The guidance cycle of a burn, what navigation knows, and what counts as reached; of `orbsoc fly` alone."""

    period_s: float = Field(default=5.0, gt=0.0, le=1.0e4, description="from one re-plan to the next")
    last_s: float = Field(
        default=8.0, ge=0.0, le=1.0e4, description="of the burn, in which no re-plan begins any more"
    )
    allowance_ms: float = Field(
        default=100.0,
        ge=0.0,
        le=1.0e6,
        description="for a computation: guidance plans from where the vehicle will be then",
    )
    latest_end_s: Positive | None = Field(
        default=None, description="of all thrust, from the scenario's state; by default the propellant's end"
    )
    position_m: NotNegative = Field(default=20.0, description="error of navigation an axis, 1σ")
    velocity_m_s: NotNegative = Field(default=0.05, description="error of navigation an axis, 1σ")
    drag_area_m2: NotNegative = Field(
        default=0.0, description="C_D·A of the vehicle as it flies; plans know no air"
    )
    apsis_km: Positive = Field(default=3.0, description="by which an apsis of the flown orbit may be off")
    plane_deg: Positive = Field(default=0.1, description="by which its plane may be off")
    safe_perigee_km: float = Field(
        default=120.0, ge=0.0, le=1.0e6, description="above which an orbit lasts a revolution"
    )
    instead: Annotated[tuple[Instead, ...], Strict(False)] = Field(
        default=("shape",),
        description="where the target is out of reach, in order: its shape in any plane, the largest orbit; last the highest perigee",
    )


class ThrustLoss(Table):
    """A fault of the engine during the burn; of `orbsoc fly` alone."""

    at_s: NotNegative = Field(description="from the ignition; during the burn")
    thrust_kept: float = Field(
        ge=0.0, lt=1.0, description="share of the thrust that is left; 0: the engine is out"
    )
    flow_kept: float | None = Field(
        default=None, ge=0.0, le=1.0, description="share of the mass flow that is left; that of the thrust"
    )
    detected_after_s: float = Field(
        default=0.1, ge=0.0, le=60.0, description="until guidance knows of it and begins to plan"
    )

    reignite_after_s: Positive | None = Field(
        default=None, description="until an engine that is out burns again, whole; by default never"
    )

    @property
    def back_s(self) -> float:
        """When the engine is whole again; infinite where it stays as it is."""
        return inf if self.reignite_after_s is None else self.at_s + self.reignite_after_s

    def lasts(self, at_s: float) -> bool:
        """Whether the engine is at fault at a time."""
        return self.at_s <= at_s < self.back_s

    @property
    def known_s(self) -> float:
        """When guidance knows of it."""
        return self.at_s + self.detected_after_s

    @property
    def flow(self) -> float:
        """The share of the mass flow that is left."""
        return self.thrust_kept if self.flow_kept is None else self.flow_kept


IN_FLIGHT = ("guidance", "event")
"""Tables of a scenario that a plan on the ground does not depend on."""


def idle_complaints(keys: Iterable[str]) -> list[Complaint]:
    """Of keys that were set for a plan on the ground, those of flights alone."""
    allowed = "changes nothing here: it is of `orbsoc fly`"
    return [Complaint(key, "", allowed) for key in keys if key.partition(".")[0] in IN_FLIGHT]


def loss_complaints(loss: ThrustLoss, burn_s: float) -> Iterator[Complaint]:
    """A fault that the burn, which takes `burn_s` as planned, does not meet."""
    if loss.at_s >= burn_s:
        allowed = f"lies outside the burn; must be below {burn_s:.6g}, when it ends as planned"
        yield Complaint("event.at_s", f"{loss.at_s:g}", allowed)
    if loss.thrust_kept > 0.0 and loss.flow <= 0.0:
        yield Complaint("event.flow_kept", f"{loss.flow:g}", "leaves thrust without flow; must be above 0")
    if loss.reignite_after_s is None:
        return
    if loss.thrust_kept > 0.0 or loss.flow > 0.0:
        kept = max(loss.thrust_kept, loss.flow)
        yield Complaint("event.thrust_kept", f"{kept:g}", "must be 0, and so the flow, with reignite_after_s")
    if not loss.detected_after_s < loss.reignite_after_s < burn_s - loss.at_s:
        allowed = (
            f"must be above detected_after_s = {loss.detected_after_s:g}, and below {burn_s - loss.at_s:.6g}, when the burn"
            " ends as planned"
        )
        yield Complaint("event.reignite_after_s", f"{loss.reignite_after_s:g}", allowed)


class BurnCycle(Table):
    """Re-plans before the impulses of a rendezvous, and what counts as reached; of `orbsoc fly` alone."""

    lead_s: float = Field(
        default=60.0, gt=0.0, le=1.0e5, description="before an impulse, that guidance begins to plan it again"
    )
    miss_m: Positive = Field(default=10.0, description="by which a flight may end beside its goal")
