"""Plan two burns onto the target orbit: the search, and its result with the face of a plan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orbsoc.guidance.figure_style import image_element
from orbsoc.guidance.mission import Difference, FigureFile, PlanStatus
from orbsoc.guidance.scp import Iteration, Rules, Solve
from orbsoc.guidance.verdict import Verdict

from ..figures.orbit import orbit_figure
from ..record.attitude import attitude_table
from ..record.messages import messages
from ..search.setup import InsertionSetup
from ..verification import shape_of
from .bounded_search import BoundedSearch
from .figures import draw_figures, title_of
from .record import plan_document
from .search import Found, Search
from .transfer_plan import TransferPlan
from .verdict import verdict_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class TwoBurnPlan(TransferPlan):
    """A plan of two burns as `guidance.mission.Plan` has it."""

    def plot(self) -> Figure:
        """The orbits with both burns, a Matplotlib figure. Raises ValueError for a plan that was not flown."""
        if self.verification is None:
            raise ValueError(f"nothing to plot: the plan is {self.status.value}; {self.message}")
        start = self.scenario.launch_inertial(self.scenario.initial)
        return orbit_figure(title_of(self), start, self.verification.flight)

    def __repr__(self) -> str:
        found = self.verification
        burns = " and ".join(f"{each.duration_s:.3f} s at {each.ignition_s:.1f} s" for each in self.burns)
        lines = [
            f"Plan {self.scenario.name!r}, two burns: {self.status.value}",
            f"  burns of {burns or 'nothing'}, {self.propellant_kg:.1f} kg of propellant, {self.delta_v_m_s:.1f} m/s",
        ]
        if found is not None:
            tilt = np.rad2deg(found.planned_orbit.inc_rad)
            lines.append(f"  orbit {shape_of(found.planned_orbit)}, inclination {tilt:.3f}°")
        return "\n".join([*lines, f"  {len(self.subproblems)} subproblems; {self.message}"])

    def _repr_html_(self) -> str:
        """Of a notebook: the verdict, and the figure where there is one."""
        text = self.verdict._repr_html_()
        if self.verification is None:
            return text
        return text + image_element(self.plot(), "the orbits and both burns")

    @property
    def verdict(self) -> Verdict:
        """The answer, and what is claimed of the optimum."""
        return verdict_of(self)

    def to_dict(self) -> dict[str, Any]:
        return plan_document(self)

    def tables(self) -> dict[str, str]:
        if self.verification is None or self.status is not PlanStatus.VERIFIED:
            return {}
        arcs = self.verification.flight
        return {"attitude.csv": attitude_table(self.scenario, arcs)} | messages(self.scenario, arcs)

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        return draw_figures(self, folder)

    def differences(self, other: TransferPlan) -> tuple[Difference, ...]:
        """All burns together and the semi-major axis, relative; steering is flat where the burns are shortest."""
        mine, theirs = self.time_of_flight_s, other.time_of_flight_s
        longest = max(mine, theirs)
        found = [
            Difference(
                "time_of_flight_s_rel",
                "burn time",
                abs(mine - theirs) / longest if longest else 0.0,
                BURN_REL,
            )
        ]
        if self.orbit is not None and other.orbit is not None:
            sma_rel = abs(self.orbit.sma_m / other.orbit.sma_m - 1.0)
            found.append(Difference("sma_rel", "semi-major axis", sma_rel, SMA_REL))
        return tuple(found)


BURN_REL, SMA_REL = 1e-6, 1e-7
"""A descent ends where the last step promises 1e-7 of the burns, and two solvers end it in different places."""


def plan_two_burns(
    ready: InsertionSetup, solve: Solve, callback: Callable[[Iteration], None] | None = None
) -> TwoBurnPlan:
    """Plan a scenario with `burn.count = 2`."""
    searches = Search if ready.rate_bound is None else BoundedSearch
    search = searches(solve, Rules(max_iterations=ready.scenario.method.max_iterations), callback)
    return _conclude(search.run(ready))


def _conclude(found: Found) -> TwoBurnPlan:
    if found.interrupted:
        message = found.interrupted
    elif found.proof is not None:
        message = f"proved: {found.proof.what} takes more than there is"
    elif found.best is None:
        message = "no pair of impulses to start from"
    else:
        message = found.best.outcome.message
    return TwoBurnPlan(
        scenario=found.ready.scenario,
        target=found.ready.target,
        status=found.status,
        message=message,
        attempts=tuple(found.attempts),
        best=found.best,
        verification=found.verification,
        proof=found.proof,
    )
