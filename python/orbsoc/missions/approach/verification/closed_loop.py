"""Fly the programme about the Earth with J2 and drag, corrected before every impulse, and tell how well it is kept.

The correction is a linear law: of all corrections to come the first, of the least sum of squares of misses and corrections, by
the linear model (a Riccati recursion). A miss counts by a hundredth of the range, at least 0.1 m, a correction by 1 cm/s.
Corrections end at the largest impulse.
Without errors of navigation and execution there is one flight, otherwise as many as are asked for, each of its own draws.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from orbsoc.guidance.held_thrust import HeldThrust
from orbsoc.guidance.impulses import ImpulseProgramme, spread_kick
from orbsoc.guidance.relative_flight import TRUTHS
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.orbit import state_from_elements
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import coast
from orbsoc.orbit.relative import absolute_state, relative_state

from ..model.approach import Approach
from .linear import LIMIT_M, Arc

MISS_SHARE, LEAST_MISS_M, CORRECTION_M_S = 0.01, 0.1, 0.01
SAMPLES = 6
"""Of an arc, at which a flight is judged, its ends among them."""
RTOL = 1e-10


@dataclass(frozen=True, slots=True, eq=False)
class CorrectedFlights:
    """Of B flights: times (M,), relative positions (M, B, 3) and speeds (M, B), and what they kept.

    Least distances outside the keep-out before the gate (B,) and inside the corridor after it (B,), m; miss of the last point
    (B,), m, and of its velocity (B,), m/s; Δv (B,); the largest impulse (B,), or acceleration that is held, m/s², whole or by
    axis as it is limited. The inertial pairs of each arc from which drifts are judged (K, P, B, 2, 6): after the impulse, or where
    thrust that is held may be cut.
    """

    times_s: Array
    positions: Array
    speeds: Array
    outside_m: Array
    corridor_m: Array
    speed_spare_m_s: Array
    miss_m: Array
    miss_m_s: Array
    delta_v_m_s: Array
    largest_m_s: Array
    pairs: Array

    def pairs_before(self, count: int) -> Array:
        """Of the first flight's first `count` arcs the pairs from which drifts are judged, (S, 2, 6)."""
        return self.pairs[:count, :, 0].reshape(-1, 2, 6)

    @property
    def entered(self) -> int:
        """How many came into the keep-out before the gate."""
        return int((self.outside_m < -LIMIT_M).sum())

    @property
    def left_corridor(self) -> int:
        return int((self.corridor_m < -LIMIT_M).sum())

    def to_dict(self) -> dict[str, Any]:
        """Of `truth` and `monte_carlo` in plan.json."""
        found: dict[str, Any] = {
            "flights": len(self.miss_m),
            "entered": self.entered,
            "left_corridor": self.left_corridor,
        }
        least = ("outside_m", "corridor_m", "speed_spare_m_s")
        for name in (*least, "miss_m", "miss_m_s", "delta_v_m_s", "largest_m_s"):
            values = getattr(self, name)
            extreme = float(values.min() if name in least else values.max())
            found[name] = {"mean": float(values.mean()), "worst": extreme} if np.isfinite(extreme) else None
        return found


def gains(approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...]) -> Array:
    """Of each impulse, or velocity change of an arc, what a deviation of the state before it adds to it, (K, 3, 6)."""
    price = np.eye(3) / CORRECTION_M_S**2
    last = flown[-1].states[-1]
    value = _price(float(np.linalg.norm(last[:3])))
    value[3:, 3:] = np.eye(3) / (0.1 * CORRECTION_M_S) ** 2
    found = np.empty((len(programme), 3, 6))
    for k in reversed(range(len(programme))):
        arc = flown[k]
        transition = approach.motion.transition(float(arc.times_s[-1]), float(arc.times_s[0]))
        pulled, kick = transition.T @ value @ transition, _kick(approach, arc)
        found[k] = -np.linalg.solve(price + kick.T @ pulled @ kick, kick.T @ pulled)
        value = pulled + pulled @ kick @ found[k] + _price(float(np.linalg.norm(arc.states[0, :3])))
    return found


def _kick(approach: Approach, arc: Arc) -> Array:
    """The state at the arc's beginning whose drift ends where a unit of its velocity change leads, (6, 3)."""
    motion, (first, last) = approach.motion, arc.times_s[[0, -1]].tolist()
    if not approach.held:
        return np.vstack([np.zeros((3, 3)), np.eye(3)])
    return np.asarray(motion.transition(first, last) @ spread_kick(motion, last, first, last))


def _price(range_m: float) -> Array:
    miss = max(LEAST_MISS_M, MISS_SHARE * range_m)
    return np.diag([1.0 / miss**2] * 3 + [0.0] * 3)


def fly_corrected(
    approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...], *,
    errors: Uncertainty | None = None, runs: int = 1, forces: str = "j2_drag",
) -> CorrectedFlights:  # fmt: skip
    """Fly `runs` times. Run k draws from (seed, k). Raises PropagationError."""
    scenario, law = approach.scenario, gains(approach, programme, flown)
    draws = [np.random.default_rng([errors.seed, run]) for run in range(runs)] if errors else []
    acting = TRUTHS[forces](runs)
    target = np.concatenate(state_from_elements(approach.orbit()))
    pull = _pulls(np.array([target, target]), TRUTHS[forces](1))[0]
    pairs = np.tile(np.array([target, absolute_state(target, approach.start, pull)]), (runs, 1, 1))
    rows, times, after = [], [], []
    spent, largest = np.zeros(runs), np.zeros(runs)
    for k, arc in enumerate(flown):
        states = _relative(pairs, acting)
        planned, fired = arc.states[0].copy(), np.empty((runs, 3))
        lasts_s = float(arc.times_s[-1] - arc.times_s[0]) if approach.held else 1.0
        if not approach.held:
            planned[3:] -= programme.dv_m_s[k]
        for run in range(runs):
            known = errors.navigated(states[run], draws[run]) if errors else states[run]
            dv = programme.dv_m_s[k] + law[k] @ (known - planned)
            dv = _limited(dv, float(approach.largest_m_s[k]), scenario.engine.limit)
            fired[run] = errors.executed(dv, draws[run]) if errors else dv
        spent += np.linalg.norm(fired, axis=1)
        by_axis = scenario.engine.limit == "axes"
        largest = np.maximum(largest, np.linalg.norm(fired, np.inf if by_axis else 2, axis=1) / lasts_s)
        if not approach.held:
            states[:, 3:] += fired
        bodies = pairs[:, 0]
        pulls = _pulls(pairs.reshape(-1, 6), acting)[::2]
        chasers = [absolute_state(*each) for each in zip(bodies, states, pulls, strict=True)]
        pairs = np.stack([bodies, np.array(chasers)], axis=1)
        thrust = [HeldThrust(fired / lasts_s)] if approach.held else []
        grid = np.linspace(arc.times_s[0], arc.times_s[-1], SAMPLES)
        flight = coast(pairs.reshape(-1, 6), grid, [*acting, *thrust], rtol=RTOL).reshape(SAMPLES, runs, 2, 6)
        after.append(flight if approach.held else pairs[None])
        rows.append(np.array([_relative(each, acting) for each in flight]))
        times.append(grid)
        pairs = flight[-1]
    states, at = np.concatenate(rows), np.concatenate(times)
    positions, speeds = states[..., :3], np.linalg.norm(states[..., 3:], axis=-1)
    before = at <= approach.gate_s + 1e-6
    corridor, speed = scenario.corridor, scenario.speed
    inside = corridor.depth(positions[~before]).min(axis=0) if corridor is not None else np.full(runs, np.inf)
    ranges = np.linalg.norm(positions, axis=-1)
    spare = (speed.limit(ranges) - speeds).min(axis=0) if speed is not None else np.full(runs, np.inf)
    last = list(scenario.points.values())[-1]
    wanted = last.velocity()
    off = np.zeros(runs) if wanted is None else np.linalg.norm(states[-1, :, 3:] - wanted, axis=1)
    return CorrectedFlights(
        at, positions, speeds, approach.outside_m(positions[before]).min(axis=0), inside, spare,
        np.linalg.norm(states[-1, :, :3] - last.position(), axis=1), off, spent, largest, np.array(after),
    )  # fmt: skip


def _limited(dv: Array, most: float, limit: str) -> Array:
    """What the engine gives of a velocity change (3,): no more than its largest, whole or by axis, m/s."""
    if limit == "axes":
        return dv.clip(-most, most)
    return np.asarray(dv * min(1.0, most / max(float(np.linalg.norm(dv)), 1e-30)))


def _relative(pairs: Array, acting: Any) -> Array:
    """Relative states (B, 6) of inertial pairs (B, 2, 6)."""
    pulls = _pulls(pairs.reshape(-1, 6), acting)[::2]
    return np.array([relative_state(pair[0], pair[1], pull) for pair, pull in zip(pairs, pulls, strict=True)])


def _pulls(bodies: Array, acting: Any) -> Array:
    return np.asarray(sum(force.acceleration(bodies) for force in acting))
