"""`Solver.update`: the quick way in for plain arrays, the checked way for all else, one meaning."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import orbsoc
from orbsoc.conic.problem import Cones, Problem

DATA = ("c", "A", "b", "G", "h")


def case(seed: int) -> Problem:
    """One sparsity pattern, a row of h absent, numbers by `seed`."""
    rng = np.random.default_rng(seed)
    A = sparse.csc_array(np.array([[1.0, 0.0, 2.0]])) * rng.uniform(1.0, 2.0)
    G = sparse.csc_array(np.vstack([-np.eye(3), [1.0, 1.0, 0.0], np.zeros((1, 3)), -np.eye(3)]))
    G.data = G.data * rng.uniform(0.5, 1.5, size=G.nnz)
    h = np.concatenate([rng.uniform(1.0, 2.0, size=3), [np.inf], [9.0], rng.uniform(size=3)])
    return Problem(
        c=rng.normal(size=3), A=A, b=rng.uniform(size=1), G=G, h=h, cones=Cones(l=4, q=[4]), P=np.eye(3)
    )


def data(problem: Problem) -> dict[str, Any]:
    return {name: getattr(problem, name) for name in DATA}


def bits(solution: orbsoc.Solution) -> tuple[bytes, ...]:
    return tuple(getattr(solution, name).tobytes() for name in "xyzs")


WAYS: list[Callable[[Problem], dict[str, Any]]] = [
    data,
    lambda p: data(p) | {"P": p.P},
    lambda p: {name: value.tolist() for name, value in data(p).items() if name in "cbh"} | {"A": p.A, "G": p.G},
    lambda p: data(p) | {"c": np.repeat(p.c, 2)[::2]},
    lambda p: data(p) | {"h": p.h.astype(">f8")},
    lambda p: data(p) | {"G": p.G.tocsr()},
    lambda p: data(p) | {"A": p.A.toarray()},
    lambda p: data(p) | {"G": sparse.csc_matrix(p.G)},
]  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_every_way_of_giving_the_numbers_solves_like_a_fresh_solver(
    way: Callable[[Problem], dict[str, Any]],
) -> None:
    solver = orbsoc.Solver(case(0))
    solver.solve()
    solver.update(**way(case(1)))
    assert bits(solver.solve()) == bits(orbsoc.solve(case(1)))
    for name in DATA:
        found, wanted = getattr(solver.problem, name), getattr(case(1), name)
        assert np.array_equal(
            *(v.toarray() if sparse.issparse(v) else np.asarray(v) for v in (found, wanted))
        )


def test_parts_replaced_one_after_the_other_add_up() -> None:
    solver = orbsoc.Solver(case(0))
    for name, value in data(case(2)).items():
        solver.update(**{name: value})
    assert bits(solver.solve()) == bits(orbsoc.solve(case(2)))
    solver.update()
    assert bits(solver.solve()) == bits(orbsoc.solve(case(2)))


def test_the_numbers_are_copied_where_the_cost_matrix_comes_with_them() -> None:
    problem = orbsoc.Problem(P=np.eye(2), c=[1.0, 1.0], G=-np.eye(2), h=[5.0, 5.0], cones=orbsoc.Cones(l=2))
    solver, buffer = orbsoc.Solver(problem), np.array([1.0, 2.0])
    curvature = sparse.csc_array(2.0 * np.eye(2))
    solver.update(P=curvature, c=buffer)
    buffer[:] = np.nan
    curvature.data[:] = 7.0
    solver.update(h=[4.0, 4.0])
    assert solver.solve().x == pytest.approx([-0.5, -1.0], abs=1e-7)
    assert solver.problem.c.tolist() == [1.0, 2.0]
    assert solver.problem.P.data.tolist() == [2.0, 2.0]


def test_the_numbers_are_copied() -> None:
    solver, other = orbsoc.Solver(case(0)), case(1)
    given = data(other)
    given["c"], kept = given["c"].copy(), given["c"]
    solver.update(**given)
    given["c"][:] = 1e9
    assert bits(solver.solve()) == bits(orbsoc.solve(case(1)))
    assert solver.problem.c.tobytes() == kept.tobytes()
    solver.update(b=other.b)
    assert bits(solver.solve()) == bits(orbsoc.solve(case(1)))


def csc_of_masked() -> Any:
    G = case(0).G.copy()  # type: ignore[attr-defined]
    G.data = np.ma.array(G.data, mask=np.arange(G.nnz) == 1)
    return G


SPOILED: list[tuple[dict[str, Any], str]] = [
    ({"c": np.array([1.0, np.nan, 0.0])}, r"`c\[1\]` is nan"),
    ({"c": np.zeros(2)}, "`c` has 2 entries, but the solver was set up for 3"),
    ({"h": np.full(8, np.inf)}, r"`h\[4\]` is inf"),
    ({"h": np.ones(8)}, r"`h` is \+∞ in other rows"),
    ({"G": csc_of_masked()}, "`G` has masked entries"),
    ({"b": np.array(["x"])}, "`b` has entries of type"),
    ({"c": np.ma.array([1.0, 2.0, 0.0], mask=[False, True, False])}, "`c` has masked entries"),
    ({"G": sparse.csc_array(np.ones((8, 3)))}, "`G` does not have the sparsity pattern .* for$"),
    ({"G": np.ones((8, 3))}, "`G` does not have the sparsity pattern .* for$"),
    ({"G": np.zeros((8, 3))}, "a zero of a dense matrix is no entry"),
    ({"A": sparse.csc_array((1, 2))}, r"`A` has shape \(1, 2\)"),
    ({"A": sparse.csc_array(np.array([[1.0, 0.0, np.inf]]))}, r"`A\[0, 2\]` is inf"),
    ({"P": -np.eye(3)}, "`P` is not positive semidefinite"),
]


@pytest.mark.parametrize(("spoiled", "message"), SPOILED)
def test_what_is_refused_replaces_nothing(spoiled: dict[str, Any], message: str) -> None:
    """The good data of the same call come first, and are not kept either."""
    solver = orbsoc.Solver(case(0))
    good = {name: value for name, value in data(case(1)).items() if name not in spoiled}
    with pytest.raises(orbsoc.ProblemError, match=message):
        solver.update(**good, **spoiled)
    assert bits(solver.solve()) == bits(orbsoc.solve(case(0)))
    assert solver.problem.c.tobytes() == case(0).c.tobytes()


def test_an_unknown_name_is_refused_and_replaces_nothing() -> None:
    solver = orbsoc.Solver(case(0))
    with pytest.raises(TypeError, match="no data named 'g'"):
        solver.update(c=case(1).c, g=case(1).h)
    assert bits(solver.solve()) == bits(orbsoc.solve(case(0)))


@pytest.mark.parametrize("again", [copy.deepcopy, lambda solver: pickle.loads(pickle.dumps(solver))])
def test_a_copy_of_a_solver_has_its_numbers_its_settings_and_its_last_solution(
    again: Callable[[orbsoc.Solver], orbsoc.Solver],
) -> None:
    solver = orbsoc.Solver(case(0), tol=1e-6)
    solver.update(**data(case(1)))
    solver.solve()
    other = again(solver)
    solver.update(**data(case(2)))
    assert other.settings == solver.settings
    assert bits(other.solve()) == bits(orbsoc.solve(case(1), tol=1e-6)) != bits(solver.solve())
    other = again(solver)
    assert bits(other.solve(warm_start=True)) == bits(solver.solve(warm_start=True))
