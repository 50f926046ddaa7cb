"""Better times for the pulses: a trust region about the present ones, the pulses' moves linearised."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.settings import Settings
from orbsoc.guidance.scp import Iteration
from orbsoc.orbit.array import Array

from .tube import TOLERANCE, USABLE, NoTube, Revolution, Tube, solve_tube, tube_impulses

MAX_ROUNDS = 15
FIRST_RADIUS = 0.05
"""Of the mean interval: how far a pulse may move at first."""
LEAST_GAIN_M = 2e-4
"""The search ends where a round improves the error by less."""


def least_error(whole: Revolution, times_s: Array, enough_m: float = -np.inf) -> Tube | NoTube:
    """The least error found with as many pulses as `times_s`, which stays the first guess; earlier below `enough_m`.

    A local search: the error of its result is reached, and no bound below others'.
    """
    best = solve_tube(whole, times_s, "error")
    if times_s.size == 1:
        return best
    radius = FIRST_RADIUS * whole.end_s / times_s.size
    for _ in range(MAX_ROUNDS):
        if isinstance(best, NoTube) or best.error_m <= enough_m:
            break
        times = _moved(whole, best, radius)
        after = None if times is None else solve_tube(whole, times, "error", between_m=best.between_m)
        if not isinstance(after, Tube) or after.error_m >= best.error_m:
            radius *= 0.3
            if radius < 1e-3 * whole.end_s / times_s.size:
                break
            continue
        gain, best = best.error_m - after.error_m, after
        radius *= 1.5
        if gain < LEAST_GAIN_M:
            break
    return best


def _moved(whole: Revolution, found: Tube, radius_s: float) -> Array | None:
    """The times after the best move to first order, each within a radius; None where there is none."""
    times = found.programme.times_s
    impulses = tube_impulses(whole, times, "error", between_m=found.between_m, about=found.flown)
    builder, moves = impulses.builder, impulses.move
    assert moves is not None
    ends = np.append(times, whole.end_s)
    room = np.minimum(radius_s, 0.3 * np.minimum(np.diff(ends), np.diff(ends, prepend=-np.inf)[:-1]))
    room[0] = 0.0
    identity = np.eye(times.size)
    builder.equality([(moves.index[:1], [[1.0]])], 0.0)
    for sign in (1.0, -1.0):
        builder.nonnegative([(moves.index[1:], sign * identity[1:, 1:])], room[1:])
    problem = builder.build()
    solution = whole.solve(problem, Settings(tol=TOLERANCE))
    whole.note(Iteration(times.size, TOLERANCE, problem, solution, figures={"pulses": times.size}))
    if solution.status not in USABLE:
        return None
    return np.append(times[0], (times + builder.value(solution, moves.name))[1:])
