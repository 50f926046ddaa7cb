"""The conic problem of an approach whose impulse times are given: Xu & Meng's linear programme, or exact cones.

Rows of lengths are multiplied by the mean motion, so that every row is in m/s. The paper's (6) prints cos + 1 for cos − 1
and counts from the first impulse for the second, and its capture row cos − 1 for 1 − cos; here is what it must mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np
from scipy.optimize import brentq

from orbsoc.conic.builder import ConicBuilder, Term
from orbsoc.guidance.impulses import Impulses
from orbsoc.orbit.array import Array, Index

from ..scenario import DEFAULT_SAMPLES
from .approach import Approach, after_half_orbit, cone_rows
from .margins import Margins

HALF_PLANE_SAMPLES = 72
"""An orbit, of a drift that must stay short of the target."""
CAPTURE, CAPTURE_VELOCITY, CLOSED = "capture", "capture velocity", "closed first ellipse"
TRACK = "approach"
"""The flight itself, which the drifts imply where the first impulse is at the start."""
CLEARED, SHORT, BEYOND = "first drift clears the keep-out", "first drift stays short", "first drift encloses"
MISS, GIVEN_UP = "capture missed by", "depth given up"
MISS_PRICE, GIVEN_UP_PRICE = 50.0, 500.0
RECURSION = 4.0
"""Deviations that a re-plan in flight leaves between a plan and the margins of its own later re-plans."""
AWAY, UNINTERRUPTED = "first drift leads away", "drift 2 stays short"


def drift_name(number: int) -> str:
    """Of the rows that keep the drift after impulse `number` (1, 2, …) safe."""
    return f"drift {number}"


def assemble(
    approach: Approach,
    times_s: Sequence[float] | Array,
    *,
    margins: Margins | None = None,
    start: Array | None = None,
    start_s: float | None = None,
    done: int = 0,
    relaxed: bool = False,
) -> Impulses:
    """Impulses at times_s (N,) from the approach's start on a builder, with every condition of the scenario.

    The start is at the first time unless `start_s` says when.
    `done` impulses went before, `start` (6,) is then the state at the first time: the drift of the first impulse of all
    has its own rules. `relaxed` for re-planning in flight: the capture point may be missed and depth given up, both at a
    price that makes them zero where they can be; `MISS` and `GIVEN_UP` are what it took, in m/s.
    """
    scenario = approach.scenario
    times = np.asarray(times_s, np.float64)
    state = approach.start if start is None else start
    impulses = Impulses(ConicBuilder(), approach.motion, times, state, start_s=start_s, axes=approach.axes)
    impulses.cost(scenario.cost)
    if relaxed:
        _relax(impulses.builder)
    _capture(approach, impulses)
    if approach.guarded:
        for k in range(times.size):
            if done == 0 and k == 0:
                _first_drift(approach, impulses, margins)
            else:
                _drift(approach, impulses, k, done, margins)
        if margins is not None and relaxed:
            _stays_feasible(approach, impulses, done, margins)
        if scenario.interruption_orbits and done == 0:
            _stays_short(approach, impulses, 1, scenario.interruption_orbits, UNINTERRUPTED)
    return impulses


def first_leg(approach: Approach, second_s: float, margins: Margins | None = None) -> Impulses:
    """The first impulse and its drift until the second, with the rules of that drift alone: whatever comes later keeps them."""
    times = np.array([0.0, second_s])
    impulses = Impulses(ConicBuilder(), approach.motion, times, approach.start, axes=approach.axes)
    impulses.cost(approach.scenario.cost)
    _first_drift(approach, impulses, margins)
    return impulses


def _relax(builder: ConicBuilder) -> None:
    for name, price in ((MISS, MISS_PRICE), (GIVEN_UP, GIVEN_UP_PRICE)):
        slack = builder.variable(name, 1)
        builder.cost(slack, price)
        builder.nonnegative([(slack, [[-1.0]])], 0.0)


def _slack(impulses: Impulses, name: str, rows: int, sign: float) -> list[Term]:
    """The slack, with a sign, in the first of a number of rows; none in a problem that is not relaxed."""
    if not impulses.builder.has(name):
        return []
    block = np.zeros((rows, 1))
    block[:1] = sign
    return [(impulses.builder.columns(name), block)]


def _capture(approach: Approach, impulses: Impulses) -> None:
    n, axes = approach.mean_motion_rad_s, list(approach.axes)
    rows = n * np.eye(6)[axes]
    target = n * approach.capture[axes]
    box_m = approach.scenario.capture_box_m
    if impulses.builder.has(MISS):
        off = rows @ impulses.state(approach.duration_s)
        bound = impulses.builder.columns(MISS)
        impulses.builder.norm(off.terms, off.offset - target, bound=bound, name=CAPTURE)
    elif box_m:
        both = np.vstack([rows, -rows])
        limit = np.concatenate([target + n * box_m, n * box_m - target])
        impulses.below(approach.duration_s, both, limit, name=CAPTURE)
    else:
        impulses.meet(approach.duration_s, target, matrix=rows, name=CAPTURE)
    if approach.capture_velocity is not None:
        speed = approach.capture_velocity[axes]
        matrix = np.eye(6)[[3 + axis for axis in axes]]
        impulses.meet(approach.duration_s, speed, matrix=matrix, name=CAPTURE_VELOCITY)


def _first_drift(approach: Approach, impulses: Impulses, margins: Margins | None) -> None:
    """A closed ellipse short of the target or around it, or, without a condition, any drift that leads away."""
    condition, n, side = approach.scenario.condition, approach.mean_motion_rad_s, approach.side
    first = float(impulses.times_s[0])
    if condition == "none":
        if side * approach.start[0] >= approach.keep_out_m:
            _drift(approach, impulses, 0, 0, margins)
            return
        _stays_short(approach, impulses, 0, 1, SHORT, margins)
        if not approach.circular:
            return  # what is known about an eccentric target is known for one orbit
        lead = -approach.ahead * n * approach.closed_row(first)  # by which it drifts
        impulses.below(first, lead, 0.0, name=AWAY)
        return
    impulses.meet(first, [0.0], matrix=n * approach.closed_row(first), name=CLOSED)
    if len(impulses.times_s) > 1:
        clear = approach.motion.transition(float(impulses.times_s[1]), first)[:1]
        extra = _slack(impulses, GIVEN_UP, 1, -1.0)
        impulses.below(first, -n * side * clear, -n * approach.keep_out_m, extra=extra, name=CLEARED)
    if not approach.circular:
        _stays_short(approach, impulses, 0, 1, SHORT)
        return
    far = n * approach.ahead * after_half_orbit(n)
    margin = margins.first_m if margins else 0.0
    share = margins.first_by_size_s if margins else 0.0
    extra = _slack(impulses, GIVEN_UP, 1, -1.0)
    for columns in _sizes(approach, impulses, 0, share):
        extra.append((columns, np.full((1, len(columns)), n * share)))
    if condition == "short":
        impulses.below(first, far, -n * (approach.keep_out_m + margin), extra=extra, name=SHORT)
    else:
        impulses.below(first, -far, -n * (_least_far_vertex(approach) + margin), extra=extra, name=BEYOND)


def _least_far_vertex(approach: Approach) -> float:
    """How far beyond the target the ellipse around it must reach, m. The paper's (8) takes the keep-out radius, which is
    enough from 7 radii on; with cones it is exact."""
    away, keep_out = abs(float(approach.start[1])), approach.keep_out_m
    if approach.scenario.safety == "samples":
        return keep_out
    n = approach.mean_motion_rad_s

    def clearance(b: float) -> float:
        return approach.largest_beyond_m(n * b) - keep_out

    least = brentq(clearance, 0.25 * (away + keep_out) * 0.999, away + 2.0 * keep_out, xtol=1e-9)
    return max(keep_out, 4.0 * float(least) - away)


def _drift(approach: Approach, impulses: Impulses, k: int, done: int, margins: Margins | None) -> None:
    """The free motion after the k-th impulse stays in the safe half-space."""
    n, side, scenario = approach.mean_motion_rad_s, approach.side, approach.scenario
    at, name = float(impulses.times_s[k]), drift_name(done + k + 1)
    if scenario.safety == "samples":
        count = scenario.samples or DEFAULT_SAMPLES
        later = at + approach.period_s * np.arange(1, count + 1) / count
        rows = np.array([approach.motion.transition(float(t), at)[0] for t in later])
        impulses.below(at, -n * side * rows, -n * approach.keep_out_m, name=name)
        return
    margin = margins.drift_m[k] if margins else 0.0
    share = margins.drift_by_size_s if margins else 0.0
    extra = _slack(impulses, GIVEN_UP, 3, 1.0)
    for columns in _sizes(approach, impulses, k, share):
        block = np.zeros((3, len(columns)))
        block[0] = -n * share
        extra.append((columns, block))
    offset = [-n * (approach.keep_out_m + margin), 0.0, 0.0]
    impulses.cone(at, n * side * cone_rows(n), offset, extra=extra, name=name)


def _stays_feasible(approach: Approach, impulses: Impulses, done: int, margins: Margins) -> None:
    """At every later impulse the chaser is as deep as that one's margin will ask for, whatever the first one's errors do."""
    n, side, errors = approach.mean_motion_rad_s, approach.side, approach.scenario.uncertainty
    assert errors is not None
    first = float(impulses.times_s[0])
    for k in range(1, impulses.times_s.size):
        row = approach.motion.transition(float(impulses.times_s[k]), first)[0]
        spread = RECURSION * float(np.hypot(errors.deviation(row), errors.position_m))
        extra = _slack(impulses, GIVEN_UP, 1, -1.0)
        for j, share in ((0, RECURSION * float(errors.gain(row))), (k, margins.drift_by_size_s)):
            block = n * share
            extra += [
                (columns, np.full((1, len(columns)), block))
                for columns in _sizes(approach, impulses, j, share)
            ]
        depth = approach.keep_out_m + float(margins.drift_m[k]) + spread
        at = approach.motion.transition(float(impulses.times_s[k]), float(impulses.times_s[k - 1]))[:1]
        impulses.below(
            float(impulses.times_s[k - 1]),
            -n * side * at,
            -n * depth,
            extra=extra,
            name=f"depth {done + k + 1}",
        )


def _stays_short(
    approach: Approach, impulses: Impulses, k: int, orbits: int, name: str, margins: Margins | None = None
) -> None:
    """The free motion after the k-th impulse stays on the start's side of the keep-out for some orbits, at samples."""
    n, at = approach.mean_motion_rad_s, float(impulses.times_s[k])
    later = at + np.arange(1, orbits * HALF_PLANE_SAMPLES + 1) * 2.0 * pi / n / HALF_PLANE_SAMPLES
    rows = np.array([approach.motion.transition(float(t), at)[1] for t in later])
    margin = margins.first_m if margins else 0.0
    impulses.below(at, n * approach.ahead * rows, -n * (approach.keep_out_m + margin), name=name)


def _sizes(approach: Approach, impulses: Impulses, k: int, share: float) -> list[Index]:
    """Columns whose sum bounds the size of the k-th impulse, as one item; none where no share of it counts."""
    if not share:
        return []
    assert impulses.bounds is not None
    width = 1 if approach.scenario.cost == "norms" else len(approach.axes)
    return [impulses.bounds.index[k * width : (k + 1) * width]]
