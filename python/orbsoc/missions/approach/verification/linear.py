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
from orbsoc.orbit.array import Array

from ..model.approach import Approach

LIMIT_M = 0.01
"""Within which a condition on a length counts as kept."""
LIMIT_M_S = 1e-4
AN_ORBIT = 1850
"""Samples of a revolution."""
KEEP_OUT, CORRIDOR, SPEED = "keep-out on the way", "corridor", "speed by range"
HALF_SPACE = "half-space"


class Check(mission.Check):
    """One condition of the scenario."""

    @property
    def kept(self) -> bool:
        return self.margin >= -(LIMIT_M if self.unit == "m" else LIMIT_M_S)

    def __str__(self) -> str:
        return f"{self.name} is broken by {-self.margin:.3g} {self.unit} at {self.at_s:.0f} s"


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """The coast after an impulse: times (M,), states (M, 6), and above how far it bends from chord to chord, m and m/s."""

    times_s: Array
    states: Array
    bend_m: float
    bend_m_s: float


def arcs(approach: Approach, programme: ImpulseProgramme) -> tuple[Arc, ...]:
    """Every coast of the programme, integrated."""
    ecc = approach.scenario.target.eccentricity if not approach.circular else 0.0
    model = LinearFlight(approach.mean_motion_rad_s, ecc, approach.orbit().true_anomaly_rad)
    ends = np.append(programme.times_s[1:], approach.duration_s)
    grids = [
        np.linspace(a, b, int(np.ceil((b - a) * AN_ORBIT / approach.period_s)) + 1)
        for a, b in zip(programme.times_s.tolist(), ends.tolist(), strict=True)
    ]
    states, after, _ = model.flown(programme, approach.start, np.unique(np.concatenate(grids)))
    found, first = [], 0
    for k, grid in enumerate(grids):
        own = states[first : first + grid.size].copy()
        own[0] = after[k]
        found.append(Arc(grid, own, *bends(approach, grid, own)))
        first += grid.size - 1
    return tuple(found)


def bends(approach: Approach, times_s: Array, states: Array) -> tuple[float, float]:
    """Above how far a coast of states (M, 6) bends from chord to chord, m and m/s."""
    apart = np.diff(times_s)
    step = float(apart.max())
    n = approach.mean_motion_rad_s
    if approach.circular:
        x, _, z, vx, vy, vz = states[0]
        centre = 4.0 * x + 2.0 * vy / n
        swing, across = np.hypot(x - centre, vx / n), np.hypot(z, vz / n)
        largest = n**2 * float(np.sqrt(4.0 * swing**2 + across**2))
        return step**2 / 8.0 * largest, step**2 / 8.0 * n * largest
    pull = np.diff(states[:, 3:], axis=0) / apart[:, None]
    jerk = np.diff(pull, axis=0) / apart[1:, None] if len(pull) > 1 else np.zeros((1, 3))
    largest, changes = (2.0 * float(np.linalg.norm(each, axis=1).max(initial=0.0)) for each in (pull, jerk))
    return step**2 / 8.0 * largest, step**2 / 8.0 * max(changes, n * largest)


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
            state = flown[k + 1].states[0] if point.hold_s else arrived
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
    k = int(each.argmax())
    yield Check("engine", engine.largest_m_s - float(each[k]), "m/s", float(programme.times_s[k]))


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
