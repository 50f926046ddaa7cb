"""A plan as plain data: the document behind `plan.json`, and what its verdict has no room for."""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

import numpy as np

from ..dispersion.replanning import Surprised
from ..model.uncertain import Meeting
from ..planner import PhasingPlan
from ..search.drift import Transfer
from ..verification.finite import FiniteBurns

GIVEN = ("times_s", "dv_m_s")
"""Of a transfer in mean elements: where the true motion starts from, which is not told."""


def plan_document(plan: PhasingPlan) -> dict[str, Any]:
    """Everything about the plan that JSON can hold, SI; impulses in the chaser's (R, T, N). Null where there is none."""
    flight, programme, analysis = plan.verification, plan.programme, plan.analysis
    cost = programme and programme.total_m_s
    return {
        "mission": plan.scenario.mission,
        "name": plan.scenario.name,
        "status": plan.status.value,
        "exit_reason": plan.exit_reason.name,
        "message": plan.message,
        "details": details(plan),
        "delta_v_m_s": cost,
        "cost": cost,
        "impulses": programme.to_list() if programme else [],
        "terminal_error": flight and {"position_m": flight.miss_m, "velocity_m_s": flight.miss_m_s},
        "phasing": plan.phasing
        and {
            name: getattr(plan.phasing, name)
            for name in plan.phasing.__dataclass_fields__
            if name not in GIVEN
        },
        "scheme_m_s": plan.scheme and plan.scheme.cost_m_s,
        "constraints": [asdict(check) for check in flight.checks] if flight else [],
        "audits": {},
        "distance": flight
        and {"time_s": flight.after_s.tolist(), "distance_m": np.round(flight.distance_m, 3).tolist()},
        "finite_burns": analysis and analysis.finite and _finite(plan, analysis.finite),
        "surprise": analysis and analysis.surprised and _surprise(analysis.surprised),
        "uncertainty": analysis and analysis.meeting and _meeting(analysis.meeting),
        "front": [
            {name: getattr(each, name) for name in each.__dataclass_fields__}
            for each in (analysis.front if analysis else ())
        ],
        "certificates": _certificates(plan),
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "paper": [],
        "constants": plan.scenario.constants.to_dict(),
        "scenario": plan.scenario.model_dump(mode="json"),
    }


def details(plan: PhasingPlan) -> str:
    """What the lines of the verdict have no room for: all that is broken, the scheme's cost, another drag of the target."""
    flight = plan.verification
    if flight is None or plan.programme is None:
        return plan.message
    words = [f"it breaks {each}" for each in flight.failures] or [plan.message]
    if isinstance(plan.phasing, Transfer):
        which = f"{plan.phasing.revolutions} revolutions, {plan.phasing.mean_cost_m_s:.1f} m/s"
        words.append(f"best of {plan.phasing.tried} descents in mean elements: {which}")
    if plan.scheme is not None and plan.descended is not None:
        words.append(f"by shooting at the scheme's own epochs {plan.scheme.cost_m_s:.1f} m/s")
    surprised = plan.analysis and plan.analysis.surprised
    if surprised:
        best = [each for each in surprised.replans if isfinite(each.extra_m_s)]
        words.append(f"with the other drag it would miss by {surprised.miss_m / 1e3:.1f} km")
        if best:
            costs = ", ".join(f"{each.extra_m_s:.2f}" for each in best)
            hours = ", ".join(f"{each.before_s / 3600.0:g}" for each in best)
            words.append(f"planning again {hours} h before the meeting costs {costs} m/s more")
    return "; ".join(words)


def _certificates(plan: PhasingPlan) -> dict[str, Any]:
    """The dual bound of the last linearisation, over all instants, and the largest primer."""
    last = plan.bounded
    if last is None:
        return {}
    bound = last.lower_bound
    return {
        "optimum": {"bound": bound, "gap": last.rounds[-1].cost - bound},
        "primer": {"bound": last.rounds[-1].largest_primer, "gap": last.rounds[-1].largest_primer - 1.0},
    }


def _finite(plan: PhasingPlan, found: FiniteBurns) -> dict[str, Any]:
    assert plan.programme is not None
    return {
        "delta_v_m_s": found.dv_m_s,
        "more_m_s": found.dv_m_s - plan.programme.total_m_s,
        "mass_ratio": found.mass_ratio,
        "miss_m": found.miss_m,
        "miss_m_s": found.miss_m_s,
        "burns": [
            {
                "ignition_s": float(at),
                "duration_s": burn.duration_s,
                "delta_v_m_s": burn.dv_m_s,
                "pitch_deg": float(np.rad2deg(burn.pitch_rad)),
                "yaw_deg": float(np.rad2deg(burn.yaw_rad)),
            }
            for at, burn in zip(found.ignition_s, found.burns, strict=True)
        ],
    }


def _surprise(found: Surprised) -> dict[str, Any]:
    return {
        "miss_m": found.miss_m,
        "updates": found.updates,
        "replans": [
            {
                "before_s": each.before_s,
                "more_m_s": each.extra_m_s if isfinite(each.extra_m_s) else None,
                "status": each.reason.name if each.reason else "NO_FLIGHT",
                "problems": len(each.subproblems),
                "iterations": sum(row.solution.iterations for row in each.subproblems),
            }
            for each in found.replans
        ],
    }


def _meeting(found: Meeting) -> dict[str, Any]:
    drawn = isfinite(found.within)
    return {
        "sigmas_m": found.sigmas_m.tolist(),
        "least_m": found.least_m.tolist() if drawn else None,
        "largest_m": found.largest_m.tolist() if drawn else None,
        "within": found.within if drawn else None,
    }
