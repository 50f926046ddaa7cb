"""Fly the programme by the integrated linear equations, and judge every condition, between the samples by a bound.

Between two samples h apart a position is within h²/8 max‖p̈‖ of the chord, a velocity within h²/8 max‖p⃛‖. About a circular target
these have closed forms in the state; about another they are taken as twice the largest difference quotient.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np

from orbsoc.guidance import mission
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.linear_flight import LinearFlight
from orbsoc.guidance.relative_flight import TRUTHS
from orbsoc.orbit import state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import AlongReference

from ..model.approach import Approach

LIMIT_M = 0.01
"""Within which a condition on a length counts as kept."""
LIMITS = {"m": LIMIT_M, "m/s": 1e-4, "m/s²": 1e-6}
"""The same of every condition, by its unit."""
AN_ORBIT = 1850
"""Samples of a revolution."""
PUSH_BEND_M = 5e-4
KEEP_OUT, CORRIDOR, SPEED = "keep-out on the way", "corridor", "speed by range"
HALF_SPACE = "half-space"


class Check(mission.Check):
    """One condition of the scenario."""

    @property
    def kept(self) -> bool:
        return self.margin >= -LIMITS[self.unit]

    def __str__(self) -> str:
        return f"{self.name} is broken by {-self.margin:.3g} {self.unit} at {self.at_s:.0f} s"


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """The coast after an impulse, or the flight while thrust is held: times (M,), states (M, 6), and above how far it bends from chord to chord, m and m/s."""

    times_s: Array
    states: Array
    bend_m: float
    bend_m_s: float


def arcs(approach: Approach, programme: ImpulseProgramme) -> tuple[Arc, ...]:
    """Every arc of the programme, integrated; with J2 the target's orbit is, arc by arc, with its own variational equations."""
    ends = np.append(programme.times_s[1:], approach.duration_s)
    grids = [
        np.linspace(a, b, _samples(approach, b - a, size) + 1)
        for a, b, size in zip(programme.times_s.tolist(), ends.tolist(), programme.sizes_m_s, strict=True)
    ]
    if approach.scenario.model.j2:
        return tuple(_oblate_arcs(approach, programme, grids))
    ecc = approach.scenario.target.eccentricity if not approach.circular else 0.0
    model = LinearFlight(approach.mean_motion_rad_s, ecc, approach.orbit().true_anomaly_rad)
    every = np.unique(np.concatenate(grids))
    states, after, _ = model.flown(programme, approach.start, every, held=approach.held)
    found, first = [], 0
    for k, grid in enumerate(grids):
        own = states[first : first + grid.size].copy()
        own[0] = after[k]
        bend = bends(approach, grid, own)
        if approach.held:
            bend = pushed_bends(approach, grid, own[0], programme.dv_m_s[k] / (grid[-1] - grid[0]))
        found.append(Arc(grid, own, *bend))
        first += grid.size - 1
    return tuple(found)


def _oblate_arcs(approach: Approach, programme: ImpulseProgramme, grids: list[Array]) -> Iterator[Arc]:
    """With J2: the target's orbit integrated from arc to arc, each with its own transitions."""
    target, forces = np.concatenate(state_from_elements(approach.orbit())), TRUTHS["j2"](1)
    state = approach.start
    for grid, dv in zip(grids, programme.dv_m_s, strict=True):
        state = np.concatenate([state[:3], state[3:] + dv])
        along = AlongReference(target, forces)
        along.prepare(grid - grid[0])
        lapses = (grid - grid[0]).tolist()
        own = np.array([along.transition(t, 0.0) @ state for t in lapses])
        yield Arc(grid, own, *bends(approach, grid, own))
        target, state = along.target(lapses[-1]), own[-1]


def _samples(approach: Approach, lasts_s: float, size_m_s: float) -> int:
    """Chords of an arc, enough that a push that is held bends none by more than `PUSH_BEND_M`."""
    count = int(np.ceil(lasts_s * AN_ORBIT / approach.period_s))
    if approach.held:
        count = max(count, int(np.ceil(np.sqrt(lasts_s * size_m_s / (8.0 * PUSH_BEND_M)))))
    return count


def bends(approach: Approach, times_s: Array, states: Array) -> tuple[float, float]:
    """Above how far a coast of states (M, 6) bends from chord to chord, m and m/s."""
    apart = np.diff(times_s)
    step = float(apart.max())
    n = approach.mean_motion_rad_s
    if approach.circular:
        largest = largest_acceleration(n, states[0])
        return step**2 / 8.0 * largest, step**2 / 8.0 * n * largest
    pull = np.diff(states[:, 3:], axis=0) / apart[:, None]
    jerk = np.diff(pull, axis=0) / apart[1:, None] if len(pull) > 1 else np.zeros((1, 3))
    largest, changes = (2.0 * float(np.linalg.norm(each, axis=1).max(initial=0.0)) for each in (pull, jerk))
    return step**2 / 8.0 * largest, step**2 / 8.0 * max(changes, n * largest)


def _swings(n: float, state: Array) -> tuple[float, float, float]:
    """Of a drift about a circular target from a state (6,): how far its centre lies outward, and how far it swings along the track
    and across it, m."""
    x, _, z, vx, vy, vz = state.tolist()
    centre = 4.0 * x + 2.0 * vy / n
    return centre, 2.0 * float(np.hypot(x - centre, vx / n)), float(np.hypot(z, vz / n))


def pushed_rate(n: float, state: Array, push: Array) -> Array:
    """The rate (6,) of a state (6,) about a circular target under an acceleration (3,) that is held.

    While it is held the rate changes as the state of a drift does: ẍ = A ẋ where ẋ = A x + K a.
    """
    x, _, z, vx, vy, _ = state.tolist()
    pull = np.array([3.0 * n**2 * x + 2.0 * n * vy, -2.0 * n * vx, -(n**2) * z])
    return np.concatenate([state[3:], pull + push])


def largest_speed(n: float, state: Array) -> float:
    """Above the speed of a drift about a circular target from a state (6,), whenever, m/s."""
    centre, along, across = _swings(n, state)
    return n * float(np.hypot(1.5 * abs(centre) + along, across))


def largest_acceleration(n: float, state: Array) -> float:
    """The same of the drift's acceleration, m/s²."""
    return n**2 * float(np.hypot(*_swings(n, state)[1:]))


def pushed_bends(approach: Approach, times_s: Array, state: Array, push: Array) -> tuple[float, float]:
    """The same as `bends` of the flight from a state (6,) while an acceleration (3,) is held, about a circular target: a position's
    second derivative is the speed of the drift that its rate makes, a velocity's second that drift's acceleration."""
    n, step = approach.mean_motion_rad_s, float(np.diff(times_s).max())
    rate = pushed_rate(n, state, push)
    jerk = largest_acceleration(n, rate)
    pull = float(np.linalg.norm(rate[3:])) + float(times_s[-1] - times_s[0]) * jerk
    return step**2 / 8.0 * min(pull, largest_speed(n, rate)), step**2 / 8.0 * jerk


def checks(approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...]) -> tuple[Check, ...]:
    """Every condition on the way, with its least margin; between samples by the bends."""
    return tuple(_checks(approach, programme, flown))


def _checks(approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...]) -> Iterator[Check]:
    scenario = approach.scenario
    before = [arc for arc in flown if arc.times_s[0] < approach.gate_s - 1e-6]
    yield _least(KEEP_OUT, "m", [(arc, _outside(approach, arc)) for arc in before])
    if scenario.corridor is not None:
        inside = [arc for arc in flown if arc.times_s[0] >= approach.gate_s - 1e-6]
        depths = [(arc, scenario.corridor.depth(arc.states[:, :3]) - arc.bend_m) for arc in inside]
        yield _least(CORRIDOR, "m", depths)
    if scenario.half_space is not None:
        within = [arc for arc in flown if arc.times_s[0] >= scenario.half_space_s - 1e-6]
        depths = [(arc, scenario.half_space.depth(arc.states[:, :3]) - arc.bend_m) for arc in within]
        yield _least(HALF_SPACE, "m", depths)
    if scenario.speed is not None:
        rows = []
        for arc in flown:
            ranges = np.linalg.norm(arc.states[:, :3], axis=1)
            # a range between samples is no less than that of the nearer one less half a step's way
            slack = arc.bend_m_s + scenario.speed.by_range_per_s * arc.bend_m
            rows.append(
                (arc, scenario.speed.limit(ranges) - np.linalg.norm(arc.states[:, 3:], axis=1) - slack)
            )
        yield _least(SPEED, "m/s", rows)
    for name, point in scenario.points.items():
        k = int(np.searchsorted(programme.times_s, point.arrive_s - 1e-6)) - 1
        arrived = flown[k].states[-1]
        miss = float(np.linalg.norm(arrived[:3] - point.position()))
        yield Check(f"reach {name}", -miss, "m", point.arrive_s)
        velocity = point.velocity()
        if velocity is not None:
            state = flown[k + 1].states[0] if point.hold_s and not approach.held else arrived
            yield Check(
                f"velocity at {name}", -float(np.linalg.norm(state[3:] - velocity)), "m/s", point.arrive_s
            )
        held = [arc for arc in flown if point.arrive_s - 1e-6 <= arc.times_s[0] < point.leave_s - 1e-6]
        if point.hold_s:
            away = [
                (
                    arc,
                    point.hold_within_m
                    - np.linalg.norm(arc.states[:, :3] - point.position(), axis=1)
                    - arc.bend_m,
                )
                for arc in held
            ]
            yield _least(f"hold at {name}", "m", away)
    engine = scenario.engine
    each = programme.sizes_m_s if engine.limit == "norm" else np.abs(programme.dv_m_s).max(axis=1)
    if approach.held:
        each = each / (approach.ends_s - approach.times_s)
    most = engine.largest_m_s if engine.largest_m_s2 is None else engine.largest_m_s2
    k = int(each.argmax())
    yield Check("engine", most - float(each[k]), approach.limit_unit, float(programme.times_s[k]))


def _least(name: str, unit: str, rows: list[tuple[Arc, Array]]) -> Check:
    found = Check(name, inf, unit, 0.0)
    for arc, margins in rows:
        k = int(margins.argmin())
        if margins[k] < found.margin:
            found = Check(name, float(margins[k]), unit, float(arc.times_s[min(k, len(arc.times_s) - 1)]))
    return found


def _outside(approach: Approach, arc: Arc) -> Array:
    """Below how far outside the keep-out each chord stays, m."""
    sizes = chord_lengths(arc.states[:, :3] / approach.axes_m)
    return np.asarray(approach.axes_m.min() * (sizes - 1.0) - arc.bend_m)


def chord_lengths(positions: Array) -> Array:
    """The least norm on each chord of a path (M, 3), (M − 1,)."""
    first, along = positions[:-1], np.diff(positions, axis=0)
    squares = np.maximum((along**2).sum(axis=1), 1e-30)
    share = np.clip(-(first * along).sum(axis=1) / squares, 0.0, 1.0)
    return np.asarray(np.linalg.norm(first + share[:, None] * along, axis=1))
