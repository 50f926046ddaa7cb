"""Plan the burn again from the plan that is flown: one pattern, numbers written into it, a reference that is nearly the answer.

The sequence is the product's own (`guidance.scp`), and so are the problem's numbers; only what is built anew for each plan on the
ground is not built here. The answer is flown by another integrator before it is trusted.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import ceil

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss
from orbsoc.guidance.outer_loop import OuterLoop
from orbsoc.guidance.powered_flight import Burn as CanonicalBurn
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.guidance.scp import ExitReason, Outcome, Rules, Solve, Subproblem, sequential_convex
from orbsoc.orbit import CanonicalUnits, Thruster
from orbsoc.orbit.array import Array

from ..model.problem_data import ProblemData
from ..model.problems import Iterate, MinTime
from ..outer_loop import replan_loop
from ..scenario import Scenario
from ..search.setup import InsertionSetup
from ..targets.target_orbit import TargetOrbit
from .motion import STEP_S, Burn, Engine, Field, flown, steps_to

MISS = 1e-5
"""Of the terminal conditions, relative, that an answer may leave in its own flight: 64 m and 8 cm/s, about what navigation knows."""
THRUST_EXCESS = 1e-3
"""By which its interpolant may be longer than 1 between nodes: 0.1 % of the thrust, less than its error."""
FIRM = 10.0
"""Factor on the weight of the slack. With the scenario's own a burn that is a little longer is dearer than the slack, so that 4 flights
of rec1 in 100 found no answer; with ten times it none, and 3.4 problems a re-plan instead of 3.8. A hundred times takes longer."""
RULES = Rules(max_iterations=8)
"""A reference that is nearly the answer needs two or three iterations; what more of them gain near the burn's end is below `MISS`."""
USABLE = (ExitReason.CONVERGED, ExitReason.INFEASIBLE, ExitReason.MAX_ITERATIONS)
"""Ends of a sequence whose burn is flown, and so judged."""


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """What guidance takes for true when its answer takes over: state (6,), SI, mass, engine, and the longest burn from there."""

    at_s: float
    state: Array
    mass_kg: float
    engine: Engine
    longest_s: float
    ahead_s: float = 0.0
    """For how long the estimate was flown on to it."""


@dataclass(frozen=True, slots=True, eq=False)
class WarmAnswer:
    """The burn, None without; how the sequence ended; and what the burn misses of the target in its own flight."""

    burn: Burn | None
    outcome: Outcome[Iterate]
    miss: float
    excess: float
    around: OuterLoop
    """What a program in C would do around the solves."""


@dataclass(frozen=True, slots=True, eq=False)
class WarmPlanner:
    """The target, the units, and the patterns by their number of nodes, analysed once for all flights."""

    target: TargetOrbit
    units: CanonicalUnits
    slack_weight: float
    field: Field
    patterns: dict[int, ProblemData]

    @classmethod
    def of(cls, scenario: Scenario) -> WarmPlanner:
        """For the target of a scenario, which is given whole."""
        setup = InsertionSetup.of(scenario)
        assert isinstance(setup.target, TargetOrbit)
        field = Field.as_planned(scenario.constants)
        return cls(setup.target, setup.units, FIRM * scenario.method.slack_weight, field, {})

    def plan(self, belief: Belief, flying: Burn, solve: Solve) -> WarmAnswer:
        """The shortest burn from a belief; its reference turns as what is left of the flying burn, for the same impulse."""
        units, engine = self.units, belief.engine
        thruster = Thruster(belief.mass_kg, engine.thrust_n, engine.flow_kg_s)
        burn = CanonicalBurn.of(belief.state, thruster, belief.longest_s, units)
        left_s = max(flying.end_s - belief.at_s, 1.0) * flying.thrust_n / engine.thrust_n
        grid = flying.grid
        reference = Iterate(self.reference(belief, flying, grid, min(left_s, belief.longest_s)))
        outcome = sequential_convex(reference, partial(self._about, burn), solve=solve, rules=RULES)
        if outcome.reason is ExitReason.INTERRUPTED:
            raise KeyboardInterrupt
        if outcome.reason not in USABLE:
            return WarmAnswer(None, outcome, np.inf, np.inf, self._around(belief, outcome, grid, 0.0))
        arc = outcome.iterate.trajectory
        found = replace(
            flying,
            start_s=belief.at_s,
            duration_s=arc.duration * units.time_s,
            controls=arc.controls,
            thrust_n=engine.thrust_n,
        )
        end, excess = self.end_of(belief, found)
        miss = float(np.abs(self.target.conditions(end[None])).max())
        good = miss <= MISS and excess <= THRUST_EXCESS
        around = self._around(belief, outcome, grid, found.duration_s)
        return WarmAnswer(found if good else None, outcome, miss, excess, around)

    def _around(
        self, belief: Belief, outcome: Outcome[Iterate], grid: LegendreGauss, judged_s: float
    ) -> OuterLoop:
        entries = self.patterns[grid.size].pattern.A.nnz
        ahead, judged = (ceil(span_s / STEP_S - 1e-9) for span_s in (belief.ahead_s, judged_s))
        return replan_loop(grid.size, entries, len(outcome.iterations), ahead, judged)

    def towards(self, target: TargetOrbit) -> WarmPlanner:
        """The same to another orbit."""
        return replace(self, target=target, patterns={})

    def end_of(self, belief: Belief, burn: Burn) -> tuple[Array, float]:
        """Where a burn ends from a belief, canonical (6,), and by how much its interpolant is longer than 1."""
        times, all_times = steps_to(burn.start_s, burn.end_s)
        vectors = burn.vectors(all_times)
        states = flown(
            belief.state.tolist(), belief.mass_kg, times, vectors.tolist(), belief.engine, self.field
        )
        excess = float(np.sqrt((vectors * vectors).sum(axis=1).max())) - 1.0
        return self.units.state_from_si(np.array(states[-1])), excess

    def _about(self, burn: CanonicalBurn, reference: Iterate) -> Subproblem[Iterate]:
        """The problem about a reference; the first of a grid is built, and its numbers are replaced from then on."""
        nodes = reference.trajectory.grid.size
        if nodes not in self.patterns:
            built = MinTime(burn, self.target, self.slack_weight, lambda _: {})(reference)
            self.patterns[nodes] = ProblemData.of(built.problem, nodes, self.slack_weight)
        return self.patterns[nodes].about(burn, self.target, reference)

    def reference(self, belief: Belief, flying: Burn, grid: LegendreGauss, duration_s: float) -> Trajectory:
        """What the flying attitude would do from a belief, at the nodes; one step from node to node."""
        at = np.concatenate([[0.0], 0.5 * (grid.nodes + 1.0), [1.0]])
        middles = 0.5 * (at[1:] + at[:-1])
        shares = np.empty(2 * at.size - 1)
        shares[::2], shares[1::2] = at, middles
        left_s = max(flying.end_s - belief.at_s, 0.0)
        vectors = flying.vectors(belief.at_s + left_s * shares)
        states = flown(
            belief.state.tolist(),
            belief.mass_kg,
            (duration_s * at).tolist(),
            vectors.tolist(),
            belief.engine,
            self.field,
        )
        canonical = self.units.state_from_si(np.array(states))
        controls = vectors[2:-1:2]
        controls /= np.sqrt((controls * controls).sum(axis=1))[:, None]
        return Trajectory(grid, canonical[1:-1], controls, canonical[-1], duration_s / self.units.time_s)
