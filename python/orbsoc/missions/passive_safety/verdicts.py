"""The answer in words: safe for all time, also if a burn stops half-way, and at what distance."""

from __future__ import annotations

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.safety import CutBurn

from .plan import ApproachPlan
from .verification import LIMIT_M


def verdict(plan: ApproachPlan) -> str:
    """One or two sentences without a full stop."""
    if plan.verification is None or plan.programme is None:
        return f"{plan.status.name.replace('_', ' ')}: {plan.message}"
    spent = f"{plan.status.name.replace('_', ' ')}: {plan.programme.words}"
    if plan.scenario.cost == "absolutes":
        spent += f", {plan.cost:.4f} m/s by thrusters along the axes"
    broken = "".join(f"; {words}" for words in plan.verification.failures)
    if not plan.approach.guarded:
        return f"{spent}{broken}; no keep-out was asked for"
    return f"{safety(plan)}; {cut_burns(plan)}. {spent}{broken}{flights(plan)}"


def safety(plan: ApproachPlan) -> str:
    """Of completed burns."""
    keep_out, span = plan.scenario.keep_out_m, "for all time" if plan.approach.circular else "for one orbit"
    nearest = f"{plan.nearest_m:.2f} m from the target at the nearest, keep-out {keep_out:g} m"
    if plan.safe:
        return f"SAFE {span} after every completed burn ({nearest})"
    worst = min(plan.verification.cuts, key=lambda cut: cut.completed_m) if plan.verification else None
    number = worst.number if worst else 0
    samples = " but at the samples asked for" if plan.status is PlanStatus.VERIFIED else ""
    return f"NOT SAFE {span} after burn {number} ({nearest}){samples}"


def cut_burns(plan: ApproachPlan) -> str:
    """Of burns that stop inside."""
    assert plan.verification is not None
    cuts, keep_out = plan.verification.cuts, plan.scenario.keep_out_m
    if plan.safe_when_cut:
        return "also if any burn stops half-way or anywhere else"
    worst = min(cuts, key=lambda cut: cut.distance_m)
    others = [str(cut.number) for cut in cuts if cut.distance_m < keep_out - LIMIT_M and cut is not worst]
    words = f"NOT if burn {worst.number} stops inside: {where(worst)}"
    if others:
        words += f"; burn{'s' if len(others) > 1 else ''} {' and '.join(others)} neither"
    orbits, within = plan.scenario.interruption_orbits, plan.verification.cuts_within_orbits
    if orbits and all(cut.distance_m >= keep_out - LIMIT_M for cut in within):
        nearest = min(cut.distance_m for cut in within)
        span = "the first orbit" if orbits == 1 else f"the first {orbits} orbits"
        return f"for {span} wherever a burn stops ({nearest:.2f} m), after that {words}"
    return words


def flights(plan: ApproachPlan) -> str:
    """Of the Monte Carlo; empty without."""
    found = plan.flights.get("re_planned")
    if found is None:
        return ""
    words = f"; {found.unsafe} of {found.runs} flights with errors enter the keep-out when re-planned before every burn"
    given = found.fallbacks + found.failed
    return f"{words}, {given} of {found.replans} re-plans could not keep the margins"


def where(cut: CutBurn) -> str:
    """How near the drift comes when a burn stops in the middle, and where it is worst."""
    hours = cut.after_s / 3600.0
    later = f"{hours:.1f} h" if hours < 100.0 else f"{hours / 24.0:.0f} days"
    worst = f"{cut.distance_m:.1f} m from the target at {100.0 * cut.fraction:.3g} % of it, {later} later"
    return f"{worst}, {cut.half_m:.1f} m at 50 %"
