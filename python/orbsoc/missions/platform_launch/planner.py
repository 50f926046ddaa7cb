"""Plan a launch and its rendezvous: separation, impulses, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Column, PlanStatus
from orbsoc.guidance.safety import CutBurn
from orbsoc.guidance.scp import Iteration, Solve, uninterrupted
from orbsoc.orbit import Elements

from .model.launch import LaunchError
from .model.perturbation import Approximation, PerturbationError, approximations
from .model.separation import Separation
from .model.transfer import Transfers, in_plane, stationary_minima
from .scenario import Scenario
from .search.rendezvous import Rendezvous, rendezvous
from .search.sequence import Sequence, Sequencer
from .verification.audits import Dispersed, HoldPoint, Scan, cut_burns, dispersed, hold_points, pointing
from .verification.checks import Verification, verify
from .verification.flights import orbits

COLUMNS = {"time_s": Column("time of flight", ".2f", "s"), "dv_m_s": Column("Σ‖Δv‖", ".6f", "m/s")}
"""Columns of the iteration table that are this mission's own."""
USABLE = (Status.SOLVED, Status.SOLVED_INACCURATE)
FRONT_ORBITS = (0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)


@dataclass(frozen=True, eq=False)
class LaunchPlan:
    """What planning found; `Plan` adds the files. `meeting` is None where the solver gave no impulses.

    What follows from the plan and is told beside it is computed when it is first asked for.
    """

    scenario: Scenario
    status: PlanStatus
    message: str
    separation: Separation
    meeting: Rendezvous | None = None
    subproblems: tuple[Iteration, ...] = field(default=(), repr=False)
    verification: Verification | None = None

    @property
    def programme(self) -> ImpulseProgramme | None:
        return None if self.meeting is None else self.meeting.programme

    @cached_property
    def cuts(self) -> tuple[CutBurn, ...]:
        assert self.programme is not None
        return cut_burns(self.scenario, self.separation.state, self.programme)

    @cached_property
    def holds(self) -> tuple[HoldPoint, ...]:
        table = self.scenario.rendezvous
        state = self.separation.state
        return hold_points(self.scenario.motion, state, table.cost, table.hold_m, self.scenario.longest_s)

    @cached_property
    def scans(self) -> tuple[Scan, Scan]:
        """Over yaw bias and phase."""
        return pointing(self.scenario)

    @cached_property
    def sequence(self) -> Sequence | None:
        """Of all servers; None where there are too many orders, or one of the servers cannot be launched."""
        try:
            return Sequencer(self.scenario).sequence()
        except LaunchError:
            return None

    @cached_property
    def series(self) -> tuple[Approximation, ...] | str:
        """The paper's approximations, or why there are none."""
        try:
            return approximations(self.separation.server, self.scenario.motion)
        except PerturbationError as error:
            return str(error)

    @cached_property
    def stationary_s(self) -> tuple[float, ...]:
        """Times of all local minima of Σ‖Δv‖², by polynomials."""
        state = in_plane(self.separation.state)
        return stationary_minima(self.scenario.motion, state, self.scenario.longest_s)

    @cached_property
    def orbits(self) -> dict[str, Elements]:
        """Of platform and server, as they are and as the paper has them."""
        assert self.programme is not None
        return orbits(self.scenario, self.separation, self.programme.dv_m_s[0])

    @cached_property
    def dispersed(self) -> Dispersed | None:
        if self.scenario.uncertainty is None or self.meeting is None:
            return None
        return dispersed(self.scenario, self.meeting.programme, self.meeting.time_s)

    @cached_property
    def front(self) -> tuple[tuple[float, float, float, int], ...]:
        """Time of flight, Σ‖Δv‖ of two impulses in any time up to it, of as many as pay, and how many; for "generated"."""
        if self.meeting is None or self.meeting.generated is None:
            return ()
        from orbsoc.solving.solver import solve

        rows = []
        state, motion = self.separation.state, self.scenario.motion
        for share in FRONT_ORBITS:
            longest = share * motion.period_s
            found = rendezvous(
                state, motion, cost="norms", longest_s=longest, time_s=None, generated=True, solve=solve
            )  # fmt: skip
            two = Transfers.of(motion, longest).best(in_plane(state), "norms").cost
            if found.solution.status in USABLE:
                rows.append((longest, two, found.value, len(found.programme)))
        return tuple(rows)


def made(scenario: Scenario, solve: Solve | None, callback: Callable[[Iteration], None] | None) -> LaunchPlan:
    """Plan the scenario; Ctrl-C is a status. Raises PropagationError."""
    separation, table = scenario.separation(), scenario.rendezvous
    try:
        found = rendezvous(
            separation.state, scenario.motion, cost=table.cost, longest_s=scenario.longest_s,
            time_s=None if table.duration_s == "free" else table.duration_s,
            generated=table.impulses == "generated", solve=uninterrupted(solve), callback=callback,
        )  # fmt: skip
    except KeyboardInterrupt:
        return LaunchPlan(scenario, PlanStatus.INTERRUPTED, "interrupted", separation)
    if found.solution.status not in USABLE:
        message = f"the conic problem ended with {found.solution.status.name}: {found.solution.message}"
        return LaunchPlan(scenario, PlanStatus.FAILED, message, separation, None, found.subproblems)
    flown = verify(scenario, separation, found)
    status = PlanStatus.NOT_VERIFIED if flown.failures else PlanStatus.VERIFIED
    return LaunchPlan(scenario, status, _message(found), separation, found, found.subproblems, flown)


def _message(found: Rendezvous) -> str:
    if found.generated is not None:
        rounds = len(found.generated.rounds)
        return f"{rounds} rounds of impulse times, each a conic problem; gap {found.generated.gap:.1e}"
    minima = f"{len(found.minima)} local minim{'a' if len(found.minima) > 1 else 'um'} of two impulses"
    return f"{minima}; solved in {found.solution.iterations} iterations"
