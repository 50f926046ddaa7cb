"""What attempts work with: grids, sequences, Newton, and the flight that confirms a plan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.powered_flight import Burn
from orbsoc.guidance.scp import Rules
from orbsoc.orbit.array import Array, Flags, Index

from ...model.direct.arcs import Arcs, Collocation
from ...model.direct.sequence import Sequences, Watch, sequences
from ...model.direct.subproblems import Subproblems
from ...model.direct.terminal import LargestOrbit, Target
from ...model.flight.orbits import RADIUS_M, Flown
from ...model.flight.propagation import FIRST_STEPS, Flights, fly
from ...model.indirect.shooting import Indirect

MOST_GRIDS = 5
"""Grids of a sequence, from 4 to 64 nodes."""
CLEAR_MISS = 100.0
"""A flight whose miss exceeds its own error by this factor is not flown more accurately."""
ALONG_BOUND_SMA_REL = 0.01
"""Along a bound on the altitude, on the finest grid, the flown orbit is the answer; one further from the prediction is
another plan's."""


@dataclass(frozen=True, slots=True)
class Tolerances:
    """What a flown plan must keep: see `orbits.Flown.kept`."""

    sma_rel: float = 1e-6
    plane_rad: float = 1e-6
    bound_m: float = 1.0
    raw_excess: float = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Tools:
    """What attempts work with: the burn, grids, Newton, tolerances, and a solver of batches.

    `lowest` is the smallest radius allowed on the way, canonical, −inf for none.
    """

    burn: Burn
    duration: float
    nodes: int
    fine_nodes: int
    lowest: float
    rules: Rules
    tolerances: Tolerances
    solve: Subproblems
    watch: Watch | None = None

    @property
    def grids(self) -> tuple[int, ...]:
        """Nodes of the grids that a sequence may be run on, coarsest first."""
        found = {self.fine_nodes, self.nodes}
        nodes = self.nodes
        while nodes < self.fine_nodes:
            found.add(nodes)
            nodes *= 2
        return tuple(sorted(found))

    def collocation(self, nodes: int) -> Collocation:
        return Collocation.of(self.burn, self.duration, nodes)

    def indirect(self, steps: int) -> Indirect:
        return Indirect(self.burn, self.duration, steps)

    def sequences(self, nodes: int, target: Target, start: Arcs, *, lowest: Array | None = None) -> Sequences:
        """Sequences of every point of `target` from its arc of `start` on a grid."""
        grid = self.collocation(nodes)
        return sequences(
            grid, target, start, lowest=lowest, solve=self.solve, rules=self.rules, watch=self.watch
        )

    def subproblems(self, nodes: int, found: Sequences) -> NDArray[np.int32]:
        """How many sequences on a grid solved on each of `grids`, (B, MOST_GRIDS)."""
        return np.asarray(found.iterations[:, None] * (np.arange(MOST_GRIDS) == self.grids.index(nodes)))

    @property
    def bounded(self) -> bool:
        """Whether the altitude is bounded."""
        return bool(np.isfinite(self.lowest))

    def sma_rel_along_bound(self, nodes: int) -> float:
        """How far prediction and flight may differ along a bound on the altitude, on a grid of `nodes` nodes."""
        return self.tolerances.sma_rel if nodes < self.fine_nodes else ALONG_BOUND_SMA_REL

    def verify(
        self, programmes: Array, target: LargestOrbit, predicted_sma: Array, *, steps: int = FIRST_STEPS
    ) -> Flown:
        """Fly programmes (B, N, 3), in `steps` steps or more, and compare each flight with its target and predicted semi-major
        axis."""

        def compared(which: Index, flights: Flights) -> Flown:
            return Flown.compare(flights, predicted_sma[which], target[which], self.lowest)

        def clear_miss(which: Index, flights: Flights) -> Flags:
            return ~self.kept(compared(which, flights), slack=CLEAR_MISS * flights.error)

        flights = fly(self.burn, self.duration, programmes, steps=steps, give_up=clear_miss)
        return compared(np.arange(len(target)), flights)

    def kept(self, flown: Flown, *, slack: Array | float = 0.0, sma_rel: float | None = None) -> Flags:
        """Whether flights are within the tolerances plus `slack`; `sma_rel` overrides that of the semi-major axis. Along a
        bound on the altitude the best steering has corners, between whose nodes the interpolant of any grid is longer
        than 1: there its length is reported, and the flight alone decides."""
        t = self.tolerances
        return flown.kept(
            sma_rel=t.sma_rel + slack if sma_rel is None else sma_rel,
            plane_rad=t.plane_rad + slack,
            bound=t.bound_m / RADIUS_M + slack,
            raw_excess=np.inf if self.bounded else t.raw_excess,
        )
