"""A solved reachable domain, read from its folder."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.files.html_table import html_table
from orbsoc.orbit import Elements
from orbsoc.orbit.planes import normals
from orbsoc.sweep import ShardStore, StoreError

from ...model.direct.terminal import LargestTilt
from ...model.flight.orbits import canonical_radius
from ...scenario import Scenario
from ..continuation.boundary import inside_box, next_azimuths
from ..continuation.domain import Domain
from ..continuation.largest_tilt import RESOLUTION_RAD, largest_tilts
from ..continuation.table import PointStatus
from .largest_orbit import LargestOrbits
from .margin import Margin, Verdict, check_orbit
from .shortest_burn import shortest_burn
from .tilt_limit import TiltLimit

Columns = dict[str, NDArray[Any]]
Known = tuple[float, float]
"""A number and the error that it may have."""

POINTS, BOUNDARY = "points", "boundary"

CIRCULAR = 1e-6
"""Eccentricity up to which the perigee's direction is nothing: a dozen metres between perigee and apogee."""
SAME_ARGP_DEG = 1e-6
"""Arguments of perigee nearer than this are the same."""


@dataclass(frozen=True, eq=False)
class ReachableDomain:
    """The domain of one scenario: `points` is the grid's table, `boundary` the edge's, columns by name."""

    scenario: Scenario
    points: Columns
    boundary: Columns

    def __repr__(self) -> str:
        return f"ReachableDomain({', '.join(f'{name} {value}' for name, value in self._counts().items())})"

    def _repr_html_(self) -> str:
        return html_table(f"ReachableDomain {self.scenario.name}", self._counts())

    def _counts(self) -> dict[str, object]:
        """What a reader wants to know first."""
        heights = self.scenario.grid.perigee_height_km.values()
        return {
            "scenario": self.scenario.name,
            "points": len(next(iter(self.points.values()), ())),
            "boundary": len(next(iter(self.boundary.values()), ())),
            "perigee heights": f"{heights[0]:g} to {heights[-1]:g} km",
        }

    @cached_property
    def domain(self) -> Domain:
        """The tools that solved it, for points that are not in the table."""
        return Domain.of(self.scenario)

    @cached_property
    def limit(self) -> TiltLimit:
        """The edge as a function of azimuth and perigee height."""
        return TiltLimit.of(self.boundary)

    def tilt_and_azimuth_deg(self, inc_deg: float, raan_deg: float) -> tuple[float, float]:
        """Tilt and azimuth of a plane about the current one."""
        tilt, azimuth = self.domain.frame.tilt_and_azimuth(normals(np.deg2rad(inc_deg), np.deg2rad(raan_deg)))
        return float(np.rad2deg(tilt)), float(np.rad2deg(azimuth))

    def can_reach(self, orbit: Elements, *, exact: bool = False) -> Margin:
        """Whether and by how much an orbit lies within reach: the burn of the scenario, cut off on the orbit.

        The tables know the largest orbit of each plane for each perigee height, its perigee where it suits best. They
        rule out what is larger or tilted further, and promise nothing: an orbit may be smaller and still not be met, as
        a short burn in orbit shows. With `exact` the plane is solved now, and unless that rules the orbit out the
        shortest burn onto it, its own perigee included, is sought and flown: that decides. It takes a few seconds.
        The scenario's least altitude holds during the burn, cut-off included. Errors of interpolated numbers are estimates.
        Raises OrbitError, a ValueError that names the field, for an orbit that is not an ellipse above the ground; TypeError
        for what is no orbit.
        """
        if not isinstance(orbit, Elements):
            raise TypeError(f"`orbit` is of type {type(orbit).__name__}; it must be an orbsoc.orbit.Elements")
        check_orbit(orbit)
        height_km = orbit.perigee_height_m() / 1e3
        inc_deg, raan_deg = float(np.rad2deg(orbit.inc_rad)), float(np.rad2deg(orbit.raan_rad))
        tilt, azimuth = self.tilt_and_azimuth_deg(inc_deg, raan_deg)
        not_in_tables = self._not_in_tables(orbit)
        ask = self._solved if exact else self._interpolated
        (edge, edge_error), (largest, largest_error) = ask(inc_deg, raan_deg, height_km, azimuth)
        if not exact and self._made_for_another_perigee(orbit):
            largest, largest_error = np.nan, np.nan
        box = inside_box(self.domain, np.array([inc_deg]), np.array([raan_deg]))
        found = Margin(
            tilt_deg=edge - tilt,
            tilt_error_deg=edge_error,
            sma_km=largest - orbit.sma_m / 1e3,
            sma_error_km=largest_error,
            over_floor_km=self._over_floor_km(orbit),
            inside_box=bool(box[0]),
            exact=exact,
            not_in_tables=not_in_tables,
        )
        if not exact or found.verdict is Verdict.BEYOND:
            return found
        return replace(found, burn=shortest_burn(self.scenario, orbit))

    def _over_floor_km(self, orbit: Elements) -> float:
        """The apogee over the least altitude of the burn; inf without one, and 0 as far below it as flights may be."""
        floor_km = self.scenario.burn.minimum_altitude_km
        if floor_km is None:
            return float("inf")
        over = orbit.apogee_height_m() / 1e3 - floor_km
        return over if over < -self.scenario.verification.bound_m / 1e3 else max(over, 0.0)

    def _made_for_another_perigee(self, orbit: Elements) -> bool:
        """Whether the tables fix an argument of perigee that is not the orbit's; a circular one has any."""
        argp_deg = self.scenario.perigee.argp_deg
        if argp_deg is None or orbit.ecc <= CIRCULAR:
            return False
        away = np.mod(np.rad2deg(orbit.argp_rad) - argp_deg + 180.0, 360.0) - 180.0
        return bool(abs(away) > SAME_ARGP_DEG)

    def _not_in_tables(self, orbit: Elements) -> str:
        """Why the tables cannot be asked about an orbit; empty where they can."""
        height_km, heights = orbit.perigee_height_m() / 1e3, self.scenario.grid.perigee_height_km.values()
        if not heights[0] - 1e-9 <= height_km <= heights[-1] + 1e-9:
            have = f"{heights[0]:g}…{heights[-1]:g} km"
            return f"its perigee height, {height_km:.6g} km, is not in the tables ({have})"
        if not self.limit.covers(height_km):
            return f"no edge is known at its perigee height, {height_km:.6g} km"
        if self._made_for_another_perigee(orbit):
            return f"the tables were made for an argument of perigee of {self.scenario.perigee.argp_deg:g} degrees"
        return ""

    def _interpolated(self, inc: float, raan: float, height: float, azimuth: float) -> tuple[Known, Known]:
        """The furthest tilt (deg) and the largest semi-major axis (km) by the tables."""
        edge, error = float(self.limit(azimuth, height)), float(self.limit.error_deg(azimuth, height))
        return (edge, error), self.largest(inc, raan, height)

    def _solved(self, inc: float, raan: float, height: float, azimuth: float) -> tuple[Known, Known]:
        """The same, solved now."""
        free = self.domain.with_free_perigee()
        table = free.solve_planes(np.array([inc]), np.array([raan]), np.array([height]))
        perigee = np.array([canonical_radius(height)])
        edge = largest_tilts(free.tools, LargestTilt(free.frame, np.deg2rad([azimuth]), perigee))
        tilt = float(np.rad2deg(edge.tilt[0]))
        uncertainty = float(np.rad2deg(np.fmax(edge.change[0], RESOLUTION_RAD)))
        status = table["status"][0]
        if status == PointStatus.REACHED.value:
            largest = float(table["a_km"][0])
            if largest < 0.0:  # a hyperbola has more energy than any ellipse
                return (tilt, uncertainty), (float("inf"), 0.0)
            error = np.fmax(table["sma_error_rel"][0], self.scenario.verification.sma_rel)
            return (tilt, uncertainty), (largest, largest * float(error))
        # On a plane beyond the edge there is no orbit at all; of one within it that no plan was found for nothing is known.
        beyond = status == PointStatus.NOT_REACHED.value and not table["tilt_deg"][0] < tilt - uncertainty
        return (tilt, uncertainty), (float(-np.inf if beyond else np.nan), 0.0)

    @cached_property
    def largest(self) -> LargestOrbits:
        """The largest semi-major axis (km) as a function of plane and perigee height."""
        grid = self.scenario.grid
        axes = [span.values() for span in (grid.inclination_deg, grid.raan_deg, grid.perigee_height_km)]
        return LargestOrbits.of(axes, self.points["a_km"])


def load(folder: str | PathLike[str]) -> ReachableDomain:
    """Read the results of `orbsoc reach` from a folder.

    Raises `orbsoc.sweep.StoreError` when it is not one, or lacks shards.
    """
    store = ShardStore.load(Path(folder))
    scenario = Scenario.model_validate(store.document())
    points, boundary = store.read(POINTS), store.read(BOUNDARY)
    grid, edge = scenario.grid, scenario.boundary
    rows = grid.inclination_deg.count * grid.raan_deg.count * grid.perigee_height_km.count
    edge_rows = 2 * (edge.azimuths // 2) * edge.perigee_height_km.count
    if len(boundary["azimuth_deg"]) >= edge_rows:  # what was added where the edge bends
        edge_rows = len(boundary["azimuth_deg"])
        edge_rows += 2 * len(next_azimuths(edge, boundary)) * edge.perigee_height_km.count
    for name, found, expected in ((POINTS, points, rows), (BOUNDARY, boundary, edge_rows)):
        have = len(next(iter(found.values())))
        if have != expected:
            raise StoreError(
                f"{folder}: has {have} of {expected} rows of `{name}`; resume the sweep (--resume) to finish it"
            )
    # Shards hold planes from all over the grid: put the rows back in its order.
    order = np.lexsort((points["perigee_bound_km"], points["raan_deg"], points["inc_deg"]))
    return ReachableDomain(scenario, {name: values[order] for name, values in points.items()}, boundary)
