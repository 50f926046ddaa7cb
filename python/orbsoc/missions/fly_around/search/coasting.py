"""A bound for flights that coast before their first pulse: that pulse may come at any time until the coast leaves the tube.

The first pulse's time t is cut into pieces. For t in one, the N arcs hold [t, end], so that one contains [t, u₁] or one of
[u_k, u_k+1], k ≥ 1. The arc over [t, u₁] leaves the coast at t: coast(s) + Φ(s − t) Δv, whose rows alone depend on t. The
multipliers of one t bound the error for every other: −hᵀz + (c + G(t)ᵀz)ᵀx, with x held by the rows themselves. It is
computed on a grid of t, less what it can change between two points, for ‖dG/dt‖ is bounded in closed form: it is the
velocity block of the transition matrix. The same change enters the bound on x (`_distance_bound`).
"""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import project_dual
from orbsoc.guidance.scp import Solve
from orbsoc.orbit.array import Array

from ..model.flight import Flight
from .fewest import SAMPLES, TOLERANCE, even_bound

PIECES = 24
POINTS = 8
"""Intervals of a piece at whose ends the bound is computed."""


def coasting_bound(
    flight: Flight, start: Array, end_s: float, pulses: int, left_s: float, level_m: float, *, solve: Solve
) -> float:
    """No flight of as many pulses whose first is in [0, left_s] strays less, nor less than `level_m`; NaN or less where
    a solve failed."""
    edges = np.linspace(0.0, left_s, PIECES + 1)
    least = level_m
    for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        middle = 0.5 * (low + high)
        place = flight.state_after(start, middle)[:3]
        even = even_bound(flight, place, end_s, pulses, solve=solve, from_s=middle)
        rest = [arc.bound_m for arc in even.arcs[1:]]
        first = _first_arc(flight, start, (low, high), float(even.times_s[1]), level_m, solve)
        least = float(np.min([least, first, *rest]))
    return least


def _largest_rate(angle_rad: float) -> float:
    """Above the 2-norm of the velocity block ((c, 2s), (−2s, 4c − 3)) for all angles up to one."""
    theta = min(angle_rad, pi)
    return max(1.0, abs(4.0 * cos(theta) - 3.0)) + 2.0 * sin(min(theta, 0.5 * pi))


def _distance_bound(inverse: Array, reach_m: Array, move: float, moved: float) -> float:
    """Above ‖x* − x‖ for x* feasible at any t′ near the grid's t; infinite where the grid is too coarse to tell.

    With L (3, N, 3) a left inverse of the rows G(t), and D = G(t′) − G(t), ‖D_k‖ ≤ move:
    x* − x = L (e − D x − D (x* − x)), ‖e_k‖ ≤ reach_k, so ‖x* − x‖ (1 − ‖L‖√N move) ≤ Σ ‖L_k‖ reach_k + ‖L‖√N move ‖x‖.
    """
    change = float(np.linalg.norm(inverse.reshape(3, -1), 2)) * inverse.shape[1] ** 0.5 * move
    if not change < 1.0:
        return float("inf")
    still = float(np.linalg.norm(inverse, axis=(0, 2)) @ reach_m)
    return float((still + change * moved) / (1.0 - change))


def _first_arc(
    flight: Flight, start: Array, piece_s: tuple[float, float], until_s: float, level_m: float, solve: Solve
) -> float:
    """No arc that leaves the coast in a piece strays less up to a time, of those that stray less than a level."""
    low, high = piece_s
    length = until_s - 0.5 * (low + high)
    at = np.linspace(high, until_s, SAMPLES + 1)[1:]
    beside = np.array([flight.state_after(start, t)[:3] for t in at.tolist()]) - flight.ellipse.position(at)

    def rows(t: float) -> Array:
        return np.array([flight.motion.transition(s - t, 0.0)[:3, 3:] / length for s in at.tolist()])

    def problem(t: float) -> Problem:
        builder = ConicBuilder()
        change, error = builder.variable("change", 3), builder.variable("error", 1)
        builder.cost(error, 1.0)
        bounds = np.repeat(error.index, at.size)
        builder.norm([(change, rows(t).reshape(-1, 3))], beside.ravel(), bound=bounds, size=3)
        return builder.build()

    found = problem(0.5 * (low + high))
    solution = solve(found, Settings(tol=TOLERANCE))
    if solution.status not in (Status.SOLVED, Status.SOLVED_INACCURATE, Status.NUMERICAL_LIMIT):
        return float("nan")
    z, x = project_dual(found, solution.z), np.asarray(solution.x)
    value, worst = float(-(found.h @ z)), np.inf
    weight = float(np.linalg.norm(z.reshape(-1, 4)[:, 1:], axis=1).sum())
    moved = float(np.linalg.norm(x[:3]))
    width = 0.5 * (high - low) / POINTS
    rate = _largest_rate(flight.motion.mean_motion_rad_s * (until_s - low))
    for t in np.linspace(low, high, POINTS + 1).tolist():
        matrix, blocks = problem(t).G, rows(t)
        residual = found.c + matrix.T @ z
        off = np.linalg.norm(beside + blocks @ x[:3], axis=1)
        inverse: Array = np.asarray(np.linalg.pinv(blocks.reshape(-1, 3)), dtype=np.float64).reshape(3, -1, 3)
        move = rate * width / length  # ≥ ‖G_k(t) − G_k(t′)‖ of each sample's rows, for |t − t′| ≤ width
        size = _distance_bound(inverse, level_m + off, move, moved)  # ‖x − solution at t′‖ ≤
        between = move * weight * (moved + size)
        error_off = abs(float(residual[3])) * (level_m + abs(float(x[3])))
        here = value + float(residual @ x) - float(np.linalg.norm(residual[:3])) * size - error_off - between
        worst = float(np.minimum(worst, here))  # NaN stays NaN
    return worst
