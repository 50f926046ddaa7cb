"""The search for the burn: the present start, then starts that are flown onto the target, and what each is worth.

Every result is flown by an integrator of its own before it counts. The order of the starts is fixed, so that a scenario has
one answer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.scp import ExitReason, Iteration, Outcome, Rules, Solve, sequential_convex
from orbsoc.orbit import PropagationError

from ..model.problems import Iterate
from ..model.proof import Proof, proof_of_infeasibility
from ..plan.burn_plan import COLD, Stage
from ..plan.claims import Claim
from ..starts.directions import REACHED, Start, impulse, starts
from ..starts.steering_law import TOO_LONG, Law, corrected, grid_resolves, smoothed, through, unit_on
from ..verification import Verification
from .found import Found
from .setup import InsertionSetup

GROWTH = 1.5
"""Factor by which the grid grows when the propagation does not confirm a plan."""
NULL = "no start: the vehicle is on its target orbit"
SLACK_LEFT = 1e-5
"""Total slack of a sequence that ended short of convergence, but near enough to be corrected in flight."""
MOST_FLOWN = 2
"""Starts that reach the target orbit, after which others would lead to the same burn."""
SMOOTH_NOTE = "a law that turns smoothly, shortened"
WORTH_A_LAW = 1e-3
"""Share by which a verified burn may be longer than a converged sequence's before a smooth law is tried beside it."""
SMOOTHED = 6
"""Coefficients that are kept of thrust that reverses faster than a grid follows."""
REVERSES = 0.02
"""max‖u‖ − 1 between nodes, from which on finer grids are not worth the trouble: the thrust reverses."""


@dataclass(frozen=True, slots=True)
class Search:
    """How burns are sought: the solver of the subproblems, the rules of the sequence, and what sees its iterations."""

    solve: Solve
    rules: Rules
    callback: Callable[[Iteration], None] | None = None

    def run(self, ready: InsertionSetup) -> Found:
        """Every start until one is verified, the shortest verified burn; Ctrl-C ends it with what it has."""
        found = Found(ready)
        try:
            self._run(ready, found)
        except KeyboardInterrupt:
            found.interrupted = "interrupted in the search for a start"
        if found.best is None:
            found.consider(*_nothing(ready))
        return found

    def _run(self, ready: InsertionSetup, found: Found) -> None:
        for strategy in STRATEGIES:
            if found.interrupted or found.verified or found.proof is not None:
                return
            if strategy.applies(ready, found):
                strategy.attempt(self, ready, found)

    def _cold(self, ready: InsertionSetup, found: Found) -> None:
        """The present start, refined until its flight confirms it."""
        stage = self._stage(ready, found, ready.cold_start(), "cold start")
        soft = False
        if stage.outcome.reason is ExitReason.SUBPROBLEM_INFEASIBLE and ready.free_perigee:
            soft, note = True, "restart with slack: a subproblem was infeasible"
            stage = self._stage(ready, found, ready.cold_start(), note, soft=soft)
        verification = _flown(ready, stage)
        found.consider(stage, verification)
        self._refine(ready, found, stage, verification, soft=soft)

    def _refine(
        self,
        ready: InsertionSetup,
        found: Found,
        stage: Stage,
        verification: Verification | None,
        *,
        soft: bool = False,
        firm: bool = False,
    ) -> None:
        """Finer grids, each from the flight of the one before, until the flight confirms the plan."""
        most = ready.scenario.method.max_nodes
        while verification is not None and not verification.verified and stage.nodes < most:
            if firm and verification.thrust_excess > REVERSES and stage.nodes > ready.scenario.method.nodes:
                return
            nodes = min(most, int(np.ceil(GROWTH * stage.nodes)))
            reference = ready.resampled(stage.outcome.iterate, nodes)
            note = f"refined: {verification.failures[0]}"
            stage = self._stage(ready, found, reference, note, soft=soft, firm=firm, start=stage.start)
            if found.interrupted:
                return
            verification = _flown(ready, stage)
            if firm and (verification is None or not verification.verified):
                stage, verification = _corrected(ready, found, stage)
            if verification is None:  # the coarser plan, and what is wrong with it, is the better answer
                return
            found.consider(stage, verification)

    def run_from(self, ready: InsertionSetup, start: Start) -> Found:
        """From one start that reaches the target orbit, on one grid: for many neighbouring burns."""
        found = Found(ready)
        self._law(ready, found, start, refine=False)
        return found

    def _laws(self, ready: InsertionSetup, found: Found) -> None:
        """Starts that are flown onto the target orbit, until one is verified."""
        flown = 0
        for start in starts(ready.burn, ready.target):
            if start.reaches:
                self._law(ready, found, start, refine=flown == 0)
                flown += 1
                if flown == MOST_FLOWN:
                    return
            else:
                found.stages.append(_missed(ready, start))
                found.consider(found.stages[-1], None)
            if found.verified or found.interrupted:
                return

    def _law(self, ready: InsertionSetup, found: Found, start: Start, *, refine: bool) -> None:
        reference = replace(ready.by_law(start.law, ready.scenario.method.nodes), slack=())
        stage = self._stage(ready, found, reference, start.name, firm=True, start=start.name)
        if found.interrupted:
            return
        verification = _flown(ready, stage)
        if verification is None or not verification.verified:
            found.consider(stage, verification)
            stage, verification = _corrected(ready, found, stage)
        found.consider(stage, verification)
        if refine and not found.verified:
            self._refine(ready, found, stage, verification, firm=True)
        if not found.interrupted and _not_the_shortest(found):
            _follow_law(ready, found, start)

    def _directions(self, ready: InsertionSetup, found: Found) -> None:
        """Constant directions for the scenario's burn time."""
        velocity = ready.burn.start[3:]
        towards = impulse(ready.burn, ready.target)
        for name, direction in (
            ("thrust towards the target's velocity", towards),
            ("thrust against the velocity", -velocity),
        ):
            if float(np.linalg.norm(direction)) < 1e-6:
                continue
            stage = self._stage(ready, found, ready.along(direction), name, soft=True, start=name)
            if found.interrupted:
                return
            verification = _flown(ready, stage)
            found.consider(stage, verification)
            self._refine(ready, found, stage, verification, soft=True)
            if found.verified:
                return

    def _stage(
        self,
        ready: InsertionSetup,
        found: Found,
        reference: Iterate,
        note: str,
        *,
        soft: bool = False,
        firm: bool = False,
        start: str = COLD,
        claim: Claim = Claim.BEST_FOUND,
    ) -> Stage:
        outcome = sequential_convex(
            reference,
            ready.subproblem(soft=soft, firm=firm),
            solve=self.solve,
            rules=self.rules,
            callback=self.callback,
        )
        stage = Stage(reference.trajectory.grid.size, note, outcome, start, ready.ignition_s, claim)
        found.stages.append(stage)
        if outcome.reason is ExitReason.INTERRUPTED:
            found.interrupted = outcome.message
        return stage


def _min_time(ready: InsertionSetup, _found: Found) -> bool:
    return ready.scenario.problem == "min_time"


def _prove(_search: Search, ready: InsertionSetup, found: Found) -> None:
    found.proof = _proof(ready)


@dataclass(frozen=True, slots=True)
class Strategy:
    """One way to a burn: when it applies, what it adds to what was found, and the claims that its attempts may carry."""

    name: str
    applies: Callable[[InsertionSetup, Found], bool]
    run: Callable[[Search, InsertionSetup, Found], object]
    may_claim: frozenset[Claim] = frozenset()

    def attempt(self, search: Search, ready: InsertionSetup, found: Found) -> None:
        """Run it. Raises RuntimeError where one of its attempts carries a claim that it may not make."""
        before, best = len(found.stages), found.best
        self.run(search, ready, found)
        made = found.stages[before:]
        if found.best is not None and found.best is not best:
            made = [*made, found.best]
        for stage in made:
            if stage.claim not in self.may_claim:
                raise RuntimeError(f"the strategy {self.name!r} may not claim {stage.claim.name}")


STRATEGIES = (
    Strategy(
        "nothing to burn",
        _min_time,
        lambda _, ready, found: null_burn(ready, found),
        frozenset({Claim.NOTHING_TO_BURN}),
    ),
    Strategy("cold start", lambda *_: True, Search._cold, frozenset({Claim.BEST_FOUND})),
    Strategy("proof of infeasibility", lambda _, found: found.verification is None, _prove),
    Strategy(
        "laws flown onto the orbit",
        _min_time,
        Search._laws,
        frozenset({Claim.BEST_FOUND, Claim.SMOOTH_TURN}),
    ),
    Strategy(
        "constant directions",
        lambda ready, found: not _min_time(ready, found),
        Search._directions,
        frozenset({Claim.BEST_FOUND}),
    ),
)
"""In their order, until a burn is verified, none is proved to exist, or the search is interrupted."""


def null_burn(ready: InsertionSetup, found: Found) -> bool:
    """Whether the vehicle is on its target orbit: a plan of 0 s."""
    coarse = ready.along(ready.burn.start[3:]).trajectory
    states = np.tile(ready.burn.start, (coarse.grid.size, 1))
    still = replace(coarse, states=states, end=ready.burn.start, duration=0.0)
    verification = ready.verified(Iterate(still))
    if not verification.verified:
        return False
    message = "the vehicle is on its target orbit: nothing to burn"
    outcome = Outcome(ExitReason.CONVERGED, Iterate(still), (), message)
    stage = Stage(still.grid.size, NULL, outcome, NULL, claim=Claim.NOTHING_TO_BURN)
    found.consider(stage, verification)
    return True


def _flown(ready: InsertionSetup, stage: Stage) -> Verification | None:
    """The verification of a converged stage; None when there is nothing to fly."""
    if stage.outcome.reason is not ExitReason.CONVERGED:
        return None
    return fly_and_verify(ready, stage.outcome.iterate)


def fly_and_verify(ready: InsertionSetup, iterate: Iterate) -> Verification | None:
    try:
        return ready.verified(iterate)
    except (PropagationError, ValueError):  # it dives to the centre, or burns the vehicle up
        return None


def _corrected(ready: InsertionSetup, found: Found, stage: Stage) -> tuple[Stage, Verification | None]:
    """The stage with its thrust directions corrected until the flight ends on the orbit; the stage itself where that fails."""
    last, outcome = stage.outcome.iterate, stage.outcome
    near = outcome.reason in (ExitReason.CONVERGED, ExitReason.MAX_ITERATIONS, ExitReason.INFEASIBLE)
    if not near or sum(abs(value) for _, value in last.slack) > SLACK_LEFT:
        return stage, None
    arc = last.trajectory
    law, miss = corrected(
        ready.burn, ready.target, through(arc.grid, arc.controls, arc.duration), iterations=8
    )
    if miss > REACHED:
        return stage, _flown(ready, stage)
    message = f"{outcome.message}; the thrust directions were then corrected in flight"
    iterate = ready.by_interpolant(law, stage.nodes)
    moved = replace(
        stage, note="corrected in flight", outcome=Outcome(ExitReason.CONVERGED, iterate, (), message)
    )
    found.stages.append(moved)
    return moved, fly_and_verify(ready, iterate)


def _follow_law(ready: InsertionSetup, found: Found, start: Start) -> None:
    """The law, shortened, on a grid that follows it: a plan where the shortest burn reverses its thrust."""
    if found.best is None:
        return
    arc = found.best.outcome.iterate.trajectory
    drawn = through(arc.grid, arc.controls, arc.duration)
    drawn = replace(drawn, coefficients=drawn.coefficients[:SMOOTHED])
    method = ready.scenario.method
    known = found.best
    for too_long in (TOO_LONG, 0.1 * TOO_LONG):  # the correction on the grid lengthens the interpolant, too
        for first in (drawn, start.law):
            law = smoothed(ready.burn, ready.target, first, method.max_nodes, too_long)
            if law is not None:
                _law_flown(ready, found, law, start)
            if found.verified and found.best is not known:
                return


def _not_the_shortest(found: Found) -> bool:
    """Whether nothing is verified, or something longer than where a sequence converged."""
    if not found.verified:
        return True
    ends = [
        stage.outcome.iterate.trajectory.duration
        for stage in found.stages
        if stage.outcome.reason is ExitReason.CONVERGED and stage.outcome.iterations
    ]
    return bool(ends) and found.iterate.trajectory.duration > (1.0 + WORTH_A_LAW) * min(ends)


def _law_flown(ready: InsertionSetup, found: Found, law: Law, start: Start) -> None:
    """On the coarsest grid that follows it: the interpolant of its nodal directions, corrected and made of unit length by turns."""
    nodes = nodes_that_follow(ready, law)
    unit = unit_on(ready.burn, ready.target, law, nodes, REACHED)
    if unit is None:
        return
    message = (
        "a smooth turn of the thrust reaches the orbit; the shortest burn turns faster than the grid follows"
    )
    outcome = Outcome(ExitReason.CONVERGED, ready.by_interpolant(unit, nodes), (), message)
    found.stages.append(Stage(nodes, SMOOTH_NOTE, outcome, start.name, ready.ignition_s, Claim.SMOOTH_TURN))
    found.consider(found.stages[-1], fly_and_verify(ready, outcome.iterate))


def nodes_that_follow(ready: InsertionSetup, law: Law) -> int:
    """Of the coarsest grid that follows a law, at most the finest allowed."""
    method = ready.scenario.method
    nodes = method.nodes
    while nodes < method.max_nodes and not grid_resolves(law, nodes, 0.1 * TOO_LONG):
        nodes = min(method.max_nodes, int(np.ceil(GROWTH * nodes)))
    return nodes


def _missed(ready: InsertionSetup, start: Start) -> Stage:
    """A start that did not find the orbit, with what it leaves."""
    nodes = ready.scenario.method.nodes
    try:
        iterate = ready.by_law(start.law, nodes)
    except PropagationError:
        iterate = ready.cold_start()
    message = f"{start.name}: corrected in flight, the closest burn misses the orbit by {start.miss:.1e}"
    return Stage(
        nodes, start.name, Outcome(ExitReason.INFEASIBLE, iterate, (), message), start.name, ready.ignition_s
    )


def _nothing(ready: InsertionSetup) -> tuple[Stage, None]:
    """Of a search that was interrupted before its first stage."""
    outcome = Outcome(ExitReason.INTERRUPTED, ready.cold_start(), (), "interrupted")
    return Stage(ready.scenario.method.nodes, "interrupted", outcome), None


def _proof(ready: InsertionSetup) -> Proof | None:
    min_time = ready.scenario.problem == "min_time"
    duration = ready.burn.longest if min_time else ready.scenario.burn.guess_s / ready.units.time_s
    return proof_of_infeasibility(ready.burn, ready.target, duration, whole_orbit=min_time)
