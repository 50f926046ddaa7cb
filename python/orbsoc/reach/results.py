"""A solved reachable domain, read from its folder."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from orbsoc.missions.reachable_domain.boundary import inside_box
from orbsoc.missions.reachable_domain.domain import Domain
from orbsoc.missions.reachable_domain.evidence import largest_tilts
from orbsoc.missions.reachable_domain.planes import normals
from orbsoc.missions.reachable_domain.scenario import Scenario
from orbsoc.missions.reachable_domain.table import PointStatus
from orbsoc.missions.reachable_domain.terminal import LargestTilt
from orbsoc.orbit import EARTH, Elements
from orbsoc.sweep import ShardStore, StoreError

from .limits import TiltLimit
from .margin import Margin

Array = NDArray[np.float64]
Columns = dict[str, NDArray[Any]]

POINTS, BOUNDARY = "points", "boundary"


@dataclass(frozen=True, eq=False)
class ReachableDomain:
    """The domain of one scenario: `points` is the grid's table, `boundary` the edge's, columns by name."""

    scenario: Scenario
    points: Columns
    boundary: Columns

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
        """Whether and by how much an orbit lies within reach: the one burn of the scenario, cut off on the orbit.

        Every orbit of its plane with that perigee height or a higher one, and a semi-major axis up to the largest, is
        counted as reached, for the argument of perigee that suits it best: the orbit's own is not looked at, and an
        ellipse turned away from it may be far out of reach. Interpolated from the tables; with `exact` the plane is
        solved now, in a fraction of a second. The answer states an estimate of the interpolation error, not a bound.
        Raises ValueError for an orbit that is not an ellipse or whose perigee lies below the surface.
        """
        height_km = orbit.perigee_height_m() / 1e3
        if not (orbit.sma_m > 0.0 and 0.0 <= orbit.ecc < 1.0):
            raise ValueError(f"orbit: a = {orbit.sma_m} m, e = {orbit.ecc}: must be an ellipse")
        if height_km <= 0.0:
            raise ValueError(
                f"orbit: its perigee lies {-height_km:.3f} km below the surface; must be above it"
            )
        inc_deg, raan_deg = float(np.rad2deg(orbit.inc_rad)), float(np.rad2deg(orbit.raan_rad))
        tilt, azimuth = self.tilt_and_azimuth_deg(inc_deg, raan_deg)
        edge, edge_error, largest, largest_error = (
            self._solved(inc_deg, raan_deg, height_km, azimuth)
            if exact
            else self._interpolated(inc_deg, raan_deg, height_km, azimuth)
        )
        box = inside_box(self.domain, np.array([inc_deg]), np.array([raan_deg]))
        return Margin(
            tilt_deg=edge - tilt,
            tilt_error_deg=edge_error,
            sma_km=largest - orbit.sma_m / 1e3,
            sma_error_km=largest_error,
            inside_box=bool(box[0]),
            exact=exact,
        )

    def _interpolated(
        self, inc: float, raan: float, height: float, azimuth: float
    ) -> tuple[float, float, float, float]:
        limit = self.limit
        lowest = max(height, float(limit.height_km[0]))
        edge, error = float(limit(azimuth, lowest)), float(limit.error_deg(azimuth, lowest))
        west = float(self._axes[1][0])
        at = np.array([[inc, west + np.mod(raan - west, 360.0), max(height, float(self._axes[2][0]))]])
        largest, coarse = (float(table(at)[0]) for table in self._largest)
        error_km = (
            2.0 / 3.0 * abs(largest - coarse)
        )  # a linear table of twice the step has four times the error
        return edge, error, largest, error_km + 1e-3

    def _solved(
        self, inc: float, raan: float, height: float, azimuth: float
    ) -> tuple[float, float, float, float]:
        table = self.domain.solve_planes(np.array([inc]), np.array([raan]), np.array([height]))
        perigee = np.array([1.0 + 1e3 * height / EARTH.earth_radius_m])
        edge = largest_tilts(
            self.domain.tools, LargestTilt(self.domain.frame, np.deg2rad([azimuth]), perigee)
        )
        reached = table["status"][0] == PointStatus.REACHED.value
        # On a plane that is not reached there is no orbit at all.
        largest = float(table["a_km"][0]) if reached else -np.inf
        error = largest * self.scenario.verification.sma_rel if reached else 0.0
        return float(np.rad2deg(edge.tilt[0])), float(np.rad2deg(edge.change[0])), largest, error

    @cached_property
    def _axes(self) -> tuple[Array, Array, Array]:
        grid = self.scenario.grid
        return grid.inclination_deg.values(), grid.raan_deg.values(), grid.perigee_height_km.values()

    @cached_property
    def _largest(self) -> tuple[RegularGridInterpolator, RegularGridInterpolator]:
        """The largest semi-major axis (km) by linear interpolation, on the whole grid and on every second plane."""
        axes = self._axes
        cube = self.points["a_km"].reshape([len(axis) for axis in axes])
        both = []
        for step in (1, 2):
            thin = [axis[::step] if len(axis) > 2 * step else axis for axis in axes[:2]]
            part = cube[:: step if len(axes[0]) > 2 * step else 1, :: step if len(axes[1]) > 2 * step else 1]
            both.append(
                RegularGridInterpolator((*thin, axes[2]), part, bounds_error=False, fill_value=np.nan)
            )
        return both[0], both[1]


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
    for name, found, expected in ((POINTS, points, rows), (BOUNDARY, boundary, edge_rows)):
        have = len(next(iter(found.values())))
        if have != expected:
            raise StoreError(
                f"{folder}: has {have} of {expected} rows of `{name}`; resume the sweep (--resume) to finish it"
            )
    # Shards hold planes from all over the grid: put the rows back in its order.
    order = np.lexsort((points["perigee_bound_km"], points["raan_deg"], points["inc_deg"]))
    return ReachableDomain(scenario, {name: values[order] for name, values in points.items()}, boundary)
