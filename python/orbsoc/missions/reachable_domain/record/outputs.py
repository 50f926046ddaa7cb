"""The files beside the shards: boundary, summary, figures, NetCDF, report. All rewritten whole from the shards."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from orbsoc.files.atomic_write import write_atomically
from orbsoc.files.versions import versions

from ..search.continuation.table import COUNTS, FLOATS, PointStatus, subproblems_on
from ..search.query.results import ReachableDomain
from .cost import CYCLES, DomainCost
from .summary import summary

SUMMARY, POINTS_FILE, BOUNDARY_FILE = "summary.json", "points.parquet", "boundary.parquet"
CUBE, REPORT, BAND = "domain.nc", "report.html", "band.html"
SCHEMA = "orbsoc.reach/1"
TEMPLATE = "reach.html.j2"
"""Beside this file."""

Render = Callable[..., str]
AXES = ("inc_deg", "raan_deg", "perigee_bound_km")
STATUSES = tuple(PointStatus)
UNITS = {"deg": "degree", "km": "km", "m": "m", "rad": "rad", "rel": "1"}


def write_outputs(
    folder: Path, domain: ReachableDomain, cost: DomainCost, extra: Mapping[str, Any], render: Render | None
) -> dict[str, Any]:
    """Write everything but the shards into `folder`; returns the content of `summary.json`.

    `render` makes the report's page: `orbsoc.report.page.render`. Without it there are the tables and the summary only.
    """
    import pyarrow as pa
    import pyarrow.parquet as parquet

    document = {"schema": SCHEMA, **summary(domain), **extra, "versions": versions()}
    parquet.write_table(points_table(domain, cost), folder / POINTS_FILE)
    parquet.write_table(pa.table(dict(domain.boundary)), folder / BOUNDARY_FILE)
    pictured = _pictured(folder, domain, cost, document, render) if render else ()
    document["files"] = sorted([SUMMARY, POINTS_FILE, BOUNDARY_FILE, *pictured])
    finite: dict[str, Any] = _finite(document)
    write_atomically(folder / SUMMARY, json.dumps(finite, indent=2, allow_nan=False) + "\n")
    return finite


def _pictured(
    folder: Path, domain: ReachableDomain, cost: DomainCost, document: Mapping[str, Any], render: Render
) -> tuple[str, ...]:
    """Write figures, pages and the NetCDF cube, whose libraries take longer to load than a small domain to solve."""
    from ..figures.band_page import write_band
    from ..figures.draw import draw_figures

    figures = draw_figures(domain, folder)
    write_band(domain, folder / BAND)
    cube(domain, cost).to_netcdf(folder / CUBE, engine="h5netcdf")
    page = render(TEMPLATE, figures, folder, folder=Path(__file__).parent, found=document, band=BAND)
    write_atomically(folder / REPORT, page)
    return (CUBE, REPORT, BAND, *(figure.name for figure in figures))


def points_table(domain: ReachableDomain, cost: DomainCost) -> Any:
    """The whole table as one of Arrow, in the grid's order, with the modelled cycles of every point; their field's metadata
    say in what unit and where they come from. Attitude programmes stay with the shards."""
    import pyarrow as pa

    plain = {name: values for name, values in domain.points.items() if name != "commands"}
    table = pa.table(plain)
    about = {"unit": cost.unit, "provenance": "modelled", "source": cost.source}
    about |= {"device": cost.device, "partition": cost.partition}
    return table.append_column(pa.field(CYCLES, pa.float64(), metadata=about), pa.array(cost.cycles))


def cube(domain: ReachableDomain, cost: DomainCost) -> Any:
    """The points as a labelled cube, an `xarray.Dataset` over inclination, node and perigee bound, with the modelled cycles of
    every point; `status` is a flag with its meanings."""
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
    about = {"units": "1", "long_name": cost.unit, "provenance": "modelled", "source": cost.source}
    variables[CYCLES] = (AXES, cost.cycles.reshape(shape), about)
    attributes = {"title": f"reachable domain {domain.scenario.name}", "Conventions": "CF-1.11"}
    return xarray.Dataset(variables, coords=axes, attrs=attributes)


def _finite(value: Any) -> Any:
    """JSON has no NaN: null instead."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
