"""A scenario made ready to be planned: its burn and its target in canonical units, its subproblem, and flights of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import Burn, Trajectory, commanded
from orbsoc.guidance.scp import Subproblem
from orbsoc.orbit import CanonicalUnits, elements_from_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.propagate import Steering
from orbsoc.orbit.vectors import specific_energy

from .. import tuning
from ..model.attitude_rate import RateBound
from ..model.coast import at_ignition, coasted
from ..model.problems import Iterate, MaxEnergyFixedPerigee, MaxEnergyFreePerigee, MinTime
from ..scenario import Scenario
from ..starts.directions import along_velocity, propagated, towards_plane
from ..starts.steering_law import Law, grid_resolves
from ..targets.free_target import FreeTarget
from ..targets.target import Target
from ..targets.target_orbit import LargestOrbit, TargetOrbit
from ..verification import Verification, verify

Linearise = Callable[[Iterate], Subproblem[Iterate]]


@dataclass(frozen=True, slots=True)
class InsertionSetup:
    """The burn from where the coast of `ignition_s` ends, the target orbit, and the units that both are in."""

    scenario: Scenario
    target: Target
    burn: Burn
    units: CanonicalUnits
    start_si: Array
    ignition_s: float = 0.0
    turn: RateBound | None = None
    """Of the subproblems that are to hold one."""
    is_unbounded: bool = False
    """Whether a bound on the attitude rate was taken away."""

    @classmethod
    def of(cls, scenario: Scenario, ignition_s: float = 0.0) -> InsertionSetup:
        units = CanonicalUnits.of(scenario.constants)
        vehicle = scenario.vehicle
        start_si = at_ignition(scenario, ignition_s)
        target = target_of(scenario, units)
        burn = Burn.of(start_si, vehicle.thruster(), vehicle.longest_burn_s, units)
        return cls(scenario, target, burn, units, start_si, ignition_s)

    @property
    def rate_bound(self) -> float | None:
        """The fastest turn allowed, rad per canonical time."""
        bound = self.scenario.limits.attitude_rate_deg_s
        return None if bound is None else float(np.deg2rad(bound)) * self.units.time_s

    @property
    def unbounded(self) -> InsertionSetup:
        """The same without a bound on the attitude rate."""
        if self.rate_bound is None:
            return self
        free = self.scenario.with_changes(limits={"attitude_rate_deg_s": None})
        return replace(self, scenario=free, turn=None, is_unbounded=True)

    def at(self, ignition_s: float) -> InsertionSetup:
        """The same after a coast of another length."""
        if ignition_s == self.ignition_s:
            return self
        return replace(InsertionSetup.of(self.scenario, ignition_s), is_unbounded=self.is_unbounded)

    @property
    def latest_ignition_s(self) -> float:
        """The scenario's, or one revolution of the first orbit; no later than the coast gets too low."""
        scenario, start = self.scenario, self.scenario.launch_inertial(self.scenario.initial)
        first = elements_from_state(start[:3], start[3:], scenario.constants)
        energy = specific_energy(self.burn.start[:3], self.burn.start[3:], 1.0)
        period = (-0.5 / energy) ** 1.5 if energy < -1e-6 else None
        turn_s = (
            tuning.WITHOUT_PERIOD_S if period is None else float(2.0 * np.pi * period * self.units.time_s)
        )
        latest = scenario.burn.latest_ignition_s or turn_s
        lowest_m = scenario.constants.earth_radius_m + 1e3 * scenario.limits.lowest_altitude_km
        if first.perigee_radius_m > lowest_m + tuning.OBLATE_M * scenario.burn.coast_j2:
            return latest
        times = np.linspace(0.0, latest, tuning.LOOKS)
        low = np.linalg.norm(coasted(scenario, times)[:, :3], axis=1) < lowest_m
        return float(times[max(int(low.argmax()) - 1, 0)]) if low.any() else latest

    @property
    def free_perigee(self) -> bool:
        return isinstance(self.target, LargestOrbit) and self.target.is_direction_free

    def subproblem(self, *, soft: bool, firm: bool = False) -> Linearise:
        """The problem that fits the scenario; `soft`: slack where the problem has none by itself; `firm`: a start on the
        target orbit may not leave it."""
        weight = self.scenario.method.slack_weight * (tuning.FIRM if firm else 1.0)
        if self.scenario.problem == "min_time":
            return MinTime(self.burn, self.target, weight, self.figures, self.turn)
        target = self._largest
        if target.is_direction_free:
            return MaxEnergyFreePerigee(self.burn, target, weight if soft else None, self.figures, self.turn)
        return MaxEnergyFixedPerigee(self.burn, target, weight, self.figures, self.turn)

    def flown(self, steering: Steering, duration_s: float, nodes: int) -> Trajectory:
        """What a steering flies, at the nodes of a grid."""
        thruster = self.scenario.vehicle.thruster()
        return propagated(
            self.start_si, thruster, steering, duration_s, legendre_gauss(nodes), self.scenario.constants
        )

    def cold_start(self) -> Iterate:
        guess_s, nodes = self.scenario.burn.guess_s, self.scenario.method.nodes
        if self.free_perigee:
            return Iterate(self.flown(towards_plane(self._largest.normal, self.units), guess_s, nodes))
        return Iterate(along_velocity(self.burn, legendre_gauss(nodes), guess_s / self.units.time_s))

    def along(self, direction: Array) -> Iterate:
        """Thrust along one inertial direction for the scenario's burn time."""
        law = Law(direction[None], self.scenario.burn.guess_s / self.units.time_s)
        return self.by_law(law, self.scenario.method.nodes)

    def resampled(self, iterate: Iterate, nodes: int) -> Iterate:
        """What the commanded attitude of a plan really flies, on another grid."""
        old = iterate.trajectory
        duration_s = old.duration * self.units.time_s
        steering = commanded(old.grid, old.controls, duration_s)
        trajectory = self.flown(steering, duration_s, nodes)
        return Iterate(trajectory, iterate.momentum_scale, iterate.laplace_scale)

    def by_law(self, law: Law, nodes: int) -> Iterate:
        """A law as flown, with what it misses of the terminal rows as their slack."""
        duration_s = law.duration * self.units.time_s

        def steering(t_s: float, _state: Array) -> Array:
            return np.asarray(law.directions(np.array([2.0 * t_s / duration_s - 1.0]))[0])

        return self._missing(self.flown(steering, duration_s, nodes))

    def by_interpolant(self, law: Law, nodes: int) -> Iterate:
        """The same, where the law is the interpolant of the nodal thrusts; their length stays what it is."""
        trajectory = self.by_law(law, nodes).trajectory
        raw = law.vectors(trajectory.grid.nodes)
        return Iterate(Trajectory(trajectory.grid, trajectory.states, raw, trajectory.end, law.duration))

    def nodes_that_follow(self, law: Law) -> int:
        """Of the coarsest grid that follows a law, at most the finest allowed."""
        method = self.scenario.method
        nodes = method.nodes
        while nodes < method.max_nodes and not grid_resolves(law, nodes, 0.1 * tuning.TOO_LONG):
            nodes = min(method.max_nodes, int(np.ceil(tuning.GROWTH * nodes)))
        return nodes

    def _missing(self, trajectory: Trajectory) -> Iterate:
        return Iterate(trajectory, slack=self.target.misses(trajectory.end))

    @property
    def _largest(self) -> LargestOrbit:
        assert isinstance(self.target, LargestOrbit)
        return self.target

    def verified(self, iterate: Iterate) -> Verification:
        """The flight of an iterate, judged."""
        return verify(self.scenario, self.target, iterate, ignition_s=self.ignition_s)

    def figures(self, trajectory: Trajectory) -> Mapping[str, float]:
        """The columns of the iteration table that are this mission's own."""
        end = self.units.state_to_si(trajectory.end)
        orbit = elements_from_state(end[:3], end[3:], self.scenario.constants)
        return {
            "nodes": trajectory.grid.size,
            "time_of_flight_s": trajectory.duration * self.units.time_s,
            "perigee_height_km": orbit.perigee_height_m() / 1e3,
            "apogee_height_km": orbit.apogee_height_m() / 1e3,
        }


def target_of(scenario: Scenario, units: CanonicalUnits) -> Target:
    """The scenario's target, canonical, in the axes of plans."""
    table = scenario.target
    if table.free:
        return FreeTarget.of(table, scenario.eci_rotation, scenario.constants)
    state = units.state_from_si(scenario.launch_inertial(table))
    if scenario.problem == "min_time":
        return TargetOrbit.through(state, scenario.constants)
    assert table.perigee_height_km is not None  # the scenario checks it
    is_free = table.perigee_direction == "free"
    return LargestOrbit.about(
        state, 1e3 * table.perigee_height_km, is_direction_free=is_free, constants=scenario.constants
    )
