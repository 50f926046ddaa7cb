"""Starts that know where the target is: thrust laws that are flown onto it before any convex problem is solved.

The present start, thrust along the velocity, is tried first. Where it fails these follow, in this order: thrust along the
velocity that the target orbit has there less the vehicle's, which raises, lowers, turns and circularises; then along and
against the velocity and across the plane.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from math import sqrt

import numpy as np

from orbsoc.guidance.collocation import LegendreGauss
from orbsoc.guidance.powered_flight import Burn, Trajectory
from orbsoc.orbit import EARTH, CanonicalUnits, ConstantsSet, PropagationError, Thruster, propagate_burn
from orbsoc.orbit.array import Array
from orbsoc.orbit.propagate import Steering

from .. import tuning
from ..targets.target import Target
from .steering_law import Law, constant, corrected, longest_of


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """From where a search sets out: a law and what it misses the orbit by, the largest of the relative conditions; without a law
    what the name says."""

    name: str
    law: Law | None = None
    miss: float = np.inf

    @property
    def reaches(self) -> bool:
        return self.miss <= tuning.REACHED


def starts(burn: Burn, target: Target, *, after: int = 0) -> Iterator[Start]:
    """One start a direction, without the first ones; each is worked out when it is asked for."""
    for name, direction in islice(_directions(burn, target), after, None):
        yield _flown(burn, target, name, direction)


def impulse(burn: Burn, target: Target) -> Array:
    """Velocity of the target orbit less the vehicle's, canonical (3,): what a burn in no time would give."""
    return target.impulse(burn.start)


def burn_time(burn: Burn, delta_v: float) -> float:
    """Canonical time in which the engine gives a velocity, at most nearly all there is."""
    exhaust = burn.acceleration / burn.flow
    return min(float(-np.expm1(-delta_v / exhaust) / burn.flow), tuning.LEFT * longest_of(burn))


def _directions(burn: Burn, target: Target) -> Iterator[tuple[str, Array]]:
    velocity = burn.start[3:]
    towards = impulse(burn, target)
    if float(np.linalg.norm(towards)) > 1e-6:
        yield "thrust towards the target's velocity", towards
    yield "thrust along the velocity, corrected in flight", velocity
    yield "thrust against the velocity", -velocity
    across = np.cross(burn.start[:3], velocity)
    yield "thrust across the plane, to the left", across
    yield "thrust across the plane, to the right", -across


def _flown(burn: Burn, target: Target, name: str, direction: Array) -> Start:
    size = float(np.linalg.norm(impulse(burn, target)))
    shortest, least = burn_time(burn, size), 1e-3 * burn.longest
    best: tuple[float, Law] | None = None
    durations = [least] if shortest == 0.0 else [shortest] if shortest >= least else [shortest, least]
    tries = [(degree, time, True) for time in durations for degree in (1, 2)]
    tries += [(2, longer * durations[-1], False) for longer in tuning.LONGER]
    tries.append((2, tuning.LEFT * longest_of(burn), False))
    for degree, time, free in tries:
        if time > longest_of(burn):
            continue
        law, miss = corrected(burn, target, constant(direction, time).of_degree(degree), free_duration=free)
        if best is None or miss < best[0]:
            best = miss, law
        if miss <= tuning.REACHED:
            break
    assert best is not None
    return Start(name, best[1], best[0])


def along_velocity(burn: Burn, grid: LegendreGauss, duration: float) -> Trajectory:
    """What thrust along the velocity flies for a canonical time: the cold start of problems A and B.

    By Runge and Kutta's method of order 4, in steps of one length between two nodes, within 1e-9: it is where a sequence sets out.
    `flight/missions/flights.c` makes the same bits. Raises `orbsoc.orbit.PropagationError` where it does not stay finite.
    """
    steps = steps_between(grid, duration)
    states, state, last = [], burn.start, 0.0
    with np.errstate(all="ignore"):
        for time in [*(0.5 * duration * (grid.nodes + 1.0)).tolist(), duration]:
            state = _flown_along_velocity(burn, state, last, time, steps)
            states.append(state)
            last = time
    if not np.isfinite(states).all():
        raise PropagationError("thrust along the velocity leads through the centre")
    controls = np.array([each[3:] / sqrt(_square(each[3:])) for each in states[:-1]])
    return Trajectory(grid, np.array(states[:-1]), controls, states[-1], duration)


def steps_between(grid: LegendreGauss, duration: float) -> int:
    """Steps of that flight between two nodes."""
    widest = 0.5 * duration * float(np.diff([-1.0, *grid.nodes, 1.0]).max())
    return int(np.ceil(widest / tuning.COLD_STEP))


def _flown_along_velocity(burn: Burn, state: Array, begin: float, end: float, steps: int) -> Array:
    def rate(elapsed: float, at: Array) -> Array:
        radius, speed = sqrt(_square(at[:3])), sqrt(_square(at[3:]))
        thrust = burn.acceleration / (1.0 - burn.flow * elapsed)
        return np.concatenate([at[3:], thrust * at[3:] / speed - at[:3] / (radius * radius * radius)])

    step = (end - begin) / steps
    for k in range(steps):
        now = begin + k * step
        half = now + 0.5 * step
        first = rate(now, state)
        second = rate(half, state + 0.5 * step * first)
        third = rate(half, state + 0.5 * step * second)
        fourth = rate(now + step, state + step * third)
        state = state + step / 6.0 * (first + 2.0 * (second + third) + fourth)
    return state


def _square(a: Array) -> float:
    return float(a[0] * a[0] + (a[1] * a[1] + a[2] * a[2]))


def towards_plane(normal: Array, units: CanonicalUnits) -> Steering:
    """Thrust along v̂ − 2(v·n)n, v canonical: along the velocity and back towards the plane of normal n."""

    def steering(_t_s: float, state_si: Array) -> Array:
        velocity = state_si[3:] / units.speed_m_s
        return velocity / np.linalg.norm(velocity) - 2.0 * (velocity @ normal) * normal

    return steering


def propagated(
    state_si: Array,
    thruster: Thruster,
    steering: Steering,
    duration_s: float,
    grid: LegendreGauss,
    about: ConstantsSet = EARTH,
) -> Trajectory:
    """The trajectory (canonical) that `steering` flies, at the nodes of `grid` and at the end.

    Raises `orbsoc.orbit.PropagationError` when it cannot be integrated.
    """
    units = CanonicalUnits.of(about)
    times_s = 0.5 * duration_s * (np.append(grid.nodes, 1.0) + 1.0)
    states_si = propagate_burn(state_si, thruster, steering, times_s, constants=about)
    directions = np.array([steering(t, x) for t, x in zip(times_s[:-1], states_si[:-1], strict=True)])
    states = units.state_from_si(states_si)
    return Trajectory(
        grid=grid,
        states=states[:-1],
        controls=directions / np.linalg.norm(directions, axis=1, keepdims=True),
        end=states[-1],
        duration=duration_s / units.time_s,
    )
