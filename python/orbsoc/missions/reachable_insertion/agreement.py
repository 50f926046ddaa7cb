"""Do two plans of one scenario, made by two solvers, agree?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit import EARTH, CanonicalUnits, Elements, elements_from_state

from .planner import Plan

TIME_REL = 1e-7
"""Largest relative difference of the burn time that counts as agreement."""
SMA_REL = 1e-7
"""Largest relative difference of the semi-major axis that counts as agreement."""
NODE_STATE = 1e-6
"""Largest difference of a collocated state, in Earth radii and circular speeds, that counts as agreement."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """Differences of two plans: relative in burn time and semi-major axis, canonical in the collocated states."""

    ours: str
    theirs: str
    time_of_flight_rel: float
    sma_rel: float
    node_state: float

    @property
    def agrees(self) -> bool:
        """The same status, and every difference within its limit."""
        within = (
            self.time_of_flight_rel <= TIME_REL and self.sma_rel <= SMA_REL and self.node_state <= NODE_STATE
        )
        return self.ours == self.theirs and within

    def words(self) -> str:
        """One sentence with every difference beside its limit."""
        if self.ours != self.theirs:
            return f"the plan is {self.ours}, but the other solver's is {self.theirs}"
        return (
            f"burn time differs by {self.time_of_flight_rel:.1e} (limit {TIME_REL:.0e}), semi-major axis by"
            f" {self.sma_rel:.1e} (limit {SMA_REL:.0e}), node states by {self.node_state:.1e} canonical"
            f" (limit {NODE_STATE:.0e})"
        )


def agreement(ours: Plan, theirs: Plan) -> Agreement:
    """Compare two plans at the nodes of `theirs`; grids may differ."""
    mine, other = ours.trajectory, theirs.trajectory
    units = CanonicalUnits.of(EARTH)
    start = units.state_from_si(ours.scenario.launch_inertial(ours.scenario.initial))
    at_nodes = mine.grid.interpolate_from_start(start, mine.states, other.grid.nodes)
    sma_mine, sma_other = (_orbit(plan).sma_m for plan in (ours, theirs))
    return Agreement(
        ours=ours.status.value,
        theirs=theirs.status.value,
        time_of_flight_rel=abs(mine.duration - other.duration) / other.duration,
        sma_rel=abs(sma_mine - sma_other) / abs(sma_other),
        node_state=max(
            float(np.abs(at_nodes - other.states).max()), float(np.abs(mine.end - other.end).max())
        ),
    )


def _orbit(plan: Plan) -> Elements:
    end = CanonicalUnits.of(EARTH).state_to_si(plan.trajectory.end)
    return elements_from_state(end[:3], end[3:])
