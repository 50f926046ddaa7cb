"""What guidance does when thrust is lost: the target if it can still be reached, else the orbit that the scenario would rather have.

Branches are tried in order, and every convex problem of each of them takes the computer's time. That the target is out of reach is
said with its evidence: a bound that no burn escapes, or what was tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.guidance.closed_loop import Decision
from orbsoc.guidance.collocation import LegendreGauss, legendre_gauss
from orbsoc.guidance.outer_loop import OuterLoop
from orbsoc.guidance.powered_flight import Burn as CanonicalBurn
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.guidance.scp import ExitReason, Rules, Solve, sequential_convex
from orbsoc.orbit import PropagationError, Thruster, rotate_state
from orbsoc.orbit.array import Array

from ..model.highest_perigee import HighestPerigee, perigee_radius
from ..model.problems import Iterate
from ..model.proof import Proof, proof_of_infeasibility
from ..planner import searched
from ..scenario import Scenario
from ..search.run import SearchResult
from ..search.strategies import STRATEGIES
from ..targets.target_orbit import TargetOrbit
from .motion import Burn
from .verdict import CHOSEN, NOT_FOUND, OUT_OF_REACH, THE_TARGET
from .warm import Belief, WarmPlanner

ON_BOARD = ("thrust along the velocity", "a law flown onto the orbit")
"""Strategies of the search on the ground that are tried on board; the others take seconds where these do not succeed."""
FINER = 1.5
"""Of the scenario's nodes, those of the finest grid on board: two patterns are loaded, and one that is refined further stays unverified."""
PERIGEE_RULES = Rules(step_tol=1e-6, max_iterations=8)


@dataclass(slots=True, eq=False)
class _Counted:
    """A solver that counts."""

    solve: Solve
    count: int = 0

    def __call__(self, problem: Problem, settings: Settings | None = None, /) -> Solution:
        self.count += 1
        return self.solve(problem, settings)


@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """What is flown to, None for nothing; all branches that were tried; and the proof that the target is out of reach, if any."""

    burn: Burn | None
    decisions: tuple[Decision, ...]
    proof: Proof | None = None
    around: OuterLoop | None = None
    """What was counted around the first solves."""


class _Attempt(NamedTuple):
    """Of a branch: the burn, None without; what became of it; how many solves; what was counted around the first of them."""

    burn: Burn | None
    words: str
    solves: int
    around: OuterLoop | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Losses:
    """The decision for one scenario, whose own target is that of `warm`."""

    scenario: Scenario
    warm: WarmPlanner

    def decide(self, belief: Belief, flying: Burn, solve: Solve) -> Choice:
        """Choose an orbit from a belief, with the engine that is left."""
        proof = self.proof(belief)
        decisions: list[Decision] = []
        around: OuterLoop | None = None
        if proof is not None:
            decisions.append(Decision(THE_TARGET, self.proof_words(proof), OUT_OF_REACH, 0))
        for sought, attempt in self._branches(belief, flying, solve, reachable=proof is None):
            around = around or attempt.around
            word = NOT_FOUND if attempt.burn is None else CHOSEN
            decisions.append(Decision(sought, attempt.words, word, attempt.solves))
            if attempt.burn is not None:
                return Choice(attempt.burn, tuple(decisions), proof, around)
        return Choice(None, tuple(decisions), proof, around)

    def proof(self, belief: Belief) -> Proof | None:
        """A bound that no burn from a belief escapes; of an engine that is out every other orbit is beyond it."""
        burn = self._canonical(belief)
        if belief.engine.thrust_n == 0.0:
            h = np.cross(burn.start[:3], burn.start[3:])
            needed = self.warm.target.momentum_gap(h) / float(np.linalg.norm(burn.start[:3]))
            return Proof("changing the angular momentum", needed, 0.0)
        return proof_of_infeasibility(burn, self.warm.target, burn.longest)

    def proof_words(self, proof: Proof) -> str:
        """In metres per second."""
        speed = self.warm.units.speed_m_s
        return (
            f"{proof.what} takes at least {speed * proof.needed:.1f} m/s, and {speed * proof.available:.1f} m/s are left,"
            " however the burn is steered"
        )

    def highest(self, belief: Belief, flying: Burn, solve: Solve) -> Burn | None:
        """The burn of all the time that is left with the highest perigee of those that the sequence came to, as flown."""
        burn, grid = self._canonical(belief), legendre_gauss(self.scenario.method.nodes)
        start = self.warm.reference(belief, flying, grid, belief.longest_s)
        outcome = sequential_convex(Iterate(start), HighestPerigee(burn), solve=solve, rules=PERIGEE_RULES)
        if outcome.reason is ExitReason.INTERRUPTED:
            raise KeyboardInterrupt
        arcs = [start.controls, outcome.iterate.trajectory.controls]
        found = [self._burn(belief, grid, each, belief.longest_s, "perigee") for each in arcs]
        return max(found, key=lambda each: perigee_radius(self.warm.end_of(belief, each)[0]))

    def _branches(
        self, belief: Belief, flying: Burn, solve: Solve, *, reachable: bool
    ) -> Iterator[tuple[str, _Attempt]]:
        """Each branch when it is asked for."""
        if belief.engine.thrust_n == 0.0 or belief.longest_s <= 0.0:
            return
        if reachable:
            yield THE_TARGET, self._target(belief, flying, solve)
        instead = self.scenario.guidance.instead
        for name in dict.fromkeys((*instead, "perigee")):
            counted = _Counted(solve)
            if name == "perigee":
                found = self.highest(belief, flying, counted)
                words = self._perigee_words(belief, found)
                yield "the highest perigee", _Attempt(found, words, counted.count)
            elif name == "shape":
                yield "the target's shape in any plane", self._searched(belief, solve, "shape")
            else:
                yield "the largest orbit above the safe perigee", self._searched(belief, solve, "energy")

    def _target(self, belief: Belief, flying: Burn, solve: Solve) -> _Attempt:
        counted = _Counted(solve)
        warm = self.warm.plan(belief, flying, counted)
        if warm.burn is not None:
            words = f"a burn of {warm.burn.duration_s:.2f} s from the flying one"
            return _Attempt(warm.burn, words, counted.count, warm.around)
        found = self._searched(belief, solve, "target")
        return found._replace(solves=counted.count + found.solves, around=warm.around)

    def _searched(self, belief: Belief, solve: Solve, goal: str) -> _Attempt:
        """By the search on the ground, its strategies that a computer on board has the time for."""
        counted = _Counted(solve)
        try:
            scenario = self.scenario_of(belief, goal)
            strategies = [each for each in STRATEGIES if each.name in ON_BOARD]
            found = searched(scenario, counted, None, strategies)
        except (PropagationError, ScenarioError, ValueError) as error:
            return _Attempt(None, f"not planned: {str(error).splitlines()[0]}", counted.count)
        if found.interrupted:
            raise KeyboardInterrupt
        if not found.verified:
            return _Attempt(None, _closest(found), counted.count)
        arc = found.trajectory
        burn = self._burn(belief, arc.grid, arc.controls, found.time_of_flight_s, goal)
        if goal != "target":
            end, _ = self.warm.end_of(belief, burn)
            burn = replace(burn, target=TargetOrbit.through(end, self.scenario.constants))
        words = f"a burn of {found.time_of_flight_s:.2f} s from the start {found.best.start.name!r}"
        return _Attempt(burn, words, counted.count)

    def scenario_of(self, belief: Belief, goal: str) -> Scenario:
        """The scenario from a belief, towards its target or another orbit. Raises ScenarioError where it cannot be told as one."""
        scenario, engine = self.scenario, belief.engine
        state = belief.state if scenario.axes == "launch_inertial" else self._eci(belief.state)
        vectors = {"position_m": state[:3].tolist(), "velocity_m_s": state[3:].tolist()}
        document = scenario.model_dump() | {
            "name": f"{scenario.name}, {goal}",
            "compare_with": None,
            "event": None,
        }
        document["initial"] = vectors
        document["vehicle"] = {
            "mass_kg": belief.mass_kg,
            "dry_mass_kg": max(0.0, belief.mass_kg - engine.flow_kg_s * belief.longest_s),
            "thrust_n": engine.thrust_n,
            "mass_flow_kg_s": engine.flow_kg_s,
        }
        document["burn"] = {"duration_s": 0.9 * belief.longest_s}
        nodes = scenario.method.nodes
        finest = min(scenario.method.max_nodes, int(np.ceil(FINER * nodes)))
        document["method"] = scenario.method.model_dump() | {"max_nodes": finest}
        if goal == "energy":
            document |= {"problem": "max_energy", "burn": {"duration_s": 0.999 * belief.longest_s}}
            safe_km = scenario.guidance.safe_perigee_km
            document["target"] = vectors | {"perigee_height_km": safe_km, "perigee_direction": "free"}
        elif goal == "shape":
            document["target"] = self._shape()
        return checked(Scenario, document, source=scenario.name)

    def _shape(self) -> dict[str, object]:
        """The target's shape alone."""
        target = self.warm.target
        radius_km = self.scenario.constants.earth_radius_m / 1e3
        sma = target.momentum**2 / (1.0 - target.eccentricity**2)
        return {
            "perigee_height_km": (sma * (1.0 - target.eccentricity) - 1.0) * radius_km,
            "apogee_height_km": (sma * (1.0 + target.eccentricity) - 1.0) * radius_km,
            "free": ["inc_deg", "raan_deg", "argp_deg"],
        }

    def _eci(self, state: Array) -> Array:
        return np.asarray(rotate_state(self.scenario.eci_rotation, state))

    def _canonical(self, belief: Belief) -> CanonicalBurn:
        engine = belief.engine
        thruster = Thruster(belief.mass_kg, engine.thrust_n, engine.flow_kg_s)
        longest_s = belief.longest_s if np.isfinite(belief.longest_s) else 0.0
        return CanonicalBurn.of(belief.state, thruster, longest_s, self.warm.units)

    def _burn(
        self, belief: Belief, grid: LegendreGauss, controls: Array, duration_s: float, goal: str
    ) -> Burn:
        return Burn(belief.at_s, duration_s, grid, controls, belief.engine.thrust_n, goal)

    def _perigee_words(self, belief: Belief, burn: Burn | None) -> str:
        if burn is None:
            return "no burn"
        end, _ = self.warm.end_of(belief, burn)
        height_km = (perigee_radius(end) - 1.0) * self.scenario.constants.earth_radius_m / 1e3
        return f"a burn of {burn.duration_s:.2f} s to a perigee of {height_km:.1f} km"


def _closest(found: SearchResult) -> str:
    """What the closest attempt leaves, where there was one."""
    if not found.attempts:
        return "nothing that could be tried"
    return f"{len(found.attempts)} attempts; the best leaves {found.best.violation:.1e} of the conditions"
