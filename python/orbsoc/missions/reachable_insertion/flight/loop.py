"""The insertion as a closed loop: when guidance plans again, from what it believes, and what the end of a flight is held against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.closed_loop import ON_TARGET, PERIOD, Answer, Decision, FlownCycles, Sensed, Trigger
from orbsoc.guidance.in_flight import loss_complaints
from orbsoc.guidance.outer_loop import OuterLoop
from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.guidance.scp import Solve
from orbsoc.guidance.verdict import VerdictLine
from orbsoc.orbit import angular_momentum
from orbsoc.orbit.array import Array

from ..dispersion import disperse
from ..on_board import what_it_has_not
from ..planner import searched
from ..scenario import Scenario
from ..search.run import SearchResult
from ..targets.target_orbit import TargetOrbit
from ..verification import orbit_of
from .losses import Losses
from .motion import Burn, Engine, flown, steps_to
from .vehicle import FlyingVehicle
from .verdict import verdict_lines
from .warm import Belief, WarmPlanner

EVENT = "thrust lost"
"""The cause of a trigger that the engine's fault gives."""
COLUMNS = {
    ON_TARGET: "",
    "perigee_km": "km",
    "apogee_km": "km",
    "perigee_off_km": "km",
    "apogee_off_km": "km",
    "plane_off_deg": "°",
    "propellant_kg": "kg",
    "cutoff_s": "s",
    "safe": "",
}


@dataclass(frozen=True, slots=True, eq=False)
class InsertionLoop:
    """A scenario with the plan that was made on the ground."""

    scenario: Scenario
    first: Burn
    warm: WarmPlanner
    target: TargetOrbit
    losses: Losses

    @classmethod
    def of(cls, scenario: Scenario, solve: Solve) -> InsertionLoop:
        """Plan on the ground. Raises ScenarioError where there is no loop for the scenario, or no plan to fly."""
        complaints = [
            Complaint(key, "", f"a flight in a closed loop {allowed}")
            for is_wrong, key, allowed in what_it_has_not(scenario)
            if is_wrong
        ]
        if complaints:
            raise ScenarioError(scenario.name, complaints)
        found = searched(scenario, solve)
        if found.interrupted:
            raise KeyboardInterrupt
        if not found.verified:
            allowed = f"no verified plan to set out with: {found.message}"
            raise ScenarioError(scenario.name, [Complaint("target", "", allowed)])
        return cls._about(scenario, found)

    @classmethod
    def _about(cls, scenario: Scenario, found: SearchResult) -> InsertionLoop:
        arc, vehicle = found.trajectory, scenario.vehicle
        first = Burn(0.0, found.time_of_flight_s, arc.grid, arc.controls, vehicle.thrust_n)
        wrong = list(_complaints(scenario, first))
        if wrong:
            raise ScenarioError(scenario.name, wrong)
        warm = WarmPlanner.of(scenario)
        return cls(scenario, first, warm, warm.target, Losses(scenario, warm))

    @property
    def period_s(self) -> float:
        return self.scenario.guidance.period_s

    @property
    def allowance_s(self) -> float:
        return 1e-3 * self.scenario.guidance.allowance_ms

    @property
    def columns(self) -> Mapping[str, str]:
        return COLUMNS

    @property
    def shown(self) -> Sequence[tuple[str, str]]:
        return ("perigee_off_km", "perigee off (km)"), ("apogee_off_km", "apogee off (km)")

    def vehicle(self, seed: int, number: int) -> FlyingVehicle:
        """The dispersed case of that number, with this scenario's field."""
        return FlyingVehicle.of(disperse(self.scenario, number, seed), self.scenario)

    def next_trigger(self, last: Trigger | None, programme: Burn) -> Trigger | None:
        """A period after the last one that came at its time; the fault when it is detected, whatever else is due then; none while
        an engine that will burn again is out."""
        cycle, event = self.scenario.guidance, self.scenario.event
        number, at_s = (0, 0.0) if last is None else (last.number, last.at_s)
        after_s = (
            event.back_s if event is not None and event.known_s <= at_s < event.back_s < np.inf else at_s
        )
        due_s = cycle.period_s * (np.floor(after_s / cycle.period_s + 1e-9) + 1.0)
        found = []
        if event is not None and at_s < event.known_s < programme.end_s:
            found.append(Trigger(number + 1, event.known_s, EVENT, urgent=True))
        if due_s <= programme.end_s - cycle.last_s:
            found.append(Trigger(number + 1, float(due_s), PERIOD))
        return min(found, key=lambda each: each.at_s, default=None)

    def answer(
        self, trigger: Trigger, sensed: Sensed, programme: Burn, solve: Solve, allowance_s: float
    ) -> Answer:
        """From where the vehicle is believed to be when the allowance is over."""
        belief = self._belief(sensed, programme, allowance_s)
        if belief.longest_s <= 0.0:
            return Answer(None, belief.at_s, "there is no time or propellant left for a burn")
        lost = belief.engine.thrust_n < self.scenario.vehicle.thrust_n
        if not lost and belief.at_s >= programme.end_s:
            return Answer(None, belief.at_s, "the burn is over before an answer can be flown")
        around: OuterLoop | None = None
        resumes = trigger.cause == EVENT and not lost
        if resumes:  # the same attitude, later
            assert self.scenario.event is not None
            out_s = self.scenario.event.back_s - self.scenario.event.at_s
            programme = replace(programme, start_s=programme.start_s + out_s)
        if trigger.cause != EVENT or resumes:
            burn, around = self._again(belief, programme, solve)
            if burn is not None:
                return self._answer(belief, burn, "planned again from the flying burn", around)
        if not lost and not resumes:
            words = "no burn to the target that its own flight confirms"
            return Answer(None, belief.at_s, words, around=around)
        choice = self.losses.decide(belief, programme, solve)
        around = around or choice.around
        last = choice.decisions[-1] if choice.decisions else None
        words = "nothing to decide" if last is None else f"{last.sought}: {last.found}"
        if choice.burn is None:
            return Answer(None, belief.at_s, words, decisions=choice.decisions, around=around)
        return self._answer(belief, choice.burn, words, around, choice.decisions)

    def _again(self, belief: Belief, flying: Burn, solve: Solve) -> tuple[Burn | None, OuterLoop | None]:
        """The flying burn's goal once more, from where it has come, and what was counted around the solves."""
        if belief.engine.thrust_n == 0.0:
            return None, None
        if flying.goal == "perigee":
            return self.losses.highest(belief, flying, solve), None
        planner = self.warm if flying.target is None else self.warm.towards(flying.target)
        found = planner.plan(belief, flying, solve)
        return found.burn, found.around

    def _answer(
        self,
        belief: Belief,
        burn: Burn,
        words: str,
        around: OuterLoop | None,
        decisions: tuple[Decision, ...] = (),
    ) -> Answer:
        return Answer(burn, belief.at_s, words, {"left_s": burn.duration_s}, decisions, around)

    def outcome(self, vehicle: FlyingVehicle, programme: Burn) -> dict[str, float]:
        """The orbit at cut-off, osculating, beside the target's."""
        cycle, orbit = self.scenario.guidance, orbit_of(self.scenario, vehicle.state)
        wanted = orbit_of(self.scenario, self.scenario.launch_inertial(self.scenario.target))
        h = angular_momentum(vehicle.state[:3], vehicle.state[3:])
        perigee, apogee = orbit.perigee_height_m() / 1e3, orbit.apogee_height_m() / 1e3
        off = perigee - wanted.perigee_height_m() / 1e3, apogee - wanted.apogee_height_m() / 1e3
        plane = float(np.rad2deg(self.target.plane_error(h)))
        good = max(map(abs, off)) <= cycle.apsis_km and plane <= cycle.plane_deg
        return {
            ON_TARGET: float(good),
            "perigee_km": perigee,
            "apogee_km": apogee,
            "perigee_off_km": off[0],
            "apogee_off_km": off[1],
            "plane_off_deg": plane,
            "propellant_kg": vehicle.start_kg - vehicle.mass_kg,
            "cutoff_s": vehicle.cutoff_s,
            "safe": float(perigee >= cycle.safe_perigee_km),
        }

    def verdict(self, flown: FlownCycles) -> Sequence[VerdictLine]:
        return verdict_lines(self.scenario, flown)

    def _belief(self, sensed: Sensed, programme: Burn, allowance_s: float) -> Belief:
        """The estimate flown on by the programme, with what guidance knows of the engine."""
        scenario = self.scenario
        event = scenario.event
        back_s = event.back_s if event is not None and event.known_s <= sensed.at_s < event.back_s else np.inf
        until_s = sensed.at_s + allowance_s
        if back_s < np.inf:  # nothing can be flown before
            until_s = max(until_s, back_s)
        mass_kg = self._mass_kg(sensed.at_s)
        state: Array = np.asarray(sensed.estimate)
        begun_s = sensed.at_s
        for end_s in (min(back_s, until_s), until_s):
            if end_s > begun_s:
                engine = self._engine(begun_s)
                times, all_times = steps_to(begun_s, end_s)
                vectors = programme.vectors(all_times).tolist()
                state = np.array(flown(state.tolist(), mass_kg, times, vectors, engine, self.warm.field)[-1])
                mass_kg -= engine.flow_kg_s * (end_s - begun_s)
                begun_s = end_s
        engine = self._engine(sensed.at_s if back_s == np.inf else until_s)
        left_kg = mass_kg - scenario.vehicle.dry_mass_kg
        longest_s = left_kg / engine.flow_kg_s if engine.flow_kg_s > 0.0 else np.inf
        if scenario.guidance.latest_end_s is not None:
            longest_s = min(longest_s, scenario.guidance.latest_end_s - until_s)
        return Belief(until_s, state, mass_kg, engine, longest_s, until_s - sensed.at_s)

    def _engine(self, at_s: float) -> Engine:
        """As it is known: whole until its fault is detected, and when it burns again."""
        vehicle, event = self.scenario.vehicle, self.scenario.event
        if event is None or at_s < event.known_s or at_s >= event.back_s:
            return Engine(vehicle.thrust_n, vehicle.mass_flow_kg_s)
        return Engine(vehicle.thrust_n * event.thrust_kept, vehicle.mass_flow_kg_s * event.flow)

    def _mass_kg(self, at_s: float) -> float:
        """By the flow as it is known."""
        vehicle, event = self.scenario.vehicle, self.scenario.event
        whole_s = at_s
        after_s = 0.0
        if event is not None and at_s >= event.known_s:
            faulty_s = min(at_s, event.back_s) - event.at_s
            whole_s, after_s = at_s - faulty_s, faulty_s * event.flow
        return vehicle.mass_kg - vehicle.mass_flow_kg_s * (whole_s + after_s)


def _complaints(scenario: Scenario, first: Burn) -> list[Complaint]:
    """What a flight contradicts once its burn is known."""
    found = [] if scenario.event is None else list(loss_complaints(scenario.event, first.duration_s))
    latest = scenario.guidance.latest_end_s
    if latest is not None and latest < first.duration_s:
        allowed = f"lies within the burn as planned; must be at least {first.duration_s:.6g}"
        found.append(Complaint("guidance.latest_end_s", f"{latest:g}", allowed))
    return found
