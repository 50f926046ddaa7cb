"""The shortest burn onto one very orbit, its perigee's height and direction included: problem A of the paper.

The reachable domain leaves the perigee its freedom; an orbit does not. A burn that ends on the orbit decides.
The mission `reachable_insertion` seeks the shortest one, `steering` corrects it where its flight misses, and an integrator that
neither of them uses flies the result.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import BaseScenario, checked
from orbsoc.guidance.scp import ExitReason
from orbsoc.missions.registry import MISSIONS
from orbsoc.orbit import EARTH, CanonicalUnits, Elements, PropagationError, state_from_elements
from orbsoc.orbit.array import Array

from ...model.flight.propagation import fly
from ...scenario import Scenario
from .steering import OrbitConditions, Programme, steered_onto

INSERTION = MISSIONS["reachable_insertion"]
MOST_NODES = 48
"""Of the grids on which the burn is sought: some orbits need steering that swings around within seconds."""
MISS = 1e-6
"""Of angular momentum and Laplace vector, relative, that a flown burn may miss the orbit by."""


LONGER_REL = 2e-4
"""By how much a burn found may be longer than the shortest: the most, 1.7e-4, on thousands of orbits whose burn is known
(docs/measurements/insertion-missions.md)."""


@dataclass(frozen=True, slots=True)
class ShortestBurn:
    """The shortest burn found (s, NaN for none) that flies to the orbit, or that is planned where none flies; what it leaves
    of the scenario's; whether its sequence converged; whether its flight meets the orbit and the bound on the altitude,
    and if not, why."""

    duration_s: float
    left_s: float
    converged: bool
    verified: bool
    why_not: str

    @classmethod
    def none(cls, why_not: str) -> ShortestBurn:
        """Nothing found."""
        return cls(float("nan"), float("nan"), converged=False, verified=False, why_not=why_not)

    @property
    def error_s(self) -> float:
        """How much shorter the shortest burn may be."""
        return LONGER_REL * self.duration_s

    @property
    def words(self) -> str:
        """In a sentence."""
        if not self.converged:
            return f"a burn onto the very orbit was sought and not found ({self.why_not})"
        text = (
            f"the shortest burn onto the very orbit takes {self.duration_s:.1f} s, {abs(self.left_s):.1f} s"
        )
        if self.left_s < 0.0:
            return f"{text} more than there is (a shorter one by {self.error_s:.2g} s may exist)"
        text += " less than there is"
        return text if self.verified else f"{text} (not confirmed in flight: {self.why_not})"


def shortest_burn(scenario: Scenario, orbit: Elements) -> ShortestBurn:
    """Seek the shortest burn of the scenario's vehicle from its state onto an elliptic orbit, anywhere on it, and fly it."""
    units, allowed_s = CanonicalUnits.of(EARTH), scenario.burn.duration_s
    target = np.concatenate(state_from_elements(replace(orbit, true_anomaly_rad=0.0)))
    conditions = OrbitConditions.through(units.state_from_si(target))
    if conditions.miss(units.state_from_si(scenario.initial_eci())) <= MISS:
        return ShortestBurn(0.0, allowed_s, converged=True, verified=True, why_not="")
    try:
        plan: Any = INSERTION.plan(_insertion(scenario, target))
    except (PropagationError, ValueError) as error:  # a start or a step of the sequence cannot be flown
        return ShortestBurn.none(str(error).partition("\n")[0])
    if plan.verification is None or plan.status not in (PlanStatus.VERIFIED, PlanStatus.NOT_VERIFIED):
        return ShortestBurn.none(plan.message)
    planned_s, why_not = plan.time_of_flight_s, ""
    shortest_s = np.inf
    for programme in _programmes(scenario, plan, conditions):
        duration_s = programme.duration * units.time_s
        broken = _broken(scenario, conditions, programme) if duration_s < min(shortest_s, allowed_s) else ""
        if not broken:
            shortest_s = min(shortest_s, duration_s)
        why_not = why_not or broken or f"one that flies takes {duration_s:.1f} s"
    if shortest_s <= allowed_s:
        return ShortestBurn(shortest_s, allowed_s - shortest_s, True, True, "")
    return ShortestBurn(planned_s, allowed_s - planned_s, True, False, why_not)


def _programmes(scenario: Scenario, plan: Any, orbit: OrbitConditions) -> Iterator[Programme]:
    """The planned attitude programme; unless the first sequence led to it, also what steers onto the orbit from the arcs that
    converged on their finest grid, on the coarsest grid and on their own."""
    burn = scenario.canonical_burn()
    yield Programme(plan.trajectory.controls, plan.trajectory.duration)
    if plan.status is PlanStatus.VERIFIED and len(plan.attempts) == 1:
        return
    first = [each for each in plan.attempts if each.start == plan.attempts[0].start]
    sequences = [each for each in first if each.outcome.reason is ExitReason.CONVERGED][-1:]
    for arc in (plan.trajectory, *(each.outcome.iterate.trajectory for each in sequences)):
        turned = arc.controls
        coarse = arc.grid.interpolate(turned, legendre_gauss(scenario.method.nodes).nodes)
        coarse /= np.linalg.norm(coarse, axis=1, keepdims=True)
        for vectors in (coarse, turned):
            found = steered_onto(burn, orbit, Programme(vectors, arc.duration))
            if found is not None:
                yield found


def _broken(scenario: Scenario, orbit: OrbitConditions, programme: Programme) -> str:
    """What the flight of a programme breaks of the orbit, the ground and the scenario's bound on the altitude; empty for
    nothing. The end is SciPy's DOP853's, the lowest point between steps that of the domain's own flights."""
    units, floor_km = CanonicalUnits.of(EARTH), scenario.burn.minimum_altitude_km or 0.0
    duration_s = programme.duration * units.time_s
    try:
        end = scenario.flown(programme.vectors, np.array([duration_s]))[-1]
    except PropagationError as error:
        return str(error).partition("\n")[0]
    miss = orbit.miss(units.state_from_si(end))
    if not miss <= MISS:
        return f"it misses the orbit by {miss:.1e}, allowed {MISS:.0e}"
    lowest = fly(scenario.canonical_burn(), programme.duration, programme.vectors[None]).lowest[0]
    lowest_km = (lowest - 1.0) * EARTH.earth_radius_m / 1e3
    if not lowest_km >= floor_km - scenario.verification.bound_m / 1e3:
        return f"it passes {lowest_km:.3f} km high, below the bound of {floor_km:g} km"
    return ""


def _insertion(scenario: Scenario, target: Array) -> BaseScenario:
    """The insertion onto the orbit through a state (6,), SI, as a scenario of its own."""
    start = scenario.initial_eci()
    document = {
        "mission": "reachable_insertion",
        "name": f"{scenario.name}, one orbit",
        "problem": "min_time",
        "axes": "eci",
        "vehicle": scenario.vehicle.model_dump(),
        "initial": {"position_m": start[:3].tolist(), "velocity_m_s": start[3:].tolist()},
        "target": {"position_m": target[:3].tolist(), "velocity_m_s": target[3:].tolist()},
        "burn": {"duration_s": scenario.burn.duration_s},
        "method": {"nodes": scenario.method.nodes, "max_nodes": max(scenario.method.nodes, MOST_NODES)},
        "verification": {"angular_momentum_rel": MISS, "laplace_rel": MISS},
    }
    return checked(INSERTION.Scenario, document, source=scenario.name)
