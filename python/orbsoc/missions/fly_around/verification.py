"""The plan flown again by an integrator that planning does not use: two bodies, J2 and drag, many chasers at once; and what
happens without the pulses to come, where the engine stops after a pulse or within it.

Each pulse aims: it takes the state at its time, as navigation has it, to the next node of the plan by the linear model.
That is how the paper flies, and what keeps small accelerations from adding up over a revolution.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from orbsoc.guidance.chaser_messages import chaser_messages
from orbsoc.guidance.impulses import KICK, ImpulseProgramme
from orbsoc.guidance.relative_flight import fly
from orbsoc.guidance.safety import CutBurn, audit_cut_burns, drift_least, states_after
from orbsoc.guidance.uncertainty import Uncertainty
from orbsoc.orbit.array import Array, Flags, Index
from orbsoc.orbit.constants import EARTH
from orbsoc.orbit.perturbations import J2, Drag, Force, PointMass, coast
from orbsoc.orbit.relative import absolute_state, local_frame, relative_state

from .model.flight import Flight, Flown
from .scenario import Scenario

ROUNDED_M = 1e-3
"""By which the flight of the linear model may exceed the tolerance."""
SAMPLES = 48
"""Intervals of an arc at which the distance from the path is taken."""
EPHEMERIS_STEPS = 180
ORBITS = 2.0
"""For so long after the last pulse, the time in which an engine is repaired or the operator acts."""
LONGEST_AIM = 0.9
"""Of π/ω: a pulse before a longer arc gives the planned velocity change, for aiming would blow errors up."""


@dataclass(frozen=True, slots=True, eq=False)
class TrueFlight:
    """B flights: times (K,), relative positions (K, B, 3), distances from the path (K, B), pulses (N, B, 3)."""

    times_s: Array
    positions_m: Array
    errors_m: Array
    dv_m_s: Array
    end_states: Array
    """Relative states at the end (B, 6)."""
    arcs: Index
    """Of each time, its arc (K,)."""

    @property
    def largest_errors_m(self) -> Array:
        """Of each flight, (B,)."""
        return np.asarray(self.errors_m.max(axis=0))

    @property
    def totals_m_s(self) -> Array:
        """Σ‖Δv‖ of each flight, (B,)."""
        return np.asarray(np.linalg.norm(self.dv_m_s, axis=2).sum(axis=0))


@dataclass(frozen=True, slots=True, eq=False)
class Push:
    """A constant acceleration (3,) in each body's own R, T, N axes, on all but the first body, the target."""

    acceleration_m_s2: Array

    def acceleration(self, states: Array) -> Array:
        """m/s², (B, 3), of states (B, 6)."""
        found = np.zeros((len(states), 3))
        for k, state in enumerate(states[1:], 1):
            found[k] = local_frame(state)[0].T @ self.acceleration_m_s2
        return found

    def jacobian(self, states: Array) -> Array:
        """Zeros (B, 3, 6): that the axes turn with the state is left out, 1e-13 of the Earth's own."""
        return np.zeros((len(states), 3, 6))


def forces_of(scenario: Scenario) -> Callable[[int], list[Force]]:
    """Point mass, J2, drag and the scenario's own force on a target and a number of chasers, in this order."""
    table, own = scenario.truth, scenario.disturbance

    def acting(chasers: int) -> list[Force]:
        ballistic = np.append(table.ballistic_target_m2_kg, np.full(chasers, table.ballistic_chaser_m2_kg))
        forces: list[Force] = [PointMass(), J2(), Drag(ballistic)]
        if own is not None and not own.stands_for_j2_and_drag:
            forces.append(Push(scenario.flight.disturbance_m_s2))
        return forces

    return acting


def target_state(scenario: Scenario) -> Array:
    """The target at time 0: on its circular orbit, inertial state (6,)."""
    table = scenario.target
    radius = EARTH.earth_radius_m + 1e3 * scenario.target.altitude_km
    speed = np.sqrt(EARTH.mu_m3_s2 / radius)
    inc, raan, place = np.deg2rad([table.inc_deg, table.raan_deg, table.latitude_argument_deg])
    node = np.array([np.cos(raan), np.sin(raan), 0.0])
    north = np.array([-np.sin(raan) * np.cos(inc), np.cos(raan) * np.cos(inc), np.sin(inc)])
    position = np.cos(place) * node + np.sin(place) * north
    velocity = np.cos(place) * north - np.sin(place) * node
    return np.concatenate([radius * position, speed * velocity])


def fly_truth(
    scenario: Scenario,
    plan: Flown,
    *,
    aiming: bool = True,
    uncertainty: Uncertainty | None = None,
    runs: int = 1,
    samples: int = SAMPLES,
) -> TrueFlight:
    """Fly a plan `runs` times, with draws of navigation and execution errors by the uncertainty's seed."""
    flight = scenario.flight
    random = np.random.default_rng(0 if uncertainty is None else uncertainty.seed)
    ends = np.append(plan.programme.times_s, plan.end_s)
    forces = forces_of(scenario)(runs)
    target = target_state(scenario)
    relative = np.tile(plan.before[0], (runs, 1))
    pulses = np.empty((len(plan.programme), runs, 3))
    times, positions, arcs = [], [], []
    for k in range(len(plan.programme)):
        known = relative if uncertainty is None else _drawn_states(relative, uncertainty, random)
        dt = ends[k + 1] - ends[k]
        asked = np.tile(plan.programme.dv_m_s[k], (runs, 1))
        if aiming and dt <= LONGEST_AIM * flight.longest_transfer_s:
            asked = _aimed(flight, known, plan.before[k + 1, :3], dt) - known[:, 3:]
        given = asked if uncertainty is None else _drawn_pulses(asked, uncertainty, random)
        pulses[k] = given
        relative = relative + np.hstack([np.zeros((runs, 3)), given])
        spin = _acceleration(target, forces)
        at = ends[k] + np.linspace(0.0, dt, samples + 1)
        states = coast(np.vstack([target, absolute_state(target, relative, spin)]), at, forces)
        found = np.array(
            [relative_state(each[0], each[1:], _acceleration(each[0], forces)) for each in states]
        )
        target, relative = states[-1, 0], found[-1]
        times.append(at)
        positions.append(found[:, :, :3])
        arcs.append(np.full(at.size, k))
    at, place = np.concatenate(times), np.concatenate(positions)
    errors = np.linalg.norm(place - flight.ellipse.position(at)[:, None], axis=2)
    return TrueFlight(at, place, errors, pulses, relative, np.concatenate(arcs))


@dataclass(frozen=True, slots=True)
class EngineOut:
    """Pulses stop after pulse `number`, counted from 1: how near the target the drift comes, m, and how long after, s."""

    number: int
    time_s: float
    distance_m: float
    after_s: float
    at_least_m: float | None
    """What no distance is below, by the linear model."""
    all_time_m: float
    """For all time, by the linear model."""
    all_time_at_least_m: float | None

    def to_dict(self) -> dict[str, Any]:
        """A row of `audits` in plan.json."""
        return asdict(self)


def inner_radius_m(scenario: Scenario) -> float:
    """The least distance from the target that the tube allows."""
    return min(scenario.ellipse.semi_axes_m) - scenario.tolerance_m


def engine_out(scenario: Scenario, flown: Flown) -> tuple[EngineOut, ...]:
    """Each pulse as the last, by the linear model without the disturbance; zero pulses are none."""
    motion, programme = scenario.motion, flown.programme
    states = states_after(programme, flown.before[0], motion, float(programme.times_s[0]))
    n = motion.mean_motion_rad_s
    rows: list[EngineOut] = []
    for at, state, worth in zip(programme.times_s.tolist(), states, _counted(programme), strict=True):
        if worth:
            soon, ever = drift_least(state, n, ORBITS * motion.period_s), drift_least(state, n)
            found = soon.distance_m, soon.after_s, soon.at_least_m, ever.distance_m, ever.at_least_m
            rows.append(EngineOut(len(rows) + 1, at, *found))
    return tuple(rows)


def cut_burns(scenario: Scenario, flown: Flown) -> tuple[CutBurn, ...]:
    """Each pulse cut at every fraction of itself, and none after it."""
    motion, programme = scenario.motion, flown.programme
    cuts = audit_cut_burns(
        programme,
        np.asarray(flown.before[0]),
        motion,
        inner_radius_m(scenario),
        mean_motion_rad_s=motion.mean_motion_rad_s,
        orbits=ORBITS,
        start_s=float(programme.times_s[0]),
    )
    fired = [cut for cut, worth in zip(cuts, _counted(programme), strict=True) if worth]
    return tuple(replace(cut, number=k) for k, cut in enumerate(fired, 1))


def _counted(programme: ImpulseProgramme) -> Flags:
    """Which pulses count, (N,): those that are fired; all where none is."""
    worth = programme.worth_firing
    return worth if worth.any() else np.ones_like(worth)


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A programme and its flights: by the model, by the truth once, by the truth in the open loop, and dispersed."""

    flown: Flown
    truth: TrueFlight
    open_loop: TrueFlight
    dispersed: TrueFlight | None
    engine_out: tuple[EngineOut, ...]
    cut_burns: tuple[CutBurn, ...]
    failures: tuple[str, ...]
    at_most_m: float
    """Above the distance from the path all along, by the linear model."""

    @property
    def largest_error_m(self) -> float:
        """With J2 and drag."""
        return float(self.truth.largest_errors_m[0])

    @property
    def nearest_out(self) -> EngineOut:
        """The pulse after which an engine failure leads nearest to the target."""
        return min(self.engine_out, key=lambda each: each.distance_m)

    @property
    def nearest_cut(self) -> CutBurn:
        """The pulse within which it does."""
        return min(self.cut_burns, key=lambda each: each.distance_m)

    @property
    def programme(self) -> ImpulseProgramme:
        return self.flown.programme


def check(scenario: Scenario, flown: Flown, truth: TrueFlight | None = None) -> Checked:
    """Judge a programme by its flight with J2 and drag, `truth` where it is flown already, and look at what may go wrong."""
    truth = truth or fly_truth(scenario, flown)
    failures = []
    ends = np.append(flown.programme.times_s, flown.end_s)
    arcs = zip(flown.before, flown.programme.dv_m_s, ends, np.diff(ends), strict=False)
    at_most = max(scenario.flight.error_at_most(each + KICK @ dv, *at) for each, dv, *at in arcs)
    for error, allowed, by in (
        (at_most, scenario.tolerance_m + ROUNDED_M, "by the linear model"),
        (float(truth.largest_errors_m[0]), scenario.allowed_m, "with J2 and drag"),
    ):
        if not error <= allowed:
            failures.append(f"{len(flown.programme)} pulses stray {error:.4f} m {by}")
    errors = scenario.uncertainty
    drawn = None
    if errors is not None and errors.runs:
        drawn = fly_truth(scenario, flown, uncertainty=errors, runs=errors.runs, samples=16)
    return Checked(
        flown,
        truth,
        fly_truth(scenario, flown, aiming=False),
        drawn,
        engine_out(scenario, flown),
        cut_burns(scenario, flown),
        tuple(failures),
        at_most,
    )


def messages(scenario: Scenario, plan: Flown, flown: TrueFlight) -> dict[str, str]:
    """`chaser.oem` and `chaser.opm` of the first of some flights, with the pulses as it gave them."""
    programme = ImpulseProgramme(plan.programme.times_s, flown.dv_m_s[:, 0])
    times = np.unique(np.append(np.linspace(0.0, plan.end_s, EPHEMERIS_STEPS + 1), programme.times_s))
    flight = fly(programme, plan.before[0], target_state(scenario), times, forces_of(scenario))
    return chaser_messages(
        scenario.name,
        programme,
        flight,
        comment="point mass, J2 and drag",
        epoch_utc=scenario.target.epoch_utc,
        assumptions=scenario.assumptions,
    )


def _acceleration(target: Array, forces: list[Force]) -> Array:
    """Of the target, (3,); a Drag of many bodies is asked for all and gives the first's."""
    bodies = next((np.size(force.ballistic_m2_kg) for force in forces if isinstance(force, Drag)), 1)
    states = np.tile(target, (bodies, 1))
    return np.asarray(sum(force.acceleration(states)[0] for force in forces))


def _aimed(flight: Flight, states: Array, to_m: Array, dt_s: float) -> Array:
    """Velocities (B, 3) that fly from the positions of states to a point in a time."""
    matrix = flight.motion.transition(dt_s, 0.0)
    left = to_m - flight.forced(dt_s)[:3] - states[:, :3] @ matrix[:3, :3].T
    return np.asarray(np.linalg.solve(matrix[:3, 3:], left.T).T)


def _drawn_states(states: Array, uncertainty: Uncertainty, random: np.random.Generator) -> Array:
    sigma = np.repeat([uncertainty.position_m, uncertainty.velocity_m_s], 3)
    return np.asarray(states + sigma * random.standard_normal(states.shape))


def _drawn_pulses(asked: Array, uncertainty: Uncertainty, random: np.random.Generator) -> Array:
    shares, fixed = random.standard_normal((2, *asked.shape))
    size = np.linalg.norm(asked, axis=1, keepdims=True)
    return np.asarray(
        asked + uncertainty.execution_share * size * shares + uncertainty.execution_fixed_m_s * fixed
    )
