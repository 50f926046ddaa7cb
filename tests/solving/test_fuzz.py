"""Whatever is handed to the Python entry points: an answer that its numbers support, or an error that names the input.

Bounded, with a fixed seed (`make fuzz`: many more, with new ones); a watchdog ends the run with a traceback if something hangs, also inside the core.
"""

from __future__ import annotations

import dataclasses
import faulthandler
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse as scipy_sparse

import orbsoc
from orbsoc.conic.errors import FileError
from orbsoc.conic.verify import check_certificate
from orbsoc.solving.bundle import read_bundle
from tests.fuzz_budget import TIMES, fuzz_budget
from tests.strategies import problems

sparse: Any = scipy_sparse  # published without types

HANG_S = 300.0
CLAIMS = (orbsoc.Status.PRIMAL_INFEASIBLE, orbsoc.Status.DUAL_INFEASIBLE)


@pytest.fixture(autouse=True)
def _watchdog() -> Iterator[None]:
    faulthandler.dump_traceback_later(HANG_S * max(1, TIMES), exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


def false_claim(problem: orbsoc.Problem, solution: orbsoc.Solution) -> str | None:
    """What is wrong with the status of a solution, judged on the problem's own data."""
    sizes = {"x": problem.n, "y": problem.p, "z": problem.m, "s": problem.m}
    if any(getattr(solution, name).shape != (size,) for name, size in sizes.items()):
        return "a vector has the wrong size"
    if solution.status is orbsoc.Status.SOLVED:
        worst = orbsoc.verify(problem, solution).worst
        return None if worst <= 1e-5 else f"SOLVED, but verification finds {worst}"
    if solution.status is orbsoc.Status.SOLVED_INACCURATE or solution.status in CLAIMS:
        residuals = check_certificate(problem, solution)
        return None if residuals.supports(solution.status, 1.001e-5) else f"{solution.status}: {residuals}"
    return None


@given(problems())
@fuzz_budget(400)
def test_no_status_is_claimed_without_support(problem: orbsoc.Problem) -> None:
    """Entries over 16 decades, absent blocks, infinite bounds."""
    assert false_claim(problem, orbsoc.solve(problem)) is None


@st.composite
def extreme(draw: st.DrawFn) -> orbsoc.Problem:
    """Any finite doubles at all, subnormal to 1e308."""
    doubles = st.floats(allow_nan=False, allow_infinity=False, allow_subnormal=True)
    n, p, l = draw(st.integers(1, 3)), draw(st.integers(0, 2)), draw(st.integers(0, 3))
    q = draw(st.lists(st.integers(1, 4), max_size=2))
    m = l + sum(q)

    def numbers(*shape: int) -> Any:
        size = int(np.prod(shape))
        return np.array(draw(st.lists(doubles, min_size=size, max_size=size)), dtype=float).reshape(shape)

    P = np.diag(np.abs(numbers(n))) if draw(st.booleans()) else None
    return orbsoc.Problem(
        P=P,
        c=numbers(n),
        A=numbers(p, n),
        b=numbers(p),
        G=numbers(m, n),
        h=numbers(m),
        cones=orbsoc.Cones(l, q),
    )


@given(extreme())
@fuzz_budget(300)
def test_the_ends_of_double_precision_break_nothing(problem: orbsoc.Problem) -> None:
    assert false_claim(problem, orbsoc.solve(problem)) is None


@st.composite
def solvable(draw: st.DrawFn) -> orbsoc.Problem:
    """Small integers with rows of zeros, free columns and dependent rows, built around a primal-dual solution."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, p, l = draw(st.integers(1, 8)), draw(st.integers(0, 5)), draw(st.integers(0, 8))
    q = draw(st.lists(st.integers(1, 5), max_size=3))
    cones = orbsoc.Cones(l, q)
    full = rng.integers(0, 2, size=l).astype(float)  # which R₊ rows are slack
    s, z = [full * rng.integers(1, 4, size=l)], [(1 - full) * rng.integers(0, 4, size=l)]
    for size in q:
        direction = rng.integers(-2, 3, size=size - 1)
        reach = float(np.ceil(np.linalg.norm(direction)))
        slack = draw(st.booleans())
        inside = np.array([reach + 1.0, *direction])
        s.append(inside if slack else np.zeros(size))
        z.append(np.zeros(size) if slack else inside)
    A, G = rng.integers(-2, 3, size=(p, n)) * 1.0, rng.integers(-2, 3, size=(cones.m, n)) * 1.0
    A[rng.random(p) < 0.2] = 0.0
    G[rng.random(cones.m) < 0.2] = 0.0
    free = rng.random(n) < 0.1
    A[:, free], G[:, free] = 0.0, 0.0
    factor = rng.integers(-1, 2, size=(draw(st.integers(0, n)), n)) * 1.0
    P = factor.T @ factor
    x, y = rng.integers(-3, 4, size=n) * 1.0, rng.integers(-3, 4, size=p) * 1.0
    s_all, z_all = np.concatenate(s), np.concatenate(z)
    c = -(P @ x + A.T @ y + G.T @ z_all)
    return orbsoc.Problem(P=P, c=c, A=A, b=A @ x, G=G, h=G @ x + s_all, cones=cones)


@given(solvable())
@fuzz_budget(400)
def test_a_problem_with_a_known_solution_is_solved(problem: orbsoc.Problem) -> None:
    solution = orbsoc.solve(problem)
    assert solution.status in (orbsoc.Status.SOLVED, orbsoc.Status.SOLVED_INACCURATE), solution.message
    assert false_claim(problem, solution) is None


@given(problems(), problems())
@fuzz_budget(100)
def test_an_update_solves_like_a_fresh_solver_or_changes_nothing(
    one: orbsoc.Problem, other: orbsoc.Problem
) -> None:
    solver = orbsoc.Solver(one, max_iterations=8)
    try:
        solver.update(**{name: getattr(other, name) for name in "PcAbGh"})
        expected = orbsoc.solve(solver.problem, max_iterations=8)
    except orbsoc.ProblemError:
        expected = orbsoc.solve(one, max_iterations=8)
    found = solver.solve()
    assert found.status is expected.status
    assert all(getattr(found, name).tobytes() == getattr(expected, name).tobytes() for name in "xyzs")


scalars = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=4), st.complex_numbers(), st.binary(max_size=4)
)  # fmt: skip


@st.composite
def garbage(draw: st.DrawFn) -> Any:
    """Scalars, lists of unequal rows, arrays of any kind and shape, sparse matrices with broken insides."""
    kind = draw(st.integers(0, 4))
    if kind == 0:
        return draw(scalars)
    if kind == 1:
        return draw(st.recursive(scalars, lambda inner: st.lists(inner, max_size=3), max_leaves=8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    shape = tuple(draw(st.lists(st.integers(0, 3), max_size=3)))
    dtype = draw(st.sampled_from(["f8", "f4", "f2", "i8", "i1", "u4", "?", "c16", "O", "U3", "M8[s]"]))
    array = rng.integers(-2, 3, size=shape).astype(dtype)
    if kind == 2 or len(shape) != 2 or dtype in ("O", "U3", "M8[s]", "f2"):
        return array
    matrix = sparse.coo_array(array).asformat(draw(st.sampled_from(["csc", "csr", "coo"])))
    if kind == 4 and matrix.format == "csc":
        part = draw(st.sampled_from(["indices", "indptr", "data"]))
        values = getattr(matrix, part)
        setattr(matrix, part, rng.integers(-3, 9, size=rng.integers(0, 6)).astype(values.dtype))
    return matrix


NAMES = ("P", "c", "A", "b", "G", "h")


@given(
    st.dictionaries(st.sampled_from(NAMES), garbage(), max_size=6),
    st.lists(st.one_of(st.integers(-2, 6), scalars), max_size=3),
    scalars,
)
@fuzz_budget(600)
def test_garbage_is_a_problem_or_an_error_that_names_an_argument(
    arguments: dict[str, Any], q: list[Any], l: Any
) -> None:
    base = {"c": np.ones(2), "G": -np.eye(2), "h": np.zeros(2)} | arguments
    try:
        cones = orbsoc.Cones(l=l, q=q) if q else orbsoc.Cones(l=2)
        problem = orbsoc.Problem(**base, cones=cones)
    except orbsoc.ProblemError as refused:
        named = "`" in str(refused)
        assert named
    else:
        assert false_claim(problem, orbsoc.solve(problem)) is None


SETTINGS = [field.name for field in dataclasses.fields(orbsoc.Settings) if field.name != "verbose"]


@given(st.dictionaries(st.sampled_from(SETTINGS), scalars, min_size=1, max_size=3))
@fuzz_budget(300)
def test_a_setting_is_obeyed_or_refused_by_name(overrides: dict[str, Any]) -> None:
    problem = orbsoc.Problem(c=[1.0, 1.0], G=-np.eye(2), h=[-1.0, 2.0], cones=orbsoc.Cones(q=[2]))
    bounds = {"max_iterations": 50, "refinement_max": 50, "ruiz_passes": 50}
    overrides = {
        name: min(value, bounds[name]) if name in bounds and type(value) is int else value
        for name, value in overrides.items()
    }
    try:
        solution = orbsoc.solve(problem, **overrides)
    except (TypeError, ValueError) as refused:
        named = any(name in str(refused) for name in overrides)
        assert named
    else:
        tol = max(overrides.get("tol", 1e-8), overrides.get("tol_inaccurate", 1e-5))
        if solution.status is orbsoc.Status.SOLVED and tol <= 1e-5:
            assert false_claim(problem, solution) is None


@st.composite
def damaged(draw: st.DrawFn, document: Any) -> Any:
    """A JSON document with one value anywhere replaced, removed or doubled."""
    here = document
    while True:
        keys = list(here) if isinstance(here, dict) else list(range(len(here)))
        if not keys:
            return document
        key = draw(st.sampled_from(keys))
        value = here[key]
        if not isinstance(value, dict | list) or draw(st.integers(0, 3)) == 0:
            break
        here = value
    replacement = draw(
        st.one_of(scalars.filter(lambda v: not isinstance(v, bytes | complex)), st.just([value]))
    )
    if isinstance(here, list) and draw(st.booleans()):
        here.append(replacement)
    else:
        here[key] = replacement
    return document


@given(st.data())
@fuzz_budget(300)
def test_a_damaged_file_is_read_or_refused_by_its_path(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    folder = tmp_path_factory.mktemp("damaged")
    problem = orbsoc.Problem(
        P=np.eye(2),
        c=[1.0, 1.0],
        A=[[1.0, 0.0]],
        b=[0.5],
        G=-np.eye(2),
        h=[-1.0, 2.0],
        cones=orbsoc.Cones(q=[2]),
    )
    solution = orbsoc.solve(problem, max_iterations=2, bundle=folder / "bundle.json")
    problem.save(folder / "problem.json")
    solution.save(folder / "solution.json")
    readers: dict[str, Any] = {
        "problem.json": orbsoc.Problem.load,
        "solution.json": orbsoc.Solution.load,
        "bundle.json": read_bundle,
    }
    name = data.draw(st.sampled_from(sorted(readers)))
    path = folder / name
    path.write_text(json.dumps(data.draw(damaged(json.loads(path.read_text())))))
    read_or_refused(readers[name], path)


@given(st.sampled_from(["problem", "solution", "bundle"]), st.one_of(st.binary(), st.text().map(str.encode)))
@fuzz_budget(150)
def test_a_file_of_noise_is_refused_by_its_path(
    tmp_path_factory: pytest.TempPathFactory, kind: str, noise: bytes
) -> None:
    path = tmp_path_factory.mktemp("noise") / "x.json"
    path.write_bytes(noise)
    reader = {"problem": orbsoc.Problem.load, "solution": orbsoc.Solution.load, "bundle": read_bundle}[kind]
    assert not read_or_refused(reader, path)


def read_or_refused(reader: Any, path: Path) -> bool:
    """Whether the file was read; if not, the error was typed and named it."""
    try:
        reader(path)
    except (orbsoc.ProblemError, FileError) as refused:
        named = str(refused).startswith(str(path))
        assert named
        return False
    return True
