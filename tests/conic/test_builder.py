"""ConicBuilder: what it builds equals the problem assembled by hand, and misuse is refused by name."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse as scipy_sparse

import orbsoc
from orbsoc.conic.builder import BuilderError, ConicBuilder, Variable
from orbsoc.conic.problem import Cones, ProblemError
from tests.strategies import Array, Point, point

sparse: Any = scipy_sparse  # published without types


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(1, 6))
def test_a_built_problem_equals_the_one_assembled_by_hand(seed: int, variables: int, calls: int) -> None:
    """Random calls in random order; the dense matrices are kept beside, R₊ rows and cone rows apart."""
    rng = np.random.default_rng(seed)
    builder = ConicBuilder()
    held = [
        builder.variable(f"v{k}", tuple(rng.integers(1, 4, rng.integers(0, 3)))) for k in range(variables)
    ]
    n = sum(v.index.size for v in held)
    c, P = np.zeros(n), np.zeros((n, n))
    rows: dict[str, list[tuple[Array, Array]]] = {"equality": [], "nonnegative": [], "second_order": []}
    sizes: list[int] = []
    for _ in range(calls):
        variable = held[rng.integers(variables)]
        coefficients = rng.normal(size=variable.shape)
        builder.cost(variable, coefficients)
        c[variable.index.ravel()] += coefficients.ravel()
        factor = rng.normal(size=(2, variable.index.size))
        builder.quadratic_cost(variable, factor.T @ factor)
        P[np.ix_(variable.index.ravel(), variable.index.ravel())] += factor.T @ factor

        kind = str(rng.choice(list(rows)))
        size, groups = int(rng.integers(1, 5)), int(rng.integers(1, 3))
        count = size * groups
        dense, rhs = np.zeros((count, n)), rng.normal(size=count)
        terms: list[tuple[Any, Any]] = []
        for _ in range(rng.integers(0, 4)):
            columns = rng.integers(0, n, rng.integers(1, 5))  # repeated columns add up
            block = rng.normal(size=(count, columns.size)) * (rng.random((count, columns.size)) < 0.7)
            np.add.at(dense.T, columns, block.T)
            terms.append((columns, sparse.csr_array(block) if rng.random() < 0.5 else block))
        if kind == "second_order":
            builder.second_order(terms, rhs, size=size)
            sizes += [size] * groups
        else:
            getattr(builder, kind)(terms, rhs)
        rows[kind].append((dense, rhs))

    problem = builder.build()

    def stacked(*kinds: str) -> tuple[Array, Array]:
        blocks = [block for kind in kinds for block in rows[kind]]
        matrices, sides = [np.zeros((0, n)), *(m for m, _ in blocks)], [np.zeros(0), *(r for _, r in blocks)]
        return np.vstack(matrices), np.concatenate(sides)

    A, b = stacked("equality")
    G, h = stacked("nonnegative", "second_order")
    np.testing.assert_allclose(problem.A.toarray(), A, rtol=0, atol=1e-14)
    np.testing.assert_allclose(problem.G.toarray(), G, rtol=0, atol=1e-14)
    np.testing.assert_allclose(problem.P.toarray(), P, rtol=0, atol=1e-13)
    np.testing.assert_allclose(problem.c, c, rtol=0, atol=1e-14)
    assert np.array_equal(problem.b, b)
    assert np.array_equal(problem.h, h)
    assert problem.cones == Cones(sum(r.size for _, r in rows["nonnegative"]), sizes)


def test_inequalities_come_before_cones_whatever_the_order_of_calls() -> None:
    b = ConicBuilder()
    x = b.variable("x", 2)
    b.second_order([(x, -np.eye(2))], [5.0, 6.0])
    b.nonnegative([(x.index[:1], [[2.0]])], [7.0])
    problem = b.build()
    assert problem.G.toarray().tolist() == [[2.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]
    assert problem.h.tolist() == [7.0, 5.0, 6.0]
    assert problem.cones == Cones(1, [2])


def test_one_number_serves_as_right_hand_side_of_all_rows() -> None:
    b = ConicBuilder()
    x = b.variable("x", 3)
    b.equality([(x, np.eye(3))], 4.0)
    assert b.build().b.tolist() == [4.0, 4.0, 4.0]


def test_costs_of_a_column_named_twice_add_up() -> None:
    b = ConicBuilder()
    b.variable("x", 2)
    b.cost([1, 1, 0], [1.0, 2.0, 4.0])
    b.cost([1], 8.0)
    assert b.build().c.tolist() == [4.0, 11.0]


def test_rows_without_size_make_one_cone_and_with_size_several() -> None:
    b = ConicBuilder()
    x = b.variable("x", 6)
    b.second_order([(x, -np.eye(6))], np.zeros(6))
    b.second_order([(x, -np.eye(6))], np.zeros(6), size=3)
    b.second_order([(x, -np.eye(6))], np.zeros(6), size=1)
    assert b.build().cones == Cones(0, [6, 3, 3, 1, 1, 1, 1, 1, 1])


def test_zeros_of_dense_blocks_are_dropped_and_of_sparse_blocks_kept() -> None:
    b = ConicBuilder()
    x = b.variable("x", 2)
    stored = sparse.csr_array((np.array([0.0, 3.0]), np.array([0, 1]), np.array([0, 2])), shape=(1, 2))
    b.equality([(x, [[0.0, 3.0]])], [1.0])
    b.equality([(x, stored)], [1.0])
    assert b.build().A.indptr.tolist() == [0, 1, 3]


def test_values_come_back_in_the_shape_of_the_variable() -> None:
    b = ConicBuilder()
    b.variable("first", 2)
    b.variable("grid", (2, 3))
    b.variable("one")
    solution = point(b.build(), np.arange(9.0))
    assert b.value(solution, "grid").tolist() == [[2.0, 3.0, 4.0], [5.0, 6.0, 7.0]]
    assert b.value(solution, "one").shape == ()
    assert float(b.value(solution, "one")) == 8.0


def test_building_twice_gives_the_same_problem_and_building_on_a_larger_one() -> None:
    b = ConicBuilder()
    x = b.variable("x", 2)
    b.equality([(x, np.eye(2))], [1.0, 2.0])
    assert np.array_equal(b.build().A.toarray(), b.build().A.toarray())
    y = b.variable("y", 1)
    b.equality([(y, [[5.0]])], [3.0])
    assert b.build().A.toarray().tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 5]]


def foreign() -> Variable:
    return ConicBuilder().variable("x", 2)


MISUSE: list[tuple[Callable[[ConicBuilder, Variable], object], str]] = [
    (lambda b, x: b.variable("x"), "variable `x` exists already"),
    (
        lambda b, x: b.variable("y", (2, 0)),
        "variable `y` has shape (2, 0); every dimension must be 1 or more",
    ),
    (lambda b, x: b.cost(x, [1.0, 2.0]), "cost: coefficients have shape (2,), but columns have shape (3,)"),
    (lambda b, x: b.cost(foreign(), 1.0), "cost: variable `x` belongs to another builder"),
    (lambda b, x: b.cost([3], 1.0), "cost: column 3 is not one of the 3 variables"),
    (lambda b, x: b.cost([-1], 1.0), "cost: column -1 is not one of the 3 variables"),
    (lambda b, x: b.cost([0.5], 1.0), "cost: columns have type float64; they must be integers"),
    (
        lambda b, x: b.equality([(x, np.eye(2))], [1.0, 2.0]),
        "equality: the block of term 0 has shape (2, 2); 2 rows and 3 columns need (2, 3)",
    ),
    (
        lambda b, x: b.equality([(x, np.eye(3)), (x.index[:1], np.ones(3))], np.ones(3)),
        "equality: the block of term 1 has shape (3,); 3 rows and 1 columns need (3, 1)",
    ),
    (
        lambda b, x: b.nonnegative([(x, sparse.eye_array(3))], np.ones(2)),
        "nonnegative: the block of term 0 has shape (3, 3); 2 rows and 3 columns need (2, 3)",
    ),
    (
        lambda b, x: b.nonnegative([], np.ones((2, 2))),
        "nonnegative: rhs has shape (2, 2); it must be (rows,) or one number",
    ),
    (
        lambda b, x: b.second_order([(x, np.eye(3))], np.ones(3), size=2),
        "second_order: 3 rows do not divide into cones of size 2",
    ),
    (
        lambda b, x: b.second_order([(x, np.eye(3))], np.ones(3), size=0),
        "second_order: 3 rows do not divide into cones of size 0",
    ),
    (lambda b, x: b.second_order([], np.ones(0)), "second_order: 0 rows do not divide into cones of size 0"),
    (
        lambda b, x: b.quadratic_cost(x, np.eye(2)),
        "quadratic_cost: the block of term 0 has shape (2, 2); 3 rows and 3 columns need (3, 3)",
    ),
    (lambda b, x: b.value(point(b.build(), np.zeros(3)), "y"), "no variable `y`; there are x"),
    (lambda b, x: b.value(foreign_point(), "x"), "the solution has (2,) entries, but the variables are 3"),
    (lambda b, x: ConicBuilder().build(), "no variables: call variable(name, shape) first"),
]


def foreign_point() -> Point:
    other = ConicBuilder()
    other.variable("x", 2)
    return point(other.build(), np.zeros(2))


@pytest.mark.parametrize(("misuse", "message"), MISUSE, ids=[message for _, message in MISUSE])
def test_misuse_is_refused_by_name(misuse: Callable[[ConicBuilder, Variable], object], message: str) -> None:
    b = ConicBuilder()
    x = b.variable("x", 3)
    with pytest.raises(BuilderError, match=re.escape(message)):
        misuse(b, x)


def test_a_refused_call_leaves_the_builder_as_it_was() -> None:
    b = ConicBuilder()
    x = b.variable("x", 3)
    with pytest.raises(BuilderError):
        b.second_order([(x, np.eye(3))], np.ones(3), size=2)
    with pytest.raises(BuilderError):
        b.equality([(x, np.eye(3)), (x, np.eye(2))], np.ones(3))
    problem = b.build()
    assert (problem.p, problem.m) == (0, 0)


def test_numbers_that_are_not_finite_are_refused_when_building() -> None:
    b = ConicBuilder()
    x = b.variable("x", 1)
    b.equality([(x, [[float("nan")]])], [1.0])
    with pytest.raises(ProblemError, match=re.escape("`A[0, 0]` is nan")):
        b.build()


# ---- Norms, absolutes, and rows by name ----


def norms_by_hand(b: ConicBuilder, x: Variable, t: Variable, blocks: Array, offsets: Array) -> None:
    for block, offset, column in zip(blocks, offsets, t.index, strict=True):
        head = np.zeros((4, 1))
        head[0] = -1.0
        b.second_order([(x, np.vstack([np.zeros(2), -block])), ([column], head)], [0.0, *offset])


@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_norms_are_the_cones_that_one_would_write_by_hand(seed: int, norms: int) -> None:
    rng = np.random.default_rng(seed)
    blocks, offsets = rng.normal(size=(norms, 3, 2)), rng.normal(size=(norms, 3))
    built = []
    for by_hand in (True, False):
        b = ConicBuilder()
        x, t = b.variable("x", 2), b.variable("t", norms)
        if by_hand:
            norms_by_hand(b, x, t, blocks, offsets)
        else:
            b.norm([(x, blocks.reshape(-1, 2))], offsets.ravel(), bound=t.index, size=3)
        built.append(b.build())
    ours, theirs = built
    assert ours.cones == theirs.cones
    assert np.array_equal(ours.h, theirs.h)
    assert np.array_equal(ours.G.toarray(), theirs.G.toarray())


def test_a_number_bounds_every_norm_and_numbers_each_its_own() -> None:
    b = ConicBuilder()
    x = b.variable("x", 2)
    b.norm([(x, np.eye(2))], bound=3)
    b.norm([(x, np.eye(2))], [5.0, 6.0], bound=[1.0, 2.0], size=1)
    problem = b.build()
    assert problem.cones == Cones(0, [3, 2, 2])
    assert problem.h.tolist() == [3.0, 0.0, 0.0, 1.0, 5.0, 2.0, 6.0]


def test_a_margin_is_taken_off_every_bound() -> None:
    b = ConicBuilder()
    x, t = b.variable("x", 2), b.variable("t", 1)
    b.norm([(x, np.eye(2))], bound=3.0, margin=0.5)
    b.norm([(x, np.eye(2))], bound=[1.0, 2.0], margin=[0.25, 0.5], size=1)
    b.norm([(x, np.eye(2))], bound=t, margin=0.5)
    assert b.build().h.tolist() == [2.5, 0.0, 0.0, 0.75, 0.0, 1.5, 0.0, -0.5, 0.0, 0.0]


@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_sums_of_norms_and_absolutes_reach_the_median_point(seed: int, size: int) -> None:
    """min Σ‖x − pᵢ‖ and min Σ|x − pᵢ|₁: the objective is the sum at the solution, and no nearby point is better."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(5, size))
    for absolutes in (False, True):
        b = ConicBuilder()
        x = b.variable("x", size)
        terms = [(x, np.tile(np.eye(size), (5, 1)))]
        if absolutes:
            b.sum_of_absolutes("distance", terms, -points.ravel(), weight=2.0)
        else:
            b.sum_of_norms("distance", terms, -points.ravel(), size=size, weight=2.0)
        solution = orbsoc.solve(b.build())
        order = 1 if absolutes else 2

        def cost(at: Array, order: int = order) -> float:
            return 2.0 * float(np.linalg.norm(points - at, ord=order, axis=1).sum())

        found = b.value(solution, "x")
        assert solution.objective == pytest.approx(cost(found), abs=1e-6)
        assert all(cost(found) <= cost(found + 0.1 * rng.normal(size=size)) + 1e-6 for _ in range(10))


def test_multipliers_come_back_by_the_name_of_their_rows() -> None:
    """min x₁ + ‖(x₂, x₃)‖ with x₁ ≥ 2, x₂ = 3: stationarity, block by block."""
    b = ConicBuilder()
    x, t = b.variable("x", 3), b.variable("t", 1)
    b.cost(x, [1.0, 0.0, 0.0])
    b.cost(t, 1.0)
    b.second_order([(x, np.zeros((2, 3)))], [1.0, 0.0], name="idle")
    b.norm([(x.index[1:], np.eye(2))], bound=t, name="length")
    b.nonnegative([(x.index[:1], [[-1.0]])], -2.0, name="least")
    b.equality([(x.index[2:], [[1.0]])], 0.0)
    b.equality([(x.index[1:2], [[1.0]])], 3.0, name="capture")
    solution = orbsoc.solve(b.build())
    assert b.dual(solution, "least") == pytest.approx([1.0], abs=1e-6)
    assert b.dual(solution, "capture") == pytest.approx([-1.0], abs=1e-6)
    np.testing.assert_allclose(b.dual(solution, "length"), [[1.0, -1.0, 0.0]], atol=1e-6)
    assert b.dual(solution, "idle").shape == (1, 2)


def test_an_infeasible_problem_says_which_rows_contradict_each_other() -> None:
    b = ConicBuilder()
    x, y = b.variable("x", 1), b.variable("y", 1)
    b.norm([(x, [[1.0]])], bound=1.0, name="largest impulse")
    b.equality([(y, [[1.0]])], 0.0, name="bystander")
    b.equality([(x, [[1.0]])], 3.0, name="capture")
    b.equality([(x, [[2.0]])], 4.0)
    words = b.why(orbsoc.solve(b.build()))
    assert words.startswith("the constraints cannot be met together: capture (")
    assert words.endswith(" of the conflict")
    assert "largest impulse (" in words
    assert "other rows (" in words
    assert "bystander" not in words


def test_without_a_certificate_there_is_no_reason() -> None:
    b = ConicBuilder()
    x = b.variable("x", 1)
    b.norm([(x, [[1.0]])], bound=1.0)
    assert b.why(orbsoc.solve(b.build())) == "there is no proof of infeasibility: the solve ended with SOLVED"


def test_rows_that_no_one_named_are_told_together() -> None:
    b = ConicBuilder()
    x = b.variable("x", 1)
    b.equality([(x, [[1.0]])], 3.0)
    b.equality([(x, [[1.0]])], 2.0)
    assert b.why(orbsoc.solve(b.build())).endswith("other rows (100 %) of the conflict")


NAMES: list[tuple[Callable[[ConicBuilder, Variable], object], str]] = [
    (lambda b, x: b.equality([(x, np.eye(3))], 0.0, name="tube"), "rows `tube` exist already"),
    (
        lambda b, x: b.norm([(x, np.eye(3))], bound=[1.0, 2.0], size=1),
        "norm: bound has shape (2,); it must be (3,) or one number",
    ),
    (
        lambda b, x: b.norm([(x, np.eye(3))], bound=x, margin=[1.0, 2.0], size=1),
        "norm: margin has shape (2,); it must be (3,) or one number",
    ),
    (
        lambda b, x: b.norm([(x, np.eye(3))], bound=x.index[:2], size=1),
        "norm: 2 columns bound 3 norms; there must be one a norm",
    ),
    (
        lambda b, x: b.norm([(x, np.eye(3))], bound=1.0, size=2),
        "norm: 3 rows do not divide into norms of size 2",
    ),
    (
        lambda b, x: b.sum_of_norms("s", [(x, np.eye(3))], size=2),
        "sum_of_norms: 3 rows do not divide into norms of size 2",
    ),
    (lambda b, x: b.sum_of_absolutes("x", [(x, np.eye(3))]), "variable `x` exists already"),
    (lambda b, x: b.dual(foreign_point(), "capture"), "no rows `capture`; there are tube"),
    (
        lambda b, x: b.dual(foreign_point(), "tube"),
        "the solution has 0 and 0 multipliers, but the rows are 0 and 3",
    ),
]


@pytest.mark.parametrize(("misuse", "message"), NAMES, ids=[message for _, message in NAMES])
def test_misuse_of_norms_and_names_is_refused(
    misuse: Callable[[ConicBuilder, Variable], object], message: str
) -> None:
    b = ConicBuilder()
    x = b.variable("x", 3)
    b.nonnegative([(x, np.eye(3))], 1.0, name="tube")
    before = b.build()
    with pytest.raises(BuilderError, match=re.escape(message)):
        misuse(b, x)
    assert b.build().m == before.m


def test_columns_of_a_variable_are_found_by_name() -> None:
    b = ConicBuilder()
    b.variable("x", 2)
    y = b.variable("y", (2, 3))
    assert b.has("y")
    assert not b.has("z")
    assert np.array_equal(b.columns("y"), y.index)
    with pytest.raises(BuilderError, match="no variable `z`; there are x, y"):
        b.columns("z")


def test_stored_zeros_make_one_pattern_of_other_numbers() -> None:
    patterns = []
    for block in (np.zeros((2, 2)), np.eye(2), np.ones((2, 2))):
        builder = ConicBuilder()
        x = builder.variable("x", 2)
        builder.nonnegative([(x, block)], 1.0, zeros=True, name="rows")
        builder.second_order([(x, block)], [1.0, 0.0], zeros=True, name="cone")
        problem = builder.build()
        np.testing.assert_array_equal(problem.G.toarray(), np.vstack([block, block]))
        np.testing.assert_array_equal(builder.rows("rows"), [0, 1])
        np.testing.assert_array_equal(builder.rows("cone"), [2, 3])
        patterns.append((problem.G.indptr.tolist(), problem.G.indices.tolist()))
    assert patterns[0] == patterns[1] == patterns[2]


def test_rows_are_found_by_name() -> None:
    builder = ConicBuilder()
    x = builder.variable("x", 2)
    builder.equality([(x, np.eye(2))], 0.0, name="fixed")
    for name in ("fixed", "absent"):
        with pytest.raises(BuilderError, match=f"no rows `{name}` of one kind in a cone"):
            builder.rows(name)
