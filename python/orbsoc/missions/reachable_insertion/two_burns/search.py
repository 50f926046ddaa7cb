"""The search for two burns: impulses as starts, each flown onto the target orbit, then shortened by convex problems.

Every transfer on the way ends on the target orbit, as flown; only one that the independent integrator confirms counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import (
    ExitReason,
    Iteration,
    Outcome,
    Proposal,
    Rules,
    Solve,
    TrustRules,
    trust_region,
    within_residual,
)
from orbsoc.orbit import PropagationError, elements_from_state
from orbsoc.orbit.array import Array

from ..model.proof import Proof, oblate_coast, proof_of_infeasibility
from ..search.setup import InsertionSetup
from .flight import Sensitivities, lowest_point, sensitivities
from .limits import Limits
from .motion import Motion
from .restoration import REACHED, Restored, restored
from .starts import MANY, as_burns, guesses, revolutions
from .subproblem import Linearised, bend_of, multipliers, problem_about, stepped
from .transfer import Transfer
from .verification import Verification, verify

FLOWN = 6
"""Pairs of impulses that are made into burns and flown onto the target orbit."""
SHORTENED = 3
"""Of these, the shortest, that convex problems shorten: all of them, for two that end alike can end beside a third."""
MORE_FLOWN, MOST_MORE = 2, 12
"""Starts that are flown beyond these for a revolution of the first orbit with J2, and at most."""
APART = 0.25
"""Of a revolution, that ignitions of starts that are shortened lie apart where J2 makes one revolution unlike the next."""
GROWTH = 1.5
"""Factor by which the grid grows when the thrust turns faster than it follows."""
BEYOND = 1.5
"""Factor on the propellant that a transfer may take on the way, so that one that is too long can be shortened."""
NEARLY_ALL = 0.98
"""Of the vehicle's mass, that a transfer may burn on the way."""
UNBOUNDED = 1e4
"""Canonical coast where the scenario names no longest one."""
TOLERANCE = 1e-9
TRUST = TrustRules(radius=0.3, least_gain=1e-7)
SPARE = 1e-6
"""Radius that coasts keep beyond the limit, for what an integrator makes of them."""


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """One run of the sequence, or a start that did not find the orbit: `miss` is the largest of the conditions, and `lowest`
    the least radius between its burns."""

    start: str
    note: str
    outcome: Outcome[Transfer]
    miss: float
    lowest: float = np.inf

    @property
    def transfer(self) -> Transfer:
        return self.outcome.iterate

    @property
    def nodes(self) -> int:
        return self.transfer.grid.size


@dataclass(slots=True)
class Found:
    """What the search came to: every attempt, the one that counts, and its verification."""

    ready: InsertionSetup
    attempts: list[Attempt] = field(default_factory=list)
    best: Attempt | None = None
    verification: Verification | None = None
    proof: Proof | None = None
    interrupted: str = ""

    def consider(self, attempt: Attempt, verification: Verification | None) -> None:
        """Keep the better of this and what was found before: verified, then flown, then closest."""
        if self.best is None or self._rank(attempt, verification) < self._rank(self.best, self.verification):
            self.best, self.verification = attempt, verification

    def _rank(self, attempt: Attempt, verification: Verification | None) -> tuple[float, float]:
        if verification is None:
            return (2.0, attempt.miss) if attempt.miss > REACHED else (1.5, attempt.transfer.burning)
        if verification.verified:
            return (0.0, attempt.transfer.burning)
        return (1.0, float(len(verification.failures)))

    @property
    def status(self) -> PlanStatus:
        if self.interrupted:
            return PlanStatus.INTERRUPTED
        if self.proof is not None:
            return PlanStatus.INFEASIBLE
        if self.verification is None:
            return PlanStatus.NOT_FOUND
        return PlanStatus.VERIFIED if self.verification.verified else PlanStatus.NOT_VERIFIED


def proof_for_two_burns(ready: InsertionSetup) -> Proof | None:
    """Why no two burns reach the target, coasts included; None for no proof."""
    burn, scenario = ready.burn, ready.scenario.burn
    coasts = 2 if scenario.ignition == "free" else 1
    drift = coasts * oblate_coast(ready.scenario.constants.j2) if scenario.coast_j2 else 0.0
    return proof_of_infeasibility(burn, ready.target, burn.longest, coasts=True, drift=drift)


def limits_of(ready: InsertionSetup) -> Limits:
    """What the scenario allows, and of the propellant somewhat more, for the way."""
    burn, scenario = ready.burn, ready.scenario
    ignition = ready.latest_ignition_s / ready.units.time_s if scenario.burn.ignition == "free" else 0.0
    longest = scenario.burn.longest_coast_s
    coast = UNBOUNDED if longest is None else longest / ready.units.time_s
    burning = min(BEYOND * burn.longest, max(burn.longest, NEARLY_ALL / burn.flow))
    lowest = (
        scenario.constants.earth_radius_m + 1e3 * scenario.limits.lowest_altitude_km
    ) / ready.units.length_m
    return Limits(ignition, coast, burning, lowest + SPARE, ready.rate_bound)


@dataclass(frozen=True, slots=True)
class Start:
    """A pair of impulses, made into burns and flown onto the orbit as far as that goes."""

    name: str
    flown: Restored


def flown_starts(ready: InsertionSetup, limits: Limits, count: int) -> list[Start]:
    """The cheapest pairs of impulses as burns that end on the orbit, those that do first, shortest first."""
    motion, speed = Motion.of(ready), ready.units.speed_m_s
    found = []
    for impulses in guesses(motion, ready.target, limits)[:count]:
        first, second = speed * np.linalg.norm(impulses.velocities, axis=1)
        name = f"impulses of {first:.1f} and {second:.1f} m/s, {impulses.flight * ready.units.time_s:.0f} s apart"
        made = as_burns(ready.burn, limits, impulses, ready.scenario.method.nodes)
        found.append(Start(name, restored(motion, ready.target, limits, made)))
    return sorted(found, key=lambda each: (not each.flown.reaches, each.flown.transfer.burning))


@dataclass(frozen=True, slots=True)
class Search:
    """How transfers are sought: the solver of the subproblems, the rules of the sequence, and what sees its iterations."""

    solve: Solve
    rules: Rules
    callback: Callable[[Iteration], None] | None = None

    def run(self, ready: InsertionSetup) -> Found:
        """The shortest two burns found, verified where the flight confirms them; Ctrl-C ends it with what it has."""
        found = Found(ready)
        found.proof = proof_for_two_burns(ready)
        if found.proof is None:
            try:
                self._run(ready, found)
            except KeyboardInterrupt:
                found.interrupted = "interrupted in the search for two burns"
        return found

    def _run(self, ready: InsertionSetup, found: Found) -> None:
        limits = limits_of(ready)
        turns = revolutions(Motion.of(ready), limits.ignition)
        apart = APART * limits.ignition / turns if turns > MANY else 0.0
        shortened: list[float] = []
        for start in flown_starts(ready, limits, FLOWN + int(min(MORE_FLOWN * (turns - 1.0), MOST_MORE))):
            ignition = float(start.flown.transfer.coasts[0])
            if not start.flown.reaches:
                miss = start.flown.miss
                message = f"corrected in flight, the burns miss the orbit by {miss:.1e}"
                outcome = Outcome(ExitReason.INFEASIBLE, start.flown.transfer, (), message)
                found.attempts.append(
                    Attempt(start.name, "corrected in flight", outcome, miss, start.flown.lowest.radius)
                )
                found.consider(found.attempts[-1], None)
            elif len(shortened) < SHORTENED and all(abs(ignition - each) >= apart for each in shortened):
                self._shorten(ready, limits, found, start)
                shortened.append(ignition)
            if found.interrupted:
                return

    def _shorten(self, ready: InsertionSetup, limits: Limits, found: Found, start: Start) -> None:
        """From one start, on finer grids while the thrust turns faster than they follow."""
        most = ready.scenario.method.max_nodes
        transfer: Transfer | None = start.flown.transfer
        note = "two burns shortened"
        while transfer is not None:
            outcome = self._descended(ready, limits, transfer)
            attempt = Attempt(start.name, note, outcome, 0.0)
            found.attempts.append(attempt)
            if outcome.reason is ExitReason.INTERRUPTED:
                found.interrupted = outcome.message
                return
            verification = fly_and_verify(ready, outcome.iterate)
            found.consider(attempt, verification)
            if verification is None or verification.verified or attempt.nodes >= most:
                return
            note = f"refined: {verification.failures[0]}"
            finer = outcome.iterate.resampled(min(most, int(np.ceil(GROWTH * attempt.nodes))))
            moved = restored(Motion.of(ready), ready.target, limits, finer)
            transfer = moved.transfer if moved.reaches else None

    def _descended(self, ready: InsertionSetup, limits: Limits, start: Transfer) -> Outcome[Transfer]:
        motion, target = Motion.of(ready), ready.target
        unit = start.burning
        known: Array | None = None
        flown: Restored | None = None
        held = False  # whether a step led too low, from which on the problems know the limit

        def propose(reference: Transfer, radius: float) -> Proposal[Transfer]:
            nonlocal known
            same = flown is not None and flown.transfer is reference
            found = flown.found if flown is not None and same else sensitivities(motion, reference)
            at = Linearised.about(reference, found)
            bend = np.zeros((4, 4)) if known is None else bend_of(motion, target, at, known)
            lowest = lowest_point(motion, reference, found) if held else None
            builder, problem = problem_about(at, target, limits, radius, bend, lowest)
            solution = self.solve(problem, Settings(tol=TOLERANCE))
            figures = _figures(ready, reference, found)
            row = Iteration(1, TOLERANCE, problem, solution, figures=figures)
            if not within_residual(solution, self.rules.usable_residual):
                return Proposal(None, 0.0, 0.0, (row,))
            known = multipliers(builder, solution, at, target)
            new, distance = stepped(builder, solution, at)
            return Proposal(new, new.burning / unit, distance, (row,))

        def restore(transfer: Transfer) -> Transfer | None:
            nonlocal flown, held
            flown = restored(motion, target, limits, transfer)
            held |= flown.held
            return flown.transfer if flown.reaches else None

        return trust_region(
            start,
            propose,
            restore,
            lambda transfer: transfer.burning / unit,
            rules=replace(TRUST, max_iterations=max(self.rules.max_iterations, TRUST.max_iterations)),
            callback=self.callback,
        )


def fly_and_verify(ready: InsertionSetup, transfer: Transfer) -> Verification | None:
    """The flight of a transfer that the propellant allows; None where it does not, or where it cannot be flown."""
    if transfer.burning > ready.burn.longest:
        return None
    end = sensitivities(Motion.of(ready), transfer).end
    try:
        return verify(ready.scenario, ready.target, transfer, end)
    except (PropagationError, ValueError):
        return None


def _figures(ready: InsertionSetup, transfer: Transfer, found: Sensitivities) -> dict[str, float]:
    """The columns of the iteration table that are this mission's own; of the reference."""
    end = ready.units.state_to_si(found.end)
    orbit = elements_from_state(end[:3], end[3:], ready.scenario.constants)
    return {
        "nodes": transfer.grid.size,
        "time_of_flight_s": transfer.burning * ready.units.time_s,
        "perigee_height_km": orbit.perigee_height_m() / 1e3,
        "apogee_height_km": orbit.apogee_height_m() / 1e3,
    }
