"""The `[target]` table: an orbit table on which any place will do, and elements may be left free."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, Strict

from orbsoc.guidance.orbit_input import Orbit
from orbsoc.guidance.orbit_input.checks import (
    beside_a_state,
    frame_complaints,
    given_keys,
    parabola_complaints,
    shape_complaints,
    shape_count_complaints,
)
from orbsoc.guidance.orbit_input.elements import ANGLES, ANOMALIES, SHAPE
from orbsoc.guidance.orbit_input.table import STATE
from orbsoc.guidance.scenario_file import Complaint
from orbsoc.guidance.vehicle import State, state_complaints

PerigeeDirection = Literal["fixed", "free"]


class TargetTable(Orbit):
    """The target orbit; for `max_energy` its plane and perigee direction, and a perigee height.

    The burn may end anywhere on it: an anomaly is not needed and changes nothing.
    """

    free: Annotated[tuple[Literal["inc_deg", "raan_deg", "argp_deg", "shape"], ...], Strict(False)] = Field(
        default=(),
        description="elements that may end as they like, of min_time; with shape, one number of the shape or none is given",
    )
    perigee_direction: PerigeeDirection = "fixed"


def target_complaints(target: TargetTable, problem: str) -> Iterator[Complaint]:
    """What names no orbit, or two; then what no vehicle's state can be."""
    yield from frame_complaints("target", target)
    states = given_keys(target, STATE)
    if states:
        if target.free:
            allowed = "there is a state already; must be one of the two"
            yield Complaint("target.free", f"{target.free}", allowed)
        # perigee_height_km beside a state is what max_energy asks for
        yield from beside_a_state("target", target, states, ("perigee_height_km", *ANOMALIES))
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


def idle_target_keys(target: TargetTable, problem: str) -> dict[str, str]:
    """Dotted keys of the table that a plan does not depend on, each with the reason."""
    anywhere = "changes nothing: the burn may end anywhere on the orbit"
    idle = {f"target.{key}": anywhere for key in ANOMALIES}
    if problem == "min_time":
        asked = 'changes nothing: problem = "min_time" takes the whole orbit from {}; it is of problem = "max_energy"'
        idle["target.perigee_direction"] = asked.format("the target")
        if not target.by_elements:
            idle["target.perigee_height_km"] = asked.format("the target's state")
    return idle


def _element_complaints(target: TargetTable) -> Iterator[Complaint]:
    """A key that is missing and not free, given and free, or one too many."""
    found, angles = given_keys(target, SHAPE), given_keys(target, ANGLES)
    needed = "is missing; an orbit by elements needs it, or name it in target.free, or give position_m and velocity_m_s"
    for key in ANGLES:
        if key in angles and key in target.free:
            value = f"{getattr(target, key)}"
            yield Complaint(f"target.{key}", value, "is in target.free; must be one of the two")
        if key not in angles and key not in target.free:
            yield Complaint(f"target.{key}", "", needed)
    if "shape" not in target.free:
        yield from shape_count_complaints("target", target)
    elif len(found) > 1:
        allowed = f'with "shape" in target.free must be one of {", ".join(SHAPE)}, or none'
        yield Complaint("target", ", ".join(found), allowed)


def _free_complaints(target: TargetTable) -> Iterator[Complaint]:
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
            allowed = f"needs target.inc_deg, for {reason}; or must be free"
            yield Complaint(f"target.{key}", f"{getattr(target, key)}", allowed)
    flat = target.inc_deg is not None and abs(np.sin(np.deg2rad(target.inc_deg))) < 1e-9
    if target.argp_deg is not None and target.raan_deg is None and flat:
        allowed = "needs target.raan_deg, for an equatorial orbit has no node; or must be free"
        yield Complaint("target.argp_deg", f"{target.argp_deg}", allowed)
    if not given_keys(target, (*SHAPE, *ANGLES)):
        allowed = "leaves nothing to reach; must leave something out"
        yield Complaint("target.free", f"{list(target.free)}", allowed)


def _shape_complaints(target: TargetTable) -> Iterator[Complaint]:
    if "shape" not in target.free:
        yield from shape_complaints("target", target)
        return
    yield from parabola_complaints("target", target)
    if target.sma_km == 0.0:
        yield Complaint("target.sma_km", "0", "names no orbit; must not be 0")
