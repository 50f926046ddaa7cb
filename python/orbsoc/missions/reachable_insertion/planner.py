"""From a scenario to the result of its search for one burn."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from orbsoc.guidance.mission import Column
from orbsoc.guidance.scp import Iteration, Rules, Solve

from .scenario import Scenario
from .search.run import Search, SearchResult, Strategy
from .search.setup import InsertionSetup
from .search.strategies import STRATEGIES

COLUMNS = {
    "nodes": Column("nodes", ".0f"),
    "time_of_flight_s": Column("burn", ".6f", "s"),
    "perigee_height_km": Column("perigee", ".3f", "km"),
    "apogee_height_km": Column("apogee", ".3f", "km"),
}
"""Columns of the iteration table that are this mission's own."""


def searched(
    scenario: Scenario,
    solve: Solve,
    callback: Callable[[Iteration], None] | None = None,
    strategies: Sequence[Strategy] = STRATEGIES,
) -> SearchResult:
    """What the strategies find for a scenario, by any solver with the call shape of `orbsoc.solve`."""
    search = Search(solve, Rules(max_iterations=scenario.method.max_iterations), callback)
    return search.run(InsertionSetup.of(scenario), strategies)
