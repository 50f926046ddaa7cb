"""Approaches that no second impulse can make, by closed form: `python -m benchmarks.claims_infeasible [--cases N] [--seed S] [--first K]`.

Two impulses below the V-bar, the second's time free. An own closed form of the motion gives at 20 001 times the deepest
drift that the first impulse's size leaves; a case counts as infeasible where all are too shallow by more than the margin
changes to the next time, and as feasible where a few are deep enough. Counts what the planner says of both.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scenario_file import checked
from orbsoc.missions import passive_safety

Array = NDArray[np.float64]

N_RAD_S = 1e-3
TIMES = 20_001
NARROW = 0.4
"""Share of the times, below which a feasible case is worth planning."""
STEPS = 30
"""Of the ternary search for the first impulse's size: the margin is concave in it."""


@dataclass(frozen=True, slots=True)
class Case:
    """Start behind, capture ahead and below, keep-out, m, and the duration, s."""

    behind: float
    along: float
    below: float
    keep_out: float
    duration: float

    @classmethod
    def drawn(cls, random: np.random.Generator) -> Case:
        """At random, feasible or not."""
        keep_out = float(random.uniform(20.0, 60.0))
        return cls(
            behind=float(random.uniform(300.0, 1500.0)),
            along=float(random.uniform(-100.0, 100.0)),
            below=keep_out * float(random.uniform(1.02, 3.0)),
            keep_out=keep_out,
            duration=float(random.uniform(2500.0, 4000.0)),
        )

    def scenario(self) -> passive_safety.Scenario:
        """As the planner takes it."""
        data = {
            "mission": "passive_safety", "name": "random", "condition": "short", "keep_out_m": self.keep_out,
            "duration_s": self.duration, "target": {"mean_motion_rad_s": N_RAD_S},
            "start": {"x_m": -self.behind}, "capture": {"x_m": self.along, "z_m": self.below},
            "impulses": {"count": 2, "timing": "free"},
        }  # fmt: skip
        return checked(passive_safety.Scenario, data, source="random")

    def depths(self, times: int = TIMES) -> Array:
        """By how much the better drift of each time clears the keep-out, m; −inf where no first impulse will do."""
        n = N_RAD_S
        at = np.linspace(0.0, min(self.duration, pi / n), times + 2)[1:-1]
        low = self.keep_out * n / np.sin(n * at)  # of the first impulse's size: deep enough at the second
        high = np.full_like(at, 0.25 * n * (self.behind - self.keep_out))  # and short of the target
        none = low > high
        low = np.minimum(low, high)
        for _ in range(STEPS):
            one, two = low + (high - low) / 3.0, high - (high - low) / 3.0
            better = self._depth(at, one) < self._depth(at, two)
            low, high = np.where(better, one, low), np.where(better, high, two)
        return np.where(none, -np.inf, self._depth(at, 0.5 * (low + high)))

    def _depth(self, at: Array, size: Array) -> Array:
        n = N_RAD_S
        x, y = -size * np.sin(n * at) / n, -self.behind + 2.0 * size * (1.0 - np.cos(n * at)) / n
        dt = self.duration - at
        s, c = np.sin(n * dt), np.cos(n * dt)
        to_x = -self.below - (4.0 - 3.0 * c) * x
        to_y = self.along - y - 6.0 * (s - n * dt) * x
        a, b, d = s / n, 2.0 * (1.0 - c) / n, 4.0 * s / n - 3.0 * dt
        singular = a * d + b * b
        vx, vy = (d * to_x - b * to_y) / singular, (a * to_y + b * to_x) / singular
        centre = 4.0 * x + 2.0 * vy / n
        found = -centre - np.hypot(x - centre, vx / n) - self.keep_out
        return np.asarray(np.where(np.hypot(vx, vy) < 140.0, found, -np.inf))

    def feasible(self, times: int = TIMES) -> bool | None:
        """By closed form; None where it is too close to tell, or feasible at all but a few times, where nothing is tried."""
        depth = self.depths(times)
        if depth.max() > 1e-3:
            return True if np.mean(depth > 0.0) < NARROW else None
        with np.errstate(invalid="ignore"):
            steps = np.nan_to_num(np.abs(np.diff(depth)), nan=0.0, posinf=0.0)
        change = np.maximum(np.append(steps, 0.0), np.insert(steps, 0, 0.0))
        return False if float((depth + change).max()) < -1e-3 else None


def main() -> None:
    """Run until as many infeasible cases are judged, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--seed", type=int, default=51)
    parser.add_argument("--first", type=int, default=0, help="draw to begin with")
    options = parser.parse_args()
    said: Counter[str] = Counter({"contradicted": 0})
    number, judged = options.first, 0
    while judged < options.cases:
        case = Case.drawn(np.random.default_rng([options.seed, number]))
        feasible = case.feasible()
        number += 1
        if feasible is None:
            said["left out"] += 1
            continue
        if feasible and said["feasible"] >= options.cases:
            continue
        found = passive_safety.plan(case.scenario())
        judged += not feasible
        said["feasible" if feasible else "infeasible"] += 1
        said[f"{'feasible' if feasible else 'infeasible'}: {found.status.value}"] += 1
        wrong = found.status is (PlanStatus.INFEASIBLE if feasible else PlanStatus.VERIFIED)
        said["contradicted"] += wrong
        if wrong:
            sys.stdout.write(f"case {number - 1}: contradicted\n")
        if (judged % 20 == 0 and not feasible) or wrong:
            sys.stdout.write(f"{number} {dict(sorted(said.items()))}\n")
            sys.stdout.flush()
    sys.stdout.write(f"{number} {dict(sorted(said.items()))}\n")


if __name__ == "__main__":
    main()
