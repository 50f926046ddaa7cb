"""The verdict of a plan as lines: *Answer*, *Option* and *Optimum*."""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word, shortened
from orbsoc.orbit import EARTH, CanonicalUnits, Elements

from ..model.proof import Proof
from ..scenario import MOST_NODES, Scenario
from ..search.ignition import later_ignition
from ..two_burns.instead import two_burns_instead
from ..verification import EndOfFlight
from .burn_plan import BurnPlan
from .claims import Claim
from .verdicts import in_words, starts_tried, violations


def verdict_of(plan: BurnPlan) -> Verdict:
    """The lines of a plan with one burn."""
    optimum = _optimum(plan) if plan.status is PlanStatus.VERIFIED else None
    return Verdict.of([_answer(plan), _later(plan) or _two_burns(plan), optimum])


def fitted(question: Question, word: Word, figure: str, evidence: str = "") -> VerdictLine:
    """A line whose figure, made elsewhere, ends with a clause; the sentences of the plan have the rest."""
    return VerdictLine(question, word, shortened(figure), evidence=evidence)


def flown_within(scenario: Scenario, found: EndOfFlight) -> str:
    """The larger of the two errors of a flight, in parts of what is allowed."""
    rules = scenario.verification
    error, allowed = max(
        (found.angular_momentum_rel, rules.angular_momentum_rel),
        (found.laplace_rel, rules.laplace_rel),
        key=lambda each: each[0] / each[1],
    )
    return f"flown to {error:.0e} ≤ {allowed:.0e}".replace("e-0", "e-")


def short_shape(orbit: Elements) -> str:
    """Perigee and apogee heights; of a hyperbola C3."""
    if orbit.ecc < 1.0:
        return f"{orbit.perigee_height_m() / 1e3:.2f} × {orbit.apogee_height_m() / 1e3:.2f} km"
    return f"C3 {-EARTH.mu_m3_s2 / orbit.sma_m / 1e6:.4f} km²/s²"


def infeasible_line(proof: Proof) -> VerdictLine:
    """What the target needs more of than the vehicle has."""
    speed = CanonicalUnits.of(EARTH).speed_m_s
    has, needs = speed * proof.available, speed * proof.needed
    figure = f"{proof.what} takes {needs:.1f} m/s, there are {has:.1f} m/s"
    return fitted(Question.ANSWER, Word.INFEASIBLE, figure, "proved")


def not_verified_line(scenario: Scenario, found: EndOfFlight) -> VerdictLine:
    """The first tolerance that a flight does not meet, and what to try."""
    most = scenario.method.max_nodes
    advice = f"try method.max_nodes above {most}" if most < MOST_NODES else ""
    return fitted(Question.ANSWER, Word.NOT_VERIFIED, f"do not fly: {found.failures[0]}", advice)


def _answer(plan: BurnPlan) -> VerdictLine:
    found, status = plan.verification, plan.status
    if status is PlanStatus.VERIFIED and found is not None:
        if plan.time_of_flight_s == 0.0:
            return fitted(Question.ANSWER, Word.VERIFIED, "burn 0 s: the vehicle is on its target orbit")
        coast = f"coast {plan.ignition_s:.0f} s, " if plan.ignition_s > 0.0 else ""
        figure = f"{coast}burn {plan.time_of_flight_s:.3f} s → {short_shape(found.planned_orbit)}"
        return fitted(Question.ANSWER, Word.VERIFIED, figure, flown_within(plan.scenario, found))
    if status is PlanStatus.NOT_VERIFIED and found is not None:
        return not_verified_line(plan.scenario, found)
    if plan.proof is not None and status is PlanStatus.INFEASIBLE:
        return infeasible_line(plan.proof)
    if status is PlanStatus.NOT_FOUND:
        left = violations(plan)
        tried = len(starts_tried(plan))
        worst = left[0].words if left else "a flight through the ground"
        figure = f"{tried} start{'s' if tried > 1 else ''}; the closest leaves {worst}"
        return fitted(Question.ANSWER, Word.NOT_FOUND, figure)
    return fitted(Question.ANSWER, Word[status.name], plan.message)


def _later(plan: BurnPlan) -> VerdictLine | None:
    later = later_ignition(plan)
    if later is None:
        return None
    saved = 1.0 - later.burn_s / plan.time_of_flight_s
    word, figure = (
        Word.CHEAPER,
        f"with ignition free the burn takes {later.burn_s:.1f} s (−{100.0 * saved:.0f} %)",
    )
    if plan.status is not PlanStatus.VERIFIED:
        word, figure = (
            Word.POSSIBLE,
            f"{in_words(later.ignition_s)} later a burn of {later.burn_s:.1f} s reaches it",
        )
    return VerdictLine(Question.OPTION, word, figure, settings={"burn.ignition": "free"})


def _two_burns(plan: BurnPlan) -> VerdictLine | None:
    found = two_burns_instead(plan)
    if found is None:
        return None
    figure = f"two burns of {found.first_s:.1f} and {found.second_s:.1f} s reach it"
    return VerdictLine(Question.OPTION, Word.POSSIBLE, figure, settings={"burn.count": "2"})


def _optimum(plan: BurnPlan) -> VerdictLine:
    found, nodes = plan.verification, plan.trajectory.grid.size
    assert found is not None
    peak = f"{np.rad2deg(found.peak_rate_rad_s):.4g} °/s"
    claim = plan.claim
    if claim is Claim.NOTHING_TO_BURN:
        return fitted(Question.OPTIMUM, Word.PROVED, "no burn is shorter than 0 s")
    if claim is Claim.FAST_TURN:
        figure = f"turns at up to {peak}, as {nodes} nodes follow; the shortest burn turns faster"
    elif claim is Claim.SMOOTH_TURN:
        figure = f"turns smoothly; the shortest burn turns faster than {nodes} nodes follow"
    elif plan.scenario.limits is not None:
        figure = f"a local optimum; turns at up to {peak}, allowed {plan.scenario.limits.attitude_rate_deg_s:g} °/s"
    else:
        figure = f"a local optimum of {len(plan.subproblems)} conic problems on {nodes} nodes"
    return fitted(Question.OPTIMUM, Word.BEST_FOUND, figure)
