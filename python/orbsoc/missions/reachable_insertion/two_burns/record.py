"""A plan of two burns as plain data: the document behind `plan.json`, and the programme behind `attitude.csv`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.mission import PlanStatus
from orbsoc.orbit import EARTH

from ..record.document import (
    ATTITUDE_COLUMNS,
    attitude_axes,
    attitude_rows,
    csv_text,
    end_document,
    forces_document,
    proof_document,
    rate_document,
    violations_document,
)
from .search import TOLERANCE, TRUST
from .transfer_plan import TransferPlan
from .verdicts import starts_tried, verdict, violations
from .verification import TransferFlight, Verification

Array = NDArray[np.float64]

COASTED = 4
"""Every fourth sample of a coast between burns is told."""


def plan_document(plan: TransferPlan) -> dict[str, Any]:
    """Everything that JSON can hold, in the keys of a plan with one burn where these mean the same; `burns` holds each."""
    found, best = plan.verification, plan.best
    return {
        "mission": plan.scenario.mission,
        "name": plan.scenario.name,
        "problem": plan.scenario.problem,
        "status": plan.status.value,
        "message": plan.message,
        "details": verdict(plan),
        "time_of_flight_s": plan.time_of_flight_s,
        "propellant_kg": plan.propellant_kg,
        "delta_v_m_s": plan.delta_v_m_s,
        "ignition_s": plan.ignition_s,
        "coast_s": plan.coast_s,
        "total_time_s": plan.total_time_s,
        "burns": [asdict(each) for each in plan.burns],
        **end_document(found),
        "verification": found
        and {
            "verified": found.verified,
            "failures": list(found.failures),
            "plane_error_rad": found.plane_rad,
            "thrust_excess": found.thrust_excess,
            "thrust_deficit": found.thrust_deficit,
            "lowest_altitude_km": found.flight.lowest_altitude_m / 1e3,
            "samples": sum(each.times_s.size for each in found.flight.burns),
        },
        "violations": violations_document(violations(plan)),
        "starts": starts_tried(plan),
        "assumptions": plan.scenario.assumptions,
        "proof": plan.proof and proof_document(plan.proof),
        "forces": forces_document(plan.scenario),
        "attitude_rate": found and {**rate_document(plan.scenario, found), "slew_deg_s": _slew_deg_s(found)},
        "scp_iterations": len(plan.subproblems),
        "nodes": best and best.nodes,
        "stages": [
            {
                "nodes": each.nodes,
                "note": f"{each.note}, from {each.start}",
                "exit_reason": each.outcome.reason.name,
                "iterations": len(each.outcome.iterations),
            }
            for each in plan.attempts
        ],
        "subproblems": [row.to_dict() for row in plan.subproblems],
        "attitude_axes": attitude_axes(plan.scenario),
        "trajectory": best and _programme_document(plan),
        "settings": {**asdict(TRUST), "tolerance": TOLERANCE},
        "constants": EARTH.to_dict(),
        "scenario": plan.scenario.model_dump(mode="json"),
    }


def _slew_deg_s(found: Verification) -> float | None:
    """Between the burns; null without a coast there."""
    return float(np.rad2deg(found.slew_rad_s)) if np.isfinite(found.slew_rad_s) else None


def _programme_document(plan: TransferPlan) -> dict[str, Any]:
    """The thrust directions at the nodes of each burn; times count from the scenario's state."""
    transfer = plan.transfer
    assert transfer is not None
    return {
        "axes": plan.scenario.plan_axes,
        "burns": [
            {
                "time_s": (each.ignition_s + 0.5 * each.duration_s * (transfer.grid.nodes + 1.0)).tolist(),
                "thrust_direction": controls.tolist(),
            }
            for each, controls in zip(plan.burns, transfer.controls, strict=True)
        ],
    }


def attitude_csv(plan: TransferPlan) -> str | None:
    """`attitude.csv`: the columns of a plan with one burn, and the thrust; None when there is no plan to fly.

    Times count from the first ignition. Over the coast between the burns the thrust is 0, and the attitude turns at a constant
    rate from the last direction of the first burn to the first of the second.
    """
    if plan.verification is None or plan.status is not PlanStatus.VERIFIED:
        return None
    axes = attitude_axes(plan.scenario)
    flight, vehicle = plan.verification.flight, plan.scenario.vehicle
    rows: list[Array] = []
    mass_kg = vehicle.mass_kg
    for k, burn in enumerate(flight.burns):
        if k:
            rows.append(_coast_rows(axes, flight, k, mass_kg))
        mass = mass_kg - vehicle.mass_flow_kg_s * burn.times_s
        times, rate = burn.times_s + flight.starts_s[2 * k + 1], np.rad2deg(burn.rate_rad_s)
        told = attitude_rows(axes, times, burn.direction, burn.propagated, mass, rate)
        rows.append(np.column_stack([told, np.full(len(told), vehicle.thrust_n)]))
        mass_kg = float(mass[-1])
    table = np.vstack(rows)
    table[:, 0] -= flight.starts_s[1]
    return csv_text((*ATTITUDE_COLUMNS[axes], "thrust_n"), table)


def _coast_rows(axes: str, flight: TransferFlight, k: int, mass_kg: float) -> Array:
    """Of the coast before burn k, without its ends, which are the burns'."""
    coast = flight.coasts[k]
    times, states = coast.times_s[COASTED:-1:COASTED], coast.states[COASTED:-1:COASTED]
    shares = times / coast.times_s[-1]
    first, last = flight.burns[k - 1].direction[-1], flight.burns[k].direction[0]
    still = np.ones(len(times))
    told = attitude_rows(
        axes,
        times + flight.starts_s[2 * k],
        turned(first, last, shares),
        states,
        mass_kg * still,
        np.rad2deg(flight.slew_rad_s) * still,
    )
    return np.column_stack([told, np.zeros(len(told))])


def turned(first: Array, last: Array, shares: Array) -> Array:
    """Unit vectors (K, 3) on the great circle between two, at shares (K,) of the way; of opposite ones, any."""
    axis = np.cross(first, last)
    if np.linalg.norm(axis) < 1e-9:
        axis = np.cross(first, np.eye(3)[int(np.abs(first).argmin())])
    ahead = np.cross(axis / np.linalg.norm(axis), first)
    angle = shares * np.arctan2(last @ ahead, last @ first)
    return np.asarray(np.outer(np.cos(angle), first) + np.outer(np.sin(angle), ahead))
