"""What is said of a plan of two burns: the lines *Answer*, *Option* and *Optimum*, and the same in sentences."""

from __future__ import annotations

from typing import Any

import numpy as np

from orbsoc.guidance.claims import Kind
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.verdict import Question, Verdict, VerdictLine, Word
from orbsoc.orbit import CanonicalUnits

from ..record.words import (
    Phrases,
    Violation,
    answer_line,
    optimum_line,
    rate_in_words,
    sentences,
    start_tried,
    worst_first,
)
from ..search.setup import InsertionSetup
from ..targets.rows import Row
from ..verification import shape_of, short_shape
from .flight import sensitivities
from .motion import Motion
from .restoration import REACHED
from .search import Attempt
from .transfer_plan import TransferPlan
from .turning import turn_rates


def verdict_of(plan: TransferPlan) -> Verdict:
    """*Answer*, what one burn would do where it is enough, and *Optimum*."""
    return Verdict.of([_answer(plan), *(_found(plan) if plan.status is PlanStatus.VERIFIED else ())])


def _answer(plan: TransferPlan) -> VerdictLine:
    verified = closest = ""
    if plan.verification is not None:
        first, second = plan.burns
        shape = short_shape(plan.verification.planned_orbit)
        verified = f"burns {first.duration_s:.3f} + {second.duration_s:.3f} s → {shape}"
    elif plan.best is not None:
        left = violations(plan)
        worst = f"closest leaves {left[0].words}" if left else f"burns take {plan.time_of_flight_s:.1f} s"
        closest = f"{len(starts_tried(plan))} starts; the {worst}"
    return answer_line(plan, verified, closest, _proved_for(plan))


def _proved_for(plan: TransferPlan) -> str:
    """The class of a proof of infeasibility."""
    burns = (
        "two burns and their coasts with J2"
        if plan.scenario.burn.coast_j2
        else "any number of burns and coasts"
    )
    return f"{burns} above the ground"


def _found(plan: TransferPlan) -> tuple[VerdictLine, ...]:
    tried = len(starts_tried(plan))
    figure = f"a local optimum, {plan.delta_v_m_s:.1f} m/s; the best of {tried} starts"
    class_ = "two burns onto the target orbit, less than a revolution apart"
    evidence = (
        f"{len(plan.subproblems)} conic problems from {tried} pairs of impulses, the cheapest of a grid"
    )
    optimum = optimum_line(Kind.BEST_FOUND, figure, class_, evidence)
    if not plan.one_is_enough:
        return (optimum,)
    one = {"burn.count": "1", "burn.ignition": "free"}
    return (VerdictLine(Question.OPTION, Word.POSSIBLE, "one burn is enough", settings=one), optimum)


def verdict(plan: TransferPlan) -> str:
    """One or two sentences."""
    tried = len(starts_tried(plan))
    sought = f"two burns that end on the target orbit were found from {tried} start{'s' if tried > 1 else ''}"
    if plan.best is None:
        sought = (
            "pair of impulses within the limits on ignition and coast leads to the target above the ground"
        )
    return sentences(
        plan,
        Phrases(
            achievement="" if plan.verification is None else _achievement(plan),
            flown="coasts and burns end",
            nodes="" if plan.best is None else f"{plan.best.nodes} nodes a burn",
            oblate="J2 acts on the coasts, and not on the burns",
            objection="",
            option=_slew(plan) + _one_is_enough(plan),
            which="burns, however steered and whenever begun",
            proved_for=_proved_for(plan),
            sought=sought,
            left=_left(plan),
            advice=_what_to_try(plan),
        ),
    )


def violations(plan: TransferPlan) -> tuple[Violation, ...]:
    """Terminal rows that the closest transfer leaves violated, worst first; empty where one ends on the orbit."""
    return () if plan.best is None else violations_of(plan, plan.best)


def violations_of(plan: TransferPlan, attempt: Attempt) -> tuple[Violation, ...]:
    """The same of any attempt."""
    ready, found = InsertionSetup.of(plan.scenario), []
    if attempt.miss > REACHED:
        end = sensitivities(Motion.of(ready), attempt.transfer).end
        for row, value in plan.target.misses(end):
            found.append(Violation(row, value, plan.target.words(row, value, end, (1.0, 1.0))))
        low_km = (attempt.lowest * ready.units.length_m - plan.scenario.constants.earth_radius_m) / 1e3
        short_km = plan.scenario.limits.lowest_altitude_km - low_km
        if short_km > 0.0:
            words = f"the coast between the burns at {low_km:.4g} km, {short_km:.4g} below limits.lowest_altitude_km"
            found.append(Violation(Row.COAST_ALTITUDE, 1e3 * short_km / ready.units.length_m, words))
    if ready.rate_bound is not None:
        over = float(turn_rates(attempt.transfer).max()) - ready.rate_bound
        if over > 0.0:
            found.append(Violation(Row.ATTITUDE_RATE, over, rate_in_words(plan.scenario, over)))
    return worst_first(found, REACHED)


def starts_tried(plan: TransferPlan) -> list[dict[str, Any]]:
    """Every start of the search, in its order: how its last attempt ended, and the worst row that it left."""
    last = {attempt.start: attempt for attempt in plan.attempts}
    time_s = CanonicalUnits.of(plan.scenario.constants).time_s
    return [
        start_tried(
            start,
            float(attempt.transfer.coasts[0]) * time_s,
            attempt.outcome.reason,
            violations_of(plan, attempt),
        )
        for start, attempt in last.items()
    ]


def _achievement(plan: TransferPlan) -> str:
    assert plan.verification is not None
    first, second = plan.burns
    ignition = f" after a coast of {plan.ignition_s:.1f} s" if plan.scenario.burn.ignition == "free" else ""
    return (
        f"the two shortest burns found onto the target orbit, {shape_of(plan.verification.planned_orbit)}, take"
        f" {first.duration_s:.3f} s{ignition} and, {plan.coast_s:.1f} s later, {second.duration_s:.3f} s: together"
        f" {plan.time_of_flight_s:.3f} s, {plan.propellant_kg:.1f} kg of propellant and {plan.delta_v_m_s:.1f} m/s,"
        f" in {plan.total_time_s:.0f} s"
    )


def _slew(plan: TransferPlan) -> str:
    """How fast the thrust turns between the burns, where that is faster than their bound."""
    found, bound = plan.verification, plan.scenario.limits.attitude_rate_deg_s
    if found is None or bound is None or not np.rad2deg(found.slew_rad_s) > bound:
        return ""
    slew = f"the slew between the burns takes {np.rad2deg(found.slew_rad_s):.4g} °/s"
    return f". The bound is for the burns alone; {slew}"


def _one_is_enough(plan: TransferPlan) -> str:
    if not plan.one_is_enough:
        return ""
    return ". One of them came out as nothing, so that one burn is enough: --set burn.count=1 --set burn.ignition=free"


def _left(plan: TransferPlan) -> str:
    if plan.best is None:
        return ""
    found, longest_s = violations(plan), plan.scenario.vehicle.longest_burn_s
    if found:
        return f"The closest ones leave {found[0].words}"
    if plan.time_of_flight_s > longest_s:
        return f"The shortest ones found take {plan.time_of_flight_s:.1f} s, and the propellant lasts for {longest_s:.1f} s"
    return "The closest ones could not be flown by the independent integrator"


def _what_to_try(plan: TransferPlan) -> str:
    burn = plan.scenario.burn
    if burn.ignition == "now":
        return "try --set burn.ignition=free, a nearer target, or more propellant"
    if burn.longest_coast_s is not None or burn.latest_ignition_s is not None:
        return "try a later burn.latest_ignition_s, a longer burn.longest_coast_s, a nearer target, or more propellant"
    return "try a nearer target, or more propellant"
