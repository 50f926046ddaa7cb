"""A plan as plain data: the document behind `plan.json`, what is told beside the verdict, and CCSDS messages."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

from orbsoc.guidance.chaser_messages import two_body_messages
from orbsoc.orbit import EARTH

from .planner import ApproachPlan
from .verification.aborts import Abort

STEPS = 160
"""Of the ephemeris."""


def plan_document(plan: ApproachPlan) -> dict[str, Any]:
    """Everything about the plan that JSON can hold; null where nothing was planned or flown."""
    found, programme, flights = plan.verification, plan.programme, plan.flights
    return {
        "mission": plan.scenario.mission,
        "name": plan.scenario.name,
        "status": plan.status.value,
        "exit_reason": plan.exit_reason.name,
        "message": plan.message,
        "details": details(plan),
        "delta_v_m_s": programme and programme.total_m_s,
        "cost": _number(plan.cost),
        "impulses": programme.to_list() if programme and not plan.approach.held else [],
        "thrust": thrust(plan),
        "constraints": [asdict(check) for check in found.checks] if found else [],
        "audits": [cut.to_dict() for cut in found.cuts] if found else [],
        "aborts": [each.to_dict() for each in found.aborts] if found else [],
        "truth": {"j2_drag_corrected": found.corrected.to_dict()} if found else {},
        "drift_with_j2_m": _number(found.drift_with_j2_m) if found else None,
        "errors": _errors(plan),
        "monte_carlo": flights.to_dict() if flights else None,
        "certificates": {"optimum": {"bound": plan.lower_bound, "gap": plan.cost - plan.lower_bound}}
        if plan.lower_bound is not None and programme
        else {},
        "attempts": [
            {
                "side": each.side,
                "reason": each.reason.name,
                "cost": _number(each.reference.cost),
                "found": each.found,
            }
            for each in plan.attempts
        ],
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "target": {
            "mean_motion_rad_s": plan.approach.mean_motion_rad_s,
            "period_s": plan.approach.period_s,
            "altitude_km": (plan.approach.orbit().sma_m - EARTH.earth_radius_m) / 1e3,
        },
        "constants": EARTH.to_dict(),
        "scenario": plan.scenario.model_dump(mode="json"),
    }


def _errors(plan: ApproachPlan) -> dict[str, float] | None:
    """What `[uncertainty]` takes of the room about the keep-out, and what was added to the margin for it."""
    errors = plan.scenario.uncertainty
    if errors is None or plan.verification is None:
        return None
    return {
        "sigmas": errors.sigmas,
        "room_m": plan.verification.room_m,
        "margin_added_m": plan.approach.errors_m,
    }


def _number(value: float) -> float | None:
    return value if isfinite(value) else None


def spans(aborts: tuple[Abort, ...], every_s: float) -> str:
    """Instants in words, neighbours as one span.

    >>> spans((), 60.0)
    ''
    """
    found: list[list[float]] = []
    for each in aborts:
        if found and each.time_s - found[-1][1] <= 1.5 * every_s:
            found[-1][1] = each.time_s
        else:
            found.append([each.time_s, each.time_s])
    return ", ".join(f"{a:.0f} s" if a == b else f"{a:.0f} to {b:.0f} s" for a, b in found)


def details(plan: ApproachPlan) -> str:
    """What the lines of the verdict have no room for: what is broken, and the instants that need an abort."""
    found = plan.verification
    if found is None:
        return plan.message
    every = plan.scenario.safety.abort_every_s
    words = [*found.failures]
    needed = tuple(each for each in found.aborts if not each.safe)
    if needed:
        words.append(f"the drift is not safe by itself at {spans(needed, every)}")
        gaps = [each.size_m_s - each.at_least_m_s for each in needed if each.dv_m_s is not None]
        if gaps:
            words.append(f"abort impulses are at most {max(gaps):.4f} m/s above the smallest in the plane")
    if found.unsafe_aborts and not plan.approach.held:
        most = plan.scenario.safety.abort_m_s
        proved = all(each.at_least_m_s >= most for each in found.unsafe_aborts)
        what = "no impulse in the plane" if proved else "no impulse was found that"
        words.append(f"{what} up to {most:g} m/s makes it safe at {spans(found.unsafe_aborts, every)}")
    if isfinite(found.drift_with_j2_m):
        words.append(
            f"with J2 and drag the drifts before the gate stay {found.drift_with_j2_m:.1f} m outside"
        )
    return "; ".join(words) or plan.message


def thrust(plan: ApproachPlan) -> list[dict[str, Any]]:
    """The `thrust` of plan.json: of each arc the acceleration that is held, (R, T, N); empty without a programme, or with impulses."""
    approach, programme = plan.approach, plan.programme
    if programme is None or not approach.held:
        return []
    ends = approach.ends_s
    rows = zip(
        approach.times_s.tolist(), ends.tolist(), programme.dv_m_s / (ends - approach.times_s)[:, None],
        programme.sizes_m_s.tolist(), strict=True,
    )  # fmt: skip
    return [
        {"from_s": a, "until_s": b, "acceleration_m_s2": push.tolist(), "dv_m_s": size}
        for a, b, push, size in rows
    ]


def thrust_table(plan: ApproachPlan) -> str:
    """`thrust.csv`: of each arc from when until when which acceleration is held, R outward, T along the motion, N normal."""
    rows = ["from_s,until_s,a_r_m_s2,a_t_m_s2,a_n_m_s2"]
    for each in thrust(plan):
        rows.append(",".join(map(repr, (each["from_s"], each["until_s"], *each["acceleration_m_s2"]))))
    return "\n".join(rows) + "\n"


def messages(plan: ApproachPlan) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of a plan, by two-body motion; empty without a programme, or where thrust is held."""
    approach = plan.approach
    if approach.held:
        return {}
    return two_body_messages(
        plan.scenario.name, plan.programme, approach.start, approach.orbit(),
        duration_s=approach.duration_s, steps=STEPS, epoch_utc=plan.scenario.target.epoch_utc,
    )  # fmt: skip


def abort_table(plan: ApproachPlan) -> str:
    """`aborts.csv`: of every instant whether the drift is safe by itself, the impulse that makes it so, and its least size."""
    rows = ["time_s,safe_by_itself,dv_r_m_s,dv_t_m_s,dv_n_m_s,margin_m,at_least_m_s"]
    for each in plan.verification.aborts if plan.verification else ():
        numbers = [""] * 3 if each.dv_m_s is None else [repr(value) for value in each.dv_m_s.tolist()]
        margin = "" if each.dv_m_s is None else repr(each.margin_m)
        ends = [margin, repr(each.at_least_m_s)]
        rows.append(",".join([repr(each.time_s), str(each.safe).lower(), *numbers, *ends]))
    return "\n".join(rows) + "\n"
