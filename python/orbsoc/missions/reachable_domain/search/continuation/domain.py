"""A scenario made ready: tools, the current plane, and the planes of the grid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.scp import Rules
from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import TiltFrame, cross

from ...model.direct.sequence import Watch
from ...model.direct.subproblems import Subproblems
from ...model.flight.orbits import canonical_radius
from ...scenario import Perigee, Scenario
from .perigee_at_bound import lower_perigees
from .table import PointTable
from .tools import Tolerances, Tools
from .turned_perigee import turn_perigees
from .wavefront import Part, PlaneSet, Wavefront


@dataclass(frozen=True, slots=True, eq=False)
class Domain:
    """What every task of a scenario shares."""

    scenario: Scenario
    tools: Tools
    frame: TiltFrame

    @classmethod
    def of(
        cls, scenario: Scenario, *, solve: Subproblems | None = None, watch: Watch | None = None
    ) -> Domain:
        """Make a scenario ready; `solve` solves batches of subproblems, by default with `orbsoc.solve_batch`, and `watch`
        sees them."""
        burn, method, limits = scenario.canonical_burn(), scenario.method, scenario.verification
        lowest_km = scenario.burn.minimum_altitude_km
        tools = Tools(
            burn=burn,
            duration=scenario.duration,
            nodes=method.nodes,
            fine_nodes=method.fine_nodes,
            lowest=-np.inf if lowest_km is None else canonical_radius(lowest_km),
            rules=Rules(max_iterations=method.max_iterations),
            tolerances=Tolerances(limits.sma_rel, limits.plane_rad, limits.bound_m),
            solve=solve or Subproblems.in_process(),
            watch=watch,
        )
        momentum = cross(burn.start[:3], burn.start[3:])
        return cls(scenario, tools, TiltFrame.about(momentum / np.linalg.norm(momentum)))

    def with_free_perigee(self) -> Domain:
        """The same domain with the perigee anywhere at its bound or above: the scenario's own domain lies within it."""
        if self.scenario.perigee == Perigee():
            return self
        free = self.scenario.with_changes(perigee={"condition": "at_least", "argp_deg": None})
        return replace(self, scenario=free)

    def planes(self) -> tuple[Array, Array]:
        """Inclinations and nodes (degrees) of all planes of the grid, node fastest, each (P,)."""
        grid = self.scenario.grid
        inc, raan = np.meshgrid(grid.inclination_deg.values(), grid.raan_deg.values(), indexing="ij")
        return inc.ravel(), raan.ravel()

    def solve_planes(
        self, inc_deg: Array, raan_deg: Array, heights_km: Array | None = None, *, part: Part | None = None
    ) -> PointTable:
        """All perigee bounds of some planes, one row a point; `part` does parts of the work, or knows their results."""
        perigee = self.scenario.perigee
        heights = self.scenario.grid.perigee_height_km.values() if heights_km is None else heights_km
        argp = None if perigee.argp_deg is None else float(np.deg2rad(perigee.argp_deg))
        planes = PlaneSet(np.asarray(inc_deg), np.asarray(raan_deg), np.asarray(heights), argp)
        continuation = self.scenario.method.continuation == "wavefront"
        at_bound = perigee.condition == "equal"
        front = Wavefront.over(self.tools, self.frame, planes, continuation=continuation, part=part)
        table = front.run()
        if at_bound:
            table = lower_perigees(front)
        return table if argp is None else turn_perigees(front, at_bound=at_bound)
