"""A scenario in the frame (R, T, N): motion, instants of the impulses, what is held when."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi, radians

import numpy as np

from orbsoc.guidance.relative_flight import TRUTHS
from orbsoc.orbit import Elements, state_from_elements
from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.relative import (
    AlongReference,
    ClohessyWiltshire,
    LinearMotion,
    Tabulated,
    YamanakaAnkersen,
)

from ..scenario import Point, Scenario

AN_ORBIT = 720
"""Instants of a revolution, counted from the start, at which drifts about an eccentric target are looked at."""


class Remembered:
    """A motion whose transitions come from those to time 0, each computed once: about an ellipse they take long."""

    def __init__(self, motion: LinearMotion) -> None:
        self._motion = motion
        self._known: dict[float, tuple[Array, Array]] = {}

    def transition(self, t1_s: float, t0_s: float) -> Array:
        """The state transition matrix (6, 6) from t0_s to t1_s, frame (R, T, N)."""
        return self._at(t1_s)[0] @ self._at(t0_s)[1]

    def _at(self, t_s: float) -> tuple[Array, Array]:
        if t_s not in self._known:
            self._known[t_s] = self._motion.transition(t_s, 0.0), self._motion.transition(0.0, t_s)
        return self._known[t_s]


def _oblate(scenario: Scenario) -> Tabulated:
    """Along the target's orbit with J2, for the flight and the drifts after it."""
    period_s = 2.0 * pi / scenario.target.mean_motion()
    forces = TRUTHS["j2"](1)
    along = AlongReference(np.concatenate(state_from_elements(scenario.target.elements)), forces)
    drift_s = max(1.0, scenario.safety.orbits) * period_s
    return Tabulated(along, scenario.duration_s + drift_s + 1.0, 2.0 * period_s / AN_ORBIT)


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """Motion, start (6,), instants of the impulses (K,), and the semi-axes of the keep-out (3,)."""

    scenario: Scenario
    motion: LinearMotion
    mean_motion_rad_s: float
    start: Array
    times_s: Array
    axes_m: Array
    share: float = 1.0
    """Of the drifts' horizon: less on the way to a plan."""
    narrow: float = 1.0
    """Of the keep-out: the same."""
    errors_m: float = 0.0
    """That the plan leaves beyond the scenario's margin, for errors of navigation and execution."""
    in_flight: bool = False
    """Whether the start is where a flight has come to: its drift is what it is, and the first burn is not looked at cut."""
    first_margin_m: float = inf
    """Of the corridor's margin what the first arc keeps, m, where that is less."""
    across: bool = False
    """Whether a flight across the orbital plane is looked for though start and points lie in it."""

    @classmethod
    def of(cls, scenario: Scenario) -> Approach:
        target, rate = scenario.target, scenario.target.mean_motion()
        motion: LinearMotion = ClohessyWiltshire(rate)
        if target.elliptic:
            motion = Remembered(YamanakaAnkersen(rate, target.eccentricity, radians(target.true_anomaly_deg)))
        if scenario.model.j2:
            motion = _oblate(scenario)
        times, before_s = [], 0.0
        for point in scenario.points.values():
            times.append(np.linspace(before_s, point.arrive_s, point.impulses, endpoint=False))
            if point.hold_s:
                times.append(np.linspace(point.arrive_s, point.leave_s, point.hold_impulses, endpoint=False))
            before_s = point.leave_s
        axes = scenario.keep_out.semi_axes()
        return cls(scenario, motion, rate, scenario.start.state(), np.concatenate(times), axes)

    @property
    def period_s(self) -> float:
        return 2.0 * pi / self.mean_motion_rad_s

    @property
    def duration_s(self) -> float:
        return self.scenario.duration_s

    @property
    def planar(self) -> bool:
        """Whether the flight is looked for in the orbital plane, where start and points lie in it. Without a keep-out the cheapest
        flight lies there, too; one past a keep-out may be cheaper beside the plane (`across`)."""
        places = [self.start[2::3], *(each.position()[2:] for each in self.scenario.points.values())]
        speeds = [each.velocity() for each in self.scenario.points.values()]
        if self.across or self.scenario.model.j2:  # which pulls out of it
            return False
        half_space = self.scenario.half_space
        if half_space is not None:
            places.append(half_space.direction()[2:])
        return not any(each.any() for each in (*places, *(each[2:] for each in speeds if each is not None)))

    @property
    def held(self) -> bool:
        """Whether the engine holds an acceleration along every arc, instead of an impulse at its beginning."""
        return self.scenario.engine.thrust == "held"

    @property
    def largest_m_s(self) -> Array:
        """Of the velocity change of each arc, (K,): what the engine gives, whole or by axis."""
        engine = self.scenario.engine
        if engine.largest_m_s2 is None:
            return np.full(self.times_s.size, engine.largest_m_s)
        return np.asarray(engine.largest_m_s2 * (self.ends_s - self.times_s))

    @property
    def limit_unit(self) -> str:
        """Of what the engine gives at most."""
        return "m/s²" if self.held else "m/s"

    @property
    def circular(self) -> bool:
        """Whether the motion is that about a circular target."""
        return isinstance(self.motion, ClohessyWiltshire)

    @property
    def spherical(self) -> bool:
        """Whether the keep-out is a sphere."""
        return bool(np.ptp(self.axes_m) == 0.0)

    @property
    def outer_m(self) -> Array:
        """Semi-axes of the keep-out with its margins, (3,)."""
        return self.narrow * (self.axes_m + self.scenario.keep_out.margin_m + self.errors_m)

    @property
    def gate_s(self) -> float:
        """When the keep-out ends and the corridor begins."""
        return self.scenario.gate.leave_s

    @property
    def guarded(self) -> int:
        """How many impulses come before the gate is left: their drifts must be safe."""
        return int(np.searchsorted(self.times_s, self.gate_s - 1e-6))

    @property
    def ends_s(self) -> Array:
        """When the arc after each impulse ends, (K,)."""
        return np.append(self.times_s[1:], self.duration_s)

    @property
    def horizon_s(self) -> float:
        """For how long a drift stays out; infinite for all time."""
        safety = self.scenario.safety
        return inf if safety.all_time else self.share * safety.orbits * self.period_s

    def transitions(self, times_s: Array, from_s: Array) -> Array:
        """State transition matrices (S, 6, 6) to times (S,) from others (S,)."""
        if isinstance(self.motion, ClohessyWiltshire):
            return self.motion.transitions(times_s - from_s)
        if isinstance(self.motion, Tabulated):
            return self.motion.transitions(times_s, from_s)
        pairs = zip(times_s.tolist(), from_s.tolist(), strict=True)
        return np.array([self.motion.transition(t, at) for t, at in pairs]).reshape(-1, 6, 6)

    def responses(self, times_s: Array, arcs: Index, fractions: Array) -> Array:
        """From what arcs begin with, as `problem.flown` tells it, to the states at times (S,) of the arcs (S,).

        After impulses they are transition matrices (S, 6, 6). Thrust that is held is cut at `fractions` (S,) of the arc, if it is
        not later than the time: (S, 6, 9) on the state at the arc's beginning and the velocity change of the whole arc.
        """
        starts = self.times_s[arcs]
        if not self.held:
            return self.transitions(times_s, starts)
        assert isinstance(self.motion, ClohessyWiltshire)  # the scenario checks it
        whole, lapse = self.ends_s[arcs] - starts, times_s - starts
        pushed = np.clip(fractions * whole, 0.0, np.maximum(lapse, 0.0))
        kick = self.motion.transitions(lapse - pushed) @ self.motion.held(pushed) / whole[:, None, None]
        return np.concatenate([self.motion.transitions(lapse), kick], axis=2)

    def instants(self, first_s: float, last_s: float, each: int = 1) -> Array:
        """Every `each`-th instant of the common grid within a span, and its ends."""
        step = self.period_s / AN_ORBIT
        grid = step * np.arange(0, int(last_s / step) + 1, each)
        return np.concatenate([[first_s], grid[(grid > first_s + 1e-6) & (grid < last_s - 1e-6)], [last_s]])

    def size(self, positions: Array, margin_m: float = 0.0) -> Array:
        """‖p / semi-axes‖ of positions (..., 3): 1 on the keep-out, widened by a margin."""
        return np.asarray(np.linalg.norm(positions / (self.axes_m + margin_m), axis=-1))

    def outside_m(self, positions: Array) -> Array:
        """How far outside the keep-out, at least, m: of a sphere exactly, of an ellipsoid by its least semi-axis."""
        return np.asarray(self.axes_m.min() * (self.size(positions) - 1.0))

    def corridor_margins(self, arcs: Index) -> Array:
        """From the corridor's side on arcs (S,), m."""
        corridor = self.scenario.corridor
        assert corridor is not None
        return np.where(arcs == 0, min(corridor.margin_m, self.first_margin_m), corridor.margin_m)

    def holds(self) -> list[tuple[str, Point]]:
        """The points with a hold."""
        return [(name, point) for name, point in self.scenario.points.items() if point.hold_s]

    def orbit(self) -> Elements:
        """The target's at the start."""
        return self.scenario.target.elements
