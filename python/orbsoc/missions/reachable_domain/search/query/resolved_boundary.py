"""The boundary at as many azimuths as it takes: halved where it bends, until its stated error is within the scenario's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array

from ...scenario import Boundary
from ..continuation.boundary import first_azimuths, solve_boundary
from ..continuation.domain import Domain
from .tilt_limit import TiltLimit


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
