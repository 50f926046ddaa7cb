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
    lowest = load_scenario(scenarios / "paper004_reach.toml").grid.perigee_height_km.first
    scenario = load_scenario(scenarios / "paper004_reach.toml").with_changes(
        boundary={"perigee_height_km": {"first": lowest, "last": lowest, "step": 1.0}}
    )
    domain = Domain.of(scenario)
    boundary = resolved_boundary(domain)
    found = ReachableDomain(scenario, PointTable.empty(0, domain.tools.grids).columns, boundary)
    return tuple(
        PaperRow(
            quantity=f"{row.limit} (deg)",
            source="table 2",
            paper=f"{row.paper_deg:g}",
            ours=f"{row.whole_deg:.2f}",
            verdict="not reproduced",
            reason=row.reason,
        )
        for row in envelope(found, limits(found))
    )
