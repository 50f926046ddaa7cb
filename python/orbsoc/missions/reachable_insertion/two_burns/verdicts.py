"""What a plan of two burns says in words: the verdict first, and what to try when it is no plan."""

from __future__ import annotations

from typing import Any

import numpy as np

from orbsoc.guidance.mission import PlanStatus
from orbsoc.orbit import EARTH, CanonicalUnits

from ..plan.verdicts import Violation, rate_in_words, row_in_words, shape_of, start_tried, turns_in_words
from ..scenario import MOST_NODES
from ..search.setup import InsertionSetup
from ..targets.rows import Row
from .flight import sensitivities
from .motion import Motion
from .restoration import REACHED
from .search import Attempt
from .transfer_plan import TransferPlan
from .turning import turn_rates


def verdict(plan: TransferPlan) -> str:
    """One or two sentences."""
    if plan.status is PlanStatus.VERIFIED:
        return f"VERIFIED: {_achievement(plan)}. {_evidence(plan)}{_turns(plan)}{_one_is_enough(plan)}"
    if plan.status is PlanStatus.NOT_VERIFIED:
        return f"NOT VERIFIED, do not fly: {_achievement(plan)}, but {_objection(plan)}"
    if plan.status is PlanStatus.INFEASIBLE:
        return _infeasible(plan)
    if plan.status is PlanStatus.INTERRUPTED:
        return f"INTERRUPTED: {plan.message}; there is no plan"
    return _not_found(plan)


def violations(plan: TransferPlan) -> tuple[Violation, ...]:
    """Terminal rows that the closest transfer leaves violated, worst first; empty where one ends on the orbit."""
    return () if plan.best is None else violations_of(plan, plan.best)


def violations_of(plan: TransferPlan, attempt: Attempt) -> tuple[Violation, ...]:
    """The same of any attempt."""
    ready, found = InsertionSetup.of(plan.scenario), []
    if attempt.miss > REACHED:
        end = sensitivities(Motion.of(ready), attempt.transfer).end
        found = [
            Violation(row, value, row_in_words(plan.target, row, value, end))
            for row, value in plan.target.misses(end)
        ]
    if attempt.miss > REACHED:
        low_km = (attempt.lowest * ready.units.length_m - EARTH.earth_radius_m) / 1e3
        short_km, words = plan.scenario.limits.lowest_altitude_km - low_km, "the coast between the burns at "
        words += f"{low_km:.4g} km, {short_km:.4g} below limits.lowest_altitude_km"
        found += (
            [Violation(Row.COAST_ALTITUDE, 1e3 * short_km / ready.units.length_m, words)]
            if short_km > 0.0
            else []
        )
    if ready.rate_bound is not None:
        over = float(turn_rates(attempt.transfer).max()) - ready.rate_bound
        found += (
            [Violation(Row.ATTITUDE_RATE, over, rate_in_words(plan.scenario, over))] if over > 0.0 else []
        )
    return tuple(
        sorted((each for each in found if abs(each.value) > REACHED), key=lambda each: -abs(each.value))
    )


def starts_tried(plan: TransferPlan) -> list[dict[str, Any]]:
    """Every start of the search, in its order: how its last attempt ended, and the worst row that it left."""
    last = {attempt.start: attempt for attempt in plan.attempts}
    time_s = CanonicalUnits.of(EARTH).time_s
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


def _evidence(plan: TransferPlan) -> str:
    found, best = plan.verification, plan.best
    assert found is not None
    assert best is not None
    return (
        "Flown by an independent integrator, coasts and burns end within"
        f" {found.angular_momentum_rel:.0e} of the promised angular momentum and {found.laplace_rel:.0e} of the"
        f" promised eccentricity vector, on a grid of {best.nodes} nodes a burn"
        f"{'; J2 acts on the coasts, and not on the burns' if plan.scenario.burn.coast_j2 else ''}"
    )


def _turns(plan: TransferPlan) -> str:
    """How fast the thrust turns over the burns, and between them where that is faster than the bound of the burns."""
    found, bound = plan.verification, plan.scenario.limits.attitude_rate_deg_s
    told = turns_in_words(plan.scenario, found)
    if found is None or bound is None or not np.rad2deg(found.slew_rad_s) > bound:
        return told
    slew = f"the slew between the burns takes {np.rad2deg(found.slew_rad_s):.4g} °/s"
    return f"{told}. The bound is for the burns alone; {slew}"


def _one_is_enough(plan: TransferPlan) -> str:
    if not plan.one_is_enough:
        return ""
    return ". One of them came out as nothing, so that one burn is enough: --set burn.count=1 --set burn.ignition=free"


def _objection(plan: TransferPlan) -> str:
    found, most = plan.verification, plan.scenario.method.max_nodes
    assert found is not None
    advice = f"raise method.max_nodes above {most}" if most < MOST_NODES else "no grid allowed is finer"
    return f"the propagation does not confirm it: {'; '.join(found.failures)}; {advice}"


def _infeasible(plan: TransferPlan) -> str:
    proof, speed = plan.proof, CanonicalUnits.of(EARTH).speed_m_s
    assert proof is not None
    oblate = plan.scenario.burn.coast_j2
    for_which = "two burns and their coasts with J2" if oblate else "any number of burns and coasts"
    return (
        "INFEASIBLE: no burns, however steered and whenever begun, reach the target."
        f" {proof.what[0].upper()}{proof.what[1:]} takes more than {speed * proof.needed:.1f} m/s, and the vehicle has"
        f" {speed * proof.available:.1f} m/s. This is a proof for {for_which} above the ground"
    )


def _not_found(plan: TransferPlan) -> str:
    if plan.best is None:
        return (
            "NOT FOUND: no pair of impulses within the limits on ignition and coast leads to the target above the ground."
            f" This is not a proof that there are no burns; {_what_to_try(plan)}"
        )
    found = violations(plan)
    if found:
        left = f"The closest ones leave {found[0].words}"
    elif plan.time_of_flight_s > plan.scenario.vehicle.longest_burn_s:
        left = (
            f"The shortest ones found take {plan.time_of_flight_s:.1f} s, and the propellant lasts for"
            f" {plan.scenario.vehicle.longest_burn_s:.1f} s"
        )
    else:
        left = "The closest ones could not be flown by the independent integrator"
    tried = len(starts_tried(plan))
    return (
        f"NOT FOUND: no two burns that end on the target orbit were found from {tried} start{'s' if tried > 1 else ''}."
        f" {left}. This is not a proof that there are none; {_what_to_try(plan)}"
    )


def _what_to_try(plan: TransferPlan) -> str:
    burn = plan.scenario.burn
    if burn.ignition == "now":
        return "try --set burn.ignition=free, a nearer target, or more propellant"
    if burn.longest_coast_s is not None or burn.latest_ignition_s is not None:
        return "try a later burn.latest_ignition_s, a longer burn.longest_coast_s, a nearer target, or more propellant"
    return "try a nearer target, or more propellant"
