"""Flight from waypoint to waypoint on the ellipse, as the paper has it: equal intervals, or each as long as it may be.

The paper finds interval lengths from its eq. (15), which drops the curvature of the ellipse. Here the error of an arc is
that of its exact flight, a Euclidean norm; with it the paper's 19 pulses come out, and with eq. (15) they do not.
"""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.orbit.array import Array

from .flight import Flight

CLOSE = 1e-9
"""Of the tolerance: how near to it an arc's error must come."""
GRID = 2001
"""Points of the quadrature of √|a_req|."""


def required_size(flight: Flight, times_s: ArrayLike) -> Array:
    """|a_req| at times: with it, an arc of length d between two waypoints strays by d²/8 |a_req|."""
    return np.asarray(
        np.linalg.norm(flight.ellipse.required_acceleration(times_s, flight.disturbance_m_s2), axis=-1)
    )


def effort(flight: Flight, end_s: float) -> tuple[Array, Array]:
    """Times (K,) and ∫₀ᵗ √|a_req| dt at them: equal parts of it are arcs of equal error.

    It grows everywhere, by a floor of 1e-6 of the path's own centripetal acceleration.
    """
    times = np.linspace(0.0, end_s, GRID)
    path = flight.ellipse
    root = np.sqrt(required_size(flight, times) + 1e-6 * path.rate_rad_s**2 * max(path.semi_axes_m))
    return times, np.concatenate([[0.0], np.cumsum(0.5 * (root[1:] + root[:-1]) * np.diff(times))])


def counts_by_rule(flight: Flight, end_s: float, tolerance_m: float) -> tuple[float, float]:
    """Adaptive and equal counts of intervals before rounding up, by d²/8 |a_req| = tolerance."""
    times, total = effort(flight, end_s)
    adaptive = total[-1] / np.sqrt(8.0 * tolerance_m)
    equal = end_s * np.sqrt(required_size(flight, times).max() / (8.0 * tolerance_m))
    return float(adaptive), float(equal)


def count_in_tube(flight: Flight, end_s: float, tolerance_m: float) -> int:
    """About how many pulses with waypoints free: arcs stray to both sides, by d²/16 |a_req|, the first from the path."""
    return max(1, ceil(counts_by_rule(flight, end_s, 2.0 * tolerance_m)[0] + 0.146))


def through_waypoints(flight: Flight, start: ArrayLike, times_s: Array) -> ImpulseProgramme:
    """The impulses at all but the last of `times_s` that fly from where the start is through the path at those times."""
    state = np.asarray(start, dtype=np.float64)
    points = flight.ellipse.position(times_s)
    dv = np.empty((len(times_s) - 1, 3))
    for k, dt in enumerate(np.diff(times_s)):
        speed = flight.transfer(state[:3], points[k + 1], dt)
        dv[k] = speed - state[3:]
        after = np.concatenate([state[:3], speed])
        state = flight.state_after(after, dt)
    return ImpulseProgramme(times_s[:-1], dv)


def arc_error(flight: Flight, start_m: Array, start_s: float, dt_s: float) -> float:
    """The largest error of an arc from a position to the path at its end."""
    speed = flight.transfer(start_m, flight.ellipse.position(start_s + dt_s), dt_s)
    return flight.largest_error(flight.arc(np.concatenate([start_m, speed]), dt_s), start_s, dt_s)[0]


def equal_times(flight: Flight, start_m: Array, end_s: float, tolerance_m: float) -> Array:
    """Ends of the fewest equal intervals whose exact errors are within the tolerance, (N + 1,)."""

    def holds(count: int) -> bool:
        times = np.linspace(0.0, end_s, count + 1)
        positions = [start_m, *flight.ellipse.position(times[1:-1])]
        return all(
            arc_error(flight, r, t, end_s / count) <= tolerance_m
            for r, t in zip(positions, times[:-1], strict=True)
        )

    least = int(end_s / flight.longest_transfer_s) + 1
    count = max(least, ceil(counts_by_rule(flight, end_s, tolerance_m)[1]))
    if holds(count):
        while count > least and holds(count - 1):
            count -= 1
    else:
        while not holds(count):
            count += 1
    return np.linspace(0.0, end_s, count + 1)


def adaptive_times(flight: Flight, start_m: Array, end_s: float, tolerance_m: float) -> Array:
    """Ends of intervals each as long as its exact error allows, the last cut at the end, (N + 1,)."""
    times, position = [0.0], start_m
    while times[-1] < end_s:
        length = _longest(flight, position, times[-1], end_s - times[-1], tolerance_m)
        times.append(min(end_s, times[-1] + length))
        position = flight.ellipse.position(times[-1])
    return np.array(times)


def _longest(flight: Flight, start_m: Array, start_s: float, left_s: float, tolerance_m: float) -> float:
    """The longest arc within the tolerance and what is left, below π/ω; the error grows with the square of the length."""
    limit = min(left_s, 0.999 * flight.longest_transfer_s)
    if arc_error(flight, start_m, start_s, limit) <= tolerance_m:
        return limit
    low, high = 0.0, limit
    size = float(required_size(flight, start_s))
    length = min(0.5 * limit, np.sqrt(8.0 * tolerance_m / size) if size > 0.0 else limit)
    for _ in range(100):
        error = arc_error(flight, start_m, start_s, length)
        if abs(error - tolerance_m) <= CLOSE * tolerance_m:
            return float(length)
        low, high = (length, high) if error < tolerance_m else (low, length)
        guess = length * np.sqrt(tolerance_m / error) if error > 0.0 else high
        length = guess if low < guess < high else 0.5 * (low + high)
    return float(low)
