"""Quadratic programs with known answers, singular P and missing blocks included."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from orbsoc.conic.problem import Cones, Problem
from tests.zoo.case import ZooCase, box, infeasible, lp, solvable, unbounded


def unconstrained() -> ZooCase:
    """−½cᵀP⁻¹c, no rows at all."""
    P, c = np.array([[4.0, 1.0], [1.0, 3.0]]), np.array([1.0, -2.0])
    return solvable("qp_unconstrained", lp(c, P=P), -0.5 * c @ np.linalg.solve(P, c))


def projection_on_box() -> ZooCase:
    """The nearest point of a box clips."""
    v = np.array([2.0, -0.3, -5.0, 0.7])
    nearest = np.clip(v, -1.0, 1.0)
    value = 0.5 * nearest @ nearest - v @ nearest
    return solvable("qp_projection_on_box", lp(-v, *box(4, -1.0, 1.0), P=np.eye(4)), value)


def projection_on_simplex() -> ZooCase:
    """The nearest point of the simplex: (v − θ)₊ with Σ = 1; here θ = 0.35 and the support is {0, 1}."""
    v = np.array([1.0, 0.7, 0.1])
    nearest = np.array([0.65, 0.35, 0.0])
    problem = lp(-v, -np.eye(3), np.zeros(3), np.ones((1, 3)), [1.0], P=np.eye(3))
    return solvable("qp_projection_on_simplex", problem, 0.5 * nearest @ nearest - v @ nearest)


def least_norm() -> ZooCase:
    """min ½‖x‖², Ax = b is ½bᵀ(AAᵀ)⁻¹b; no inequalities."""
    A = np.array([[1.0, 2, 0, -1], [0, 1, 1, 1]])
    b = np.array([3.0, -1.0])
    value = 0.5 * b @ np.linalg.solve(A @ A.T, b)
    return solvable("qp_least_norm", lp(np.zeros(4), None, None, A, b, P=np.eye(4)), value)


def dependent_equalities() -> ZooCase:
    """The same with a row repeated."""
    A = np.array([[1.0, 2, 0, -1], [0, 1, 1, 1]])
    b = np.array([3.0, -1.0])
    value = 0.5 * b @ np.linalg.solve(A @ A.T, b)
    problem = lp(np.zeros(4), None, None, np.vstack([A, A[0]]), [3, -1, 3], P=np.eye(4))
    return solvable("qp_dependent_equalities", problem, value)


def rank_one() -> ZooCase:
    """P = ppᵀ on a box: ½(pᵀx)² − pᵀx is least at pᵀx = 1, on a whole slice."""
    p = np.array([1.0, -2.0, 3.0])
    return solvable("qp_rank_one", lp(-p, *box(3, -1.0, 1.0), P=np.outer(p, p)), -0.5)


def singular_and_unconstrained() -> ZooCase:
    """c in the range of a singular P: a line of solutions."""
    p = np.array([1.0, 1.0])
    return solvable("qp_singular_and_unconstrained", lp(-p, P=np.outer(p, p)), -0.5)


def stored_zeros() -> ZooCase:
    """P, A and G with stored zeros; P is zero altogether."""
    nothing = sparse.csc_array((np.zeros(2), ([0, 1], [0, 1])), shape=(2, 2))
    A = sparse.csc_array((np.array([1.0, 1.0, 0.0]), ([0, 0, 1], [0, 1, 1])), shape=(2, 2))
    G = sparse.csc_array((np.array([-1.0, 0.0, -1.0]), ([0, 0, 1], [0, 1, 1])), shape=(2, 2))
    problem = Problem(P=nothing, c=[1.0, 2.0], A=A, b=[1.0, 0.0], G=G, h=[0.0, 0.0], cones=Cones(l=2))
    return solvable("qp_stored_zeros", problem, 1.0)


def weak_curvature() -> ZooCase:
    """Curvature of 1e-6 beside costs of 1: almost a linear program."""
    c = np.array([1.0, -1.0, 2.0])
    value = float(-np.abs(c).sum() + 0.5e-6 * 3)
    return solvable("qp_weak_curvature", lp(c, *box(3, -1.0, 1.0), P=1e-6 * np.eye(3)), value)


def hock_schittkowski_21() -> ZooCase:
    """Problem 21 of Hock & Schittkowski (1981): f* = −99.96, its constant −100 left out here."""
    G = [[-10.0, 1], [1, 0], [-1, 0], [0, 1], [0, -1]]
    return solvable("qp_hs21", lp([0, 0], G, [-10, 50, -2, 50, 50], P=np.diag([0.02, 2.0])), 0.04)


def hock_schittkowski_35() -> ZooCase:
    """Problem 35 of Hock & Schittkowski (1981): f* = 1/9, its constant 9 left out here."""
    P = np.array([[4.0, 2, 2], [2, 4, 0], [2, 0, 2]])
    G = np.vstack([[1.0, 1, 2], -np.eye(3)])
    return solvable("qp_hs35", lp([-8, -6, -4], G, [3, 0, 0, 0], P=P), 1 / 9 - 9)


def hock_schittkowski_76() -> ZooCase:
    """Problem 76 of Hock & Schittkowski (1981): f* = −4.681818181…  = −103/22."""
    P = np.array([[2.0, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 2, 1], [0, 0, 1, 1]])
    G = np.vstack([[1.0, 2, 1, 1], [3, 1, 2, -1], [0, -1, -4, 0], -np.eye(4)])
    return solvable("qp_hs76", lp([-1, -3, 1, -1], G, [5, 4, -1.5, 0, 0, 0, 0], P=P), -103 / 22)


def portfolio() -> ZooCase:
    """Least variance at a required return, long only; no closed form, a second solver gives the reference."""
    rng = np.random.default_rng(11)
    factors = rng.normal(size=(8, 3))
    P = factors @ factors.T + np.diag(rng.uniform(0.1, 0.5, 8))
    returns = rng.uniform(0.0, 0.2, 8)
    A, b = np.ones((1, 8)), [1.0]
    G, h = np.vstack([-returns, -np.eye(8)]), np.concatenate([[-0.1], np.zeros(8)])
    return solvable("qp_portfolio", lp(np.zeros(8), G, h, A, b, P=P))


def tracking() -> ZooCase:
    """Ten steps of a bounded double integrator to the origin; a second solver gives the reference."""
    steps = 10
    F, B = np.array([[1.0, 0.2], [0.0, 1.0]]), np.array([[0.02], [0.2]])
    n = 3 * steps
    A, b = np.zeros((2 * steps, n)), np.zeros(2 * steps)
    for k in range(steps):
        rows = slice(2 * k, 2 * k + 2)
        A[rows, 3 * k : 3 * k + 1] = -B
        A[rows, 3 * k + 1 : 3 * k + 3] = np.eye(2)
        if k:
            A[rows, 3 * k - 2 : 3 * k] = -F
    b[:2] = F @ np.array([1.0, 0.5])
    thrust = np.zeros((steps, n))
    thrust[np.arange(steps), 3 * np.arange(steps)] = 1.0
    problem = lp(
        np.zeros(n),
        np.vstack([thrust, -thrust]),
        np.ones(2 * steps),
        A,
        b,
        P=np.diag(np.tile([0.1, 1.0, 1.0], steps)),
    )
    return solvable("qp_tracking", problem)


def infeasible_box() -> ZooCase:
    """A strictly convex cost does not make crossed bounds feasible."""
    G, h = box(2, 1.0, 0.0)
    return infeasible("qp_infeasible_box", lp([1, 1], G, h, P=np.eye(2)))


def falling_null_direction() -> ZooCase:
    """c leaves the range of a singular P in a direction that no row stops."""
    P = np.diag([1.0, 0.0])
    return unbounded("qp_falling_null_direction", lp([0, 1], [[-1, 0]], [0], P=P))


def falling_without_rows() -> ZooCase:
    """The same without any row."""
    return unbounded("qp_falling_without_rows", lp([1, -1], P=np.ones((2, 2))))
