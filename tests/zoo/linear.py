"""Linear programs whose optimal value is known in closed form, or small enough to check by hand."""

from __future__ import annotations

import numpy as np

from tests.zoo.case import ZooCase, box, infeasible, lp, solvable, unbounded

INF = float("inf")


def two_variables() -> ZooCase:
    """max 3x + 5y, x ≤ 4, 2y ≤ 12, 3x + 2y ≤ 18: (2, 6) with 36."""
    G = [[1, 0], [0, 2], [3, 2], [-1, 0], [0, -1]]
    return solvable("lp_two_variables", lp([-3, -5], G, [4, 12, 18, 0, 0]), -36.0)


def unit_box() -> ZooCase:
    """min cᵀx on the unit box is −‖c‖₁."""
    c = np.array([1.0, -2.0, 0.5, 4.0])
    return solvable("lp_unit_box", lp(c, *box(4, -1.0, 1.0)), -np.abs(c).sum())


def simplex() -> ZooCase:
    """min cᵀx on the unit simplex is the smallest cost."""
    c = np.array([3.0, 1.5, 7.0, 2.0, 9.0])
    return solvable("lp_simplex", lp(c, -np.eye(5), np.zeros(5), np.ones((1, 5)), [1.0]), 1.5)


def klee_minty() -> ZooCase:
    """The five-dimensional cube of Klee and Minty (1972), optimum 5⁵."""
    n = 5
    G = np.eye(n) + 2.0 * np.array([[2.0 ** (i - j) if i > j else 0.0 for j in range(n)] for i in range(n)])
    c = -(2.0 ** np.arange(n - 1, -1, -1))
    return solvable(
        "lp_klee_minty",
        lp(c, np.vstack([G, -np.eye(n)]), np.concatenate([5.0 ** np.arange(1, n + 1), np.zeros(n)])),
        -(5.0**n),
    )


def degenerate_vertex() -> ZooCase:
    """Eight edges through the optimal vertex (1, 1)."""
    angles = np.linspace(0.05, np.pi / 2 - 0.05, 8)
    G = np.column_stack([np.cos(angles), np.sin(angles)])
    return solvable("lp_degenerate_vertex", lp([-1, -1], G, G.sum(axis=1)), -2.0)


def repeated_rows() -> ZooCase:
    """Every bound of a box stated four times."""
    G, h = box(3, -1.0, 2.0)
    return solvable("lp_repeated_rows", lp([1, -1, 2], np.tile(G, (4, 1)), np.tile(h, 4)), -5.0)


def whole_edge_optimal() -> ZooCase:
    """The cost is parallel to an edge: many solutions, one value."""
    return solvable("lp_whole_edge_optimal", lp([-1, -1], [[1, 1], [-1, 0], [0, -1]], [1, 0, 0]), -1.0)


def zero_rows() -> ZooCase:
    """Rows of zeros: 0ᵀx = 0 and 0ᵀx ≤ 1."""
    G = [[-1, 0], [0, 0], [0, -1]]
    return solvable("lp_zero_rows", lp([1, 2], G, [0, 1, 0], [[1, 1], [0, 0]], [1, 0]), 1.0)


def zero_row_on_the_boundary() -> ZooCase:
    """0ᵀx ≤ 0: feasible everywhere, but its slack cannot be positive."""
    return solvable("lp_zero_row_on_the_boundary", lp([1, 2], [[-1, 0], [0, 0], [0, -1]], [-1, 0, -1]), 3.0)


def free_columns() -> ZooCase:
    """Two variables that occur nowhere and cost nothing."""
    G = np.hstack([-np.eye(2), np.zeros((2, 2))])
    return solvable("lp_free_columns", lp([1, 1, 0, 0], G, [-1, -2]), 3.0)


def fixed_by_equality() -> ZooCase:
    """Two of three variables are fixed by rows of A."""
    A = [[1, 0, 0], [0, 2, 0]]
    return solvable("lp_fixed_by_equality", lp([1, 1, 1], -np.eye(3), np.zeros(3), A, [2, 6]), 5.0)


def fixed_by_two_bounds() -> ZooCase:
    """x₀ ≤ 1 and x₀ ≥ 1: no interior."""
    G = [[1, 0], [-1, 0], [0, -1]]
    return solvable("lp_fixed_by_two_bounds", lp([1, 1], G, [1, -1, 0]), 1.0)


def infinite_bounds() -> ZooCase:
    """Rows with h = +inf do not constrain."""
    G, _ = box(3, 0.0, 0.0)
    return solvable("lp_infinite_bounds", lp([1, 1, -1], G, [INF, 5, 2, 1, 3, INF]), -6.0)


def only_infinite_bounds() -> ZooCase:
    """No row constrains, no cost: any point is optimal."""
    return solvable("lp_only_infinite_bounds", lp([0, 0], np.eye(2), [INF, INF]), 0.0)


def no_inequalities() -> ZooCase:
    """The cost is a combination of the rows: constant on the feasible set."""
    A = np.array([[1.0, 2.0, 0.0], [0.0, 1.0, -1.0]])
    y, b = np.array([2.0, -1.0]), np.array([3.0, 1.0])
    return solvable("lp_no_inequalities", lp(A.T @ y, None, None, A, b), y @ b)


def no_rows_no_cost() -> ZooCase:
    """Nothing to do."""
    return solvable("lp_no_rows_no_cost", lp([0, 0, 0]), 0.0)


def dependent_equalities() -> ZooCase:
    """A of rank 2 with four consistent rows, one repeated and one a combination."""
    A = np.array([[1.0, 1, 1, 1], [1, -1, 0, 0], [1, 1, 1, 1], [3, 1, 2, 2]])
    b = A @ np.array([0.25, 0.25, 0.25, 0.25])
    return solvable("lp_dependent_equalities", lp([4, 3, 2, 1], -np.eye(4), np.zeros(4), A, b), 1.0)


def transport() -> ZooCase:
    """A balanced transport problem (3 sources, 4 sinks): A has one dependent row. 435 is Taha's textbook value."""
    supply, demand = np.array([15.0, 25.0, 10.0]), np.array([5.0, 15.0, 15.0, 15.0])
    cost = np.array([[10.0, 2, 20, 11], [12, 7, 9, 20], [4, 14, 16, 18]])
    rows = np.kron(np.eye(3), np.ones(4))
    columns = np.kron(np.ones(3), np.eye(4))
    A, b = np.vstack([rows, columns]), np.concatenate([supply, demand])
    return solvable("lp_transport", lp(cost.ravel(), -np.eye(12), np.zeros(12), A, b), 435.0)


def largest_flow() -> ZooCase:
    """Greatest flow from 0 to 3 in a network of five edges; the cut {0} has capacity 5."""
    edges = [(0, 1), (0, 2), (1, 2), (1, 3), (2, 3)]
    capacity = np.array([3.0, 2.0, 1.0, 2.0, 4.0])
    balance = np.zeros((2, 5))
    for e, (tail, head) in enumerate(edges):
        for node, sign in ((tail, -1.0), (head, 1.0)):
            if node in (1, 2):
                balance[node - 1, e] += sign
    G = np.vstack([np.eye(5), -np.eye(5)])
    h = np.concatenate([capacity, np.zeros(5)])
    return solvable("lp_largest_flow", lp([-1, -1, 0, 0, 0], G, h, balance, [0, 0]), -5.0)


def median() -> ZooCase:
    """min Σ|x − aₖ| is reached at the median."""
    a = np.array([3.0, -1.0, 4.0, 1.0, 5.0])
    eye, ones = np.eye(5), np.ones((5, 1))
    G = np.vstack([np.hstack([ones, -eye]), np.hstack([-ones, -eye])])
    value = np.abs(a - np.median(a)).sum()
    return solvable("lp_median", lp([0, 1, 1, 1, 1, 1], G, np.concatenate([a, -a])), value)


def midrange() -> ZooCase:
    """min maxₖ|x − aₖ| is half the range."""
    a = np.array([3.0, -1.0, 4.0, 1.0, 5.0])
    ones = np.ones((5, 1))
    G = np.vstack([np.hstack([ones, -ones]), np.hstack([-ones, -ones])])
    return solvable("lp_midrange", lp([0, 1], G, np.concatenate([a, -a])), 3.0)


def one_variable() -> ZooCase:
    """The smallest bounded problem: min x, x ≥ 3."""
    return solvable("lp_one_variable", lp([1], [[-1]], [-3]), 3.0)


def crossed_bounds() -> ZooCase:
    """x ≥ 1 and x ≤ 0."""
    return infeasible("lp_crossed_bounds", lp([1, 1], [[1, 0], [-1, 0], [0, -1]], [0, -1, 0]))


def inconsistent_equalities() -> ZooCase:
    """x + y = 1 and 2x + 2y = 3."""
    return infeasible("lp_inconsistent_equalities", lp([1, 1], -np.eye(2), [0, 0], [[1, 1], [2, 2]], [1, 3]))


def impossible_zero_equality() -> ZooCase:
    """0ᵀx = 1."""
    return infeasible("lp_impossible_zero_equality", lp([1, 1], -np.eye(2), [0, 0], [[0, 0]], [1]))


def impossible_zero_inequality() -> ZooCase:
    """0ᵀx ≤ −1."""
    return infeasible("lp_impossible_zero_inequality", lp([1, 1], [[-1, 0], [0, -1], [0, 0]], [0, 0, -1]))


def negative_sum_of_nonnegatives() -> ZooCase:
    """x ≥ 0 with Σx = −1."""
    return infeasible("lp_negative_sum", lp(np.ones(6), -np.eye(6), np.zeros(6), np.ones((1, 6)), [-1]))


def open_quadrant() -> ZooCase:
    """min −x − y, x, y ≥ 0."""
    return unbounded("lp_open_quadrant", lp([-1, -1], -np.eye(2), [0, 0]))


def no_rows_at_all() -> ZooCase:
    """A cost and nothing that holds it."""
    return unbounded("lp_no_rows_at_all", lp([1, -2]))


def cost_outside_the_row_space() -> ZooCase:
    """Equalities only, and the cost is not a combination of them."""
    return unbounded("lp_cost_outside_the_row_space", lp([1, 0, 0], None, None, [[1, 1, 1]], [1]))


def costly_free_column() -> ZooCase:
    """A variable that occurs in no row but has a cost."""
    return unbounded("lp_costly_free_column", lp([1, 1], [[-1, 0]], [0]))


def neither_side_feasible() -> ZooCase:
    """No feasible x and no feasible (y, z): either certificate is right."""
    problem = lp([0, -1], [[1, 0], [-1, 0]], [-1, 0])
    both = infeasible("", problem).expected | unbounded("", problem).expected
    return ZooCase("lp_neither_side_feasible", problem, both)
