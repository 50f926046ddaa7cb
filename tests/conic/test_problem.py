"""Problem: every malformed input is refused by name, every well-formed one is held as canonical CSC."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse as scipy_sparse

from orbsoc.conic import csc
from orbsoc.conic.problem import Cones, Problem, ProblemError
from tests.strategies import problems

sparse: Any = scipy_sparse  # published without types

INF = float("inf")
NAN = float("nan")


def two_by_two(**changes: Any) -> Problem:
    """min x₀ + 2x₁, x ≥ 0, x₀ + x₁ = 1 with some arguments replaced."""
    data: dict[str, Any] = {
        "P": np.eye(2),
        "c": [1.0, 2.0],
        "A": [[1.0, 1.0]],
        "b": [1.0],
        "G": -np.eye(2),
        "h": [0.0, 0.0],
        "cones": Cones(l=2),
    }
    return Problem(**(data | changes))


MALFORMED: list[tuple[dict[str, Any], str]] = [
    ({"c": []}, "`c` is empty; a problem needs at least one variable"),
    ({"c": [[1.0, 2.0]]}, "`c` has shape (1, 2); it must be one-dimensional"),
    ({"c": [1.0, NAN]}, "`c[1]` is nan; it must be finite"),
    ({"c": [1.0, -INF]}, "`c[1]` is -inf; it must be finite"),
    ({"c": ["a", "b"]}, "`c` has entries of type <U1; they must be real numbers"),
    ({"c": [1.0 + 1.0j, 0.0]}, "`c` has entries of type complex128; they must be real numbers"),
    ({"c": [1.0, [2.0]]}, "`c` is not an array of numbers: setting an array element with a sequence"),
    ({"G": [[1.0, 0.0], [1.0]]}, "`G` is not an array of numbers: setting an array element with a sequence"),
    ({"A": np.ones((1, 3))}, "`A` has 3 columns, but c has 2 entries"),
    ({"A": np.ones(2)}, "`A` has shape (2,); it must be two-dimensional"),
    ({"A": [[1.0, NAN]]}, "`A[0, 1]` is nan; it must be finite"),
    ({"A": [[1.0j, 0.0]]}, "`A` has entries of type complex128; they must be real numbers"),
    ({"A": None}, "`b` has 1 entries, but A is missing"),
    ({"b": None}, "`b` is missing, but A has 1 rows"),
    ({"b": [1.0, 2.0]}, "`b` has 2 entries, but A has 1 rows"),
    ({"b": [INF]}, "`b[0]` is inf; it must be finite"),
    ({"G": np.ones((2, 1))}, "`G` has 1 columns, but c has 2 entries"),
    ({"G": [[1.0, 0.0], [INF, 0.0]]}, "`G[1, 0]` is inf; it must be finite"),
    ({"h": np.zeros(41)}, "`h` has 41 entries, but G has 2 rows"),
    ({"h": [0.0, -INF]}, "`h[1]` is -inf; it must be finite, or +inf for no constraint"),
    ({"h": [0.0, NAN]}, "`h[1]` is nan; it must be finite, or +inf for no constraint"),
    (
        {"h": [0.0, INF], "cones": Cones(l=0, q=[2])},
        "`h[1]` is inf; it must be finite, because the row is in a second-order cone",
    ),
    ({"cones": None}, "`cones` is missing, but G has 2 rows; Cones(l=2) makes each an inequality"),
    ({"cones": Cones(l=1, q=[2])}, "`cones` add up to 3 rows (l = 1, q = (2,)), but G has 2 rows"),
    ({"P": np.ones((2, 3))}, "`P` has 3 columns, but c has 2 entries"),
    ({"P": np.ones((3, 2))}, "`P` has 3 rows, but c has 2 entries"),
    ({"P": [[2.0, 1.0], [0.5, 2.0]]}, "`P` is not symmetric: P[1, 0] is 0.5, but P[0, 1] is 1.0"),
    (
        {
            "P": [[1e13, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, 0.1, 1.0]],
            "c": [0.0] * 3,
            "A": np.ones((1, 3)),
            "G": np.ones((2, 3)),
        },
        "`P` is not symmetric: P[2, 1] is 0.1, but P[1, 2] is 0.5",
    ),
    ({"P": [[-1.0, 0.0], [0.0, 1.0]]}, "`P` is not positive semidefinite: P[0, 0] is -1.0"),
    (
        {"P": [[1.0, 2.0], [2.0, 1.0]]},
        "`P` is not positive semidefinite: P[0, 1] is 2.0, P[0, 0] is 1.0 and P[1, 1] is 1.0",
    ),
    (
        {"P": [[1.0, 0.5], [0.5, 0.0]]},
        "`P` is not positive semidefinite: P[0, 1] is 0.5, P[0, 0] is 1.0 and P[1, 1] is 0.0",
    ),
]


@pytest.mark.parametrize(("changes", "message"), MALFORMED, ids=[message for _, message in MALFORMED])
def test_malformed_data_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=re.escape(message)):
        two_by_two(**changes)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"l": -1}, "`cones.l` is -1; it must be 0 or more"),
        ({"q": [3, 0]}, "`cones.q[1]` is 0; a second-order cone has size 1 or more"),
        ({"q": [-2]}, "`cones.q[0]` is -2; a second-order cone has size 1 or more"),
        ({"l": 1.5}, "`cones` must hold integers"),
        ({"q": ["3"]}, "`cones` must hold integers"),
    ],
)
def test_impossible_cones_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=re.escape(message)):
        Cones(**arguments)


@pytest.mark.parametrize("triangle", [np.triu, np.tril])
def test_one_triangle_of_p_is_refused_and_from_upper_suggested(triangle: Callable[..., Any]) -> None:
    full = np.array([[2.0, 1.0], [1.0, 2.0]])
    with pytest.raises(ProblemError, match=r"Problem\.from_upper"):
        two_by_two(P=triangle(full))


def test_from_upper_mirrors_the_triangle() -> None:
    full = np.array([[2.0, 1.0, 0.0], [1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    assert np.array_equal(Problem.from_upper(np.triu(full), c=np.zeros(3)).P.toarray(), full)


def test_from_upper_refuses_entries_below_the_diagonal() -> None:
    with pytest.raises(ProblemError, match=re.escape("`P[1, 0]` lies below the diagonal")):
        Problem.from_upper(np.ones((2, 2)), c=[0.0, 0.0])


def test_p_symmetric_up_to_rounding_is_averaged() -> None:
    P = np.array([[2.0, 1.0], [1.0 + 1e-15, 2.0]])
    held = two_by_two(P=P).P.toarray()
    assert np.array_equal(held, held.T)
    assert abs(held[0, 1] - 1.0) < 1e-15


def test_p_whose_mirror_is_a_stored_zero_elsewhere_is_accepted() -> None:
    stored = sparse.csc_array((np.array([1.0, 0.0, 1.0]), ([0, 0, 1], [0, 1, 1])), shape=(2, 2))
    held = two_by_two(P=stored).P
    assert np.array_equal(held.toarray(), np.eye(2))


@pytest.mark.parametrize("order", [3, 150, 260])
def test_a_hidden_direction_of_negative_curvature_is_found(order: int) -> None:
    """Every 2 × 2 minor of I − 1.5/order·11ᵀ is positive, its eigenvalue along 1 is −½."""
    P = np.eye(order) - 1.5 / order * np.ones((order, order))
    with pytest.raises(ProblemError, match="not positive semidefinite"):
        Problem(P=P, c=np.zeros(order))


@pytest.mark.parametrize("order", [3, 150, 260])
def test_a_singular_gram_matrix_of_any_scale_is_accepted(order: int) -> None:
    factor = np.random.default_rng(order).normal(size=(2, order)) * 10.0 ** np.linspace(-6, 6, order)
    gram = factor.T @ factor
    assert Problem(P=gram, c=np.zeros(order)).P.nnz == order * order


@pytest.mark.parametrize("make", [sparse.csc_matrix, sparse.csr_array, sparse.coo_array, sparse.lil_array,
                                  sparse.dok_array, sparse.bsr_array, sparse.dia_array, np.asarray, np.asfortranarray])  # fmt: skip
def test_every_matrix_format_gives_the_same_problem(make: Callable[..., Any]) -> None:
    A = np.array([[1.0, 0.0, -2.0], [0.0, 3.0, 0.0]])
    problem = Problem(c=np.zeros(3), A=make(A), b=[1.0, 2.0])
    assert np.array_equal(problem.A.toarray(), A)
    assert problem.A.indices.dtype == problem.A.indptr.dtype == np.int32


def test_unsorted_and_duplicate_entries_are_sorted_and_added_in_a_copy() -> None:
    data, indices, indptr = np.array([1.0, 2.0, 4.0, 8.0]), np.array([2, 0, 2, 1]), np.array([0, 3, 4])
    given_matrix = sparse.csc_array((data, indices, indptr), shape=(3, 2))
    problem = Problem(c=[0.0, 0.0], A=given_matrix, b=np.zeros(3))
    assert problem.A.indices.tolist() == [0, 2, 1]
    assert problem.A.data.tolist() == [2.0, 5.0, 8.0]
    assert data.tolist() == [1.0, 2.0, 4.0, 8.0]
    assert indices.tolist() == [2, 0, 2, 1]


def test_int64_indices_become_int32() -> None:
    matrix = sparse.csc_array(np.eye(2))
    matrix.indices, matrix.indptr = matrix.indices.astype(np.int64), matrix.indptr.astype(np.int64)
    problem = two_by_two(G=matrix)
    assert problem.G.indices.dtype == problem.G.indptr.dtype == np.int32


def test_canonical_data_are_not_copied() -> None:
    G, h = sparse.csc_array(np.eye(2)), np.zeros(2)
    problem = two_by_two(G=G, h=h)
    assert np.shares_memory(problem.G.data, G.data)
    assert np.shares_memory(problem.h, h)


def test_read_only_arrays_are_accepted() -> None:
    G, h = sparse.csc_array(np.array([[1.0, 1.0], [0.0, 1.0]])), np.zeros(2)
    for array in (G.data, G.indices, G.indptr, h):
        array.setflags(write=False)
    assert two_by_two(G=G, h=h).G.nnz == 3


def test_strided_arrays_are_made_contiguous() -> None:
    problem = two_by_two(c=np.arange(4.0)[::2], h=np.zeros((2, 2))[:, 0])
    assert problem.c.tolist() == [0.0, 2.0]
    assert problem.c.flags.c_contiguous
    assert problem.h.flags.c_contiguous


def test_integer_and_boolean_data_become_float64() -> None:
    problem = two_by_two(c=[1, 2], A=np.array([[True, False]]), b=[1])
    assert problem.c.dtype == problem.A.data.dtype == np.float64


def test_entries_outside_the_matrix_are_refused() -> None:
    matrix = sparse.csc_array(np.eye(2))
    matrix.indices = np.array([0, 7], dtype=np.int32)
    with pytest.raises(ProblemError, match="`G` has an entry in row 7, but only 2 rows"):
        two_by_two(G=matrix)


def test_column_pointers_that_fall_are_refused() -> None:
    matrix = sparse.csc_array(np.eye(2))
    matrix.indptr = np.array([0, 3, 2], dtype=np.int32)
    with pytest.raises(ProblemError, match="`G` is not a CSC matrix"):
        two_by_two(G=matrix)


def test_sizes_beyond_32_bits_are_refused() -> None:
    tall = sparse.csc_array((2**31 + 5, 2))
    with pytest.raises(ProblemError, match=f"`A` has shape .* limited to {csc.INDEX_LIMIT}"):
        two_by_two(A=tall)


def test_positive_infinity_is_legal_in_h_of_an_inequality() -> None:
    assert two_by_two(h=[INF, 0.0]).h.tolist() == [INF, 0.0]


def test_a_bound_of_1e20_is_none_and_what_was_given_stays() -> None:
    given = np.array([1e20, 9.9e19])
    assert two_by_two(h=given).h.tolist() == [INF, 9.9e19]
    assert given[0] == 1e20
    cone = Problem(c=[1.0], G=[[1.0], [1.0], [0.0]], h=[1e300, 1e20, 1e20], cones=Cones(l=1, q=[2]))
    assert cone.h.tolist() == [INF, 1e20, 1e20]


def test_huge_but_finite_data_are_not_called_infinite() -> None:
    assert two_by_two(c=[1e300, -1e300]).c.tolist() == [1e300, -1e300]


def test_cone_blocks_follow_the_inequalities() -> None:
    assert list(Cones(l=2, q=[3, 1]).second_order()) == [slice(2, 5), slice(5, 6)]


def same(left: Problem, right: Problem) -> bool:
    """Whether two problems agree in every bit."""
    vectors = all(getattr(left, k).tobytes() == getattr(right, k).tobytes() for k in "cbh")
    matrices = all(
        getattr(getattr(left, k), part).tobytes() == getattr(getattr(right, k), part).tobytes()
        for k in "PAG"
        for part in ("data", "indices", "indptr")
    )
    return vectors and matrices and left.cones == right.cones


@given(problems())
def test_a_saved_problem_comes_back_bit_for_bit(
    tmp_path_factory: pytest.TempPathFactory, problem: Problem
) -> None:
    path = tmp_path_factory.mktemp("problem") / "p.json"
    problem.save(path)
    assert same(problem, Problem.load(path))


@given(problems(), st.randoms(use_true_random=False))
def test_a_problem_does_not_depend_on_the_order_of_its_entries(problem: Problem, random: Any) -> None:
    values, rows, columns = csc.entries(problem.G)
    order = list(range(values.size))
    random.shuffle(order)
    shuffled = sparse.coo_array((values[order], (rows[order], columns[order])), shape=problem.G.shape)
    again = Problem(
        P=problem.P, c=problem.c, A=problem.A, b=problem.b, G=shuffled, h=problem.h, cones=problem.cones
    )
    assert same(problem, again)


DAMAGE: list[tuple[str, Callable[[dict[str, Any]], Any], str]] = [
    ("schema missing", lambda d: d.pop("schema"), "field `schema` is None"),
    ("other schema", lambda d: d.update(schema="orbsoc.problem/9"), "field `schema` is 'orbsoc.problem/9'"),
    ("unknown field", lambda d: d.update(weight=1), "field `weight` is unknown"),
    ("n missing", lambda d: d.pop("n"), "field `n` is None; it must be an integer, 0 or more"),
    ("n negative", lambda d: d.update(n=-1), "field `n` is -1"),
    ("n a float", lambda d: d.update(n=2.0), "field `n` is 2.0"),
    ("c missing", lambda d: d.pop("c"), "field `c` has 0 entries; 2 are needed"),
    ("c not a list", lambda d: d.update(c=3), "field `c` is 3; it must be a list"),
    ("text in c", lambda d: d.update(c=[1, "two"]), "field `c[1]` is 'two'; it must be a number"),
    ("inf in c", lambda d: d.update(c=[1, "inf"]), "`c[1]` is inf; it must be finite"),
    ("huge integer", lambda d: d.update(c=[1, 10**400]), "field `c[1]` is 1000"),
    ("true in h", lambda d: d.update(h=[0, True]), "field `h[1]` is True"),
    ("A not an object", lambda d: d.update(A=[1]), "field `A` must be an object with indptr, indices and data"),
    ("A.data short", lambda d: d["A"].update(data=[1.0]), "field `A.data` has 1 entries; 2 are needed"),
    ("A.indptr short", lambda d: d["A"].update(indptr=[0, 1]), "field `A.indptr` has 2 entries; 3 are needed"),
    ("A.indptr falls", lambda d: d["A"].update(indptr=[0, 3, 2]), "field `A.indptr` must ascend from 0"),
    ("A.indices", lambda d: d["A"].update(indices=[0, 4]), "field `A.indices` must lie in 0 … 0"),
    ("A.indices huge", lambda d: d["A"].update(indices=[0, 2**70]), "field `A.indices[1]` is 118059162071741130"),
    ("cones.q", lambda d: d["cones"].update(q=3), "field `cones.q` is 3; it must be a list of integers"),
    ("cones.l", lambda d: d["cones"].update(l="2"), "field `cones.l` is '2'; it must be an integer"),
    ("cones short", lambda d: d["cones"].update(l=1), "`cones` add up to 1 rows"),
]  # fmt: skip


@pytest.mark.parametrize(("damage", "message"), [row[1:] for row in DAMAGE], ids=[row[0] for row in DAMAGE])
def test_a_damaged_file_is_refused_by_field(
    tmp_path: Path, damage: Callable[[dict[str, Any]], Any], message: str
) -> None:
    path = tmp_path / "p.json"
    two_by_two().save(path)
    document = json.loads(path.read_text())
    damage(document)
    path.write_text(json.dumps(document))
    with pytest.raises(ProblemError, match=re.escape(message)) as caught:
        Problem.load(path)
    assert str(caught.value).startswith(str(path))


@pytest.mark.parametrize("text", ["", "{", '{"schema": NaN}', "[]", "\x00"])
def test_a_file_that_is_not_such_a_document_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "p.json"
    path.write_text(text)
    with pytest.raises(ProblemError, match=re.escape(str(path))):
        Problem.load(path)


def test_a_missing_file_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        Problem.load(tmp_path / "none.json")


def test_absent_blocks_may_be_left_out_of_a_file(tmp_path: Path) -> None:
    path = tmp_path / "p.json"
    path.write_text('{"schema": "orbsoc.problem/1", "n": 2, "p": 0, "m": 0, "c": [1, -2.5]}')
    assert same(Problem.load(path), Problem(c=[1.0, -2.5]))


@pytest.mark.parametrize("dtype", [complex, "U3", object])
def test_empty_data_of_any_type_are_empty(dtype: Any) -> None:
    """Without an error or a warning: what is not there has no type."""
    problem = Problem(
        c=[1.0, 2.0],
        A=np.zeros((0, 2), dtype),
        b=np.zeros(0, dtype),
        G=np.eye(2),
        h=[1.0, 1.0],
        cones=Cones(l=2),
    )
    assert (problem.p, problem.A.shape, problem.b.dtype) == (0, (0, 2), np.float64)
    with pytest.raises(ProblemError, match="`c` is empty"):
        Problem(c=np.zeros(0, dtype))
