"""A plan as plain data: the document behind `plan.json`, and what is told beside the verdict."""

from __future__ import annotations

from typing import Any

import numpy as np

from orbsoc.conic.solution import Status
from orbsoc.guidance.mission import PlanStatus
from orbsoc.orbit import EARTH
from orbsoc.orbit.array import Array

from .paper import compare
from .planner import FlyAround
from .search.pulses import Search
from .verification import ORBITS, Checked, TrueFlight, inner_radius_m


def plan_document(plan: FlyAround) -> dict[str, Any]:
    """Everything about the plan that JSON can hold, SI, vectors in (R, T, N); null for absent."""
    found, search, scenario = plan.verification, plan.search, plan.scenario
    return {
        "mission": scenario.mission,
        "name": scenario.name,
        "status": plan.status.value,
        "exit_reason": plan.status.name,
        "message": plan.message,
        "details": details(plan),
        "assumptions": scenario.assumptions,
        "pulses": found and found.programme.fired,
        "delta_v_m_s": found and found.programme.total_m_s,
        "cost": found and found.programme.total_m_s,
        "largest_error_m": found and found.flown.largest_error_m,
        "impulses": found and found.programme.to_list(),
        "terminal_error": found and _terminal_error(found),
        "proof": search and _proof(search),
        "front": [{"pulses": each.pulses, "delta_v_m_s": each.dv_m_s} for each in plan.front],
        "constraints": [] if found is None else _constraints(plan, found),
        "audits": found and _audits(plan, found),
        "certificates": search and _certificates(search),
        "verification": found and _verification(found),
        "dispersed": found and found.dispersed and dispersed_document(plan, found.dispersed),
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "paper": [row.to_dict() for row in compare(plan)],
        "constants": EARTH.to_dict(),
        "scenario": scenario.model_dump(mode="json"),
    }


def details(plan: FlyAround) -> str:
    """What the lines of the verdict have no room for."""
    found, search, scenario = plan.verification, plan.search, plan.scenario
    if found is None:
        advice = {
            PlanStatus.INFEASIBLE: ". Allow more pulses, a larger tolerance_m, or smaller errors in uncertainty",
            PlanStatus.FAILED: ". This is no proof that there is none; try more pulses, or a larger tolerance_m",
        }
        return plan.message + advice.get(plan.status, "")
    words = f"By the linear model the flight strays {found.flown.largest_error_m:.4f} m of {scenario.tolerance_m:g} m"
    if search is not None and search.margin_m:
        words += f"; {search.margin_m:.3f} m are left to errors of navigation and execution"
    if search is not None and search.room_m:
        words += f"; {search.room_m:.4f} m are left to J2 and drag"
    cut = found.nearest_cut
    return f"{words}. Pulse {cut.number} is worst cut at {100 * cut.fraction:.0f} %"


def _terminal_error(found: Checked) -> dict[str, float]:
    miss = found.truth.end_states[0] - found.flown.before[-1]
    return {"position_m": float(np.linalg.norm(miss[:3])), "velocity_m_s": float(np.linalg.norm(miss[3:]))}


def _proof(search: Search) -> dict[str, Any]:
    """`fewest` is null unless no fewer pulses can do; `next_needs_tolerance_m` is what one pulse fewer would need, one at
    time 0; `any_first_time_m` is a bound below the error with the first pulse at any time, margin not included."""
    proof = next((b for b in search.bounds if b.pulses == search.impossible), None)
    return {
        "fewest": search.pulses if search.certified else None,
        "next_needs_tolerance_m": search.next_needs_m,
        "impossible": search.impossible if search.impossible >= 0 else None,
        "margin_m": search.impossible_margin_m,
        "any_first_time_m": search.impossible_any_m if search.impossible >= 0 else None,
        "bounds": [{"pulses": b.pulses, "error_m": b.bound_m} for b in search.bounds],
        "arcs": []
        if proof is None
        else [{"start_s": arc.start_s, "end_s": arc.end_s, "bound_m": arc.bound_m} for arc in proof.arcs],
    }


def _certificates(search: Search) -> dict[str, Any]:
    """The least error of one pulse fewer, and the least Σ‖Δv‖ at these times and limits, by their dual objectives."""
    found: dict[str, Any] = {}
    if search.impossible >= 0:
        found["error_m"] = {"pulses": search.impossible, "bound": search.impossible_below_m, "gap": None}
    if search.found is not None and search.found.solution.status is Status.SOLVED:
        solution = search.found.solution
        cost = solution.objective
        gap = (cost - solution.dual_objective) / max(abs(cost), 1e-12)
        found["delta_v_m_s"] = {"pulses": search.pulses, "bound": solution.dual_objective, "gap": gap}
    return found


def _constraints(plan: FlyAround, found: Checked) -> list[dict[str, Any]]:
    scenario, flown = plan.scenario, found.flown
    k, j = int(flown.errors_m.argmax()), int(found.truth.errors_m[:, 0].argmax())
    after = float(found.truth.errors_m[j, 0])
    longest = scenario.flight.longest_transfer_s
    lengths = np.diff(np.append(flown.programme.times_s, flown.end_s))
    rows = [
        ("tube", scenario.tolerance_m - float(flown.errors_m[k]), "m", float(flown.errors_at_s[k])),
        ("tube, with J2 and drag", scenario.tolerance_m - after, "m", float(found.truth.times_s[j])),
    ]
    if plan.search is None:
        at = int(lengths.argmax())
        rows.append(
            ("interval below π/ω", longest - float(lengths[at]), "s", float(flown.programme.times_s[at]))
        )
    return [dict(zip(("name", "margin", "unit", "at_s"), row, strict=True)) for row in rows]


def _audits(plan: FlyAround, found: Checked) -> dict[str, Any]:
    out, cut = found.nearest_out, found.nearest_cut
    ever = min(found.engine_out, key=lambda each: each.all_time_m)
    return {
        "engine_out": {
            "orbits": ORBITS,
            "least_m": out.distance_m,
            "after_pulse": out.number,
            "at_least_m": min(each.at_least_m or 0.0 for each in found.engine_out),
            "least_for_all_time_m": ever.all_time_m,
            "inner_radius_m": inner_radius_m(plan.scenario),
            "pulses": [each.to_dict() for each in found.engine_out],
        },
        "cut_burns": {
            "orbits": ORBITS,
            "least_m": cut.distance_m,
            "at_least_m": min(each.at_least_m or 0.0 for each in found.cut_burns),
            "pulse": cut.number,
            "fraction": cut.fraction,
            "pulses": [each.to_dict() for each in found.cut_burns],
        },
    }


def _verification(found: Checked) -> dict[str, Any]:
    """The same programme by an integrator that planning does not use; differences from the linear model."""
    truth, model = found.truth, found.flown
    return {
        "verified": not found.failures,
        "failures": list(found.failures),
        "forces": ["point mass", "J2", "drag"],
        "largest_error_m": found.largest_error_m,
        "linear_error_at_most_m": found.at_most_m,
        "delta_v_m_s": float(truth.totals_m_s[0]),
        "error_difference_m": found.largest_error_m - model.largest_error_m,
        "delta_v_difference_m_s": float(truth.totals_m_s[0]) - model.programme.total_m_s,
        "open_loop_largest_error_m": float(found.open_loop.largest_errors_m[0]),
    }


def later_errors_m(flights: TrueFlight) -> Array:
    """Of each flight, the largest distance after the second arc, (B,)."""
    return np.asarray(flights.errors_m[flights.arcs >= 2].max(axis=0, initial=0.0))


def dispersed_document(plan: FlyAround, flights: TrueFlight) -> dict[str, Any]:
    """What draws of navigation and execution errors do, run by run in quantiles."""
    errors, totals = flights.largest_errors_m, flights.totals_m_s
    arcs = np.array([flights.errors_m[flights.arcs == k].max(axis=0) for k in range(len(flights.dv_m_s))])
    tolerance = plan.scenario.tolerance_m
    return {
        "runs": errors.size,
        "largest_error_m": {"mean": float(errors.mean()), "p95": float(np.quantile(errors, 0.95)),
                            "max": float(errors.max())},
        "runs_beyond": float(np.mean(errors > tolerance)),
        "runs_beyond_after_second_arc": float(np.mean(later_errors_m(flights) > tolerance)),
        "arcs_beyond": float(np.mean(arcs > tolerance)),
        "delta_v_m_s": {"mean": float(totals.mean()), "p95": float(np.quantile(totals, 0.95))},
    }  # fmt: skip
