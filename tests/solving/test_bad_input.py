"""Awkward but legal data are solved rightly; what is not a problem never reaches the core.

Refusals at the door are in test_problem.py. Here is what passes it: rows of zeros, free columns, absent blocks, cones
of one row, odd memory layouts, and thousands of solves in one process.
"""

from __future__ import annotations

import copy
import pickle
import re
import resource
import threading
from collections.abc import Callable
from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import sparse as scipy_sparse

import orbsoc
from orbsoc import Cones, Problem, Settings, Status, _core
from orbsoc.conic.settings import COUNTS

sparse: Any = scipy_sparse  # published without types

INF = float("inf")
X_ABOVE_ONE: dict[str, Any] = {"G": [[-1.0, 0.0]], "h": [-1.0], "cones": Cones(l=1)}

LEGAL: list[tuple[str, dict[str, Any], Status, float | None]] = [
    ("nothing but a zero cost", {"c": [0.0, 0.0]}, Status.SOLVED, 0.0),
    ("nothing but a cost", {"c": [1.0, 0.0]}, Status.DUAL_INFEASIBLE, None),
    ("a quadratic cost alone", {"P": np.eye(2), "c": [1.0, -2.0]}, Status.SOLVED, -2.5),
    ("a free column without cost", {"c": [1.0, 0.0], **X_ABOVE_ONE}, Status.SOLVED, 1.0),
    ("a free column with a cost", {"c": [1.0, 1e-3], **X_ABOVE_ONE}, Status.DUAL_INFEASIBLE, None),
    ("an equality 0 = 0", {"c": [1.0, 0.0], "A": np.zeros((1, 2)), "b": [0.0], **X_ABOVE_ONE}, Status.SOLVED, 1.0),
    (
        "an equality 0 = 1e-3",
        {"c": [1.0, 0.0], "A": np.zeros((1, 2)), "b": [1e-3], **X_ABOVE_ONE},
        Status.PRIMAL_INFEASIBLE,
        None,
    ),
    (
        "a row 0 ≤ 1",
        {"c": [1.0, 0.0], "G": [[-1.0, 0.0], [0.0, 0.0]], "h": [-1.0, 1.0], "cones": Cones(l=2)},
        Status.SOLVED,
        1.0,
    ),
    (
        "a row 0 ≤ 0",
        {"c": [1.0, 0.0], "G": [[-1.0, 0.0], [0.0, 0.0]], "h": [-1.0, 0.0], "cones": Cones(l=2)},
        Status.SOLVED,
        1.0,
    ),
    (
        "a row 0 ≤ −1",
        {"c": [1.0, 0.0], "G": [[-1.0, 0.0], [0.0, 0.0]], "h": [-1.0, -1.0], "cones": Cones(l=2)},
        Status.PRIMAL_INFEASIBLE,
        None,
    ),
    (
        "a cone without variables that holds",
        {"c": [1.0], "G": [[-1.0], [0.0], [0.0]], "h": [0.0, 2.0, 1.0], "cones": Cones(l=1, q=[2])},
        Status.SOLVED,
        0.0,
    ),
    (
        "a cone without variables that fails",
        {"c": [1.0], "G": [[-1.0], [0.0], [0.0]], "h": [0.0, 1.0, 2.0], "cones": Cones(l=1, q=[2])},
        Status.PRIMAL_INFEASIBLE,
        None,
    ),
    ("a cone of one row", {"c": [1.0], "G": [[-1.0]], "h": [-3.0], "cones": Cones(q=[1])}, Status.SOLVED, 3.0),
    (
        "rows that do not constrain",
        {"P": [[1.0]], "c": [1.0], "G": [[-1.0], [1.0]], "h": [INF, INF], "cones": Cones(l=2)},
        Status.SOLVED,
        -0.5,
    ),
    (
        "the same equality twice",
        {"c": [1.0, 0.0], "A": [[0.0, 1.0], [0.0, 1.0]], "b": [4.0, 4.0], **X_ABOVE_ONE},
        Status.SOLVED,
        1.0,
    ),
    (
        "two equalities that disagree",
        {"c": [1.0, 0.0], "A": [[0.0, 1.0], [0.0, 1.0]], "b": [4.0, 5.0], **X_ABOVE_ONE},
        Status.PRIMAL_INFEASIBLE,
        None,
    ),
    ("more equalities than variables", {"c": [1.0], "A": [[1.0], [2.0], [3.0]], "b": [2.0, 4.0, 6.0]}, Status.SOLVED, 2.0),
    ("explicit zeros only", {"c": [0.0], "A": sparse.csc_array(([0.0], ([0], [0])), shape=(1, 1)), "b": [0.0]}, Status.SOLVED, 0.0),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "status", "objective"), [row[1:] for row in LEGAL], ids=[row[0] for row in LEGAL])  # fmt: skip
def test_awkward_but_legal_data_are_solved_rightly(
    arguments: dict[str, Any], status: Status, objective: float | None
) -> None:
    solution = orbsoc.solve(Problem(**arguments))
    assert solution.status is status, solution.message
    if objective is not None:
        assert solution.objective == pytest.approx(objective, abs=1e-7)


def layouts() -> dict[str, Callable[[Any], Any]]:
    """The same matrix in other memory."""

    def read_only(matrix: Any) -> Any:
        out = sparse.csc_array(matrix)
        for array in (out.data, out.indices, out.indptr):
            array.setflags(write=False)
        return out

    def wide_indices(matrix: Any) -> Any:
        out = sparse.csc_array(matrix)
        out.indices, out.indptr = out.indices.astype(np.int64), out.indptr.astype(np.int64)
        return out

    def halved_duplicates(matrix: Any) -> Any:
        once = sparse.coo_array(matrix)
        rows, columns = (np.tile(index, 2)[::-1] for index in once.coords)
        return sparse.coo_array((np.tile(once.data / 2, 2)[::-1], (rows, columns)), shape=once.shape)

    return {
        "read-only": read_only,
        "int64 indices": wide_indices,
        "duplicates, unsorted": halved_duplicates,
        "Fortran order": np.asfortranarray,
        "a strided view": lambda matrix: np.repeat(np.repeat(matrix, 2, axis=0), 3, axis=1)[::2, ::3],
        "single precision": lambda matrix: np.asarray(matrix, dtype=np.float32),
    }


@pytest.mark.parametrize("layout", layouts().values(), ids=layouts())
def test_memory_layout_changes_no_bit(layout: Callable[[Any], Any]) -> None:
    P, A = np.array([[2.0, 0.5], [0.5, 1.0]]), np.array([[1.0, -1.0]])
    G, h = np.array([[0.0, 0.0], [-1.0, 0.0], [0.0, -2.0]]), np.array([2.0, 0.25, -0.5])
    kwargs: dict[str, Any] = {"c": [1.0, 1.0], "b": [0.5], "h": h, "cones": Cones(q=[3])}
    plain = orbsoc.solve(Problem(P=P, A=A, G=G, **kwargs))
    again = orbsoc.solve(Problem(P=layout(P), A=layout(A), G=layout(G), **kwargs))
    assert plain.status is again.status is Status.SOLVED
    assert all(getattr(plain, name).tobytes() == getattr(again, name).tobytes() for name in "xyzs")


@pytest.mark.parametrize("name", ["c", "G", "h"])
def test_masked_entries_are_no_numbers(name: str) -> None:
    data: dict[str, Any] = {"c": np.ones(2), "G": -np.eye(2), "h": np.zeros(2)}
    first = np.arange(data[name].size).reshape(data[name].shape) == 0
    unmasked, hidden = np.ma.array(data[name]), np.ma.array(data[name], mask=first)
    assert orbsoc.solve(Problem(**data | {name: unmasked}, cones=Cones(l=2))).status is Status.SOLVED
    with pytest.raises(orbsoc.ProblemError, match=f"`{name}` has masked entries"):
        Problem(**data | {name: hidden}, cones=Cones(l=2))
    with pytest.raises(orbsoc.ProblemError, match=f"`{name}` has masked entries"):
        Problem(**data | {name: list(hidden) if name == "G" else hidden}, cones=Cones(l=2))
    with pytest.raises(orbsoc.ProblemError, match="`c` has masked entries"):
        orbsoc.solve_batch(Problem(**data, cones=Cones(l=2)), c=np.ma.array([[1.0, 2.0]], mask=[[0, 1]]))


def test_a_finite_number_beyond_double_precision_is_no_absent_row() -> None:
    far = np.array([np.longdouble("0.0"), np.longdouble("1e400")])
    if np.isinf(far[1]):
        pytest.skip("long double is double here")
    with pytest.raises(orbsoc.ProblemError, match=r"`h\[1\]` is 1e\+400, beyond double precision"):
        Problem(c=[1.0], G=[[-1.0], [1.0]], h=far, cones=Cones(l=2))


def test_a_batch_of_matrices_is_rows_of_their_entries() -> None:
    problem = Problem(c=np.ones(2), G=-np.eye(2), h=np.zeros(2), cones=Cones(l=2))
    with pytest.raises(orbsoc.ProblemError, match="`G` is a sparse matrix; it must be an array of numbers"):
        orbsoc.solve_batch(problem, G=problem.G)


def test_read_only_vectors_are_solved() -> None:
    c, h = np.array([1.0]), np.array([-2.0])
    for array in (c, h):
        array.setflags(write=False)
    assert orbsoc.solve(Problem(c=c, G=[[-1.0]], h=h, cones=Cones(l=1))).x == pytest.approx([2.0])


@pytest.mark.parametrize(
    ("overrides", "error", "message"),
    [
        ({"tol": "small"}, TypeError, "tol = 'small' must be a number"),
        ({"tol": None}, TypeError, "tol = None must be a number"),
        ({"tol": True}, TypeError, "tol = True must be a number"),
        ({"tol": float("nan")}, ValueError, "tol = nan must be a positive number"),
        ({"max_iterations": 2.5}, TypeError, "max_iterations = 2.5 must be an integer"),
        ({"max_iterations": 10**20}, ValueError, "max_iterations = 100000000000000000000 must be at least 1"),
        (
            {"max_iterations": 100_001},
            ValueError,
            "max_iterations = 100001 must be at least 1, at most 100000",
        ),
        ({"refinement_max": 101}, ValueError, "refinement_max = 101 must be at least 0, at most 100"),
        ({"tol": float("inf")}, ValueError, "tol = inf must be finite"),
        ({"tol": 10**400}, ValueError, "tol is too large"),
        ({"ruiz_passes": -1}, ValueError, "ruiz_passes = -1 must be at least 0"),
        ({"refinement_max": -1}, ValueError, "refinement_max = -1 must be at least 0"),
        ({"verbose": "yes"}, TypeError, "verbose = 'yes' must be True or False"),
        ({"tolerance": 1e-8}, TypeError, "tolerance"),
    ],
)
def test_a_wrong_setting_is_refused_by_name(
    overrides: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        orbsoc.solve(Problem(c=[0.0]), **overrides)


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), 1.0])
@pytest.mark.parametrize("name", [field.name for field in fields(Settings) if field.type == "float"])
def test_numbers_that_the_core_would_refuse_are_refused_at_once(name: str, value: float) -> None:
    as_it_is = SimpleNamespace(
        **{f.name: getattr(Settings(), f.name) for f in fields(Settings)} | {name: value}
    )
    try:
        _core.Engine(Problem(c=[0.0]), as_it_is)
    except _core.CoreError:
        with pytest.raises(ValueError, match=rf"settings: {name} = {value!r} must be"):
            Settings(**{name: value})
    else:
        assert getattr(Settings(**{name: value}), name) == value


def test_numpy_numbers_are_settings() -> None:
    assert Settings(tol=np.float32(0.5), max_iterations=np.int64(7)) == Settings(tol=0.5, max_iterations=7)


def test_the_largest_counts_are_the_core_s() -> None:
    largest = {name: most for name, (_, most) in COUNTS.items()}
    assert orbsoc.solve(Problem(c=[0.0]), **largest).status is orbsoc.Status.SOLVED


def test_a_solver_keeps_its_settings() -> None:
    solver = orbsoc.Solver(Problem(c=[0.0]), tol=1e-6)
    with pytest.raises(AttributeError, match="settings"):
        solver.settings = Settings()  # type: ignore[misc]
    assert solver.settings.tol == 1e-6


def test_what_is_no_problem_or_no_settings_is_a_type_error() -> None:
    with pytest.raises(TypeError, match=r"`cones` is of type dict; it must be an orbsoc\.Cones"):
        Problem(c=[0.0], cones={"l": 0})
    with pytest.raises(TypeError, match="`callback` is 3; it must be callable"):
        orbsoc.solve(Problem(c=[0.0]), callback=3)
    with pytest.raises(TypeError, match=r"`problem` is of type dict; it must be an orbsoc\.Problem"):
        orbsoc.solve({"c": [1.0]})
    with pytest.raises(TypeError, match=r"`settings` is of type float; it must be an orbsoc\.Settings"):
        orbsoc.solve(Problem(c=[0.0]), 1e-8)


def test_an_exception_of_a_callback_comes_out_and_the_solver_stays_usable() -> None:
    problem = Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=Cones(l=1))
    solver = orbsoc.Solver(problem)

    def fail(_: object) -> None:
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        solver.solve(callback=fail)
    assert solver.solve().x.tobytes() == orbsoc.solve(problem).x.tobytes()


def test_a_solution_belongs_to_its_holder() -> None:
    """Writing into a returned vector changes no later solve and no other copy."""
    solver = orbsoc.Solver(Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=Cones(l=1)))
    first = solver.solve()
    kept = pickle.loads(pickle.dumps(first)).x, copy.deepcopy(first).x
    first.x[:] = 77.0
    second = solver.solve()
    assert second.x.tobytes() == kept[0].tobytes() == kept[1].tobytes()


def test_threads_that_share_nothing_get_the_same_bits() -> None:
    rng = np.random.default_rng(0)
    G = rng.normal(size=(60, 20))
    problem = Problem(c=-G.T @ np.ones(60), G=G, h=np.ones(60), cones=Cones(l=20, q=[20, 20]))
    expected = orbsoc.solve(problem).x.tobytes()
    found: list[bytes] = []
    threads = [
        threading.Thread(target=lambda: found.append(orbsoc.solve(problem).x.tobytes())) for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found == [expected] * 8


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"c": [1.0]}, "`c` has 1 entries, but the solver was set up for 2"),
        ({"h": np.zeros(3)}, "`h` has 3 entries, but the solver was set up for 2"),
        ({"b": [1.0]}, "`b` has 1 entries, but the solver was set up for 0"),
        ({"G": np.eye(3)}, "`G` has shape (3, 3), but the solver was set up for (2, 2)"),
        ({"P": sparse.eye_array(1)}, "`P` has shape (1, 1), but the solver was set up for (2, 2)"),
        ({"c": [[1.0, 2.0]]}, "`c` has shape (1, 2); it must be one-dimensional"),
    ],
)
def test_an_update_of_another_size_names_the_argument_and_both_sizes(
    data: dict[str, Any], message: str
) -> None:
    solver = orbsoc.Solver(Problem(c=[1.0, 2.0], G=-np.eye(2), h=[0.0, 0.0], cones=Cones(l=2)))
    with pytest.raises(orbsoc.ProblemError, match=f"^{re.escape(message)}$"):
        solver.update(**data)
    assert solver.solve().status is orbsoc.Status.SOLVED


def test_thousands_of_solves_keep_no_memory() -> None:
    """Each engine here holds over 300 kB: kept ones would show by hundreds of MB."""
    rng = np.random.default_rng(1)
    G = rng.normal(size=(120, 40))
    problem = Problem(c=-G.T @ np.ones(120), G=G, h=np.ones(120), cones=Cones(l=120))

    def churn(times: int) -> None:
        for _ in range(times):
            solver = orbsoc.Solver(problem, max_iterations=1)
            solver.update(c=problem.c)
            solver.solve()

    churn(50)
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    churn(1000)
    grown_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb
    assert grown_kb < 20_000


@pytest.mark.parametrize("part", ["indptr", "indices", "data"])
@pytest.mark.parametrize("kind", ["f8", "i8"])
@pytest.mark.parametrize("form", ["csc", "csr"])
def test_a_sparse_matrix_with_an_array_missing_is_refused_by_name(part: str, kind: str, form: str) -> None:
    """SciPy's own complaint would be an IndexError from wherever it first looks."""
    matrix = sparse.coo_array(np.ones((3, 2), dtype=kind)).asformat(form)
    setattr(matrix, part, getattr(matrix, part)[:0])
    with pytest.raises(orbsoc.ProblemError, match="`G` has"):
        Problem(c=np.ones(2), G=matrix, h=np.zeros(3), cones=Cones(l=3))


@pytest.mark.parametrize(
    ("part", "row", "said"),
    [
        ("rows", [5, 1], "an entry in column 5, but only 2 columns"),
        ("rows", [-1, 1], "an entry in column -1"),
        ("data", [1.0], "2 indices for 1 entries in row 1"),
    ],
)
def test_lists_that_do_not_fit_are_refused(part: str, row: list[float], said: str) -> None:
    """SciPy writes beside its arrays."""
    matrix = sparse.lil_array(np.ones((3, 2)))
    getattr(matrix, part)[1] = row
    with pytest.raises(orbsoc.ProblemError, match=said):
        Problem(c=np.ones(2), G=matrix, h=np.zeros(3), cones=Cones(l=3))


@pytest.mark.parametrize(
    ("form", "part", "values", "said"),
    [
        ("csr", "indptr", [0, 2, 4, 9], "row pointers do not ascend"),
        ("csr", "indptr", [1, 2, 4, 6], "row pointers do not ascend"),
        ("csr", "indptr", [0, 5, 4, 6], "row pointers do not ascend"),
        ("csr", "indices", [0, 1, 0, 1, 0, 7], "an entry in column 7, but only 2 columns"),
        ("csr", "indices", [0, 1, 0, 1, 0, -2], "an entry in column -2"),
        ("coo", "row", [0, 0, 1, 1, 2, 3], "an entry in row 3, but only 3 rows"),
        ("coo", "col", [0, 1, 0, 1, 0, -1], "an entry in column -1"),
        ("coo", "data", [1.0], "6 indices for 1 entries"),
        ("bsr", "indptr", [0, 2, 4, 9], "no BSR matrix"),
        ("csc", "indptr", [0, 3, 9], "column pointers do not ascend"),
    ],
)
def test_indices_that_do_not_fit_are_refused_before_entries_are_lost(
    form: str, part: str, values: list[float], said: str
) -> None:
    """SciPy converts such a matrix into another one, without an error."""
    matrix = sparse.coo_matrix(np.ones((3, 2)))
    matrix = sparse.bsr_matrix(matrix, blocksize=(1, 1)) if form == "bsr" else matrix.asformat(form)
    setattr(matrix, part, np.array(values, dtype=getattr(matrix, part).dtype))
    with pytest.raises(orbsoc.ProblemError, match=said):
        Problem(c=np.ones(2), G=matrix, h=np.zeros(3), cones=Cones(l=3))
