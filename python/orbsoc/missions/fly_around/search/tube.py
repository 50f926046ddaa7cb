"""Flight within a tube about the ellipse, waypoints free: a second-order cone program for given times of the pulses.

The paper flies through points of the ellipse; an arc then strays to one side by d²/8 |a_req|. Arcs that are free within
the tube stray to both sides, and are longer by √2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.conic.builder import ConicBuilder, Term
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.impulses import KICK, ImpulseProgramme, Impulses
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.array import Array

from ..model.flight import Flight, Flown, fly

Goal = Literal["error", "dv"]
Note = Callable[[Iteration], None]

SAMPLES = 8
"""Intervals of an arc at whose ends the tube is enforced: the extremes of a parabola, its ends and middle, are among them.
The limits make up for what lies between; with 24 the velocity change is the same to 1e-4 m/s, and the engine's tables are
thrice as large."""
TOLERANCE = 1e-8
USABLE = (Status.SOLVED, Status.SOLVED_INACCURATE)
"""A programme that its solver calls inaccurate is flown like any other: the flight decides."""
GUARD_ROUNDS = 5
FINER = 8
"""Parts of an interval between samples at which its rise is looked for."""
NEAR = 0.8
"""Of an arc's largest error: below, a rise between samples does not matter."""
CLOSE_M = 1e-5
"""How far beyond the tolerance the flight between the samples may be."""


@dataclass(frozen=True, slots=True, eq=False)
class Tube:
    """The programme of a solved tube problem, and its flight by the model, between the samples too."""

    goal: Goal
    impulses: Impulses = field(repr=False)
    problem: Problem = field(repr=False)
    solution: Solution = field(repr=False)
    programme: ImpulseProgramme
    flown: Flown
    between_m: Array
    """Of each arc, by how much its error rises between two samples, where it is near its largest, (N,)."""

    @property
    def error_m(self) -> float:
        """The largest error of the flight."""
        return self.flown.largest_error_m


@dataclass(frozen=True, slots=True, eq=False)
class NoTube:
    """A tube problem without a solution, and why."""

    solution: Solution
    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Revolution:
    """What all tube problems of a plan share: the flight from a state (6,) to an end, who solves them, and who is told.

    The tube is enforced at the ends of `samples` intervals of every arc. With `coast` the pulse at the start is zero.
    """

    flight: Flight
    start: Array
    end_s: float
    solve: Solve
    note: Note = lambda _: None
    samples: int = SAMPLES
    coast: bool = False


def tube_impulses(
    whole: Revolution,
    times_s: Array,
    goal: Goal,
    tolerance_m: float = np.inf,
    between_m: ArrayLike = 0.0,
    *,
    about: Flown | None = None,
) -> Impulses:
    """min e, or min Σ‖dv‖, with ‖r(t) − path(t)‖ ≤ e, or ≤ the tolerance, less `between_m` (N,), at samples of every arc.

    States are linked: of one arc's rows only its own unknowns are part. With a flight `about` which to linearise, all
    pulses may move, and the samples of the arcs with them.
    """
    flight, end_s, samples = whole.flight, whole.end_s, whole.samples
    movable = None if about is None else about.programme.dv_m_s
    builder = ConicBuilder()
    impulses = Impulses(
        builder, flight.motion, times_s, whole.start, forced=_forced(flight), linked=True, movable=movable
    )
    if whole.coast:
        builder.equality([(impulses.dv.index[0], np.eye(3))], 0.0)
    error = builder.variable("error", 1) if goal == "error" else None
    if error is not None:
        builder.cost(error, 1.0)
    else:
        impulses.cost("norms")
    margins = np.broadcast_to(np.asarray(between_m, dtype=np.float64), times_s.shape)
    bound = tolerance_m if error is None else error
    ends = np.append(times_s, end_s)
    for k in range(times_s.size):
        shares = np.linspace(0.0, 1.0, samples + 1)[0 if k else 1 :]
        if k < times_s.size - 1:  # the next arc begins with this one's end
            shares = shares[:-1]
        at = ends[k] + shares * (ends[k + 1] - ends[k])
        if not at.size:
            continue
        if k == times_s.size - 1:
            at[-1] = end_s
        also = [] if about is None else _moving_samples(flight, impulses, about, k, shares)
        impulses.within(
            at,
            flight.ellipse.position(at),
            bound,
            margin=float(margins[k]),
            name=f"tube, arc {k + 1}",
            also=also,
        )
    return impulses


def _moving_samples(flight: Flight, impulses: Impulses, about: Flown, k: int, shares: Array) -> list[Term]:
    """How the distance from the path grows where samples of arc k move with the pulses at its ends."""
    assert impulses.move is not None
    ends = np.append(about.programme.times_s, about.end_s)
    after = about.before[k] + KICK @ about.programme.dv_m_s[k]
    at = ends[k] + shares * (ends[k + 1] - ends[k])
    states = np.array([flight.state_after(after, dt) for dt in (at - ends[k]).tolist()])
    rate = states[:, 3:] - flight.ellipse.velocity(at)
    weights = [(k, 1.0 - shares), (k + 1, shares)]
    return [
        (impulses.move.index[j : j + 1], (rate * weight[:, None]).reshape(-1, 1))
        for j, weight in weights
        if j < len(about.programme)
    ]


def solve_tube(
    whole: Revolution, times_s: Array, goal: Goal, tolerance_m: float = np.inf, between_m: ArrayLike = 0.0
) -> Tube | NoTube:
    """Solve one tube problem and fly its programme."""
    impulses = tube_impulses(whole, times_s, goal, tolerance_m, between_m)
    problem = impulses.builder.build()
    solution = whole.solve(problem, Settings(tol=TOLERANCE))
    if solution.status not in USABLE:
        whole.note(Iteration(times_s.size, TOLERANCE, problem, solution))
        infeasible = solution.status is Status.PRIMAL_INFEASIBLE
        return NoTube(solution, impulses.builder.why(solution) if infeasible else solution.message)
    programme = impulses.programme(solution)
    if whole.coast:
        programme = ImpulseProgramme(times_s, np.vstack([np.zeros(3), programme.dv_m_s[1:]]))
    flown = fly(whole.flight, whole.start, programme, whole.end_s)
    figures = {"pulses": times_s.size, "error_m": flown.largest_error_m, "dv_m_s": programme.total_m_s}
    whole.note(Iteration(times_s.size, TOLERANCE, problem, solution, figures=figures))
    return Tube(goal, impulses, problem, solution, programme, flown, _between(whole, flown))


def cheapest(whole: Revolution, times_s: Array, tolerance_m: float) -> Tube | NoTube:
    """The least Σ‖dv‖ within the tolerance, between the samples too: each arc gives up what its flight exceeds.

    The pattern stays the same from round to round, only right-hand sides move. The last programme found is returned when
    the next round has none; its excess is in `Tube.error_m`.
    """
    between = np.zeros(times_s.size)
    found: Tube | None = None
    for _ in range(GUARD_ROUNDS):
        after = solve_tube(whole, times_s, "dv", tolerance_m, between)
        if isinstance(after, NoTube):
            return after if found is None else found
        found = after
        excess = found.flown.errors_m - tolerance_m
        if excess.max() <= CLOSE_M:
            break
        between = between + np.maximum(0.0, excess + 0.1 * CLOSE_M)
    assert found is not None
    return found


def _between(whole: Revolution, flown: Flown) -> Array:
    """Of each arc, the largest rise of the error over both ends of an interval between samples, (N,)."""
    flight, samples = whole.flight, whole.samples
    ends = np.append(flown.programme.times_s, flown.end_s)
    found = np.empty(len(flown.programme))
    for k, dv in enumerate(flown.programme.dv_m_s):
        length = ends[k + 1] - ends[k]
        states = flight.arc(flown.before[k] + KICK @ dv, length, FINER * samples)
        path = flight.ellipse.position(ends[k] + np.linspace(0.0, length, FINER * samples + 1))
        errors = np.linalg.norm(states[:, :3] - path, axis=1)
        at_ends = np.maximum(errors[:-1:FINER], errors[FINER::FINER])
        inside = np.lib.stride_tricks.sliding_window_view(errors, FINER + 1)[::FINER].max(axis=1)
        found[k] = np.max(np.where(inside > NEAR * errors.max(), inside - at_ends, 0.0))
    return found


def _forced(flight: Flight) -> Callable[[float], Array] | None:
    return flight.forced if flight.disturbance_m_s2.any() else None
