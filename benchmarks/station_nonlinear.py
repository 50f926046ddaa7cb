"""The part of random approaches before the gate beside a nonlinear solver, SLSQP, from ten starts.

`python -m benchmarks.station_nonlinear --count 20`: all impulses before the gate are its variables; points, holds, engine and the
state at the gate are those of the plan, holds and speeds are kept at nine instants of each arc, drifts stay out at 48 instants of an orbit after
burns cut at the fraction that is nearest then. That is less than the plan keeps. Starts are the plan's impulses with noise of 1 mm/s to 0.3 m/s.
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import minimize

from benchmarks.station_approaches import scenario
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions import approach
from orbsoc.orbit.array import Array

STARTS = 10
AN_ORBIT = 48
SMOOTH_M_S = 1e-4
NEAR = 2.0
"""Of the drifts at their instants, those nearer than this number of radii in the plan are kept; the audit judges all."""
OF_AN_ARC = 9
"""Instants at which holds and speeds are kept."""
KEPT = 1e-4
"""Relative, and in m or m/s: what a start must keep to be judged by the mission's audit."""


class Beside:
    """The nonlinear problem of a plan: x is every impulse before the gate, (3 G,)."""

    def __init__(self, plan: approach.Plan) -> None:
        assert plan.programme is not None
        assert plan.verification is not None
        at, self.plan = plan.approach, plan
        count = at.guarded
        times, motion = at.times_s[:count].tolist(), at.motion
        self.planned = plan.programme.dv_m_s[:count].ravel()
        kick = np.vstack([np.zeros((3, 3)), np.eye(3)])

        def state(t: float, number: int, fraction: float = 1.0) -> tuple[Array, Array]:
            """Of the first `number` impulses, the last flown by a fraction: (6, 3 G) and what is known, (6,)."""
            rows = np.zeros((6, 3 * count))
            for j in range(number):
                part = fraction if j == number - 1 else 1.0
                rows[:, 3 * j : 3 * j + 3] = part * motion.transition(t, times[j]) @ kick
            return rows, motion.transition(t, 0.0) @ at.start

        points = plan.scenario.points
        equal = [state(at.gate_s, count)]
        wanted = [plan.verification.arcs[count - 1].states[-1]]
        for point in list(points.values())[: list(points).index(plan.scenario.keep_out.until) + 1]:
            number = int(np.searchsorted(times, point.arrive_s - 1e-6))
            rows, known = state(point.arrive_s, number)
            equal.append((rows[:3], known[:3]))
            wanted.append(point.position())
            velocity = point.velocity()
            if velocity is not None:
                rows, known = state(point.arrive_s, number + bool(point.hold_s))
                equal.append((rows[3:], known[3:]))
                wanted.append(velocity)
        self.equal = np.vstack([rows for rows, _ in equal])
        self.side = np.concatenate(wanted) - np.concatenate([known for _, known in equal])
        drifts, lapse = [], np.linspace(0.0, at.horizon_s, int(AN_ORBIT * at.horizon_s / at.period_s))
        for k, t in enumerate(times):
            ends_of_burn = [state(t, k + 1, fraction) for fraction in (0.0, 1.0)]
            for later in lapse:
                to = motion.transition(t + later, t)[:3]
                drifts.append(
                    (
                        np.array([to @ rows for rows, _ in ends_of_burn]),
                        np.array([to @ known for _, known in ends_of_burn]),
                    )
                )
        self.rows = np.array([rows for rows, _ in drifts])
        self.known = np.array([known for _, known in drifts])
        at_instants = [
            (k, float(t)) for k in range(count) for t in np.linspace(times[k], at.ends_s[k], OF_AN_ARC)
        ]
        arcs = [state(t, k + 1) for k, t in at_instants]
        self.arcs, self.arcs_known = (
            np.array([rows for rows, _ in arcs]),
            np.array([known for _, known in arcs]),
        )
        gate = plan.scenario.gate
        self.held = np.array([gate.arrive_s <= times[k] for k, _ in at_instants])
        self.gate, self.within = gate.position(), gate.hold_within_m
        self.least = float(at.axes_m[0]) + plan.scenario.keep_out.margin_m
        near = np.linalg.norm(self._nearest(self.planned)[0], axis=1) < NEAR * self.least
        self.rows, self.known = self.rows[near], self.known[near]

    def cost(self, x: Array) -> tuple[float, Array]:
        """Sum of the sizes, smoothed, and its gradient."""
        sizes = np.sqrt((x.reshape(-1, 3) ** 2).sum(axis=1) + SMOOTH_M_S**2)
        return float(sizes.sum()), (x.reshape(-1, 3) / sizes[:, None]).ravel()

    def _nearest(self, x: Array) -> tuple[Array, Array]:
        """Of each drift at its instants the nearest place of all fractions, (M, 3), and the fraction, (M, 1)."""
        places = self.rows @ x + self.known
        first, along = places[:, 0], places[:, 1] - places[:, 0]
        squares = np.maximum((along**2).sum(axis=1), 1e-30)
        fractions = np.clip(-(first * along).sum(axis=1) / squares, 0.0, 1.0)[:, None]
        return first + fractions * along, fractions

    def outside(self, x: Array) -> Array:
        """(‖p‖² − r²)/(2 r) of it, about metres."""
        places, _ = self._nearest(x)
        return np.asarray(((places**2).sum(axis=1) - self.least**2) / (2.0 * self.least))

    def outside_by(self, x: Array) -> Array:
        """Its derivatives; that of the fraction adds nothing."""
        places, fractions = self._nearest(x)
        rows = self.rows[:, 0] + fractions[:, :, None] * (self.rows[:, 1] - self.rows[:, 0])
        return np.asarray(np.einsum("mi,mij->mj", places, rows) / self.least)

    def inside(self, x: Array) -> Array:
        """Room of holds, m, and of speeds, m/s, at every instant of every arc."""
        states = self.arcs @ x + self.arcs_known
        away = states[self.held, :3] - self.gate
        speed = self.plan.scenario.speed
        assert speed is not None
        squares = speed.limit(np.linalg.norm(states[:, :3], axis=1)) ** 2 - (states[:, 3:] ** 2).sum(axis=1)
        return np.concatenate([(self.within**2 - (away**2).sum(axis=1)) / (2.0 * self.within), squares])

    def inside_by(self, x: Array) -> Array:
        """Its derivatives."""
        states = self.arcs @ x + self.arcs_known
        away, speed = states[self.held, :3] - self.gate, self.plan.scenario.speed
        assert speed is not None
        holds = -np.einsum("mi,mij->mj", away, self.arcs[self.held, :3]) / self.within
        ranges = np.linalg.norm(states[:, :3], axis=1)
        grows = 2.0 * speed.by_range_per_s * speed.limit(ranges) / ranges
        speeds = grows[:, None] * np.einsum("mi,mij->mj", states[:, :3], self.arcs[:, :3])
        speeds -= 2.0 * np.einsum("mi,mij->mj", states[:, 3:], self.arcs[:, 3:])
        return np.vstack([holds, speeds])

    def keeps(self, x: Array) -> bool:
        """Whether the equations and the drifts of this problem hold."""
        off = float(np.abs(self.equal @ x - self.side).max())
        return off <= KEPT and bool(self.outside(x).min() >= -KEPT * self.least)

    def verified(self, x: Array) -> bool:
        """Whether the mission's own audit of these impulses, with the plan's after the gate, verifies them."""
        assert self.plan.programme is not None
        dv = self.plan.programme.dv_m_s.copy()
        dv[: x.size // 3] = x.reshape(-1, 3)
        found = approach.audit(self.plan.scenario, ImpulseProgramme(self.plan.programme.times_s, dv))
        return (
            found.verification is not None
            and found.verification.safe
            and all(check.kept for check in found.verification.checks)
        )

    def best(self, seed: int) -> tuple[float, int]:
        """The least cost of the ends that the mission verifies, infinite for none, and how many ends keep all of this problem."""
        random, ends = np.random.default_rng([seed, 50]), []
        free = null_space(self.equal)  # what x may change by, as the equations say
        # The plan keeps its points to a millimetre, not to rounding.
        off = self.equal @ self.planned - self.side
        onto = self.planned - np.linalg.lstsq(self.equal, off, rcond=None)[0]

        def flown(z: Array) -> Array:
            return np.asarray(onto + free @ z)

        conditions: list[dict[str, Any]] = [
            {"type": "ineq", "fun": lambda z, f=f: f(flown(z)), "jac": lambda z, by=by: by(flown(z)) @ free}
            for f, by in ((self.outside, self.outside_by), (self.inside, self.inside_by))
        ]

        def cost(z: Array) -> tuple[float, Array]:
            value, slope = self.cost(flown(z))
            return value, slope @ free

        for start in range(STARTS):
            noise = np.geomspace(1e-3, 0.3, STARTS)[start] * random.standard_normal(self.planned.size)
            ended = minimize(
                cost, free.T @ noise, jac=True, method="SLSQP", constraints=conditions,
                options={"maxiter": 300, "ftol": 1e-6},
            )  # fmt: skip
            if self.keeps(flown(ended.x)):
                ends.append((float(ended.fun), flown(ended.x)))
        cheapest = sorted(ends, key=lambda end: end[0])
        return next((cost for cost, x in cheapest if self.verified(x)), np.inf), len(ends)


def main() -> None:
    """Print a line an approach: docs/measurements/approach-nonlinear.csv is of the first 200."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    chosen = parser.parse_args()
    sys.stdout.write("approach,plan_m_s,ends,best_m_s\n")
    for seed in range(chosen.first, chosen.first + chosen.count):
        try:
            plan = approach.plan(checked(approach.Scenario, scenario(seed), source=f"random {seed}"))
        except ScenarioError:
            continue
        if plan.status is not PlanStatus.VERIFIED:
            continue
        beside = Beside(plan)
        ours = beside.cost(beside.planned)[0]
        theirs, ends = beside.best(seed)
        sys.stdout.write(f"{seed},{ours:.5f},{ends},{theirs:.5f}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
