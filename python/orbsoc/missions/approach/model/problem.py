"""The conic problem about a reference flight: hold points, corridor, speed and engine as they are, the keep-out by half-spaces.

Every condition holds at instants on the arc after an impulse, as rows on the state just after it. Outside the keep-out is not
convex: at each instant the flight stays beyond a plane that touches it, where a safe reference looks at it from, or all on one
side. Beyond its planes a flight is outside; one slack, at a price, tells by how much that cannot be. The speed limit by range
uses the range along the reference's direction, which is no longer than the range.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, radians, tan

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.guidance.impulses import ImpulseProgramme, Impulses
from orbsoc.guidance.safety import states_after
from orbsoc.orbit.array import Array

from .approach import Approach

ENTERED = "metres inside the keep-out"
PRICE = 1.0
"""Of a metre inside, in m/s: far above what a metre of the keep-out costs."""
ROOM_M = 2e-3
"""By which every condition is kept better at its instants, for the time between them."""
CORRIDOR, SPEED, KEEP_OUT, HOLD = "corridor", "speed", "keep-out", "hold"


@dataclass(frozen=True, slots=True)
class Instant:
    """After impulse `arc`, of which a `fraction` was flown, at a time."""

    arc: int
    t_s: float
    fraction: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Instants:
    """Where each condition is asked for."""

    keep_out: tuple[Instant, ...] = ()
    corridor: tuple[Instant, ...] = ()
    speed: tuple[Instant, ...] = ()
    hold: tuple[Instant, ...] = ()

    def with_more(self, other: Instants) -> Instants:
        """Both, each instant once."""
        names = self.__dataclass_fields__
        return replace(
            self, **{name: tuple(dict.fromkeys(getattr(self, name) + getattr(other, name))) for name in names}
        )


def at_nodes(approach: Approach) -> Instants:
    """After each impulse, and at the end of its arc: where the conditions are asked for at first."""
    arcs = list(enumerate(zip(approach.times_s.tolist(), approach.ends_s.tolist(), strict=True)))
    ends = [Instant(k, end) for k, (_, end) in arcs]
    both = [Instant(k, t) for k, pair in arcs for t in pair]
    scenario = approach.scenario
    return Instants(
        corridor=tuple(each for each in ends if scenario.corridor and each.t_s > approach.gate_s),
        speed=tuple(both) if scenario.speed else (),
        hold=tuple(
            each
            for _, point in approach.holds()
            for each in both
            if point.arrive_s <= approach.times_s[each.arc] < point.leave_s
        ),
    )


def flown(approach: Approach, programme: ImpulseProgramme) -> Array:
    """States just after each impulse, (K, 6)."""
    return states_after(programme, approach.start, approach.motion)


def position_rows(approach: Approach, at: Instant) -> Array:
    """What the state just after its impulse does to the position then, (3, 6)."""
    return approach.motion.transition(at.t_s, float(approach.times_s[at.arc]))[:3]


def assemble(
    approach: Approach,
    instants: Instants,
    reference: Array | None,
    programme: ImpulseProgramme | None = None,
    side: Array | None = None,
    away: Array | None = None,
) -> Impulses:
    """The problem about a reference, states (K, 6) after the impulses of `programme`; with `side` (3,) all planes have this
    normal. Without either the keep-out is left out. With `away` (3,) each drift's ellipse moves that way along T, or rests.
    """
    builder = ConicBuilder()
    impulses = Impulses(builder, approach.motion, approach.times_s, approach.start, linked=True)
    impulses.cost(approach.scenario.engine.cost)
    _engine(approach, impulses)
    for name, point in approach.scenario.points.items():
        impulses.meet(point.arrive_s, point.position(), before=True, name=f"reach {name}")
        velocity = point.velocity()
        if velocity is not None:
            wanted = np.concatenate([point.position(), velocity])[3:]
            before = not point.hold_s
            impulses.meet(
                point.arrive_s, wanted, matrix=np.eye(6)[3:], before=before, name=f"velocity at {name}"
            )
    for k, at in enumerate(instants.hold):
        _hold(approach, impulses, at, named(HOLD, at, k))
    for k, at in enumerate(instants.corridor):
        _corridor(approach, impulses, at, named(CORRIDOR, at, k))
    for k, at in enumerate(instants.speed):
        _speed(approach, impulses, at, reference, named(SPEED, at, k))
    if away is not None:
        row = away[1] * np.array([[4.0, 0.0, 0.0, 0.0, 2.0 / approach.mean_motion_rad_s, 0.0]])
        for k, t in enumerate(approach.times_s[: approach.guarded].tolist()):
            impulses.below(t, row, 0.0, name=f"moves away {k}")
    if instants.keep_out:
        entered = builder.variable(ENTERED, 1)
        builder.cost(entered, PRICE)
        builder.nonnegative([(entered, [[-1.0]])], 0.0)
        for k, at in enumerate(instants.keep_out):
            normal = side if side is not None else _sight(approach, at, reference, programme)
            _keep_out(approach, impulses, at, normal, named(KEEP_OUT, at, k))
    return impulses


def named(what: str, at: Instant, number: int) -> str:
    """The name of a condition at an instant; the number tells those of one instant apart."""
    return f"{what} at {at.t_s:.0f} s (row {number})"


def _engine(approach: Approach, impulses: Impulses) -> None:
    engine, builder, dv = approach.scenario.engine, impulses.builder, impulses.dv
    if engine.limit == "axes":
        builder.bounds(dv, -engine.largest_m_s, engine.largest_m_s, name="engine")
    else:
        builder.norm([(dv, np.eye(dv.index.size))], bound=engine.largest_m_s, size=3, name="engine")


def _hold(approach: Approach, impulses: Impulses, at: Instant, name: str) -> None:
    t = float(approach.times_s[at.arc])
    point = next(point for _, point in approach.holds() if point.arrive_s <= t < point.leave_s)
    rows = np.vstack([np.zeros(6), position_rows(approach, at)])
    offset = np.concatenate(
        [[point.hold_within_m - min(ROOM_M, 0.1 * point.hold_within_m)], -point.position()]
    )
    impulses.cone(t, rows, offset, name=name)


def _corridor(approach: Approach, impulses: Impulses, at: Instant, name: str) -> None:
    corridor = approach.scenario.corridor
    assert corridor is not None
    axis, angle = corridor.direction(), radians(corridor.half_angle_deg)
    across = np.linalg.svd(axis[None])[2][1:]
    steps = tan(angle)
    matrix = np.vstack([steps * axis, across]) @ position_rows(approach, at)
    less = (corridor.margin_m + min(ROOM_M, 0.1 * corridor.margin_m)) / cos(angle)
    offset = np.concatenate([[-steps * corridor.apex_m - less], np.zeros(2)])
    impulses.cone(float(approach.times_s[at.arc]), matrix, offset, name=name)


def _speed(approach: Approach, impulses: Impulses, at: Instant, reference: Array | None, name: str) -> None:
    speed = approach.scenario.speed
    assert speed is not None
    t = float(approach.times_s[at.arc])
    transition = approach.motion.transition(at.t_s, t)
    # without a reference the line of sight where the way would be straight
    place = _straight(approach, at.t_s) if reference is None else transition[:3] @ reference[at.arc]
    sight = place / max(float(np.linalg.norm(place)), 1e-9)
    matrix = np.vstack([speed.by_range_per_s * sight @ transition[:3], transition[3:]])
    impulses.cone(t, matrix, np.array([speed.at_target_m_s, 0.0, 0.0, 0.0]), name=name)


def _straight(approach: Approach, t_s: float) -> Array:
    """The position on straight lines between the points."""
    times, places = [0.0], [approach.start[:3]]
    for point in approach.scenario.points.values():
        times += [point.arrive_s, point.leave_s]
        places += 2 * [point.position()]
    return np.array([np.interp(t_s, times, column) for column in np.array(places).T])


def _sight(
    approach: Approach, at: Instant, reference: Array | None, programme: ImpulseProgramme | None
) -> Array:
    """The direction, in semi-axes of the keep-out, in which the reference is then, (3,)."""
    assert reference is not None
    assert programme is not None
    axes = approach.axes_m + approach.scenario.keep_out.margin_m
    state = reference[at.arc].copy()
    state[3:] -= (1.0 - at.fraction) * programme.dv_m_s[at.arc]
    place = position_rows(approach, at) @ state / axes
    return np.asarray(place / max(float(np.linalg.norm(place)), 1e-9))


def _keep_out(approach: Approach, impulses: Impulses, at: Instant, normal: Array, name: str) -> None:
    axes = approach.axes_m + approach.scenario.keep_out.margin_m
    least = float(axes.min())
    matrix = -(least * normal / axes)[None] @ position_rows(approach, at)
    terms = [(impulses.builder.columns(ENTERED), np.array([[-1.0]]))]
    if at.fraction < 1.0:
        terms.append((impulses.dv.index[at.arc], -(1.0 - at.fraction) * matrix[:, 3:]))
    impulses.below(float(approach.times_s[at.arc]), matrix, -least - ROOM_M, extra=terms, name=name)
