"""Problems on which releases of well-known solvers gave false answers, in the smallest form that shows how."""

from __future__ import annotations

import numpy as np

from tests.zoo.case import Array, ZooCase, lp, solvable, unbounded


def tolerance_taken_from_x() -> ZooCase:
    """An unbounded LP whose iterates grow until a dual tolerance relative to ‖x‖ accepts ‖c + Gᵀz‖ ≥ 1e-3.

    min −1e-3·x₀, x₀ ≤ x₁ + 1, x ≥ 0: unbounded along (1, 1).
    """
    G = [[1, -1], [-1, 0], [0, -1]]
    return unbounded("lie_tolerance_taken_from_x", lp([-1e-3, 0], G, [1, 0, 0]))


def _powell_20(n: int) -> ZooCase:
    """POWELL20 of Maros & Mészáros with n (even) variables: feasible on one line only.

    min ½‖x‖², x_{k+1} − x_k ≥ (−1)ᵏk − ½ (k = 1 … n−1), x₁ − x_n ≥ n − ½. The left sides add up to 0 and so do the
    right sides, hence every row is tight: multipliers near 1 look like a Farkas certificate, but exclude nothing.
    """
    k = np.arange(1, n)
    steps = np.where(k % 2 == 0, k, -k) - 0.5
    differences = np.zeros((n, n))
    differences[np.arange(n - 1), np.arange(n - 1)] = -1.0
    differences[np.arange(n - 1), np.arange(1, n)] = 1.0
    differences[n - 1, 0], differences[n - 1, n - 1] = 1.0, -1.0
    sides = np.concatenate([steps, [n - 0.5]])
    line = np.concatenate([[0.0], np.cumsum(steps)])
    nearest = line - line.mean()
    problem = lp(np.zeros(n), -differences, -sides, P=np.eye(n))
    return solvable(f"lie_powell_20_with_{n}", problem, 0.5 * nearest @ nearest)


def powell_20_with_10() -> ZooCase:
    return _powell_20(10)


def powell_20_with_100() -> ZooCase:
    return _powell_20(100)


def _transport_costs() -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(31)
    A = np.vstack([np.kron(np.eye(3), np.ones(4)), np.kron(np.ones(3), np.eye(4))]).astype(np.float64)
    flow = rng.uniform(0.0, 2.0, 12) * (rng.random(12) < 0.5)
    return A, A @ flow, rng.uniform(1.0, 5.0, 12)


def before_columns_are_rescaled() -> ZooCase:
    """A transport problem as first set up; a second solver gives the reference."""
    A, b, c = _transport_costs()
    return solvable("lie_before_columns_are_rescaled", lp(c, -np.eye(12), np.zeros(12), A, b))


def after_columns_are_rescaled() -> ZooCase:
    """The same pattern after an update that multiplies every third column by 1e4.

    A solver that keeps the equilibration of the first data loses its digits here; the optimal value is unchanged.
    """
    A, b, c = _transport_costs()
    factors = np.where(np.arange(12) % 3 == 0, 1e4, 1.0)
    problem = lp(c * factors, -np.diag(factors), np.zeros(12), A * factors, b)
    return solvable("lie_after_columns_are_rescaled", problem, scaled=True)


def large_multipliers() -> ZooCase:
    """min x₀ + x₁ with 1e-4·(x₀ + x₁) ≥ 1: multipliers of 1e4, objective 1e4, data around 1."""
    return solvable("lie_large_multipliers", lp([1, 1], [[-1e-4, -1e-4], [-1, 0], [0, -1]], [-1, 0, 0]), 1e4)


def far_feasible_set() -> ZooCase:
    """Feasible, but only far out (x ≥ 1e5): near-certificates of infeasibility abound on the way."""
    reason = "stops after one iteration with Gx + s − h = 1.6e-5: its residual is relative to ‖x‖ of 1e5"
    problem = lp([1.0], [[-1e-5]], [-1.0])
    return solvable("lie_far_feasible_set", problem, 1e5, scaled=True, clarabel_fails=reason)
