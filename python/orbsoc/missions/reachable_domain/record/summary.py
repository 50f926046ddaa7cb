"""What a solved domain amounts to: counts, work, accuracy, envelope, in one document."""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from typing import Any

import numpy as np

from ..planner import CHECKED
from ..search.continuation.boundary import edge_note
from ..search.continuation.table import PointStatus
from ..search.query.envelope import envelope, limits
from ..search.query.results import ReachableDomain


def summary(domain: ReachableDomain) -> dict[str, Any]:
    """The content of `summary.json`, apart from times and hardware."""
    points, edge, own = domain.points, domain.boundary, limits(domain)
    reached = points["status"] == PointStatus.REACHED.value
    lowest = points["perigee_bound_km"] == points["perigee_bound_km"].min()
    return {
        "scenario": domain.scenario.name,
        "points": len(points["status"]),
        "planes": int(lowest.sum()),
        "planes_reached_at_lowest_bound": int((lowest & reached).sum()),
        "status": dict(sorted(Counter(points["status"].tolist()).items())),
        "origin": dict(sorted(Counter(points["origin"].tolist()).items())),
        "level": dict(sorted(Counter(points["level"][reached].tolist()).items())),
        "work": {
            name: int(points[name].sum() + (edge[name].sum() if name in edge else 0))
            for name in ("sequence_iterations", "solver_iterations", "newton_steps")
        },
        "worst": _worst(points, reached),
        "nearest_to_the_edge": nearest_to_the_edge(domain),
        "boundary": {
            "not_drawn": edge_note(domain.domain),
            "points": len(edge["tilt_deg"]),
            "failed": int(np.isnan(edge["tilt_deg"]).sum()),
            "outside_search_box": int((~edge["inside_box"]).sum()),
            "largest_change_from_coarser_grid_deg": float(np.nanmax(edge["tilt_change_deg"], initial=0.0)),
        },
        "limits": [asdict(row) for row in own],
        "envelope": [asdict(row) for row in envelope(domain, own)],
    }


def nearest_to_the_edge(domain: ReachableDomain, within_deg: float = 0.02) -> list[dict[str, Any]]:
    """Grid planes at the lowest bound that lie nearer to the edge than `within_deg`: numerics may decide about them."""
    points = domain.points
    rows = np.flatnonzero(points["perigee_bound_km"] == points["perigee_bound_km"].min())
    gap = (
        domain.limit(points["azimuth_deg"][rows], points["perigee_bound_km"][rows]) - points["tilt_deg"][rows]
    )
    near = np.flatnonzero(np.abs(gap) < within_deg)
    return [
        {
            "inc_deg": float(points["inc_deg"][rows[k]]),
            "raan_deg": float(points["raan_deg"][rows[k]]),
            "inside_by_deg": float(gap[k]),
            "status": str(points["status"][rows[k]]),
        }
        for k in near
    ]


def _worst(points: dict[str, Any], reached: Any) -> dict[str, float]:
    """The largest miss of any reached point."""
    return {name: float(points[name][reached].max()) if reached.any() else 0.0 for name in CHECKED}
