"""The envelope that the paper prints, beside that of the boundary."""

from __future__ import annotations

from pathlib import Path

from orbsoc.guidance.mission import PaperRow

from .scenario import load_scenario
from .search.continuation.boundary import resolved_boundary
from .search.continuation.domain import Domain
from .search.continuation.table import PointTable
from .search.query.envelope import envelope, limits
from .search.query.results import ReachableDomain


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    """The envelope of the paper's table 2 beside that of the boundary at its lowest perigee height."""
    scenario = load_scenario(scenarios / "paper004_reach.toml")
    lowest = scenario.grid.perigee_height_km.first
    height = {"first": lowest, "last": lowest, "step": 1.0}
    scenario = scenario.with_changes(boundary={"perigee_height_km": height})
    domain = Domain.of(scenario)
    boundary = resolved_boundary(domain)
    found = ReachableDomain(scenario, PointTable.empty(0, domain.tools.grids).columns, boundary)
    return tuple(
        PaperRow(
            f"{row.limit} (deg)",
            "table 2",
            f"{row.paper_deg:g}",
            f"{row.whole_deg:.2f}",
            "not reproduced",
            row.reason,
        )
        for row in envelope(found, limits(found))
    )
