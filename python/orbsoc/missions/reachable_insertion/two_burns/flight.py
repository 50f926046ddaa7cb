"""Transfers flown many at once, and the sensitivities of the ends of their burns to everything that a transfer commands.

Coasts are those of `motion`; burns are integrated in the commanded direction, the interpolant of the nodal
directions, normalised. The transition matrices of the burns are central differences of neighbouring flights; the influence of
the thrust on an end state is the quadrature of Φ(1, τ) [0; k u] on the Legendre–Gauss points at which the steps of a burn end.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from orbsoc.guidance.collocation import interpolation_matrix, legendre_gauss
from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit.array import Array
from orbsoc.orbit.runge_kutta import RungeKuttaArc, force_times, integrate_explicitly

from .motion import DIFFERENCE, Motion, lowest_of
from .transfer import Transfer

FEWEST_STEPS = 16
SPARE = 4
"""Steps of a burn beyond its nodes: the quadrature is then exact for the interpolant times a smooth transition."""
LIGHTEST = 1e-3
"""Of the first mass, that a flight is never lighter than."""


@dataclass(frozen=True, slots=True, eq=False)
class CutOff:
    """The state (6,) at the end of a burn, by [coasts, durations] (6, 2K) and by thrust (6, K, N, 3), a length of which counts."""

    state: Array
    by_times: Array
    by_controls: Array


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivities:
    """Of a transfer: the end of each burn, the states (K, 6) at the ignitions, and `turns` (K, 3, 2K): by which rotation the
    direction to each ignition follows [coasts, durations]."""

    cut_offs: tuple[CutOff, ...]
    ignitions: Array
    turns: Array

    @property
    def last(self) -> CutOff:
        return self.cut_offs[-1]

    @property
    def end(self) -> Array:
        return self.last.state


@dataclass(frozen=True, slots=True, eq=False)
class LowestPoint:
    """The least radius of the coasts between burns, by [coasts, durations] (2K,) and by thrust (K, N, 3)."""

    radius: float
    by_times: Array
    by_controls: Array


def lowest_point(motion: Motion, transfer: Transfer, found: Sensitivities) -> LowestPoint:
    """Where it lies inside a coast, the time of it does not count to first order."""
    coast = float(transfer.coasts[1])
    cut_off = found.cut_offs[0]
    radius, when = lowest_of(motion.coast, cut_off.state, coast)
    state, transition = motion.coast.transition(cut_off.state, when)
    up = state[:3] / float(np.linalg.norm(state[:3]))
    by_state = up @ transition[:3]
    by_times = by_state @ cut_off.by_times
    if when >= coast:
        by_times[1] += up @ state[3:]
    return LowestPoint(radius, by_times, np.einsum("i,iknd->knd", by_state, cut_off.by_controls))


def ends_of(motion: Motion, transfers: list[Transfer]) -> Array:
    """States (B, K, 6) at the ends of the burns of transfers on one grid."""
    count, burn = len(transfers), motion.burn
    states = np.repeat(burn.start[None], count, axis=0)
    elapsed, ends = np.zeros(count), []
    for k in range(len(transfers[0].coasts)):
        states = motion.coast.ends(states, np.array([each.coasts[k] for each in transfers]))
        durations = np.array([each.durations[k] for each in transfers])
        controls = np.array([each.controls[k] for each in transfers])
        arc = _burnt(burn, states, elapsed, durations, controls)
        states = np.hstack([arc.positions[-1].T, (arc.velocities[-1] / durations).T])
        elapsed = elapsed + durations
        ends.append(states)
    return np.stack(ends, axis=1)


def sensitivities(motion: Motion, transfer: Transfer) -> Sensitivities:
    """Of a transfer, by one batch of flights a burn."""
    burn = motion.burn
    state, elapsed = burn.start, 0.0
    burns = len(transfer.coasts)
    nodes = transfer.grid.size
    by_coasts, by_durations = np.zeros((6, burns)), np.zeros((6, burns))
    by_controls = np.zeros((6, burns, nodes, 3))
    ignitions, cut_offs = np.zeros((burns, 6)), []
    turns = np.zeros((burns, 3, 2 * burns))
    for k in range(burns):
        state, transition = motion.coast.transition(state, float(transfer.coasts[k]))
        radius = float(np.linalg.norm(state[:3]))
        by_coasts = transition @ by_coasts
        by_durations = transition @ by_durations
        by_coasts[:, k] = motion.coast.rate(state)
        by_times = np.hstack([by_coasts, by_durations])
        turns[k] = np.cross(state[:3], by_times[:3].T).T / radius**2
        arc = _burn_transition(burn, state, elapsed, float(transfer.durations[k]), transfer.controls[k])
        by_coasts = arc.transition @ by_coasts
        by_durations = arc.transition @ by_durations
        by_durations[:, :k] += arc.by_elapsed[:, None]
        by_controls = np.einsum("ij,jknd->iknd", arc.transition @ transition, by_controls)
        by_durations[:, k] = arc.by_duration
        by_controls[:, k] = arc.by_controls
        cut_offs.append(CutOff(arc.end, np.hstack([by_coasts, by_durations]), by_controls.copy()))
        ignitions[k] = state
        state, elapsed = arc.end, elapsed + float(transfer.durations[k])
    return Sensitivities(tuple(cut_offs), ignitions, turns)


@cache
def step_ends(nodes: int) -> tuple[Array, Array]:
    """Ends of the steps of a burn on [0, 1] and the weights of a quadrature there: 0, Legendre–Gauss points, 1."""
    grid = legendre_gauss(max(FEWEST_STEPS, nodes + SPARE))
    ends = np.concatenate([[0.0], 0.5 * (grid.nodes + 1.0), [1.0]])
    weights = np.concatenate([[0.0], 0.5 * grid.weights, [0.0]])
    ends.setflags(write=False)
    weights.setflags(write=False)
    return ends, weights


@cache
def _interpolation(nodes: int) -> tuple[Array, Array]:
    """From nodal values to the times at which a force is evaluated, and to the ends of steps."""
    grid, ends = legendre_gauss(nodes), step_ends(nodes)[0]
    at = (force_times(ends), ends)
    to_forces, to_ends = (interpolation_matrix(grid.nodes, 2.0 * each - 1.0) for each in at)
    return to_forces, to_ends


def _burnt(burn: Burn, starts: Array, elapsed: Array, durations: Array, controls: Array) -> RungeKuttaArc:
    """Burns from states (B, 6), after propellant of `elapsed` (B,) is gone, of controls (B, N, 3); velocities times durations."""
    nodes = controls.shape[1]
    ends = step_ends(nodes)[0]
    times = force_times(ends)
    raw = np.einsum("kn,bni->kib", _interpolation(nodes)[0], controls)
    size = np.linalg.norm(raw, axis=1, keepdims=True)
    left = np.maximum(1.0 - burn.flow * (elapsed + times[:, None, None] * durations), LIGHTEST)
    thrust = burn.acceleration / left * raw / np.maximum(size, 1e-12)
    square = durations**2

    def force(k: int, position: Array) -> Array:
        radius = np.sqrt(np.maximum(np.einsum("ib,ib->b", position, position), 0.01))
        return np.asarray(square * (thrust[k] - position / radius**3))

    return integrate_explicitly(ends, starts[:, :3].T, starts[:, 3:].T * durations, force)


@dataclass(frozen=True, slots=True, eq=False)
class _Arc:
    """One burn's end (6,) and its derivatives: (6, 6), by its duration (6,), by burning before it (6,), by thrust (6, N, 3)."""

    end: Array
    transition: Array
    by_duration: Array
    by_elapsed: Array
    by_controls: Array


def _burn_transition(burn: Burn, start: Array, elapsed: float, duration: float, controls: Array) -> _Arc:
    sides = DIFFERENCE * np.vstack([np.eye(8), -np.eye(8)])
    sides[:, 7] *= duration  # a share of the duration
    points = np.vstack([np.zeros(8), sides]) + np.concatenate([start, [elapsed, duration]])
    durations = points[:, 7]
    arc = _burnt(burn, points[:, :6], points[:, 6], durations, np.repeat(controls[None], len(points), axis=0))
    states = np.concatenate([arc.positions, arc.velocities / durations], axis=1)  # (E, 6, 17)
    slopes = (states[:, :, 1:9] - states[:, :, 9:]) / (2.0 * DIFFERENCE)
    ends, weights = step_ends(controls.shape[0])
    transitions = slopes[:, :, :6]
    try:
        onwards = np.linalg.solve(transitions.swapaxes(1, 2), transitions[-1].T).swapaxes(1, 2)  # Φ(1, σ)
    except (
        np.linalg.LinAlgError
    ):  # through the Earth's centre, say: no neighbour tells where such a burn leads
        onwards = np.full_like(transitions, np.nan)
    left = np.maximum(1.0 - burn.flow * (elapsed + ends * duration), LIGHTEST)
    push = weights * duration * burn.acceleration / left
    to_ends = _interpolation(controls.shape[0])[1]
    by_controls = np.einsum("e,eid,en->ind", push, onwards[:, :, 3:], to_ends)
    return _Arc(states[-1, :, 0], transitions[-1], slopes[-1, :, 7] / duration, slopes[-1, :, 6], by_controls)
