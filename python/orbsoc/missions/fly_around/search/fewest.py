"""The fewest pulses, with a proof: no flight of N − 1 pulses stays within the tolerance.

A flight of N pulses is N free arcs within the tube about the path. Let go of the joints: each arc may start anywhere in
the tube at any velocity. Take any times 0 = u₀ < u₁ < … < u_N = end. Of the flight's own arcs, one contains
one of the intervals [u_k, u_k+1], because they have the same ends. So a flight strays at least as far as
the least, over k, of the errors of the best free arcs over [u_k, u_k+1]: N conic problems of 7 unknowns, whose dual
objectives are the bound. The bound is best where all N errors are equal. It holds with the tube enforced at a few times
of each interval, which lets arcs do more. The first arc starts where the flight does, if its first pulse is at time 0.

With the first pulse at any time, the flight coasts until then, and the coast leaves the tube at a known time τ. Its N arcs
hold all of [τ, end], so that the same bound over a partition of [τ, end], all arcs free, holds for every first time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.conic.verify import project_dual
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.array import Array

from ..model.flight import Flight
from ..model.waypoints import effort

COAST_SAMPLES = 4000
SAMPLES = 8
"""Intervals of an arc at whose ends the tube is enforced."""
TOLERANCE = 1e-9
MAX_ROUNDS = 12
EVEN = 1e-4
"""Relative spread of the arcs' errors at which the partition is even enough: it is what the bound may gain."""


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """The best free arc over an interval: its error at the samples, and a bound below every arc's error."""

    start_s: float
    end_s: float
    error_m: float
    bound_m: float
    problem: Problem = field(repr=False)
    solution: Solution = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """No flight with as many pulses as there are arcs stays within less than `bound_m` of the path."""

    arcs: tuple[Arc, ...]

    @property
    def pulses(self) -> int:
        return len(self.arcs)

    @property
    def bound_m(self) -> float:
        """The least of the arcs'; NaN where a solve failed."""
        return float(np.min([arc.bound_m for arc in self.arcs]))

    @property
    def times_s(self) -> Array:
        """Ends of the intervals, (N + 1,)."""
        return np.array([*(arc.start_s for arc in self.arcs), self.arcs[-1].end_s])


def bound_below(problem: Problem, solution: Solution) -> float:
    """A bound below the error of every arc that is better than the solution's, from multipliers z, whatever their residual.

    For feasible x and z ∈ K: cᵀx ≥ cᵀx − zᵀ(h − Gx) = −hᵀz + (c + Gᵀz)ᵀx ≥ −hᵀz − |c + Gᵀz|ᵀ|x|, with |x| by `largest`.
    """
    z = project_dual(problem, solution.z)
    residual = np.abs(problem.c + problem.G.T @ z)
    return float(-(problem.h @ z) - residual @ largest(problem, abs(float(problem.c @ solution.x))))


def largest(problem: Problem, error_m: float) -> Array:
    """Above |x| of every arc with ‖R_k x + o_k‖ ≤ e ≤ `error_m` at all samples k, and of e: (unknowns + 1,).

    With L a left inverse of R, x = L (d − o) and ‖d_k‖ ≤ e, so that |x_i| ≤ |(L o)_i| + e Σ_k ‖L_ik‖.
    """
    rows = -problem.G.toarray().reshape(-1, 4, problem.n)[:, 1:, :-1]
    offsets = problem.h.reshape(-1, 4)[:, 1:].ravel()
    inverse = np.asarray(np.linalg.pinv(rows.reshape(-1, problem.n - 1)), dtype=np.float64)
    by_sample = np.linalg.norm(inverse.reshape(problem.n - 1, -1, 3), axis=2).sum(axis=1)
    return np.append(np.abs(inverse @ offsets) + error_m * by_sample, error_m)


def arc_problem(
    flight: Flight, start_s: float, end_s: float, start_m: Array | None, samples: int = SAMPLES
) -> Problem:
    """min e, ‖r(t) − path(t)‖ ≤ e at samples + 1 times of a free arc: 7 unknowns.

    They are e, and in metres how far the arc is from the path in the middle of the interval, and how much faster it is
    times half the interval. With `start_m` the arc starts there: 4 unknowns, the velocity then, times the interval, and e.
    """
    builder = ConicBuilder()
    free = start_m is None
    unknown = builder.variable("beside the path", 6 if free else 3)
    error = builder.variable("error", 1)
    builder.cost(error, 1.0)
    at = np.linspace(start_s, end_s, samples + 1)[0 if free else 1 :]
    middle, unit = (0.5 * (start_s + end_s), 0.5 * (end_s - start_s)) if free else (start_s, end_s - start_s)
    path = flight.ellipse
    known = np.concatenate([path.position(middle) if start_m is None else start_m, path.velocity(middle)])
    scale = np.repeat([1.0, 1.0 / unit], 3)
    blocks = [flight.motion.transition(t, middle)[:3] for t in at.tolist()]
    offsets = [
        block @ known + flight.forced(t - middle)[:3] for block, t in zip(blocks, at.tolist(), strict=True)
    ]
    rows = np.vstack([(block * scale)[:, 0 if free else 3 :] for block in blocks])
    bounds = np.repeat(error.index, at.size)
    builder.norm([(unknown, rows)], (np.array(offsets) - path.position(at)).ravel(), bound=bounds, size=3)
    return builder.build()


def free_arc(
    flight: Flight,
    start_s: float,
    end_s: float,
    start_m: Array | None,
    *,
    solve: Solve,
    samples: int = SAMPLES,
) -> Arc:
    """The best arc over an interval, free or from a position."""
    problem = arc_problem(flight, start_s, end_s, start_m, samples)
    solution = solve(problem, Settings(tol=TOLERANCE))
    solved = solution.status in (Status.SOLVED, Status.SOLVED_INACCURATE, Status.NUMERICAL_LIMIT)
    bound = bound_below(problem, solution) if solved else float("nan")
    return Arc(start_s, end_s, solution.objective, bound, problem, solution)


def first_shares(pulses: int) -> Array:
    """Of ∫√|a_req| dt by interval, (N,): the first arc starts on the path, and strays to both sides by less."""
    shares = np.ones(pulses)
    shares[0] = (2.0 + 2.0**0.5) / 4.0
    return shares


def coast_end(flight: Flight, start: Array, end_s: float, within_m: float) -> float:
    """A time by which the coast from a state (6,) has left the tube; `end_s` where no sample is outside."""
    states = flight.arc(start, end_s, COAST_SAMPLES)
    times = np.linspace(0.0, end_s, COAST_SAMPLES + 1)
    outside = np.linalg.norm(states[:, :3] - flight.ellipse.position(times), axis=1) > within_m
    return float(times[outside.argmax()]) if outside.any() else end_s


def partition(flight: Flight, end_s: float, shares: Array, from_s: float = 0.0) -> Array:
    """Ends of intervals from `from_s` on, (N + 1,), whose ∫√|a_req| dt are as the shares: an arc's error goes with the square of that."""
    times, total = effort(flight, end_s)
    ends = np.concatenate([[0.0], np.cumsum(shares) / shares.sum()])
    before = float(np.interp(from_s, times, total))
    found = np.interp(before + ends * (total[-1] - before), total, times)
    found[0], found[-1] = from_s, end_s
    return np.asarray(found)


def even_bound(
    flight: Flight,
    start_m: Array | None,
    end_s: float,
    pulses: int,
    *,
    solve: Solve,
    from_s: float = 0.0,
    samples: int = SAMPLES,
    note: Callable[[Iteration], None] = lambda _: None,
) -> Bound:
    """The best bound over partitions of [from_s, end_s] into `pulses` intervals, made even; without `start_m` all are free."""
    shares = np.ones(pulses) if start_m is None else first_shares(pulses)
    best: Bound | None = None
    for _ in range(MAX_ROUNDS):
        u = partition(flight, end_s, shares, from_s)
        arcs = []
        for k in range(pulses):
            arc = free_arc(flight, u[k], u[k + 1], None if k else start_m, solve=solve, samples=samples)
            arcs.append(arc)
            note(
                Iteration(
                    k + 1,
                    TOLERANCE,
                    arc.problem,
                    arc.solution,
                    figures={"pulses": pulses, "error_m": arc.error_m},
                )
            )
        found = Bound(tuple(arcs))
        if best is None or not found.bound_m <= best.bound_m:
            best = found
        errors = np.array([arc.error_m for arc in arcs])
        if not np.isfinite(errors).all() or errors.min() <= 0.0:
            break
        if errors.max() - errors.min() <= EVEN * errors.max():
            break
        shares = shares * np.sqrt(errors.mean() / errors)
    assert best is not None
    return best
