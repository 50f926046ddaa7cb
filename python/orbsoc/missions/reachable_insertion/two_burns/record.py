"""A plan of two burns as plain data: the document behind `plan.json`."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from ..record.document import shared_document
from .search import TOLERANCE, TRUST
from .transfer_plan import TransferPlan
from .verdict import starts_tried, verdict, violations


def plan_document(plan: TransferPlan) -> dict[str, Any]:
    """Everything that JSON can hold, in the keys of a plan with one burn where these mean the same; `burns` holds each."""
    found, best = plan.verification, plan.best
    noted = [replace(each, note=f"{each.note}, from {each.start}") for each in plan.attempts]
    told = replace(plan, attempts=tuple(noted))
    document = shared_document(told, verdict(plan), violations(plan), starts_tried(plan))
    if found is not None:
        document["verification"]["samples"] = sum(each.times_s.size for each in found.flight.burns)
        slew_deg_s = float(np.rad2deg(found.slew_rad_s))
        document["attitude_rate"]["slew_deg_s"] = slew_deg_s if np.isfinite(slew_deg_s) else None
    return document | {
        "delta_v_m_s": plan.delta_v_m_s,
        "coast_s": plan.coast_s,
        "total_time_s": plan.total_time_s,
        "burns": [asdict(each) for each in plan.burns],
        "nodes": best and best.nodes,
        "trajectory": best and _programme_document(plan),
        "settings": {**asdict(TRUST), "tolerance": TOLERANCE},
    }


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
