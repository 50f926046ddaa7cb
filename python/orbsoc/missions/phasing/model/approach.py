"""What an approach starts from and must reach, the instants at which it may burn, and its flight by the compiled coast."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.orbit import PropagationError
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import fast_coast, fast_coast_with_transitions
from orbsoc.orbit.relative import local_frame

from ..scenario import Scenario
from .mean_motion import element_lengths, element_rows, equinoctial, secular, states_of, wrapped

LAST_S, LAST_NODE_S = 900.0, 150.0
"""Before the meeting instants are closer: for how long, and how close."""
MET_M = 1e-4
"""To which a flight is made to end on the target's state, m, and m/s at the rate of an orbit."""
MET_ELEMENTS_M = 0.05
"""The same in elements: after weeks the rounding of a millimetre at the start is a centimetre."""
RATE_RAD_S = 1.16e-3
"""Makes metres of metres per second where they are compared."""
ROWS = np.diag(np.repeat([1.0, 1.0 / RATE_RAD_S], 3))
NEWTON_STEPS, HALVINGS = 25, 10


@dataclass(frozen=True, slots=True, eq=False)
class Roll:
    """A flight with impulses (K, 3), m/s, inertial, at the instants: the state before each, and the transition matrices
    (K, 6, 6) from each to the end. `miss` (6,) is the chaser's state less the target's, at the end; `off` (6,) is it in
    the coordinates of the approach, m, and `rows` (6, 6) are the derivatives of `off` by the state."""

    dv_m_s: Array
    states: Array
    to_end: Array
    miss: Array
    off: Array
    rows: Array

    @property
    def cost_m_s(self) -> float:
        return float(np.linalg.norm(self.dv_m_s, axis=1).sum())

    @property
    def miss_m(self) -> float:
        """The largest of `off`."""
        return float(np.abs(self.off).max())


@dataclass(frozen=True, slots=True, eq=False)
class Approach:
    """`start` is the chaser's state (6,) at the first of the instants `times_s` (K,), `goal` the target's at the last."""

    scenario: Scenario
    times_s: Array
    start: Array
    goal: Array
    by_elements: bool = False
    """Whether the miss is counted in elements, on which the impulses of weeks act nearly linearly, or in the state."""

    @property
    def met_m(self) -> float:
        """Up to which a flight counts as ending on the target."""
        return MET_ELEMENTS_M if self.by_elements else MET_M

    @property
    def end_s(self) -> float:
        return float(self.times_s[-1])

    def roll(self, dv_m_s: Array) -> Roll:
        """Fly all impulses (K, 3), the last at the meeting. Raises PropagationError."""
        forces = self.scenario.forces_on(self.scenario.chaser.ballistic_m2_kg)
        states, matrices = fast_coast_with_transitions([self.start], self.times_s, forces, dv_m_s[:, None])
        try:
            to_end = matrices[-1, 0] @ np.linalg.inv(matrices[:, 0])
        except np.linalg.LinAlgError as error:  # of a trial that leaves the Earth or falls on it
            raise PropagationError(f"transition matrices: {error}") from None
        miss = states[-1, 0] - self.goal
        miss[3:] += dv_m_s[-1]
        return Roll(dv_m_s, states[:, 0], to_end, miss, *self._coordinates(miss))

    def _coordinates(self, miss: Array) -> tuple[Array, Array]:
        """`off` and `rows` of a miss."""
        if not self.by_elements:
            return ROWS @ miss, ROWS
        off = equinoctial(self.goal + miss) - equinoctial(self.goal)
        off[5] = wrapped(off[5])
        lengths = element_lengths(float(np.linalg.norm(self.goal[:3])))
        return lengths * off, lengths[:, None] * element_rows(self.goal + miss)

    def restore(
        self,
        dv_m_s: Array,
        basis: Callable[[Roll], Array] | None = None,
        *,
        done: int = 0,
        least_m_s: float = 0.0,
        flights: int = NEWTON_STEPS * HALVINGS,
    ) -> Roll | None:
        """A flight near the impulses given that meets the target; None where Newton's method finds none.

        `basis` of a flight, (3K, m), spans the changes of the impulses, of which the least is taken; by default each changes
        in proportion to its size, or to `least_m_s`. The first `done` impulses stay. Newton's method has at most `flights`.
        """
        weights = np.repeat(np.maximum(np.linalg.norm(dv_m_s, axis=1), least_m_s), 3)
        weights[: 3 * done] = 0.0
        try:
            now = self.roll(dv_m_s)
        except PropagationError:
            return None
        for _ in range(NEWTON_STEPS):
            if now.miss_m < self.met_m:
                return now
            effect = now.rows @ np.concatenate(now.to_end[:, :, 3:], axis=1)
            span = None if basis is None else basis(now)
            columns = self._within(np.asarray(effect * weights)) if span is None else effect @ span
            step, *_ = np.linalg.lstsq(columns, now.off, rcond=1e-12)
            change = weights * self._within(np.asarray(step)) if span is None else span @ step
            trial = self._shorter(now, change.reshape(-1, 3), flights)
            if trial is None:
                return None
            now, flights = trial
        return None

    def _shorter(self, now: Roll, change: Array, flights: int) -> tuple[Roll, int] | None:
        """The longest of halved steps that brings the end nearer, and how many of the flights are left."""
        length = 1.0
        for left in range(flights - 1, max(flights - HALVINGS, 0) - 1, -1):
            with suppress(PropagationError):  # a fall to the ground is no shorter way
                trial = self.roll(now.dv_m_s - length * change)
                if trial.miss_m < max((1.0 - 0.5 * length) * now.miss_m, self.met_m):
                    return trial, left
            length *= 0.5
        return None

    def _within(self, rows: Array) -> Array:
        """Rows (..., 3K) with the first impulse's part along the direction that it is held to."""
        if not self.scenario.window.normal_first:
            return rows
        found = rows.copy()
        found[..., :3] = (rows[..., :3] @ self.normal)[..., None] * self.normal
        return found

    def axes(self, roll: Roll, k: int) -> Array:
        """Rows R, T, N of the chaser before instant k, (3, 3)."""
        return local_frame(roll.states[k])[0]

    @property
    def normal(self) -> Array:
        """Of the chaser's plane at the first instant."""
        return np.asarray(local_frame(self.start)[0][2])

    def programme(self, roll: Roll) -> ImpulseProgramme:
        """The impulses that are not negligible, in the chaser's (R, T, N) before each."""
        sizes = np.linalg.norm(roll.dv_m_s, axis=1)
        kept = np.flatnonzero(sizes > 1e-6 * max(1.0, float(sizes.sum())))
        turned = [self.axes(roll, int(k)) @ roll.dv_m_s[k] for k in kept]
        return ImpulseProgramme(self.times_s[kept], np.array(turned))


def approach_between(
    scenario: Scenario,
    start_s: float,
    end_s: float,
    others_s: Array,
    *,
    keep_s: Array | None = None,
    by_elements: bool = False,
) -> Approach:
    """With instants every `window.node_s` and at `others_s`, of two within a second the later one, or that of `keep_s`.

    With `normal_first` the second instant is 15 minutes before the phasing burn, the second of `others_s`.
    """
    window = scenario.window
    from_s = float(others_s[1]) - LAST_S if window.normal_first else start_s
    grid = np.arange(from_s, end_s - LAST_S, window.node_s)
    last = np.arange(end_s - LAST_S, end_s, min(LAST_NODE_S, window.node_s))
    times = np.unique(np.concatenate([grid, last, others_s, [start_s, end_s]]))
    times = times[(times >= start_s) & (times <= end_s)]
    if keep_s is not None:
        apart = np.abs(times[:, None] - keep_s).min(axis=1)
        times = times[(apart > 2.0) | (apart == 0.0)]
    times = times[np.append(np.diff(times) > 1.0, True)]  # no two instants closer than a second
    times[0] = start_s
    return approach_at(scenario, times, by_elements=by_elements)


def approach_at(
    scenario: Scenario, times_s: Array, *, ballistic_m2_kg: float | None = None, by_elements: bool = False
) -> Approach:
    """With these instants alone; `ballistic_m2_kg` is the target's, the scenario's by default."""
    start = state_at(scenario, "chaser", float(times_s[0]))
    goal = state_at(scenario, "target", float(times_s[-1]), ballistic_m2_kg)
    return Approach(scenario, times_s, start, goal, by_elements)


def state_at(scenario: Scenario, name: str, t_s: float, ballistic_m2_kg: float | None = None) -> Array:
    """The coasting chaser's or target's state (6,) at a time, before its epoch too; drag is not run backwards."""
    body = scenario.chaser if name == "chaser" else scenario.target
    drag = body.ballistic_m2_kg if ballistic_m2_kg is None else ballistic_m2_kg
    if body.motion == "mean_j2":
        return np.asarray(states_of(secular(body.elements, np.array(t_s - body.epoch_s))))
    if t_s == body.epoch_s:
        return body.state
    if t_s > body.epoch_s:
        return np.asarray(fast_coast([body.state], [body.epoch_s, t_s], scenario.forces_on(drag))[-1, 0])
    mirrored = body.state * np.repeat([1.0, -1.0], 3)
    back = fast_coast([mirrored], [t_s, body.epoch_s], scenario.forces_on(0.0))[-1, 0]
    return np.asarray(back * np.repeat([1.0, -1.0], 3))


def states_at(scenario: Scenario, name: str, times_s: Array) -> Array:
    """States (M, 6) of the coasting chaser or target at increasing times, the first not before its epoch if it is osculating."""
    body = scenario.chaser if name == "chaser" else scenario.target
    if body.motion == "mean_j2":
        return np.asarray(states_of(secular(body.elements, times_s - body.epoch_s)))
    if times_s.size == 1 or times_s[0] <= body.epoch_s:
        return np.array([state_at(scenario, name, float(t)) for t in times_s])
    forces = scenario.forces_on(body.ballistic_m2_kg)
    return np.asarray(fast_coast([body.state], np.append(body.epoch_s, times_s), forces)[1:, 0])


def departing(scenario: Scenario, start_s: float, end_s: float) -> Scenario:
    """With these dates; a chaser that followed mean elements until then coasts by the forces from its state."""
    chaser = scenario.chaser
    if chaser.motion == "mean_j2":
        chaser = chaser.leaving(state_at(scenario, "chaser", start_s), start_s)
    window = scenario.window.model_copy(update={"start_s": start_s, "end_s": end_s, "dates_h": 0.0})
    return scenario.model_copy(update={"chaser": chaser, "window": window})
