"""The envelope of planes, and whose it is compared with: table 2 speaks of the paper's own case alone."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.record.summary import summary
from orbsoc.missions.reachable_domain.search.continuation.boundary import resolved_boundary
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.query.envelope import is_paper_case
from orbsoc.reach import ReachableDomain
from tests.missions.reachable_domain.cases import paper

SPAN = {"first": 27.3, "last": 29.3, "step": 2.0}
GRID = {
    "inclination_deg": SPAN,
    "raan_deg": {"first": 334.25, "last": 336.25, "step": 2.0},
    "perigee_height_km": {"first": 100.0, "last": 100.0, "step": 10.0},
}


@cache
def solved(thrust_n: float, lowest_km: float = 100.0) -> ReachableDomain:
    edge = {"azimuths": 48, "perigee_height_km": {"first": lowest_km, "last": lowest_km, "step": 10.0}}
    scenario = paper().with_changes(vehicle={"thrust_n": thrust_n}, grid=GRID, boundary=edge)
    ready = Domain.of(scenario)
    return ReachableDomain(
        scenario,
        ready.solve_planes(*ready.planes()).columns,
        resolved_boundary(ready),
    )


def test_the_papers_own_case_stands_beside_its_table_2() -> None:
    document = summary(solved(270000.0))
    assert [row["paper_deg"] for row in document["envelope"]] == [16.31, 39.31, 318.27, 349.27]
    for own, beside in zip(document["limits"], document["envelope"], strict=True):
        assert own.items() <= beside.items()
    # 44.72 on 48 equal azimuths, which round off the corner that the edge has at azimuth 25 degrees.
    highest = document["limits"][1]
    assert highest["whole_deg"] == pytest.approx(45.24, abs=0.01)
    assert 0.0 < highest["whole_error_deg"] < 0.045


@pytest.mark.parametrize(("thrust_n", "lowest_km"), [(260000.0, 100.0), (270000.0, 150.0)])
def test_another_vehicle_or_bound_has_its_own_envelope_without_the_papers(
    thrust_n: float, lowest_km: float
) -> None:
    document = summary(solved(thrust_n, lowest_km))
    assert document["envelope"] == []
    assert [row["limit"] for row in document["limits"]] == [
        "lowest inclination", "highest inclination", "lowest node", "highest node"
    ]  # fmt: skip
    assert all(np.isfinite(row["whole_deg"]) for row in document["limits"])


@pytest.mark.parametrize(
    "changes",
    [
        {"vehicle": {"mass_kg": 150000.0}},
        {"vehicle": {"dry_mass_kg": 10000.0}},
        {"burn": {"duration_s": 1100.0}},
        {"burn": {"minimum_altitude_km": 120.0}},
        {"initial": {"position_m": (-4780421.0, 4388673.2, 1079366.2)}},
    ],
)
def test_every_part_of_the_papers_case_counts(changes: dict[str, dict[str, Any]]) -> None:
    assert is_paper_case(paper())
    assert not is_paper_case(paper().with_changes(**changes))


def test_nodes_of_the_grid_are_counted_from_the_current_one_across_zero() -> None:
    """A grid that passes through 360 has its highest node at 366.25, not at 356.25."""
    grid = {**GRID, "raan_deg": {"first": 334.25, "last": 366.25, "step": 32.0}}
    found = solved(270000.0)
    across = ReachableDomain(found.scenario.with_changes(grid=grid), dict(found.points), found.boundary)
    across.points["raan_deg"] = np.where(found.points["raan_deg"] > 335.0, 6.25, found.points["raan_deg"])
    assert summary(across)["limits"][3]["grid_deg"] == pytest.approx(366.25)
