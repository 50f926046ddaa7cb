"""The document behind `plan.json`: what a plan with one burn and a plan with two share, and the rest of one burn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from orbsoc.guidance.scp import Rules
from orbsoc.orbit import Elements

from ..model.problems import Iterate
from ..paper import compare
from ..search.run import SearchResult
from ..targets.rows import Row
from ..targets.target_orbit import LargestOrbit
from .attitude import attitude_axes
from .words import Told, Violation, rate_in_words, rate_is_active, speeds_m_s, start_tried, worst_first


def shared_document(
    plan: Told, details: str, left: Sequence[Violation], starts: Sequence[dict[str, Any]]
) -> dict[str, Any]:
    """What both kinds of plan tell: angles in degrees, lengths as the key says, null for absent.

    `orbit`, `propagated_orbit` and `terminal_error` are null unless something was flown. Versions, hardware and files are the
    caller's to add.
    """
    scenario, found, proof = plan.scenario, plan.verification, plan.proof
    needed, available = (None, None) if proof is None else speeds_m_s(proof, scenario)
    return {
        "mission": scenario.mission,
        "name": scenario.name,
        "problem": scenario.problem,
        "status": plan.status.value,
        "message": plan.message,
        "details": details,
        "time_of_flight_s": plan.time_of_flight_s,
        "propellant_kg": plan.propellant_kg,
        "orbit": found and _orbit_document(found.planned_orbit),
        "propagated_orbit": found and _orbit_document(found.propagated_orbit),
        "terminal_error": found
        and {"angular_momentum_rel": found.angular_momentum_rel, "laplace_rel": found.laplace_rel},
        "verification": found
        and {
            "verified": found.verified,
            "failures": list(found.failures),
            "plane_error_rad": found.plane_rad,
            "thrust_excess": found.thrust_excess,
            "thrust_deficit": found.thrust_deficit,
            "lowest_altitude_km": found.flight.lowest_altitude_m / 1e3,
        },
        "attitude_rate": found
        and {
            "peak_deg_s": float(np.rad2deg(found.peak_rate_rad_s)),
            "bound_deg_s": scenario.limits.attitude_rate_deg_s,
            "active": rate_is_active(scenario, found),
        },
        "violations": [
            {"row": each.row.value, "value_canonical": each.value, "words": each.words} for each in left
        ],
        "starts": list(starts),
        "assumptions": scenario.assumptions,
        "proof": proof and {"what": proof.what, "needed_m_s": needed, "available_m_s": available},
        "ignition_s": plan.ignition_s,
        "forces": {
            "coast": ["point mass", "J2"] if scenario.burn.coast_j2 else ["point mass"],
            "burn": ["point mass"],
        },
        "scp_iterations": len(plan.subproblems),
        "stages": [
            {
                "nodes": each.nodes,
                "note": each.note,
                "exit_reason": each.outcome.reason.name,
                "iterations": len(each.outcome.iterations),
            }
            for each in plan.attempts
        ],
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "attitude_axes": attitude_axes(scenario),
        "constants": scenario.constants.to_dict(),
        "scenario": scenario.model_dump(mode="json"),
    }


def plan_document(plan: SearchResult, details: str, later: Any, two_burns: Any) -> dict[str, Any]:
    """Everything about a plan with one burn that JSON can hold."""
    found, scenario, target = plan.verification, plan.scenario, plan.target
    document = shared_document(plan, details, violations(plan), starts_tried(plan))
    if found is not None:
        perigee_m = (
            target.perigee_error_m(found.propagated_orbit) if isinstance(target, LargestOrbit) else None
        )
        document["verification"] |= {"perigee_error_m": perigee_m, "samples": found.flight.times_s.size}
    return document | {
        "perigee_direction": scenario.target.perigee_direction,
        "exit_reason": plan.exit_reason.name,
        "later_ignition": later and asdict(later),
        "two_burns": two_burns and asdict(two_burns),
        "nodes": plan.trajectory.grid.size,
        "paper": [row.to_dict() for row in compare(plan)],
        "trajectory": None if found is None else _trajectory_document(plan),
        "settings": asdict(Rules(max_iterations=scenario.method.max_iterations)),
    }


def violations(plan: SearchResult) -> tuple[Violation, ...]:
    """Terminal rows the sequence had to leave violated, worst first; empty for a feasible plan."""
    return _violations_of(plan, plan.iterate)


def _violations_of(plan: SearchResult, iterate: Iterate) -> tuple[Violation, ...]:
    scales, end = (iterate.momentum_scale, iterate.laplace_scale), iterate.trajectory.end

    def words(row: Row, value: float) -> str:
        is_rate = row is Row.ATTITUDE_RATE
        return rate_in_words(plan.scenario, value) if is_rate else plan.target.words(row, value, end, scales)

    return worst_first(Violation(row, value, words(row, value)) for row, value in iterate.slack)


def starts_tried(plan: SearchResult) -> list[dict[str, Any]]:
    """Every start of the search, in its order: how its last sequence ended, the worst row that it left, and by how much."""
    last = {(each.start.name, each.ignition_s): each for each in plan.attempts}
    return [
        start_tried(start, ignition_s, each.outcome.reason, _violations_of(plan, each.iterate))
        for (start, ignition_s), each in last.items()
    ]


def _orbit_document(orbit: Elements) -> dict[str, float | None]:
    """Osculating elements in ECI, in the units of reports; null for what the orbit does not have."""
    c3_km2_s2 = -orbit.constants.mu_m3_s2 / orbit.sma_m / 1e6
    found = {
        "a_km": orbit.sma_m / 1e3,
        "e": orbit.ecc,
        "inc_deg": float(np.rad2deg(orbit.inc_rad)),
        "raan_deg": float(np.rad2deg(orbit.raan_rad)),
        "argp_deg": float(np.rad2deg(orbit.argp_rad)),
        "true_anomaly_deg": float(np.rad2deg(orbit.true_anomaly_rad)),
        "perigee_height_km": orbit.perigee_height_m() / 1e3,
        "c3_km2_s2": c3_km2_s2,
        "v_infinity_m_s": 1e3 * float(np.sqrt(c3_km2_s2)) if c3_km2_s2 > 0.0 else float("nan"),
        "apogee_height_km": orbit.apogee_height_m() / 1e3,
    }
    return {name: value if np.isfinite(value) else None for name, value in found.items()}


def _trajectory_document(plan: SearchResult) -> dict[str, Any]:
    """The collocated solution at its nodes and at cut-off, SI, in the axes of plans."""
    units, trajectory = plan.setup.units, plan.trajectory
    states, end = units.state_to_si(trajectory.states), units.state_to_si(trajectory.end)
    return {
        "axes": plan.scenario.plan_axes,
        "time_s": (trajectory.elapsed() * units.time_s).tolist(),
        "position_m": states[:, :3].tolist(),
        "velocity_m_s": states[:, 3:].tolist(),
        "thrust_direction": trajectory.controls.tolist(),
        "end_position_m": end[:3].tolist(),
        "end_velocity_m_s": end[3:].tolist(),
    }
