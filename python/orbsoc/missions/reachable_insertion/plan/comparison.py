"""Do two plans of one scenario, made by two solvers, agree?"""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.mission import Difference
from orbsoc.orbit import EARTH, CanonicalUnits, Elements, elements_from_state

from .burn_plan import BurnPlan

TIME_REL = 1e-7
SMA_REL = 1e-7
NODE_STATE = 1e-6
"""Largest difference of a collocated state, in Earth radii and circular speeds, that counts as agreement."""


def differences(ours: BurnPlan, theirs: BurnPlan) -> tuple[Difference, ...]:
    """Burn time and semi-major axis, relative, and states at the nodes of `theirs`, canonical; grids may differ."""
    mine, other = ours.trajectory, theirs.trajectory
    units = CanonicalUnits.of(EARTH)
    start = units.state_from_si(ours.scenario.launch_inertial(ours.scenario.initial))
    at_nodes = mine.grid.interpolate_from_start(start, mine.states, other.grid.nodes)
    sma_mine, sma_other = (_orbit(plan).sma_m for plan in (ours, theirs))
    longest = max(mine.duration, other.duration)  # 0 of two burns of 0 s
    time_rel = abs(mine.duration - other.duration) / longest if longest else 0.0
    sma_rel = abs(sma_mine - sma_other) / abs(sma_other)
    node_state = max(float(np.abs(at_nodes - other.states).max()), float(np.abs(mine.end - other.end).max()))
    return (
        Difference("time_of_flight_rel", "burn time", time_rel, TIME_REL),
        Difference("sma_rel", "semi-major axis", sma_rel, SMA_REL),
        Difference("node_state", "node states", node_state, NODE_STATE, "canonical"),
    )


def _orbit(plan: BurnPlan) -> Elements:
    end = CanonicalUnits.of(EARTH).state_to_si(plan.trajectory.end)
    return elements_from_state(end[:3], end[3:])
