"""Re-solves through CVXPY with new parameters: orbsoc beside the solvers that CVXPY finds. `python -m benchmarks.cvxpy_resolve`.

The clock runs over the whole of `problem.solve`: CVXPY's compilation of the parameters, which all share, is in it.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

import cvxpy as cp
import numpy as np

import orbsoc

Renew = Callable[[np.random.Generator], None]
PEERS = ("CLARABEL", "OSQP", "PIQP", "QOCO", "ECOS")


def predictive_control(steps: int = 10, states: int = 6, inputs: int = 3) -> tuple[cp.Problem, Renew]:
    """A linear system to the origin from a new state, its inputs bounded."""
    random = np.random.default_rng(1)
    A = np.eye(states) + 0.1 * random.normal(size=(states, states))
    B = random.normal(size=(states, inputs))
    x, u, start = cp.Variable((states, steps + 1)), cp.Variable((inputs, steps)), cp.Parameter(states)
    dynamics = [x[:, k + 1] == A @ x[:, k] + B @ u[:, k] for k in range(steps)]
    cost = cp.sum_squares(x) + 0.1 * cp.sum_squares(u)
    problem = cp.Problem(cp.Minimize(cost), [x[:, 0] == start, *dynamics, cp.abs(u) <= 0.5])

    def renew(random: np.random.Generator) -> None:
        start.value = random.normal(size=states)

    return problem, renew


def portfolio(assets: int = 100, factors: int = 10) -> tuple[cp.Problem, Renew]:
    """Risk by factors less new expected returns, no short positions."""
    random = np.random.default_rng(2)
    loadings, spread = random.normal(size=(assets, factors)) / 10, random.uniform(0.1, 1.0, assets)
    weights, exposure, returns = cp.Variable(assets, nonneg=True), cp.Variable(factors), cp.Parameter(assets)
    risk = cp.sum_squares(exposure) + cp.sum_squares(cp.multiply(spread, weights))
    rows = [cp.sum(weights) == 1, exposure == loadings.T @ weights]

    def renew(random: np.random.Generator) -> None:
        returns.value = random.normal(size=assets)

    return cp.Problem(cp.Minimize(risk - returns @ weights), rows), renew


def least_squares(unknowns: int = 20, samples: int = 60) -> tuple[cp.Problem, Renew]:
    """A bounded fit to new samples."""
    design = np.random.default_rng(3).normal(size=(samples, unknowns))
    x, measured = cp.Variable(unknowns, bounds=[-0.3, 0.3]), cp.Parameter(samples)

    def renew(random: np.random.Generator) -> None:
        measured.value = random.normal(size=samples)

    return cp.Problem(cp.Minimize(cp.sum_squares(design @ x - measured)), [cp.sum(x) == 0.1]), renew


FAMILIES = {"MPC": predictive_control, "portfolio": portfolio, "least squares": least_squares}


def solvers() -> dict[str, Any]:
    """orbsoc from its last solution (CVXPY's default) and cold, and the peers that are installed."""
    installed = cp.installed_solvers()
    ours = {
        "orbsoc": {"solver": orbsoc.CVXPY()},
        "orbsoc, cold": {"solver": orbsoc.CVXPY(), "warm_start": False},
    }
    return ours | {name: {"solver": name} for name in PEERS if name in installed}


def measure(family: str, rounds: int) -> tuple[dict[str, float], dict[str, list[float]]]:
    """Median milliseconds of a re-solve by solver, the solvers taken in turn, and the values that they found."""
    chosen = solvers()
    problems = {name: FAMILIES[family]() for name in chosen}
    taken: dict[str, list[float]] = {name: [] for name in chosen}
    values: dict[str, list[float]] = {name: [] for name in chosen}
    for k in range(rounds + 1):
        for name, options in chosen.items():
            problem, renew = problems[name]
            renew(np.random.default_rng(1000 + k))
            start = time.perf_counter()
            problem.solve(**options)
            taken[name].append(1e3 * (time.perf_counter() - start))
            values[name].append(float(problem.value))
    return {name: float(np.median(times[1:])) for name, times in taken.items()}, values


def main(rounds: int = 200) -> None:
    """Print the table."""
    for family in FAMILIES:
        medians, _ = measure(family, rounds)
        line = "  ".join(f"{name} {ms:.2f} ms" for name, ms in medians.items())
        sys.stdout.write(f"{family:14}{line}\n")


if __name__ == "__main__":
    main()
