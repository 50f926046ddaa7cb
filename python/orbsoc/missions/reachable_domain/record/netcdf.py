"""The points as a labelled cube, for xarray and whatever else reads NetCDF."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..search.continuation.table import COUNTS, FLOATS, PointStatus, subproblems_on
from ..search.query.results import ReachableDomain
from .cost import CYCLES, DomainCost

AXES = ("inc_deg", "raan_deg", "perigee_bound_km")
STATUSES = tuple(PointStatus)
UNITS = {"deg": "degree", "km": "km", "m": "m", "rad": "rad", "rel": "1"}


def dataset(domain: ReachableDomain, cost: DomainCost | None = None) -> Any:
    """An `xarray.Dataset` over inclination, node and perigee bound; `status` is a flag with its meanings. With `cost` the
    modelled cycles of every point are in it too."""
    import xarray

    grid = domain.scenario.grid
    spans = (grid.inclination_deg, grid.raan_deg, grid.perigee_height_km)
    axes = dict(zip(AXES, (span.values() for span in spans), strict=True))
    shape = tuple(len(values) for values in axes.values())
    variables: dict[str, Any] = {}
    for name in (*FLOATS, *COUNTS, *map(subproblems_on, domain.domain.tools.grids)):
        if name not in AXES:
            units = {"units": UNITS.get(name.rsplit("_", 1)[-1], "1")}
            variables[name] = (AXES, domain.points[name].reshape(shape), units)
    codes = np.select([domain.points["status"] == status.value for status in STATUSES], range(len(STATUSES)))
    meanings = " ".join(status.value.replace(" ", "_") for status in STATUSES)
    flags = {"flag_values": np.arange(len(STATUSES), dtype=np.int8), "flag_meanings": meanings}
    variables["status"] = (AXES, codes.astype(np.int8).reshape(shape), flags)
    if cost is not None:
        about = {"units": "1", "long_name": cost.unit, "provenance": "modelled", "source": cost.source}
        variables[CYCLES] = (AXES, cost.cycles.reshape(shape), about)
    attributes = {"title": f"reachable domain {domain.scenario.name}", "Conventions": "CF-1.11"}
    return xarray.Dataset(variables, coords=axes, attrs=attributes)


def write_netcdf(domain: ReachableDomain, path: Path, cost: DomainCost | None = None) -> None:
    """Write the cube as NetCDF 4."""
    dataset(domain, cost).to_netcdf(path, engine="h5netcdf")
