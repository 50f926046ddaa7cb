"""The boundary of the reachable domain: the largest tilt at each azimuth about the current plane, a curve per bound, halved
where it bends until its stated error is within the scenario's.

The perigee is free to lie in any direction and above its bound; a bound on the altitude is kept. What a scenario asks of the
perigee beyond that makes the domain smaller: `edge_note` says so, and its edge is not drawn.

No grid and no bisection: the largest tilt is itself the optimum of a convex sequence (`terminal.LargestTilt`). The
error of a point is estimated by the change from a grid of half as many nodes, on which it depends most.

A burn mirrored in the current plane is a burn from the same state, and tilts the orbit as much the other way: the edge at
azimuth β + 180° is the edge at β. Half the azimuths are solved, the other half are their mirror images. (True of a point
mass; an oblate Earth would break it.)
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array, Flags
from orbsoc.orbit.planes import inclination_and_node

from ...model.direct.terminal import LargestTilt
from ...model.flight.orbits import canonical_radius
from ...scenario import Boundary
from ..query.tilt_limit import TiltLimit
from .domain import Domain
from .largest_tilt import largest_tilts
from .table import PointStatus

_STATUS = [PointStatus.NOT_REACHED.value, PointStatus.SOLVER_FAILED.value, PointStatus.OUTSIDE.value]


def first_azimuths(domain: Domain) -> Array:
    """Equal steps over the upper half circle, degrees: the azimuths that the boundary begins with."""
    half = domain.scenario.boundary.azimuths // 2
    return np.asarray(np.arange(half) * (180.0 / half))


def solve_boundary(domain: Domain, azimuth_deg: Array) -> dict[str, NDArray[Any]]:
    """Columns for azimuths and their opposites × the scenario's boundary heights; NaN tilts where no orbit meets
    the bound, or the sequence failed. The iterations stand with the azimuths that were solved."""
    heights = domain.scenario.boundary.perigee_height_km.values()
    azimuth = np.repeat(azimuth_deg, len(heights))
    bound = np.tile(heights, len(azimuth_deg))
    target = LargestTilt(domain.frame, np.deg2rad(azimuth), canonical_radius(bound))
    found = largest_tilts(domain.tools, target)
    azimuth, tilt = np.concatenate([azimuth, azimuth + 180.0]), np.tile(found.tilt, 2)
    inc, raan = inclination_and_node(domain.frame.tilted(tilt, np.deg2rad(azimuth)))
    inc_deg, raan_deg = np.rad2deg(inc), np.rad2deg(raan)
    mirrored = np.zeros(len(found.tilt), np.int32)
    inside, unknown = inside_box(domain, inc_deg, raan_deg), np.isnan(tilt)
    cases = [unknown & np.tile(found.infeasible, 2), unknown, ~inside]
    return {
        "azimuth_deg": azimuth,
        "perigee_bound_km": np.tile(bound, 2),
        "tilt_deg": np.rad2deg(tilt),
        "tilt_change_deg": np.rad2deg(np.tile(found.change, 2)),
        "inc_deg": inc_deg,
        "raan_deg": raan_deg,
        "status": np.select(cases, _STATUS, PointStatus.REACHED.value).astype(object),
        "inside_box": inside,
        "nodes": np.tile(found.nodes.astype(np.int32), 2),
        "sequence_iterations": np.concatenate([found.subproblems.sum(axis=1), mirrored]),
        "solver_iterations": np.concatenate([found.solver_iterations, mirrored]),
    }


def next_azimuths(rules: Boundary, boundary: Mapping[str, NDArray[Any]]) -> Array:
    """Azimuths within 0…180 to solve next, given the boundary's columns so far; none where it is resolved, or has as many
    as the scenario allows."""
    limit = TiltLimit.of(boundary)
    return limit.unresolved(rules.tolerance_deg, (rules.most_azimuths - len(limit.azimuth_deg)) // 2)


def resolved_boundary(domain: Domain) -> dict[str, NDArray[Any]]:
    """Columns of the boundary, solved in this process."""
    rules = domain.scenario.boundary
    azimuths, boundary = first_azimuths(domain), None
    while azimuths.size:
        found = solve_boundary(domain, azimuths)
        if boundary is not None:
            found = {name: np.concatenate([boundary[name], found[name]]) for name in found}
        boundary = found
        azimuths = next_azimuths(rules, boundary)
    assert boundary is not None
    return boundary


def edge_note(domain: Domain) -> str:
    """Why the curve is not the edge of the scenario's own domain; empty where it is."""
    perigee = domain.scenario.perigee
    if perigee.argp_deg is not None:
        return (
            f"not drawn: the edge with the argument of perigee at {perigee.argp_deg:g} deg is not sought; boundary.parquet holds"
            " that with the perigee anywhere, which is an outer limit"
        )
    if perigee.condition == "equal":
        return (
            "not drawn: the edge with the perigee at its bound is not sought; boundary.parquet holds that with the perigee at"
            " its bound or above, which is an outer limit"
        )
    return ""


def inside_box(domain: Domain, inc_deg: Array, raan_deg: Array) -> Flags:
    """Whether planes lie within the grid's ranges of inclination and node."""
    grid = domain.scenario.grid
    low, high = grid.inclination_deg.first, grid.inclination_deg.values()[-1]
    west, width = grid.raan_deg.first, grid.raan_deg.values()[-1] - grid.raan_deg.first
    east_of = np.mod(raan_deg - west + 1e-9, 360.0)
    return np.asarray((inc_deg >= low - 1e-9) & (inc_deg <= high + 1e-9) & (east_of <= width + 2e-9))
