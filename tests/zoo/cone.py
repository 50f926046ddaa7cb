"""Second-order cone programs: every cone size the solver treats specially, apexes, constants, mixtures."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.problem import Cones, Problem
from tests.zoo.case import Array, ZooCase, ball, infeasible, lp, socp, solvable, unbounded


def _linear_on_ball(q: int) -> ZooCase:
    """min cᵀx on the unit ball, one cone of size q: −‖c‖."""
    c = np.random.default_rng(q).normal(size=q - 1)
    return solvable(
        f"socp_ball_of_size_{q}", socp(c, [ball(np.zeros(q - 1), 1.0)]), -float(np.linalg.norm(c))
    )


def ball_of_size_2() -> ZooCase:
    return _linear_on_ball(2)


def ball_of_size_3() -> ZooCase:
    return _linear_on_ball(3)


def ball_of_size_4() -> ZooCase:
    return _linear_on_ball(4)


def ball_of_size_5() -> ZooCase:
    return _linear_on_ball(5)


def ball_of_size_300() -> ZooCase:
    return _linear_on_ball(300)


def cones_of_size_1() -> ZooCase:
    """Q¹ is R₊: x ≥ 1, y ≥ 2, z ≥ 0."""
    problem = Problem(c=[1, 2, 3], G=-np.eye(3), h=[-1, -2, 0], cones=Cones(l=1, q=[1, 1]))
    return solvable("socp_cones_of_size_1", problem, 5.0)


def mixed_sizes() -> ZooCase:
    """Unit balls of cone sizes 2, 3, 4, 5 and 7, a cone of size 1 and a simplex, each in its own variables."""
    rng = np.random.default_rng(5)
    sizes = (2, 3, 4, 5, 7)
    n = 1 + sum(q - 1 for q in sizes) + 3
    c = rng.normal(size=n)
    c[0], c[-3:] = 1.0, [3.0, 1.0, 2.0]
    first = np.zeros((1, n))
    first[0, 0] = -1.0
    cones: list[tuple[Array, Array]] = [(first, np.array([-1.0]))]  # x₀ ≥ 1 as a cone of size 1
    value, column = 1.0 + 1.0, 1
    for q in sizes:
        G = np.zeros((q, n))
        G[1:, column : column + q - 1] = -np.eye(q - 1)
        cones.append((G, np.eye(1, q)[0]))
        value -= float(np.linalg.norm(c[column : column + q - 1]))
        column += q - 1
    simplex = np.zeros((3, n))
    simplex[:, -3:] = -np.eye(3)
    A = np.zeros((1, n))
    A[0, -3:] = 1.0
    return solvable("socp_mixed_sizes", socp(c, cones, (simplex, np.zeros(3)), A, [1.0]), value)


def many_small_cones() -> ZooCase:
    """The point of least total distance to 50 pairs of points, opposite each other about (1, 2): their centre."""
    rng = np.random.default_rng(7)
    offsets = rng.normal(size=(50, 2))
    points = np.array([1.0, 2.0]) + np.vstack([offsets, -offsets])
    cones: list[tuple[Array, Array]] = []
    for k, point in enumerate(points):
        G = np.zeros((3, 102))
        G[0, 2 + k] = -1.0
        G[1:, :2] = -np.eye(2)
        cones.append((G, np.concatenate([[0.0], -point])))
    c = np.concatenate([[0.0, 0.0], np.ones(100)])
    return solvable("socp_many_small_cones", socp(c, cones), 2.0 * np.linalg.norm(offsets, axis=1).sum())


def fermat_point() -> ZooCase:
    """Least total distance to the corners of an equilateral triangle on the unit circle: 3."""
    cones: list[tuple[Array, Array]] = []
    for k, angle in enumerate(2.0 * np.pi * np.arange(3) / 3.0):
        G = np.zeros((3, 5))
        G[0, 2 + k] = -1.0
        G[1:, :2] = -np.eye(2)
        cones.append((G, np.array([0.0, -np.cos(angle), -np.sin(angle)])))
    return solvable("socp_fermat_point", socp([0, 0, 1, 1, 1], cones), 3.0)


def balls_apart() -> ZooCase:
    """The distance of two unit balls with centres 4 apart is 2."""
    between = np.array([[0, 0, 0, 0, -1], [-1, 0, 1, 0, 0], [0, -1, 0, 1, 0]], dtype=float)
    left, right = np.zeros((3, 5)), np.zeros((3, 5))
    left[1:, :2] = right[1:, 2:4] = -np.eye(2)
    cones = [(between, np.zeros(3)), (left, np.array([1.0, 0, 0])), (right, np.array([1.0, -4, 0]))]
    return solvable("socp_balls_apart", socp([0, 0, 0, 0, 1], cones), 2.0)


def hyperbola() -> ZooCase:
    """xy ≥ 1 as ‖(x − y, 2)‖ ≤ x + y: the least sum is 2."""
    G = [[-1, -1], [-1, 1], [0, 0]]
    return solvable("socp_hyperbola", socp([1, 1], [(G, [0, 0, 2])]), 2.0)


def least_norm() -> ZooCase:
    """min t, ‖x‖ ≤ t, Ax = b is √(bᵀ(AAᵀ)⁻¹b)."""
    A = np.array([[0.0, 1, 2, 0, -1], [0, 0, 1, 1, 1]])
    b = np.array([3.0, -1.0])
    value = np.sqrt(b @ np.linalg.solve(A @ A.T, b))
    return solvable("socp_least_norm", socp([1, 0, 0, 0, 0], [(-np.eye(5), np.zeros(5))], A=A, b=b), value)


def apex() -> ZooCase:
    """min t, ‖x‖ ≤ t: the apex, with the multiplier inside the cone."""
    return solvable("socp_apex", socp([1, 0, 0], [(-np.eye(3), np.zeros(3))]), 0.0)


def steep_apex() -> ZooCase:
    """min 3t − x₁ − x₂, ‖x‖ ≤ t, sizes 3 and 6: both at their apexes, shifted to value 3·2."""
    G = np.zeros((9, 9))
    G[:3, :3], G[3:, 3:] = -np.eye(3), -np.eye(6)
    c = np.array([3.0, -1, -1, 3, -1, -1, 0, 0, 0])
    h = np.zeros(9)
    h[0] = -2.0  # the first cone's apex is at t = 2
    problem = socp(c, [(G[:3], h[:3]), (G[3:], h[3:])])
    return solvable("socp_steep_apex", problem, 6.0)


def only_the_apex_is_feasible() -> ZooCase:
    """‖x‖ ≤ t and t ≤ 0: no interior, but multipliers exist."""
    inequality = (np.array([[1.0, 0, 0]]), np.array([0.0]))
    return solvable(
        "socp_only_the_apex_is_feasible", socp([0, 1, 0], [(-np.eye(3), np.zeros(3))], inequality), 0.0
    )


def constant_inside_a_cone() -> ZooCase:
    """A cone without variables, its constant inside."""
    cones = [(np.zeros((3, 2)), np.array([2.0, 1.0, 0.0])), ball([0, 0], 1.0)]
    return solvable("socp_constant_inside_a_cone", socp([3, 4], cones), -5.0)


def constant_on_a_cone() -> ZooCase:
    """A cone without variables, its constant on the boundary: no interior."""
    cones = [(np.zeros((3, 2)), np.array([1.0, 1.0, 0.0])), ball([0, 0], 1.0)]
    return solvable("socp_constant_on_a_cone", socp([3, 4], cones), -5.0)


def slack_cone() -> ZooCase:
    """A ball so wide that only the box counts."""
    G = np.vstack([np.eye(3), -np.eye(3)])
    return solvable("socp_slack_cone", socp([1, -2, 3], [ball(np.zeros(3), 100.0)], (G, np.ones(6))), -6.0)


def nearest_in_ball() -> ZooCase:
    """min ½‖x‖² − vᵀx on the unit ball: v/‖v‖ when ‖v‖ > 1."""
    v = np.array([2.0, -1.0, 2.0])
    return solvable("socp_nearest_in_ball", socp(-v, [ball(np.zeros(3), 1.0)], P=np.eye(3)), 0.5 - 3.0)


def nearest_in_cone() -> ZooCase:
    """The projection of v on Q⁵ by quadratic cost; v outside the cone and its polar."""
    v = np.array([1.0, 2.0, 0.0, -2.0, 1.0])
    height = 0.5 * (v[0] + 3.0)
    nearest = np.concatenate([[height], height / 3.0 * v[1:]])
    value = 0.5 * nearest @ nearest - v @ nearest
    return solvable("socp_nearest_in_cone", socp(-v, [(-np.eye(5), np.zeros(5))], P=np.eye(5)), value)


def dependent_equalities() -> ZooCase:
    """A ball cut by two planes, one of them stated twice: x₀ = 0.6 and c along x₁ gives −0.8."""
    A = [[1, 0, 0], [0, 0, 1], [2, 0, 0]]
    problem = socp([0, 1, 0], [ball(np.zeros(3), 1.0)], A=A, b=[0.6, 0, 1.2])
    return solvable("socp_dependent_equalities", problem, -0.8)


def robust_program() -> ZooCase:
    """aᵢᵀx + 0.1‖x‖ ≤ 1 for six random rows; a second solver gives the reference."""
    rng = np.random.default_rng(21)
    cones: list[tuple[Array, Array]] = []
    for _ in range(6):
        a = rng.normal(size=4)
        cones.append((np.vstack([a, -0.1 * np.eye(4)]), np.eye(1, 5)[0]))
    bounds = (np.vstack([np.eye(4), -np.eye(4)]), np.full(8, 2.0))
    return solvable("socp_robust_program", socp(rng.normal(size=4), cones, bounds))


def soft_landing() -> ZooCase:
    """Least total thrust of a point mass from (4, 2) to rest in eight steps; a second solver gives the reference."""
    steps, dt = 8, 1.0
    n = 4 + 7 * steps  # state 0, then per step: thrust (2), its norm (1), next state (4)
    F = np.eye(4) + dt * np.eye(4, k=2)
    B = np.vstack([0.5 * dt**2 * np.eye(2), dt * np.eye(2)])
    A, b = np.zeros((4 * steps + 8, n)), np.zeros(4 * steps + 8)
    A[:4, :4] = np.eye(4)
    b[:4] = [4.0, 2.0, -0.5, 0.5]
    c = np.zeros(n)
    cones: list[tuple[Array, Array]] = []
    before = 0
    for k in range(steps):
        u, t, after = 4 + 7 * k, 6 + 7 * k, 7 + 7 * k
        rows = slice(4 + 4 * k, 8 + 4 * k)
        A[rows, after : after + 4] = np.eye(4)
        A[rows, before : before + 4] = -F
        A[rows, u : u + 2] = -B
        b[rows] = B @ np.array([0.0, -0.1])  # gravity
        G = np.zeros((3, n))
        G[0, t], G[1, u], G[2, u + 1] = -1.0, -1.0, -1.0
        cones.append((G, np.zeros(3)))
        c[t] = 1.0
        before = after
    A[-4:, before : before + 4] = np.eye(4)
    limits = np.zeros((steps, n))
    limits[np.arange(steps), 6 + 7 * np.arange(steps)] = 1.0
    return solvable("socp_soft_landing", socp(c, cones, (limits, np.full(steps, 0.6)), A, b))


def disjoint_balls() -> ZooCase:
    """‖x‖ ≤ 1 and ‖x − (3, 0)‖ ≤ 1."""
    return infeasible("socp_disjoint_balls", socp([1, 1], [ball([0, 0], 1.0), ball([3, 0], 1.0)]))


def impossible_constant() -> ZooCase:
    """(−1, 0, 0) ∈ Q³ is false for every x."""
    cones = [(np.zeros((3, 2)), np.array([-1.0, 0, 0])), ball([0, 0], 1.0)]
    return infeasible("socp_impossible_constant", socp([1, 1], cones))


def norm_below_minus_one() -> ZooCase:
    """‖x‖ ≤ t ≤ −1, a cone of size 6."""
    inequality = (np.eye(1, 6), np.array([-1.0]))
    return infeasible("socp_norm_below_minus_one", socp(np.ones(6), [(-np.eye(6), np.zeros(6))], inequality))


def ball_misses_plane() -> ZooCase:
    """The unit ball of a cone of size 300 and a plane at distance 2."""
    direction = np.random.default_rng(3).normal(size=299)
    A = (direction / np.linalg.norm(direction))[None, :]
    return infeasible("socp_ball_misses_plane", socp(np.ones(299), [ball(np.zeros(299), 1.0)], A=A, b=[2.0]))


def open_cone() -> ZooCase:
    """min −t, ‖x‖ ≤ t."""
    return unbounded("socp_open_cone", socp([-1, 0, 0], [(-np.eye(3), np.zeros(3))]))


def narrow_open_cone() -> ZooCase:
    """min t − 1.1·x₁, ‖x‖ ≤ t: only rays near the boundary fall."""
    return unbounded("socp_narrow_open_cone", socp([1, -1.1, 0, 0], [(-np.eye(4), np.zeros(4))]))


def curvature_beside_an_open_cone() -> ZooCase:
    """Quadratic in one variable, falling along a cone in the others."""
    P = np.diag([2.0, 0, 0, 0])
    G = np.hstack([np.zeros((3, 1)), -np.eye(3)])
    return unbounded("socp_curvature_beside_an_open_cone", socp([1, -1, 0, 0], [(G, np.zeros(3))], P=P))


def ball_and_half_space() -> ZooCase:
    """The lowest point of a disc cut at x₀ ≥ 0.8: −0.6."""
    problem = socp([0, 1], [ball([0, 0], 1.0)], (np.array([[-1.0, 0]]), np.array([-0.8])))
    return solvable("socp_ball_and_half_space", problem, -0.6)


def cone_beside_a_linear_program() -> ZooCase:
    """Size-2 cones |xₖ| ≤ tₖ: a linear program written with cones; Σt at x = (1, −2, 3) fixed by equalities."""
    cones: list[tuple[Array, Array]] = []
    for k in range(3):
        G = np.zeros((2, 6))
        G[0, 3 + k], G[1, k] = -1.0, -1.0
        cones.append((G, np.zeros(2)))
    A = np.hstack([np.eye(3), np.zeros((3, 3))])
    problem = socp([0, 0, 0, 1, 1, 1], cones, A=A, b=[1, -2, 3])
    return solvable("socp_cones_of_size_2", problem, 6.0)


def no_cone_rows_but_empty_blocks() -> ZooCase:
    """G with no rows, A with no rows, a positive definite P."""
    problem = lp([2, 0], np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2)), np.zeros(0), P=np.eye(2))
    return solvable("qp_empty_blocks", problem, -2.0)
