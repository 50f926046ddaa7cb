"""The shortest burn onto one very orbit, its perigee's height and direction included: problem A of the paper.

The reachable domain leaves the perigee its freedom; an orbit does not. What decides about it is a burn that ends on it:
`missions.reachable_insertion` seeks the shortest, and flies it by an integrator of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.missions import reachable_insertion
from orbsoc.missions.reachable_domain.scenario import Scenario
from orbsoc.missions.reachable_insertion.plan import Plan, PlanStatus
from orbsoc.missions.scenario_file import checked
from orbsoc.orbit import EARTH, Elements, PropagationError, state_from_elements

MOST_NODES = 48
"""Of the grids on which the burn is sought: some orbits need steering that swings around within seconds."""
MISS = 1e-6
"""Of angular momentum and Laplace vector, relative, that a flown burn may miss the orbit by."""


@dataclass(frozen=True, slots=True)
class ShortestBurn:
    """The shortest burn found (s, NaN for none), what it leaves of the scenario's, whether its sequence converged and
    whether its flight meets the orbit and the bound on the altitude; if not, why."""

    duration_s: float
    left_s: float
    converged: bool
    verified: bool
    why_not: str

    @property
    def words(self) -> str:
        """In a sentence."""
        if not self.converged:
            return f"a burn onto the very orbit was sought and not found ({self.why_not})"
        text = (
            f"the shortest burn onto the very orbit takes {self.duration_s:.1f} s, {abs(self.left_s):.1f} s"
        )
        text += " less than there is" if self.left_s >= 0.0 else " more than there is"
        return text if self.verified else f"{text} (not confirmed in flight: {self.why_not})"


def shortest_burn(scenario: Scenario, orbit: Elements) -> ShortestBurn:
    """Seek the shortest burn of the scenario's vehicle from its state onto an elliptic orbit, anywhere on it."""
    allowed_s = scenario.burn.duration_s
    try:
        plan = reachable_insertion.plan(_insertion(scenario, orbit))
    except PropagationError as error:  # the cold start cannot be flown
        return ShortestBurn(float("nan"), float("nan"), False, False, str(error))
    if plan.verification is None or plan.status not in (PlanStatus.VERIFIED, PlanStatus.NOT_VERIFIED):
        return ShortestBurn(float("nan"), float("nan"), False, False, plan.message)
    verified, why_not = _confirmed(scenario, plan)
    return ShortestBurn(plan.time_of_flight_s, allowed_s - plan.time_of_flight_s, True, verified, why_not)


def _confirmed(scenario: Scenario, plan: Plan) -> tuple[bool, str]:
    """Whether the flight of a converged plan meets the orbit and keeps the scenario's bound on the altitude."""
    assert plan.verification is not None
    bound_km = scenario.burn.minimum_altitude_km
    lowest_km = plan.verification.flight.lowest_altitude_m / 1e3
    if plan.status is not PlanStatus.VERIFIED:
        return False, "; ".join(plan.verification.failures)
    if bound_km is not None and lowest_km < bound_km - scenario.verification.bound_m / 1e3:
        return False, f"it passes {lowest_km:.3f} km high, below the bound of {bound_km:g} km"
    return True, ""


def _insertion(scenario: Scenario, orbit: Elements) -> reachable_insertion.Scenario:
    """The insertion as a scenario of its own; its launch site only names axes, and the results are in none."""
    position, velocity = state_from_elements(orbit, EARTH)
    site = {"geocentric_latitude_deg": 0.0, "azimuth_deg": 90.0, "inertial_longitude_deg": 0.0}
    start = scenario.initial_eci()
    document = {
        "mission": "reachable_insertion",
        "name": f"{scenario.name}, one orbit",
        "problem": "min_time",
        "axes": "eci",
        "vehicle": scenario.vehicle.model_dump(),
        "launch_site": site,
        "initial": {"position_m": start[:3].tolist(), "velocity_m_s": start[3:].tolist()},
        "target": {
            "position_m": np.asarray(position).tolist(),
            "velocity_m_s": np.asarray(velocity).tolist(),
        },
        "burn": {"duration_s": scenario.burn.duration_s},
        "method": {"nodes": scenario.method.nodes, "max_nodes": max(scenario.method.nodes, MOST_NODES)},
        "verification": {"angular_momentum_rel": MISS, "laplace_rel": MISS},
    }
    return checked(reachable_insertion.Scenario, document, source=scenario.name)
