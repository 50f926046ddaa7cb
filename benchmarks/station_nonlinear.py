"""The part of random approaches before the gate beside a nonlinear solver, SLSQP, from ten starts.

`python -m benchmarks.station_nonlinear --count 20`: all impulses before the gate are its variables; points, holds, engine and the
state at the gate are those of the plan, drifts stay out at 80 instants of an orbit after burns flown to 0, 1/2 and 1. That is less than
the plan keeps. Starts are the plan's impulses with noise of 0.02 to 0.5 m/s.
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np
from scipy.optimize import minimize

from benchmarks.station_approaches import scenario
from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions import approach
from orbsoc.orbit.array import Array

STARTS = 10
AN_ORBIT = 80
SMOOTH_M_S = 1e-4
KEPT = 1e-4
"""Relative, and in m or m/s: what a start must keep to count."""


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
            for fraction in (0.0, 0.5, 1.0):
                rows, known = state(t, k + 1, fraction)
                drifts += [
                    (motion.transition(t + s, t)[:3] @ rows, motion.transition(t + s, t)[:3] @ known)
                    for s in lapse
                ]
        self.rows = np.array([rows for rows, _ in drifts])
        self.known = np.array([known for _, known in drifts])
        self.least = float(at.axes_m[0]) + plan.scenario.keep_out.margin_m

    def cost(self, x: Array) -> tuple[float, Array]:
        """Sum of the sizes, smoothed, and its gradient."""
        sizes = np.sqrt((x.reshape(-1, 3) ** 2).sum(axis=1) + SMOOTH_M_S**2)
        return float(sizes.sum()), (x.reshape(-1, 3) / sizes[:, None]).ravel()

    def outside(self, x: Array) -> Array:
        """(‖p‖² − r²)/(2 r) of every drift at its instants, about metres."""
        places = self.rows @ x + self.known
        return np.asarray(((places**2).sum(axis=1) - self.least**2) / (2.0 * self.least))

    def outside_by(self, x: Array) -> Array:
        """Its derivatives."""
        places = self.rows @ x + self.known
        return np.asarray(np.einsum("mi,mij->mj", places, self.rows) / self.least)

    def best(self, seed: int) -> tuple[float, int]:
        """The least cost of the starts that end within the constraints, and how many do; infinite for none."""
        random, found, kept = np.random.default_rng([seed, 50]), np.inf, 0
        conditions: list[dict[str, Any]] = [
            {"type": "eq", "fun": lambda x: self.equal @ x - self.side, "jac": lambda _: self.equal},
            {"type": "ineq", "fun": self.outside, "jac": self.outside_by},
        ]
        for start in range(STARTS):
            noise = np.geomspace(0.02, 0.5, STARTS)[start] * random.standard_normal(self.planned.size)
            ended = minimize(
                self.cost, self.planned + noise, jac=True, method="SLSQP", constraints=conditions,
                options={"maxiter": 150, "ftol": 1e-8},
            )  # fmt: skip
            misses = float(np.abs(self.equal @ ended.x - self.side).max())
            if misses <= KEPT * self.least and float(self.outside(ended.x).min()) >= -KEPT * self.least:
                kept += 1
                found = min(found, float(ended.fun))
        return found, kept


def main() -> None:
    """Print a line an approach."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--first", type=int, default=0)
    chosen = parser.parse_args()
    for seed in range(chosen.first, chosen.first + chosen.count):
        try:
            plan = approach.plan(checked(approach.Scenario, scenario(seed), source=f"random {seed}"))
        except ScenarioError:
            continue
        if plan.status is not PlanStatus.VERIFIED:
            continue
        beside = Beside(plan)
        ours = beside.cost(beside.planned)[0]
        theirs, kept = beside.best(seed)
        sys.stdout.write(
            f"{seed:4d} ours {ours:.5f}  best of {kept} {theirs:.5f}  above {100.0 * (ours / theirs - 1.0):+.3f} %\n"
        )
        sys.stdout.flush()


if __name__ == "__main__":
    main()
