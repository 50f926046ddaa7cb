"""What happens when the engine fails, a hold point that avoids the worst of it, and what other launches would cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety import CutBurn, audit_cut_burns, drift_clearance
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire

from ..model.launch import LaunchError
from ..model.transfer import Cost, Transfers, in_plane, programme
from ..scenario import Scenario

ORBITS = 3.0
"""After an engine failure, in which the least distance is sought."""
BIAS_DEG = np.arange(-90.0, 91.0, 5.0)
PHASE_DEG = np.arange(0.0, 360.0, 10.0)


def cut_burns(scenario: Scenario, state: Array, flown: ImpulseProgramme) -> tuple[CutBurn, ...]:
    """Each impulse cut at every fraction, and none after it."""
    n = scenario.motion.mean_motion_rad_s
    return audit_cut_burns(flown, state, scenario.motion, 0.0, mean_motion_rad_s=n, orbits=ORBITS)


@dataclass(frozen=True, slots=True)
class HoldPoint:
    """Two impulses to rest at a point of the V-bar instead of the target: their cost, what it adds, and how near to the
    target the server comes in `ORBITS` where the last impulse is not fired; then the cost of two impulses to the target."""

    ahead_m: float
    time_s: float
    cost: float
    price: float
    nearest_m: float
    from_there: float


def hold_points(
    motion: ClohessyWiltshire, state: Array, cost: Cost, ahead_m: float, longest_s: float
) -> tuple[HoldPoint, ...]:
    """Behind the target and ahead of it, by a distance on the V-bar. The motion is the same about every point of it."""
    transfers = Transfers.of(motion, longest_s)
    least = transfers.best(in_plane(state), cost).cost
    found = []
    for place in (-ahead_m, ahead_m):
        shifted = state - place * np.eye(6)[1]
        best = transfers.best(in_plane(shifted), cost)
        last = programme(motion, in_plane(shifted), best.time_s).dv_m_s[1]
        arrival = np.concatenate([[0.0, place, 0.0], -last])
        drift = drift_clearance(arrival, motion.mean_motion_rad_s, ORBITS * motion.period_s)
        near = float(drift.distance_m[0])
        there = transfers.best(np.array([0.0, place, 0.0, 0.0]), cost).cost
        found.append(HoldPoint(place, best.time_s, best.cost, best.cost - least, near, there))
    return tuple(found)


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """Least costs of two impulses over a number of the launch: at the samples, and the best, refined."""

    samples_deg: Array
    costs: Array
    best_deg: float
    best_cost: float
    best_time_s: float

    def to_dict(self) -> dict[str, Any]:
        """A scan of plan.json; costs of launches that cannot be are null."""
        costs = [each if np.isfinite(each) else None for each in self.costs.tolist()]
        best = {name: getattr(self, name) for name in ("best_deg", "best_cost", "best_time_s")}
        return {"degrees": self.samples_deg.tolist(), "costs": costs, **best}


def scan(scenario: Scenario, key: str, samples_deg: Array) -> Scan:
    """Over `yaw_bias_deg` or `phase_deg`, of launches that end with the stroke."""
    cost = scenario.rendezvous.cost
    transfers = Transfers.of(scenario.motion, scenario.longest_s)

    def best(degrees: float) -> tuple[float, float]:
        changed = scenario.model_copy(update={key: degrees, "stop": "stroke", "stop_s": None})
        try:
            found = transfers.best(in_plane(changed.separation().state), cost)
        except LaunchError:
            return np.inf, np.nan
        return found.cost, found.time_s

    costs = np.array([best(float(each))[0] for each in samples_deg])
    k = int(costs.argmin())
    step = float(samples_deg[1] - samples_deg[0])
    ends = float(samples_deg[k]) - step, float(samples_deg[k]) + step
    refined = minimize_scalar(
        lambda each: best(float(each))[0], bounds=ends, method="bounded", options={"xatol": 1e-4}
    )
    at = float(refined.x) if refined.fun < costs[k] else float(samples_deg[k])
    return Scan(samples_deg, costs, at, *best(at))


@dataclass(frozen=True, slots=True, eq=False)
class Dispersed:
    """Flights with a dispersed push, pointing and first impulse: how far each ends from the target with the plan's
    impulses and time (runs,), m; and of two impulses planned again at the separation, their cost and time."""

    miss_m: Array
    costs: Array
    times_s: Array

    def to_dict(self) -> dict[str, Any]:
        def told(values: Array) -> dict[str, float]:
            numbers = values.mean(), np.quantile(values, 0.95), values.min(), values.max()
            return dict(zip(("mean", "p95", "least", "largest"), map(float, numbers), strict=True))

        names = {"miss_m": self.miss_m, "replanned_cost": self.costs, "replanned_time_s": self.times_s}
        return {"runs": self.miss_m.size, **{name: told(values) for name, values in names.items()}}


def dispersed(scenario: Scenario, flown: ImpulseProgramme, end_s: float) -> Dispersed:
    """Draws by (seed, number); the server leaves at the end of the stroke, whatever the plan's own stop is."""
    errors = scenario.uncertainty
    assert errors is not None
    motion, cost = scenario.motion, scenario.rendezvous.cost
    transfers = Transfers.of(motion, scenario.longest_s)
    actual = scenario.model_copy(update={"stop": "stroke", "stop_s": None})
    rows = np.empty((errors.runs, 3))
    for number in range(errors.runs):
        random = np.random.default_rng([errors.seed, number])
        push, yaw = random.standard_normal(2)
        force = scenario.force_n * max(1.0 + errors.force_share * push, 0.1)
        found = actual.model_copy(
            update={"force_n": force, "yaw_bias_deg": scenario.yaw_bias_deg + errors.yaw_deg * yaw}
        ).separation()
        state, at = found.state, 0.0
        for t, dv in zip(flown.times_s.tolist(), flown.dv_m_s, strict=True):
            state = motion.transition(t, at) @ state
            state[3:] += dv * (1.0 + errors.execution_share * random.standard_normal())
            at = t
        miss = float(np.linalg.norm((motion.transition(end_s, at) @ state)[:3]))
        best = transfers.best(in_plane(found.state), cost)
        rows[number] = miss, best.cost, best.time_s
    return Dispersed(*rows.T)


def pointing(scenario: Scenario) -> tuple[Scan, Scan]:
    """What the yaw bias and the phase of the fly-around would change."""
    about = scenario.yaw_bias_deg + BIAS_DEG
    return scan(scenario, "yaw_bias_deg", about), scan(scenario, "phase_deg", PHASE_DEG)
