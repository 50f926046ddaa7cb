"""Results: one row a point of the grid, in words a person can act on, and columns with units in their names."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit.array import Array, Flags, Index

from ...model.flight.orbits import RADIUS_M, Flown
from .attempts import Attempts

Counts = NDArray[np.int32]


class PointStatus(enum.StrEnum):
    """What is known of a point; the value is the phrase for a person and for files."""

    REACHED = "reached"
    NOT_REACHED = "not reached after these attempts"
    SOLVER_FAILED = "solver failed"
    OUTSIDE = "outside the search box"


class Origin(enum.StrEnum):
    """Where a row's plan or evidence comes from."""

    COLD = "cold start"
    CONTINUATION = "continued from the bound below"
    REUSED = "plan of a lower bound, whose perigee is high enough"
    LARGEST_TILT = "restart from the furthest tilt at its azimuth"
    PERIGEE_AT_BOUND = "perigee lowered to its bound by Newton"
    BELOW = "not reached at a lower bound already"
    TURNED = "perigee turned from its natural direction by Newton"
    NEIGHBOUR = "restart from the plan of the nearest plane"


FLOATS = (
    "inc_deg", "raan_deg", "perigee_bound_km", "tilt_deg", "azimuth_deg", "a_km", "ecc", "apogee_km", "perigee_km",
    "argp_deg", "lowest_km", "sma_error_rel", "plane_error_rad", "perigee_short_m", "altitude_short_m",
    "raw_most_rel", "raw_least_rel", "furthest_tilt_deg",
)  # fmt: skip
"""Columns of numbers. Heights are over the equatorial radius; errors compare the flown plan with its prediction and
its bounds; `raw_most_rel` and `raw_least_rel` are the extremes of ‖u‖ − 1 of the attitude programme between its nodes (a polished
one is a primer, whose length has no meaning below 1); `furthest_tilt_deg` is the boundary point at the azimuth of a point that was not reached, NaN where none was sought."""
COUNTS = ("nodes", "command_nodes", "sequence_iterations", "solver_iterations", "newton_steps")
"""Columns of integers: nodes of the last sequence and of the attitude programme, subproblems solved for this row,
iterations in them (Newton steps on the dual, interior-point iterations), Newton steps of the polish. Beside them there is
`subproblems_N` for every grid of N nodes: they add up to `sequence_iterations`."""


def subproblems_on(nodes: int) -> str:
    """The column that counts the subproblems on a grid."""
    return f"subproblems_{nodes}"


WORDS = ("status", "origin", "level", "evidence")


@dataclass(slots=True, eq=False)
class PointTable:
    """Columns by name, all of one length; `commands` has flattened programmes (3N,) or None."""

    columns: dict[str, NDArray[Any]]
    grids: tuple[int, ...]

    @classmethod
    def empty(cls, rows: int, grids: tuple[int, ...]) -> PointTable:
        """Nothing known of `rows` rows, for which sequences may be run on `grids`."""
        columns: dict[str, NDArray[Any]] = {name: np.full(rows, np.nan) for name in FLOATS}
        columns |= {name: np.zeros(rows, np.int32) for name in (*COUNTS, *map(subproblems_on, grids))}
        columns |= {name: np.full(rows, "", dtype=object) for name in WORDS}
        columns["commands"] = np.full(rows, None, dtype=object)
        return cls(columns, grids)

    def __len__(self) -> int:
        return len(self.columns["status"])

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.columns[name]

    def reached(self) -> Flags:
        """Rows whose point is reached."""
        return np.asarray(self["status"] == PointStatus.REACHED.value)

    def write_spent(self, rows: Index, found: Attempts) -> None:
        """Add what the attempts cost."""
        self.add_cost(rows, found.subproblems, found.solver_iterations, found.newton_steps)

    def add_cost(
        self, rows: Index, subproblems: Counts, iterations: Counts, newton_steps: Counts | int = 0
    ) -> None:
        """Add subproblems (B, grids), the iterations (B,) in them, and steps (B,) of Newton."""
        for nodes, spent in zip(self.grids, subproblems.T, strict=False):
            self[subproblems_on(nodes)][rows] += spent
        self["sequence_iterations"][rows] += subproblems.sum(axis=1)
        self["solver_iterations"][rows] += iterations
        self["newton_steps"][rows] += newton_steps

    def write_plans(self, rows: Index, found: Attempts, origin: Origin | NDArray[np.object_]) -> None:
        """Rows whose plans a flight confirmed."""
        self["status"][rows] = PointStatus.REACHED.value
        self["origin"][rows] = origin.value if isinstance(origin, Origin) else origin
        self["level"][rows] = np.where(found.polished, "polished", "collocated")
        self["nodes"][rows] = found.nodes
        self["command_nodes"][rows] = [len(vectors) for vectors in found.programmes]
        for row, vectors in zip(rows, found.programmes, strict=True):
            self["commands"][row] = vectors.ravel()
        self.write_flown(rows, found.flown)

    def clear_plans(self, rows: Index) -> None:
        """Forget the plans of rows."""
        self.write_flown(rows, Flown.blank(len(rows)))
        self["commands"][rows] = None
        self["level"][rows] = ""

    def write_flown(self, rows: Index, flown: Flown) -> None:
        """Numbers of flown plans."""
        km = RADIUS_M / 1e3
        self["a_km"][rows], self["ecc"][rows] = flown.sma * km, flown.ecc
        self["perigee_km"][rows] = (flown.perigee - 1.0) * km
        apogee = np.where(flown.ecc < 1.0, flown.sma * (1.0 + flown.ecc), np.inf)
        self["apogee_km"][rows] = (apogee - 1.0) * km
        self["argp_deg"][rows] = np.rad2deg(flown.argp)
        self["lowest_km"][rows] = (flown.lowest - 1.0) * km
        self["sma_error_rel"][rows], self["plane_error_rad"][rows] = flown.sma_error, flown.plane_error
        self["perigee_short_m"][rows] = flown.perigee_short * RADIUS_M
        self["altitude_short_m"][rows] = flown.altitude_short * RADIUS_M
        self["raw_most_rel"][rows], self["raw_least_rel"][rows] = flown.raw_most - 1.0, flown.raw_least - 1.0

    def write_failures(
        self, rows: Index, status: PointStatus, origin: Origin, evidence: list[str], furthest_tilt: Array
    ) -> None:
        """Rows without a plan, with the reason."""
        self["status"][rows] = status.value
        self["origin"][rows] = origin.value
        self["evidence"][rows] = evidence
        self["furthest_tilt_deg"][rows] = np.rad2deg(furthest_tilt)
