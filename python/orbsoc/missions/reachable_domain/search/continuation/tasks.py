"""A scenario as coarse tasks of plain values, and their work: what a worker process or a cluster is given."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.files.versions import __version__
from orbsoc.orbit.array import Array
from orbsoc.sweep.journal import Journal

from ...model.direct.subproblems import Subproblems
from ...scenario import Scenario
from .boundary import solve_boundary
from .domain import Domain

AZIMUTHS_PER_SHARD = 24
PACKAGE = "orbsoc.missions.reachable_domain"
"""Whose classes a journal holds."""

Columns = dict[str, NDArray[Any]]


def grid_shards(domain: Domain) -> Iterator[tuple[int, dict[str, Any]]]:
    """Rows and payload of every shard of the grid: some planes each, with all perigee bounds.

    A shard has planes from all over the grid, so that each has its part of the edge, where planes take longest.
    """
    inc, raan = domain.planes()
    shards = -(-len(inc) // domain.scenario.method.planes_per_shard)
    bounds = domain.scenario.grid.perigee_height_km.count
    document = domain.scenario.model_dump(mode="json")
    for first in range(shards):
        part = slice(first, None, shards)
        payload = {"scenario": document, "inc_deg": inc[part].tolist(), "raan_deg": raan[part].tolist()}
        yield len(payload["inc_deg"]) * bounds, payload


def boundary_shards(domain: Domain, azimuths: Array) -> Iterator[tuple[int, dict[str, Any]]]:
    """Rows and payload of every shard of the boundary at some azimuths: a few each, at all its perigee bounds.

    Azimuths of the upper half circle only: each row stands for its mirror image too (`boundary.solve_boundary`).
    """
    bounds = 2 * domain.scenario.boundary.perigee_height_km.count
    document = domain.scenario.model_dump(mode="json")
    for start in range(0, len(azimuths), AZIMUTHS_PER_SHARD):
        part = azimuths[start : start + AZIMUTHS_PER_SHARD]
        yield len(part) * bounds, {"scenario": document, "azimuth_deg": part.tolist()}


def solve_grid_shard(payload: Mapping[str, Any], solve: Subproblems | None = None) -> Columns:
    """The table of one shard of the grid. Where the payload names a `journal`, a file, finished parts are kept there, and those
    that it has are not computed again."""
    domain = _domain(json.dumps(payload["scenario"]))
    if solve is not None:
        domain = Domain.of(domain.scenario, solve=solve)
    planes = np.array(payload["inc_deg"]), np.array(payload["raan_deg"])
    if "journal" not in payload:
        return domain.solve_planes(*planes).columns
    what = {name: value for name, value in payload.items() if name != "journal"}
    key = f"{__version__} {json.dumps(what, sort_keys=True)}"
    with closing(Journal(Path(payload["journal"]), key, PACKAGE)) as journal:
        return domain.solve_planes(*planes, part=journal.part).columns


def solve_boundary_shard(payload: Mapping[str, Any]) -> Columns:
    """The table of one shard of the boundary."""
    return solve_boundary(_domain(json.dumps(payload["scenario"])), np.array(payload["azimuth_deg"]))


@lru_cache(maxsize=4)
def _domain(document: str) -> Domain:
    """Of a scenario in JSON; one worker gets many tasks of one scenario."""
    return Domain.of(Scenario.model_validate_json(document))
