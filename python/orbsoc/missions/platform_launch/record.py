"""A plan as plain data: the document behind `plan.json`, and what its verdict has no room for."""

from __future__ import annotations

from dataclasses import asdict
from math import degrees
from typing import Any

from .model.transfer import flat_interval, in_plane
from .paper import compare, disturbance
from .planner import LaunchPlan
from .search.rendezvous import Rendezvous
from .verification.audits import ORBITS
from .verification.checks import Verification
from .verification.flights import Flown, element_rows


def plan_document(plan: LaunchPlan) -> dict[str, Any]:
    """Everything about the plan that JSON can hold, SI, vectors in (R, T, N); null for absent."""
    met, found, programme = plan.meeting, plan.verification, plan.programme
    return {
        "mission": plan.scenario.mission,
        "name": plan.scenario.name,
        "status": plan.status.value,
        "exit_reason": plan.status.name,
        "message": plan.message,
        "details": details(plan),
        "assumptions": plan.scenario.assumptions,
        "launch": _launch(plan),
        "delta_v_m_s": programme and programme.total_m_s,
        "cost": met and met.value,
        "duration_s": met and met.time_s,
        "impulses": programme.to_list() if programme else [],
        "impulses_two_body": found.corrected.programme.to_list() if found else [],
        "minima": [asdict(each) for each in met.minima] if met else [],
        "flat_s": _flat(plan, met) if met else None,
        "terminal_error": found and _miss(found.as_planned),
        "constraints": [asdict(check) for check in found.checks] if found else [],
        "verification": found and _verification(found),
        "audits": _audits(plan) if met else {},
        "certificates": _certificates(plan, met) if met else {},
        "series": _series(plan) if met else None,
        "scans": {name: each.to_dict() for name, each in zip(("yaw_bias", "phase"), plan.scans, strict=True)} if met else {},
        "sequence": asdict(plan.sequence) if met and plan.sequence else None,
        "front": [dict(zip(("duration_s", "two_m_s", "generated_m_s", "impulses"), row, strict=True)) for row in plan.front],
        "dispersed": plan.dispersed.to_dict() if plan.dispersed else None,
        "orbits": {name: element_rows(each) for name, each in plan.orbits.items()} if met else None,
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "paper": [row.to_dict() for row in compare(plan)],
        "constants": plan.scenario.constants.to_dict(),
        "scenario": plan.scenario.model_dump(mode="json"),
    }  # fmt: skip


def details(plan: LaunchPlan) -> str:
    """What the lines of the verdict have no room for: the launch, the flight as planned, and a hold point instead."""
    found, met, leave = plan.verification, plan.meeting, plan.separation
    if found is None or met is None:
        return plan.message
    safest = max(plan.holds, key=lambda each: each.nearest_m)
    unit = "m²/s²" if met.cost == "squares" else "m/s"
    return "; ".join((
        *found.failures,
        f"the server leaves its tube after {leave.time_s:.3f} s at {leave.q[7]:.3f} m/s",
        f"flown by two bodies as planned it ends {found.as_planned.miss_m:.3g} m away",
        f"two impulses to a hold point at {safest.ahead_m:+g} m on the V-bar instead keep it {safest.nearest_m:.1f} m away where"
        f" the last one is not fired, for {safest.price:+.4f} {unit}",
    ))  # fmt: skip


def _launch(plan: LaunchPlan) -> dict[str, Any]:
    found = plan.separation
    state = found.state.tolist()
    return {
        "separation_s": found.time_s,
        "position_m": state[:3],
        "velocity_m_s": state[3:],
        "yaw_deg": degrees(found.q[2]),
        "yaw_rate_deg_s": degrees(found.q[6]),
        "slide_m": float(found.q[3]),
        "slide_m_s": float(found.q[7]),
        "platform": disturbance(plan),
        "assembly": {
            "mass_kg": found.pair.assembly.mass_kg,
            "centre_m": found.pair.assembly.centre_m.tolist(),
            "inertia_kg_m2": found.pair.assembly.inertia_kg_m2,
        },
    }


def _flat(plan: LaunchPlan, met: Rendezvous) -> list[float] | None:
    """Between which times the sum of squares is within 2 % of its least."""
    if met.cost != "squares":
        return None
    best = min(met.minima, key=lambda each: each.cost)
    return list(flat_interval(plan.scenario.motion, in_plane(plan.separation.state), best))


def _miss(found: Flown) -> dict[str, float]:
    return {"position_m": found.miss_m, "velocity_m_s": found.speed_m_s}


def _verification(found: Verification) -> dict[str, Any]:
    return {
        "verified": not found.failures,
        "failures": list(found.failures),
        "launch": {"by_kane": found.by_kane, "by_two_bodies": found.by_two_bodies},
        "two_body": _miss(found.as_planned),
        "j2_drag": _miss(found.with_j2_and_drag),
        "two_body_corrected": _miss(found.corrected) | {"delta_v_m_s": found.corrected.programme.total_m_s},
    }


def _audits(plan: LaunchPlan) -> dict[str, Any]:
    worst = min(plan.cuts, key=lambda each: each.missed_m)
    return {
        "engine_out": {
            "orbits": ORBITS,
            "least_m": worst.missed_m,
            "number": worst.number,
            "burns": [cut.to_dict() | {"by_fraction_m": cut.by_fraction_m.tolist()} for cut in plan.cuts],
        },
        "hold_points": [asdict(each) for each in plan.holds],
    }


def _certificates(plan: LaunchPlan, met: Rendezvous) -> dict[str, Any]:
    """The dual bound of the impulses; of the least of all times, the minima that polynomials find beside the scan's."""
    found: dict[str, Any] = {"optimum": {"bound": met.lower_bound, "gap": met.value - met.lower_bound}}
    if met.cost == "squares":
        apart = [min(abs(t - each.time_s) for each in met.minima) for t in plan.stationary_s]
        found["minima"] = {"bound": len(plan.stationary_s), "gap": len(plan.stationary_s) - len(met.minima),
                           "apart_s": max(apart, default=0.0)}  # fmt: skip
    return found


def _series(plan: LaunchPlan) -> dict[str, Any]:
    found = plan.series
    if isinstance(found, str):
        return {"orders": [], "reason": found}
    return {"orders": [each.to_dict() for each in found], "reason": ""}
