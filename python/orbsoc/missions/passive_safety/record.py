"""A plan as plain data: the document behind `plan.json`, what is told beside the verdict, and CCSDS messages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from math import isfinite
from typing import Any

from orbsoc.guidance.chaser_messages import two_body_messages
from orbsoc.guidance.safety import CutBurn
from orbsoc.orbit import EARTH

from .paper import compare
from .planner import ApproachPlan
from .verification import LIMIT_M

STEPS = 120
"""Of the ephemeris."""


def plan_document(plan: ApproachPlan) -> dict[str, Any]:
    """Everything about the plan that JSON can hold; null where nothing was planned or flown."""
    found, programme = plan.verification, plan.programme
    return {
        "mission": plan.scenario.mission,
        "name": plan.scenario.name,
        "status": plan.status.value,
        "exit_reason": plan.exit_reason.name,
        "message": plan.message,
        "details": details(plan),
        "delta_v_m_s": programme and programme.total_m_s,
        "cost": _number(plan.cost),
        "impulses": programme.to_list() if programme else [],
        "terminal_error": found
        and {"position_m": found.terminal_position_m, "velocity_m_s": found.terminal_velocity_m_s},
        "constraints": [asdict(check) for check in found.checks] if found else [],
        "safe_for_all_time": plan.safe if found and plan.approach.guarded else None,
        "safe_when_cut": plan.safe_when_cut if found and plan.approach.guarded else None,
        "audits": _audits(plan),
        "truth": {truth.name: truth.to_dict() for truth in found.truths} if found else {},
        "monte_carlo": {name: flights.to_dict() for name, flights in plan.flights.items()},
        "front": [point.to_dict() for point in plan.front],
        "certificates": _certificates(plan),
        "timing": _timing(plan),
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "paper": [row.to_dict() for row in compare(plan)],
        "target": {
            "mean_motion_rad_s": plan.approach.mean_motion_rad_s,
            "period_s": plan.approach.period_s,
            "altitude_km": (plan.approach.orbit().sma_m - EARTH.earth_radius_m) / 1e3,
        },
        "constants": EARTH.to_dict(),
        "scenario": plan.scenario.model_dump(mode="json"),
    }


def _audits(plan: ApproachPlan) -> dict[str, Any]:
    """By name the least margin, where, and every burn."""
    found = plan.verification
    if found is None or not found.cuts or not plan.approach.guarded:
        return {}
    keep_out = plan.scenario.keep_out_m
    whole = min(found.cuts, key=lambda cut: cut.completed_m)
    audits: dict[str, Any] = {
        "completed_burns": {
            "least_m": whole.completed_m,
            "at_least_m": _least(cut.completed_at_least_m for cut in found.cuts),
            "margin_m": whole.completed_m - keep_out,
            "number": whole.number,
            "after_s": whole.completed_after_s,
        },
        "cut_burns": _cut_audit(found.cuts, keep_out),
    }
    if found.cuts_within_orbits:
        audits["cut_burns_within_orbits"] = _cut_audit(found.cuts_within_orbits, keep_out)
    return audits


def _cut_audit(cuts: tuple[CutBurn, ...], keep_out: float) -> dict[str, Any]:
    worst = min(cuts, key=lambda cut: cut.distance_m)
    return {
        "least_m": worst.distance_m,
        "at_least_m": _least(cut.at_least_m for cut in cuts),
        "margin_m": worst.distance_m - keep_out,
        "number": worst.number,
        "fraction": worst.fraction,
        "after_s": worst.after_s,
        "burns": [cut.to_dict() for cut in cuts],
    }


def _least(bounds: Iterable[float | None]) -> float | None:
    """None where one of them is not known."""
    found = list(bounds)
    return None if None in found else min(each for each in found if each is not None)


def _certificates(plan: ApproachPlan) -> dict[str, Any]:
    """The solver's dual bound for the times of the plan; for all candidate times, where the plan was generated from them."""
    if plan.timed is None or plan.timed.best is None:
        return {}
    solution, densest = plan.timed.best.solution, plan.timed.densest
    bound = plan.timed.lower_bound or solution.dual_objective
    found = {"optimum": {"bound": bound, "gap": solution.objective - bound}}
    if densest is not None:
        least = plan.timed.later or densest.solution.dual_objective
        found["impulses"] = {"bound": least, "gap": solution.objective - least}
    return found


def _timing(plan: ApproachPlan) -> dict[str, Any] | None:
    """The scan of the second impulse's time; null without one."""
    timed = plan.timed
    if timed is None or not timed.scanned:
        return None
    scan = timed.trials[: timed.scanned]
    return {
        "second_s": timed.best and timed.best.second_s,
        "wells": timed.wells,
        "scan": [{"second_s": trial.second_s, "cost": _number(trial.cost)} for trial in scan],
    }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


def details(plan: ApproachPlan) -> str:
    """What the lines of the verdict have no room for: what is broken, and every burn that must not stop inside."""
    found = plan.verification
    if found is None:
        return plan.message
    words = [*found.failures]
    if plan.approach.guarded:
        words += [
            f"burn {cut.number} cut at {100.0 * cut.fraction:.3g} % leads to {cut.distance_m:.1f} m,"
            f" {cut.after_s / 3600.0:.1f} h later"
            for cut in found.cuts
            if cut.distance_m < plan.scenario.keep_out_m - LIMIT_M
        ]
    if isfinite(plan.nearest_with_j2_m):
        words.append(f"with J2 the drifts come within {plan.nearest_with_j2_m:.1f} m in an orbit")
    return "; ".join(words) or plan.message


def messages(plan: ApproachPlan) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a plan, by two-body motion; empty without a programme."""
    approach = plan.approach
    return two_body_messages(
        plan.scenario.name, plan.programme, approach.start, approach.orbit(),
        duration_s=approach.duration_s, steps=STEPS, epoch_utc=plan.scenario.target.epoch_utc,
    )  # fmt: skip
