"""Planning again in flight on one pattern: executed impulses keep their columns as stored zeros, and their effect goes to
the right-hand side. So the solver analyses the pattern once a flight, and every later problem is an update of numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.guidance.scp import ExitReason, Iteration, Proposal, Solve, trust_region
from orbsoc.orbit.array import Array
from orbsoc.solving.solver import Solver

from ..model.approach import Approach, Roll, approach_at
from ..search.descent import RULES, TOLERANCE

SPREAD_M_S = 1.0
"""What a new goal may take of an instant without an impulse, before the descent gathers it again."""


@dataclass(frozen=True, slots=True, eq=False)
class Replan:
    """The rest of a flight, planned again `before_s` the meeting when `done` instants had passed."""

    before_s: float
    done: int
    roll: Roll | None
    reason: ExitReason | None
    extra_m_s: float
    """More than was planned, for all impulses of the flight; NaN without a plan."""
    subproblems: tuple[Iteration, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Surprised:
    """A plan flown with another drag of the target: the miss without, and the price with, planning again."""

    miss_m: float
    replans: tuple[Replan, ...]
    updates: int
    """Conic problems that were updates of the first one's numbers."""


class Horizon:
    """The problem of what is left of a flight over K instants, its pattern analysed once."""

    def __init__(self, settings: Settings | None = None, solve: Solve | None = None) -> None:
        """`solve` keeps the pattern itself, as a computer on board does."""
        self.settings = settings or Settings(tol=TOLERANCE)
        self.updates = 0
        self._solve = solve
        self._solver: Solver | None = None

    def solve(self, roll: Roll, done: int) -> tuple[Problem, Solution, Array]:
        """The problem about a flight of which the first `done` instants have passed, its solution, and all impulses (K, 3)."""
        effect, goal = meeting_rows(roll, done)
        dv = roll.dv_m_s.copy()
        if self._solve is not None:
            problem = _problem(effect, goal)
            solution = self._solve(problem, self.settings)
            dv[done:] = solution.x[: dv.size].reshape(-1, 3)[done:]
            return problem, solution, dv
        if self._solver is None:
            self._solver = Solver(_problem(effect, goal), self.settings)
        else:
            old = self._solver.problem.A
            numbers = sp.csc_matrix((effect.T.ravel(), old.indices, old.indptr), shape=old.shape)
            self._solver.update(A=numbers, b=goal)
            self.updates += 1
        solution = self._solver.solve()
        dv[done:] = solution.x[: dv.size].reshape(-1, 3)[done:]
        return self._solver.problem, solution, dv


def meeting_rows(roll: Roll, done: int) -> tuple[Array, Array]:
    """Rows (6, 3K) and right-hand side (6,) of the meeting, the columns of the first `done` instants zero; whatever is done, all
    problems of a flight have one pattern."""
    effect = np.concatenate(roll.to_end[:, :, 3:], axis=1)
    scale = np.abs(effect).max(axis=1)
    effect /= scale[:, None]
    effect[:, : 3 * done] = 0.0
    return effect, effect @ roll.dv_m_s.ravel() - roll.miss / scale


def _problem(effect: Array, goal: Array) -> Problem:
    """With every entry of the meeting's rows stored, zero or not."""
    builder = ConicBuilder()
    dv = builder.variable("dv", (effect.shape[1] // 3, 3))
    rows, columns = np.indices(effect.shape)
    stored = sp.csc_array((effect.ravel(), (rows.ravel(), columns.ravel())), shape=effect.shape)
    builder.equality([(dv, stored)], goal, name="meeting")
    builder.sum_of_norms("size", [(dv, sp.eye_array(effect.shape[1], format="csc"))], size=3)
    return builder.build()


def surprise(approach: Approach, planned: Roll) -> Surprised:
    """Fly the plan to a target of the drag that the scenario's `surprise` names, and plan again at each of its times."""
    scenario = approach.scenario
    found = scenario.surprise
    assert found is not None
    real = approach_at(scenario, approach.times_s, ballistic_m2_kg=found.ballistic_m2_kg)
    miss_m = float(np.linalg.norm(real.roll(planned.dv_m_s).miss[:3]))
    horizon = Horizon()
    replans = tuple(_replanned(real, planned, 3600.0 * hours, horizon) for hours in found.replans_h)
    return Surprised(miss_m, replans, horizon.updates)


def _replanned(real: Approach, planned: Roll, before_s: float, horizon: Horizon) -> Replan:
    done = int(np.searchsorted(real.times_s, real.end_s - before_s))
    roll, reason, rows = planned_again(real, planned.dv_m_s, done, horizon)
    extra = float("nan") if roll is None else roll.cost_m_s - planned.cost_m_s
    return Replan(before_s, done, roll, reason, extra, rows)


def planned_again(
    real: Approach, dv_m_s: Array, done: int, horizon: Horizon
) -> tuple[Roll | None, ExitReason | None, tuple[Iteration, ...]]:
    """The least impulses near those given (K, 3) that meet the goal of an approach; the first `done` stay. None where none do."""
    start = real.restore(dv_m_s, done=done, least_m_s=SPREAD_M_S)
    if start is None:
        return None, None, ()

    def propose(roll: Roll, radius: float) -> Proposal[Roll]:
        problem, solution, dv = horizon.solve(roll, done)
        row = Iteration(1, horizon.settings.tol, problem, solution)
        if solution.status is not Status.SOLVED:
            return Proposal(None, float("nan"), float("nan"), (row,))
        dv[np.linalg.norm(dv, axis=1) < 1e-6 * solution.objective] = 0.0
        change = dv - roll.dv_m_s
        distance = float(np.linalg.norm(change))
        fired = float(np.linalg.norm(roll.dv_m_s[:done], axis=1).sum())
        cost = solution.objective + fired
        if (
            distance > radius
        ):  # part of the way: the objective is convex, so the part's promise is at least its share
            share = radius / distance
            dv, distance = roll.dv_m_s + share * change, radius
            cost = roll.cost_m_s - share * (roll.cost_m_s - cost)
        return Proposal(replace(roll, dv_m_s=dv), cost, distance, (row,))

    outcome = trust_region(
        start,
        propose,
        lambda roll: real.restore(roll.dv_m_s, done=done),
        lambda roll: roll.cost_m_s,
        rules=RULES,
    )
    return outcome.iterate, outcome.reason, outcome.iterations
