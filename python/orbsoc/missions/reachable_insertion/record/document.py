"""A plan as plain data: the document behind `plan.json`, and the attitude programme behind `attitude.csv`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import Rules
from orbsoc.orbit import EARTH, CanonicalUnits, Elements, pitch_yaw

from ..model.problems import Iterate
from ..model.proof import Proof
from ..paper import compare
from ..scenario import Scenario
from ..search.result import SearchResult
from ..targets.free_target import FreeTarget
from ..targets.rows import Row
from ..verification import EndOfFlight
from .words import Violation, rate_in_words, rate_is_active, row_in_words, start_tried, worst_first

Array = NDArray[np.float64]


def plan_document(plan: SearchResult, details: str, later: Any, two_burns: Any) -> dict[str, Any]:
    """Everything about the plan that JSON can hold; angles in degrees, lengths as the key says, null for absent.

    `orbit`, `propagated_orbit` and `terminal_error` are null unless the sequence converged to a feasible point.
    Versions, hardware and files are the caller's to add.
    """
    found = plan.verification
    document: dict[str, Any] = {
        "mission": plan.scenario.mission,
        "name": plan.scenario.name,
        "problem": plan.scenario.problem,
        "perigee_direction": plan.scenario.target.perigee_direction,
        "status": plan.status.value,
        "exit_reason": plan.exit_reason.name,
        "message": plan.message,
        "details": details,
        "time_of_flight_s": plan.time_of_flight_s,
        "propellant_kg": plan.propellant_kg,
        **end_document(found),
        "verification": found
        and {
            "verified": found.verified,
            "failures": list(found.failures),
            "plane_error_rad": found.plane_rad,
            "perigee_error_m": None if np.isnan(found.perigee_error_m) else found.perigee_error_m,
            "thrust_excess": found.thrust_excess,
            "thrust_deficit": found.thrust_deficit,
            "lowest_altitude_km": found.flight.lowest_altitude_m / 1e3,
            "samples": found.flight.times_s.size,
        },
        "attitude_rate": found and rate_document(plan.scenario, found),
        "violations": violations_document(violations(plan)),
        "starts": starts_tried(plan),
        "assumptions": plan.scenario.assumptions,
        "proof": plan.proof and proof_document(plan.proof),
        "ignition_s": plan.ignition_s,
        "forces": forces_document(plan.scenario),
        "later_ignition": later and asdict(later),
        "two_burns": two_burns and asdict(two_burns),
        "scp_iterations": len(plan.subproblems),
        "nodes": plan.trajectory.grid.size,
        "stages": [
            {
                "nodes": stage.nodes,
                "note": stage.note,
                "exit_reason": stage.outcome.reason.name,
                "iterations": len(stage.outcome.iterations),
            }
            for stage in plan.attempts
        ],
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "paper": [row.to_dict() for row in compare(plan)],
        "attitude_axes": attitude_axes(plan.scenario),
        "trajectory": None if found is None else trajectory_document(plan),
        "settings": asdict(Rules(max_iterations=plan.scenario.method.max_iterations)),
        "constants": EARTH.to_dict(),
        "scenario": plan.scenario.model_dump(mode="json"),
    }
    return document


def violations(plan: SearchResult) -> tuple[Violation, ...]:
    """Terminal rows the sequence had to leave violated, worst first; empty for a feasible plan."""
    return violations_of(plan, plan.iterate)


def violations_of(plan: SearchResult, iterate: Iterate) -> tuple[Violation, ...]:
    """The same of any iterate of the search."""
    return worst_first(
        Violation(row, value, _in_words(plan, iterate, row, value)) for row, value in iterate.slack
    )


def starts_tried(plan: SearchResult) -> list[dict[str, Any]]:
    """Every start of the search, in its order: how its last sequence ended, the worst row that it left, and by how much."""
    last = {(each.start.name, each.ignition_s): each for each in plan.attempts}
    return [
        start_tried(start, ignition_s, each.outcome.reason, violations_of(plan, each.iterate))
        for (start, ignition_s), each in last.items()
    ]


def _in_words(plan: SearchResult, iterate: Iterate, row: Row, value: float) -> str:
    if row is Row.ATTITUDE_RATE:
        return rate_in_words(plan.scenario, value)
    if row is Row.PERIGEE_RADIUS and not isinstance(plan.target, FreeTarget):
        # slack s in e ≤ p/r_p − 1 + s lets the perigee sink by about r_p s/(1 + e)
        radius_m = EARTH.earth_radius_m + 1e3 * (plan.scenario.target.perigee_height_km or 0.0)
        return f"the perigee too low by {abs(value) * radius_m / 1e3:.2f} km"
    scales = (iterate.momentum_scale, iterate.laplace_scale)
    return row_in_words(plan.target, row, value, iterate.trajectory.end, scales)


def rate_document(scenario: Scenario, found: EndOfFlight) -> dict[str, float | bool | None]:
    """The fastest turn over a burn, the bound, and whether the plan is at it; null without a bound."""
    return {
        "peak_deg_s": float(np.rad2deg(found.peak_rate_rad_s)),
        "bound_deg_s": scenario.limits.attitude_rate_deg_s,
        "active": rate_is_active(scenario, found),
    }


def end_document(found: EndOfFlight | None) -> dict[str, Any]:
    """The orbit as planned and as propagated, and by how much the second misses the target; null where nothing was flown."""
    return {
        "orbit": found and orbit_document(found.planned_orbit),
        "propagated_orbit": found and orbit_document(found.propagated_orbit),
        "terminal_error": found
        and {"angular_momentum_rel": found.angular_momentum_rel, "laplace_rel": found.laplace_rel},
    }


def violations_document(found: Sequence[Violation]) -> list[dict[str, Any]]:
    """Terminal rows that are left violated."""
    return [{"row": each.row.value, "value_canonical": each.value, "words": each.words} for each in found]


def forces_document(scenario: Scenario) -> dict[str, list[str]]:
    """What acts beside the thrust, in the plan and in its verification."""
    oblate = ["J2"] if scenario.burn.coast_j2 else []
    return {"coast": ["point mass", *oblate], "burn": ["point mass"]}


def proof_document(proof: Proof) -> dict[str, Any]:
    """What the target needs more of than there is."""
    speed = CanonicalUnits.of(EARTH).speed_m_s
    return {"what": proof.what, "needed_m_s": proof.needed * speed, "available_m_s": proof.available * speed}


def orbit_document(orbit: Elements) -> dict[str, float | None]:
    """Osculating elements in ECI, in the units of reports; null for what the orbit does not have."""
    c3_km2_s2 = -EARTH.mu_m3_s2 / orbit.sma_m / 1e6
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
    return {name: _number(value) for name, value in found.items()}


def trajectory_document(plan: SearchResult) -> dict[str, Any]:
    """The collocated solution at its nodes and at cut-off, SI, launch-inertial axes."""
    units = CanonicalUnits.of(EARTH)
    trajectory = plan.trajectory
    states = units.state_to_si(trajectory.states)
    end = units.state_to_si(trajectory.end)
    return {
        "axes": plan.scenario.plan_axes,
        "time_s": (trajectory.elapsed() * units.time_s).tolist(),
        "position_m": states[:, :3].tolist(),
        "velocity_m_s": states[:, 3:].tolist(),
        "thrust_direction": trajectory.controls.tolist(),
        "end_position_m": end[:3].tolist(),
        "end_velocity_m_s": end[3:].tolist(),
    }


ATTITUDE_COLUMNS = {
    "launch_inertial": ("t_s", "pitch_deg", "yaw_deg", "ux", "uy", "uz", "rate_deg_s"),
    "eci": ("t_s", "ux_eci", "uy_eci", "uz_eci", "mass_kg", "rate_deg_s"),
    "velocity": (
        "t_s", "pitch_velocity_deg", "yaw_velocity_deg", "u_along_velocity", "u_across_in_plane", "u_along_momentum",
        "mass_kg", "rate_deg_s",
    ),
}  # fmt: skip
"""Columns of `attitude.csv` by its axes; times count from ignition."""


def attitude_axes(scenario: Scenario) -> str:
    """The axes that `attitude.csv` is in: "velocity" where the scenario asks for it, else those of the plan."""
    return "velocity" if scenario.axes == "velocity" else scenario.plan_axes


def attitude_programme(plan: SearchResult) -> Array | None:
    """Rows (K, C) of `ATTITUDE_COLUMNS`, uniform in time; None when there is no plan to fly.

    The directions are the ones the verification flew: the interpolant of the nodal thrust, normalised. In launch-inertial axes
    pitch and yaw are eq. 21's; about the velocity, pitch is towards the outside of the orbit and yaw along the angular momentum.
    """
    if plan.verification is None or plan.status is not PlanStatus.VERIFIED:
        return None
    axes = attitude_axes(plan.scenario)
    if plan.time_of_flight_s == 0.0:
        return np.empty((0, len(ATTITUDE_COLUMNS[axes])))
    flight, vehicle = plan.verification.flight, plan.scenario.vehicle
    mass = vehicle.mass_kg - vehicle.mass_flow_kg_s * flight.times_s
    return attitude_rows(
        axes, flight.times_s, flight.direction, flight.propagated, mass, np.rad2deg(flight.rate_rad_s)
    )


def attitude_rows(axes: str, times: Array, u: Array, states: Array, mass: Array, rate: Array) -> Array:
    """Rows (K, C) of `ATTITUDE_COLUMNS` for directions (K, 3) that turn at `rate` (K,), °/s, at states (K, 6)."""
    if axes == "launch_inertial":
        pitch, yaw = pitch_yaw(u)
        return np.column_stack([times, np.rad2deg(pitch), np.rad2deg(yaw), u, rate])
    if axes == "eci":
        return np.column_stack([times, u, mass, rate])
    along, across, normal = (np.einsum("ki,ki->k", u, each) for each in _velocity_axes(states))
    yaw = np.arcsin(np.clip(normal, -1.0, 1.0))
    return np.column_stack([
        times, np.rad2deg(np.arctan2(across, along)), np.rad2deg(yaw), along, across, normal, mass, rate
    ])  # fmt: skip


def _velocity_axes(states: Array) -> tuple[Array, Array, Array]:
    """Unit vectors (K, 3) along the velocity, across it in the plane and outwards, and along the angular momentum."""
    r, v = states[:, :3], states[:, 3:]
    along = v / np.linalg.norm(v, axis=1, keepdims=True)
    normal = np.cross(r, v)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return along, np.cross(along, normal), normal


def attitude_csv(plan: SearchResult) -> str | None:
    """`attitude.csv`: a header of `ATTITUDE_COLUMNS` and one line per time; None when there is no plan to fly."""
    rows = attitude_programme(plan)
    if rows is None:
        return None
    return csv_text(ATTITUDE_COLUMNS[attitude_axes(plan.scenario)], rows)


def csv_text(header: Sequence[str], rows: Array) -> str:
    """A header and one line per row."""
    lines = [",".join(header), *(",".join(f"{value:.12g}" for value in row) for row in rows)]
    return "\n".join(lines) + "\n"


def _number(value: float) -> float | None:
    """The value as JSON can hold it: an int stays one, NaN and infinity become null."""
    return value if np.isfinite(value) else None
