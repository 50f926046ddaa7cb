"""What is said of a plan with one burn: the lines *Answer*, *Option* and *Optimum*, and the same in sentences."""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import ExitReason
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word

from ..record.document import starts_tried, violations
from ..record.words import Phrases, answer_line, fitted, sentences, wait_in_words
from ..search.ignition import later_ignition
from ..search.result import Claim, SearchResult
from ..targets.rows import Row
from ..two_burns.instead import two_burns_instead
from ..verification import Verification, shape_of, short_shape


def verdict_of(plan: SearchResult) -> Verdict:
    """The lines of a plan."""
    optimum = _optimum(plan) if plan.status is PlanStatus.VERIFIED else None
    return Verdict.of([_answer(plan), _later_line(plan) or _two_burns_line(plan), optimum])


def _answer(plan: SearchResult) -> VerdictLine:
    found = plan.verification
    if plan.status is PlanStatus.VERIFIED and plan.time_of_flight_s == 0.0:
        return fitted(Question.ANSWER, Word.VERIFIED, "burn 0 s: the vehicle is on its target orbit")
    coast = f"coast {plan.ignition_s:.0f} s, " if plan.ignition_s > 0.0 else ""
    orbit = "" if found is None else short_shape(found.planned_orbit)
    left, tried = violations(plan), len(starts_tried(plan))
    worst = left[0].words if left else "a flight through the ground"
    return answer_line(
        plan,
        f"{coast}burn {plan.time_of_flight_s:.3f} s → {orbit}",
        f"{tried} start{'s' if tried > 1 else ''}; the closest leaves {worst}",
    )


def _later_line(plan: SearchResult) -> VerdictLine | None:
    later = later_ignition(plan)
    if later is None:
        return None
    free = {"burn.ignition": "free"}
    if plan.status is not PlanStatus.VERIFIED:
        figure = f"{wait_in_words(later.ignition_s)} later a burn of {later.burn_s:.1f} s reaches it"
        return VerdictLine(Question.OPTION, Word.POSSIBLE, figure, settings=free)
    saved = 100.0 * (1.0 - later.burn_s / plan.time_of_flight_s)
    figure = f"with ignition free the burn takes {later.burn_s:.1f} s (−{saved:.0f} %)"
    return VerdictLine(Question.OPTION, Word.CHEAPER, figure, settings=free)


def _two_burns_line(plan: SearchResult) -> VerdictLine | None:
    found = two_burns_instead(plan)
    if found is None:
        return None
    figure = f"two burns of {found.first_s:.1f} and {found.second_s:.1f} s reach it"
    return VerdictLine(Question.OPTION, Word.POSSIBLE, figure, settings={"burn.count": "2"})


def _optimum(plan: SearchResult) -> VerdictLine:
    found, nodes = plan.verification, plan.trajectory.grid.size
    bound = plan.scenario.limits.attitude_rate_deg_s
    assert found is not None
    peak = f"{np.rad2deg(found.peak_rate_rad_s):.4g} °/s"
    figure = f"a local optimum of {len(plan.subproblems)} conic problems on {nodes} nodes"
    if plan.claim is Claim.NOTHING_TO_BURN:
        return fitted(Question.OPTIMUM, Word.PROVED, "no burn is shorter than 0 s")
    if plan.claim is Claim.FAST_TURN:
        figure = f"turns at up to {peak}, as {nodes} nodes follow; the shortest burn turns faster"
    elif plan.claim is Claim.SMOOTH_TURN:
        figure = f"turns smoothly; the shortest burn turns faster than {nodes} nodes follow"
    elif bound is not None:
        figure = f"a local optimum; turns at up to {peak}, allowed {bound:g} °/s"
    return fitted(Question.OPTIMUM, Word.BEST_FOUND, figure)


def verdict(plan: SearchResult) -> str:
    """One or two sentences: what was found, what the propagation says, and what to try when it is no plan."""
    found, scenario = plan.verification, plan.scenario
    if plan.status is PlanStatus.VERIFIED and plan.time_of_flight_s == 0.0:
        return "VERIFIED: the vehicle is on its target orbit already; a burn of 0 s, and nothing to steer"
    largest = scenario.problem == "max_energy"
    burn = f"burn of {plan.time_of_flight_s:.3f} s" if largest else "burn"
    sought = burn
    longest_s = scenario.vehicle.longest_burn_s
    if not largest and plan.time_of_flight_s > 0.97 * longest_s:
        sought += f", even one of all the propellant ({longest_s:.3f} s),"
    tried = len(starts_tried(plan))
    turning = "" if scenario.limits.attitude_rate_deg_s is None else " within the attitude rate"
    option = _later(plan) or _two_burns(plan)
    last = plan.attempts[-1]
    objection = f"; {_later(plan)}" if _later(plan) else ""
    if last.outcome.reason is not ExitReason.CONVERGED:
        objection = f". On {last.nodes} nodes the sequence ended thus: {last.outcome.message}"
    return sentences(
        plan,
        Phrases(
            achievement="" if found is None else _achievement(plan, found),
            flown="the attitude programme ends",
            nodes=f"{plan.trajectory.grid.size} nodes",
            oblate="J2 acts on the coast, and not on the burn",
            objection=objection,
            option=f". {option[0].upper()}{option[1:]}" if option else "",
            which=f"{burn}, however steered",
            proved_for=f"a burn that starts {'now' if plan.ignition_s == 0.0 else 'then'} and stays above the ground",
            sought=f"{sought} that meets all terminal conditions{turning} was found from {tried} start{'s' if tried > 1 else ''}",
            left=f"The closest one leaves {_left(plan, found)}",
            advice=option or _what_to_try(plan),
        ),
    )


def _achievement(plan: SearchResult, found: Verification) -> str:
    shape, time = shape_of(found.planned_orbit), f"{plan.time_of_flight_s:.3f} s"
    burn, target = plan.scenario.burn, plan.scenario.target
    if plan.scenario.problem != "min_time":
        return (
            f"the largest orbit found for a burn of {time} is {shape}, in the target plane"
            f" with the perigee direction {target.perigee_direction}"
        )
    oblate = " with J2" if burn.coast_j2 else ""
    coast = f" after a coast of {plan.ignition_s:.1f} s{oblate}" if burn.ignition == "free" else ""
    grid = f"a grid of {plan.trajectory.grid.size} nodes follows"
    if plan.claim is Claim.FAST_TURN:
        turn = f"turns at up to {np.rad2deg(found.peak_rate_rad_s):.4g} °/s, about as fast as {grid}"
        return f"a burn of {time} onto the target orbit, {shape}, that {turn}; the shortest one turns faster{coast}"
    if plan.claim is Claim.SMOOTH_TURN:
        turn = f"turns smoothly; the shortest one turns faster than {grid}"
        return f"a burn of {time} onto the target orbit, {shape}, that {turn}{coast}"
    return f"the shortest burn found onto the target orbit, {shape}, takes {time}{coast}"


def _left(plan: SearchResult, found: Verification | None) -> str:
    if found is not None and found.below_ground:
        return f"the burn {-found.flight.lowest_altitude_m / 1e3:.1f} km below the ground on its way"
    left = violations(plan)
    if not left:
        return "no row that stands out"
    total = sum(abs(each.value) for each in left)
    return f"{left[0].words}, a total violation of {total:.1e} (canonical units)"


def _later(plan: SearchResult) -> str:
    """What a later ignition would save; empty where none is known."""
    later = later_ignition(plan)
    if later is None:
        return ""
    text = f"with ignition {wait_in_words(later.ignition_s)} later a burn of {later.burn_s:.1f} s reaches the target"
    if plan.status is PlanStatus.VERIFIED:
        saved_s = plan.time_of_flight_s - later.burn_s
        saved_kg, share = (
            plan.scenario.vehicle.mass_flow_kg_s * saved_s,
            100.0 * saved_s / plan.time_of_flight_s,
        )
        text += f" and saves {saved_kg:.1f} kg of propellant ({share:.0f} %)"
    return f"{text}: --set burn.ignition=free"


def _two_burns(plan: SearchResult) -> str:
    """Two burns that reach the target; empty where none are known."""
    found = two_burns_instead(plan)
    if found is None:
        return ""
    wait = f" after a coast of {found.ignition_s:.0f} s" if found.ignition_s > 0.0 else ""
    return (
        f"two burns of {found.first_s:.1f} s{wait} and, {found.coast_s:.0f} s later, {found.second_s:.1f} s reach the target"
        " as flown: --set burn.count=2"
    )


def _what_to_try(plan: SearchResult) -> str:
    if any(row is Row.ATTITUDE_RATE for row, _ in plan.iterate.slack):
        return "allow a faster turn, leave elements of the target free, or let the ignition wait: --set burn.ignition=free"
    if plan.scenario.problem == "max_energy":
        return "try a longer burn.duration_s, another target plane or perigee height, or more method.nodes"
    return "try another burn.duration_s as first guess, a nearer target, or more method.nodes"
