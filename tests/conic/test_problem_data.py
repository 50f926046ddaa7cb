"""Plain data, read in one pass, make the problem that the checks one by one make of the same data."""

from __future__ import annotations

import pickle
from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse as scipy_sparse

import orbsoc
from orbsoc import _core
from orbsoc.conic import csc
from orbsoc.conic.problem import Cones, Problem, ProblemError
from tests.strategies import problems

sparse: Any = scipy_sparse  # published without types

FORMATS: dict[str, Any] = {
    "csc_array": sparse.csc_array,
    "csc_matrix": sparse.csc_matrix,
    "csr_array": sparse.csr_array,
    "csr_matrix": sparse.csr_matrix,
    "coo_array": sparse.coo_array,
    "coo_matrix": sparse.coo_matrix,
    "C order": lambda matrix: matrix.toarray(),
    "Fortran order": lambda matrix: np.asfortranarray(matrix.toarray()),
    "strided": lambda matrix: np.repeat(matrix.toarray(), 2, axis=1)[:, ::2],
}


class Subclass(np.ndarray[Any, Any]):
    """An array that might mean more than its entries: the checks take it, the one pass does not."""


def arguments(problem: Problem) -> dict[str, Any]:
    return {name: getattr(problem, name) for name in ("P", "c", "A", "b", "G", "h", "cones")}


def as_checked(data: dict[str, Any]) -> Problem:
    """The problem that the checks one by one make."""
    slow = data | {"c": np.asarray(data["c"]).view(Subclass)}
    assert _core.ProblemData.plain(*(slow[k] for k in "PcAbGh"), slow["cones"].l, slow["cones"].q) is None
    return Problem(**slow)


def bits(problem: Problem) -> list[bytes]:
    vectors = [getattr(problem, name).tobytes() for name in "cbh"]
    parts = ("data", "indices", "indptr")
    matrices = [getattr(getattr(problem, k), part).tobytes() for k in "PAG" for part in parts]
    shapes = repr([getattr(problem, k).shape for k in "PAG"] + [problem.cones]).encode()
    return [*vectors, *matrices, shapes]


@given(problems(), st.sampled_from(sorted(FORMATS)))
def test_plain_data_of_every_format_make_the_checked_problem(problem: Problem, name: str) -> None:
    data = arguments(problem) | {k: FORMATS[name](getattr(problem, k)) for k in "PAG"}
    plain = _core.ProblemData.plain(*(data[k] for k in "PcAbGh"), problem.cones.l, problem.cones.q)
    assert plain is not None
    assert bits(Problem(**data)) == bits(as_checked(data))


@given(problems())
def test_both_ways_solve_to_the_same_bits(problem: Problem) -> None:
    fast, slow = orbsoc.solve(Problem(**arguments(problem))), orbsoc.solve(as_checked(arguments(problem)))
    assert (fast.status, fast.iterations) == (slow.status, slow.iterations)
    assert all(getattr(fast, k).tobytes() == getattr(slow, k).tobytes() for k in "xyzs")


@given(problems())
def test_a_copy_and_a_pickle_are_the_same_problem(problem: Problem) -> None:
    assert bits(pickle.loads(pickle.dumps(problem))) == bits(problem) == bits(deepcopy(problem))


def test_what_is_held_as_given_is_the_given_object_itself() -> None:
    G, c, h = sparse.csc_array(-np.eye(2)), np.ones(2), np.zeros(2)
    problem = Problem(c=c, G=G, h=h, cones=Cones(l=2))
    assert (problem.G is G, problem.c is c, problem.h is h) == (True, True, True)
    assert problem.A is problem.A


def test_lists_of_numbers_are_vectors() -> None:
    problem = Problem(c=[1, 2.5, 3], G=np.eye(3), h=[1.0, float("inf"), 0], cones=Cones(l=3))
    assert problem.c.tolist() == [1.0, 2.5, 3.0]
    assert problem.h.tolist() == [1.0, float("inf"), 0.0]


NOT_PLAIN: list[tuple[dict[str, Any], str]] = [
    ({"cones": Cones(q=(2**62,) * 4)}, "`cones` add up to"),
    ({"cones": Cones(l=2**70)}, "`cones` add up to"),
    ({"G": np.ma.masked_greater(np.eye(2), 0.5)}, "`G` has masked entries"),
    ({"G": sparse.coo_array(([1.0, 1.0], ([0, 1], [0, 1])), shape=(2, 3))}, "`G` has 3 columns"),
    ({"c": np.array([1.0, 2.0]) * 1j}, "`c` has entries of type complex128"),
]


@pytest.mark.parametrize(("changes", "message"), NOT_PLAIN, ids=[message for _, message in NOT_PLAIN])
def test_what_is_not_plain_keeps_its_message(changes: dict[str, Any], message: str) -> None:
    data = {"c": np.ones(2), "G": np.eye(2), "h": np.ones(2), "cones": Cones(l=2)}
    with pytest.raises(ProblemError, match=message):
        Problem(**(data | changes))


@pytest.mark.parametrize("make", [sparse.csr_array, sparse.coo_array])
def test_damaged_index_arrays_are_refused_by_name(make: Any) -> None:
    matrix = make(np.eye(2))
    if matrix.format == "csr":
        matrix.indices = np.array([0, -1], dtype=np.int32)
    else:
        matrix.coords = (matrix.coords[0], np.array([0, 5], dtype=np.int32))
    with pytest.raises(ProblemError, match="`G` has an entry in column"):
        Problem(c=np.ones(2), G=matrix, h=np.ones(2), cones=Cones(l=2))


def test_the_matrices_of_a_problem_cannot_be_replaced() -> None:
    problem = Problem(c=[1.0])
    with pytest.raises((AttributeError, TypeError)):  # which of them is up to the version of Python
        setattr(problem, "A", csc.empty(0, 1))  # noqa: B010 - a type checker refuses the assignment
