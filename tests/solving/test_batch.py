"""A batch gives every problem the answer, and the bits, of its own solve."""

from __future__ import annotations

import multiprocessing
import pickle
import signal
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import orbsoc
from orbsoc.conic.problem import Cones, Problem, ProblemError

BASE = Problem(
    P=np.diag([1.0, 0.5, 0.25]),
    c=[1.0, -2.0, 0.5],
    A=[[1.0, 1.0, 1.0]],
    b=[0.2],
    G=np.vstack([np.eye(3), np.zeros((1, 3)), -np.eye(3)]),
    h=[1.0, 1.0, 1.0, 2.0, 0.0, 0.0, 0.0],
    cones=Cones(l=3, q=[4]),
)


def random_rows(count: int, seed: int = 0) -> dict[str, np.ndarray]:
    """Random costs, right-hand sides and matrix values, some of them infeasible."""
    rng = np.random.default_rng(seed)
    b = rng.uniform(-1.0, 1.0, (count, 1))
    b[::7] = 50.0
    return {
        "c": rng.normal(size=(count, 3)) * 10.0 ** rng.integers(-3, 4, (count, 1)),
        "b": b,
        "h": BASE.h + np.pad(rng.uniform(0.0, 1.0, (count, 4)), ((0, 0), (0, 3))),
        "A": BASE.A.data * rng.uniform(0.5, 2.0, (count, BASE.A.nnz)),
        "G": BASE.G.data * rng.uniform(0.5, 2.0, (count, 1)),
        "P": BASE.P.data * rng.uniform(0.0, 2.0, (count, 1)),
    }


def own_problem(data: dict[str, np.ndarray], k: int) -> Problem:
    def matrix(name: str) -> sparse.csc_array:
        pattern = getattr(BASE, name)
        values = data[name][k] if name in data else pattern.data
        return sparse.csc_array((values, pattern.indices, pattern.indptr), shape=pattern.shape)

    vectors = {name: data[name][k] if name in data else getattr(BASE, name) for name in "cbh"}
    return Problem(P=matrix("P"), A=matrix("A"), G=matrix("G"), **vectors, cones=BASE.cones)


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("names", ["c", "bh", "AG", "cbhAGP"])
def test_every_row_has_the_bits_of_its_own_solve(names: str, threads: int) -> None:
    data = {name: value for name, value in random_rows(37).items() if name in names}
    batch = orbsoc.solve_batch(BASE, **data, threads=threads)
    assert len(batch) == 37
    for k in range(37):
        single = orbsoc.solve(own_problem(data, k))
        assert batch.status[k] is single.status
        assert batch.iterations[k] == single.iterations
        assert batch.message[k] == single.message
        for name in ("x", "y", "z", "s"):
            np.testing.assert_array_equal(getattr(batch, name)[k], getattr(single, name), strict=True)
        assert batch.objective[k] == single.objective


def test_infeasible_rows_are_found_and_change_no_other() -> None:
    batch = orbsoc.solve_batch(BASE, **random_rows(29))
    names = [status.name for status in batch.status]
    assert names.count("PRIMAL_INFEASIBLE") == len(range(0, 29, 7))
    assert names.count("SOLVED") == 29 - len(range(0, 29, 7))


def test_shapes_and_certificates_come_back_per_problem() -> None:
    batch = orbsoc.solve_batch(BASE, c=random_rows(5)["c"])
    assert (batch.x.shape, batch.y.shape, batch.z.shape, batch.s.shape) == ((5, 3), (5, 1), (5, 7), (5, 7))
    certificates = list(batch.certificates())
    assert len(certificates) == 5
    assert max(c.primal_residual for c in certificates) <= 1e-8
    assert batch.solve_s > 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "at least one of c, b, h, A, G, P"),
        ({"c": np.zeros(3)}, r"`c` has shape \(3,\); it must be \(B, 3\)"),
        ({"c": np.zeros((2, 4))}, r"`c` has shape \(2, 4\); it must be \(B, 3\)"),
        ({"c": np.zeros((2, 3)), "b": np.zeros((3, 1))}, "`c` has 2, `b` has 3"),
        ({"c": np.full((2, 3), np.nan)}, r"^problem 0 of the batch: `c` has NaN at entry 0"),
        ({"h": np.full((2, 7), np.inf)}, "`h` has inf at entry 3"),
        ({"c": np.zeros((1, 3)), "threads": 0}, "`threads` is 0"),
        ({"c": [["1", "2", "3"]]}, "`c` has entries of type <U1; they must be real numbers"),
        ({"c": [[1j, 2, 3]]}, "`c` has entries of type complex128; they must be real numbers"),
        ({"c": [[1.0, 2.0, 3.0], [1.0]]}, "`c` is not an array of numbers"),
        ({"c": sparse.eye_array(3)}, "`c` is a sparse matrix; it must be an array of numbers"),
        (
            {"P": [[1.0, 1.0, -1e-3]]},
            r"^problem 0 of the batch: `P` is not positive semidefinite: P\[2, 2\] is -0.001",
        ),
        ({"P": [[1.0, 1.0, np.nan]]}, r"^problem 0 of the batch: `P` has NaN"),
    ],
)
def test_misuse_names_the_argument(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        orbsoc.solve_batch(BASE, **arguments)


def test_all_numbers_are_looked_at_before_anything_is_solved() -> None:
    seen: list[Mapping[str, int]] = []
    rows = np.vstack([np.ones((3999, 3)), np.full((1, 3), np.nan)])
    with pytest.raises(ProblemError, match=r"^problem 3999 of the batch: `c` has NaN"):
        orbsoc.solve_batch(BASE, c=rows, callback=seen.append)
    assert not any(progress["ended"] for progress in seen)


def test_a_callback_is_asked_while_the_numbers_are_checked() -> None:
    """The last row is no cost that a problem may have: looked at to the end, the batch would be refused."""
    order, count = 150, 400
    base = Problem(P=np.eye(order) + 1.0, c=np.ones(order))
    rows = np.tile(base.P.data, (count, 1))
    rows[-1] *= -1.0
    batch = orbsoc.solve_batch(base, P=rows, callback=lambda progress: progress["ended"] == 0)
    assert {status.name for status in batch.status} == {"INTERRUPTED"}
    assert not batch.iterations.any()
    with pytest.raises(ProblemError, match=r"^problem 399 of the batch: `P` is not positive semidefinite"):
        orbsoc.solve_batch(base, P=rows)


COUPLED = Problem(P=[[2.0, 1.0], [1.0, 2.0]], c=[1.0, 1.0], G=np.eye(2), h=[1.0, 1.0], cones=Cones(l=2))


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ([2.0, 0.5, 1.0, 2.0], r"`P` is not symmetric: P\[\d, \d\] is "),
        ([2.0, 3.0, 3.0, 2.0], r"`P` is not positive semidefinite: P\[0, 1\] is 3.0"),
        ([-1.0, 0.0, 0.0, 2.0], r"`P` is not positive semidefinite: P\[0, 0\] is -1.0"),
    ],
)
def test_a_cost_that_no_problem_may_have_is_refused(row: list[float], message: str) -> None:
    """As it was not: minima that are none came back SOLVED."""
    with pytest.raises(ProblemError, match=f"^problem 1 of the batch: {message}"):
        orbsoc.solve_batch(COUPLED, P=[[2.0, 1.0, 1.0, 2.0], row])


@pytest.mark.parametrize("order", [3, 210])
def test_costs_of_any_size_that_are_convex_or_not_are_told_apart(order: int) -> None:
    """Singular ones, with a row of zeros, and just beyond: dense ones are looked at together."""
    rng = np.random.default_rng(order)
    flat = np.append(rng.normal(size=order - 1), 0.0)
    base = Problem(P=np.outer(flat, flat) + np.diag(flat != 0.0), c=np.zeros(order))
    convex = np.array([sparse.csc_array(np.outer(flat, flat)).data, 3.0 * base.P.data])
    assert [status.name for status in orbsoc.solve_batch(base, P=convex).status] == ["SOLVED", "SOLVED"]
    bent = sparse.csc_array(np.outer(flat, flat) - 1e-3 * np.diag(flat != 0.0)).data
    with pytest.raises(ProblemError, match=r"^problem 2 of the batch: `P` is not positive semidefinite"):
        orbsoc.solve_batch(base, P=[*convex, bent])


@pytest.mark.parametrize("size", [1e308, 5e-324])
def test_costs_at_the_ends_of_the_range_raise_no_warning(size: float) -> None:
    tiny, off = 5e-324, 0.5 * size
    batch = orbsoc.solve_batch(COUPLED, P=[[size, off, off, size], [1.0, 0.0, 0.0, 1.0]])
    assert batch.status[1] is orbsoc.Status.SOLVED
    with pytest.raises(ProblemError, match=r"^problem 0 of the batch: `P` is not positive semidefinite"):
        orbsoc.solve_batch(COUPLED, P=[[tiny, 1e300, 1e300, tiny]])


def test_a_cost_that_is_symmetric_but_for_rounding_is_averaged_as_a_problem_averages_it() -> None:
    row = [2.0, 1.0 + 4e-14, 1.0, 2.0]
    alone = orbsoc.solve(
        Problem(P=np.reshape(row, (2, 2)).T, c=[1.0, 1.0], G=np.eye(2), h=[1.0, 1.0], cones=Cones(l=2))
    )
    assert orbsoc.solve_batch(COUPLED, P=[row]).x[0].tobytes() == alone.x.tobytes()


def test_a_batch_of_none_is_empty() -> None:
    batch = orbsoc.solve_batch(BASE, c=np.zeros((0, 3)))
    assert len(batch) == 0
    assert batch.x.shape == (0, 3)


def test_rows_start_from_points_as_their_own_solves_do() -> None:
    """From near, from another's solution, and from no point at all."""
    data = {name: value for name, value in random_rows(29).items() if name in "cbh"}
    before = orbsoc.solve_batch(BASE, **data)
    moved = data | {"c": data["c"] * 1.001}
    points = orbsoc.Start(x=before.x.copy(), y=before.y, z=before.z.copy(), s=before.s)
    points.z[1::5] *= 1e9
    points.x[3] = np.nan
    batch = orbsoc.solve_batch(BASE, **moved, warm_start=points, threads=2)
    for k in range(29):
        point = orbsoc.Start(points.x[k], points.y[k], points.z[k], points.s[k])
        single = orbsoc.solve(own_problem(moved, k), warm_start=point)
        assert batch.status[k] is single.status
        assert (batch.warm_start[k], batch.iterations[k]) == (single.warm_start, single.iterations)
        assert batch.x[k].tobytes() == single.x.tobytes()
    assert set(batch.warm_start) == {"used", "fell_back"}
    assert before.warm_start == ["none"] * 29
    good = [k for k in range(29) if before.status[k] is orbsoc.Status.SOLVED and k % 5 != 1 and k != 3]
    assert batch.iterations[good].mean() < 0.6 * before.iterations[good].mean()


def test_one_point_may_serve_all_rows() -> None:
    h = BASE.h + np.linspace(0.0, 0.01, 9)[:, None] * (np.arange(7) < 4)
    point = orbsoc.solve(BASE)
    shared = orbsoc.solve_batch(BASE, h=h, warm_start=point)
    each = orbsoc.Start(*(np.tile(getattr(point, name), (9, 1)) for name in "xyzs"))
    assert shared.x.tobytes() == orbsoc.solve_batch(BASE, h=h, warm_start=each).x.tobytes()
    assert shared.warm_start == ["used"] * 9
    assert shared.iterations[0] == 0, "its own solution"


def test_a_point_that_does_not_fit_is_named() -> None:
    point = orbsoc.solve(BASE)
    short = orbsoc.Start(point.x, point.y, point.z[1:], point.s)
    with pytest.raises(
        ProblemError, match=r"`warm_start.z` has shape \(6,\); it must be \(2, 7\), or \(7,\) for all"
    ):
        orbsoc.solve_batch(BASE, h=np.tile(BASE.h, (2, 1)), warm_start=short)
    with pytest.raises(TypeError, match="`warm_start` is of type bool"):
        orbsoc.solve_batch(BASE, h=np.tile(BASE.h, (2, 1)), warm_start=True)  # type: ignore[arg-type]


def test_a_solver_gives_every_batch_the_bits_of_a_fresh_one() -> None:
    """Batches of other sizes, an infeasible one and a refused one in between."""
    solver = orbsoc.BatchSolver(BASE, threads=2)
    first = random_rows(37)
    before = solver.solve(**first)
    solver.solve(b=np.full((11, 1), 50.0))
    spoilt = first["c"].copy()
    spoilt[20, 1] = np.nan
    with pytest.raises(ProblemError, match=r"^problem 20 of the batch: `c` has NaN at entry 1"):
        solver.solve(c=spoilt)
    second = random_rows(5, seed=3)
    for data, found in ((first, solver.solve(**first)), (second, solver.solve(**second))):
        fresh = orbsoc.solve_batch(BASE, **data)
        for name in ("x", "y", "z", "s", "iterations", "primal_residual"):
            np.testing.assert_array_equal(getattr(found, name), getattr(fresh, name), strict=True)
        assert found.message == fresh.message
    assert before.x.tobytes() == orbsoc.solve_batch(BASE, **first).x.tobytes()
    assert before.setup_s > 0.0


def test_a_copy_of_a_solver_gives_the_same_bits() -> None:
    solver = orbsoc.BatchSolver(BASE, threads=2, tol=1e-6)
    other = pickle.loads(pickle.dumps(solver))
    assert (other.settings, other.problem.n) == (solver.settings, BASE.n)
    assert other.solve(**random_rows(9)).x.tobytes() == solver.solve(**random_rows(9)).x.tobytes()


def test_misuse_of_a_solver_is_named() -> None:
    with pytest.raises(ProblemError, match="`threads` is -1; it must be at least 1"):
        orbsoc.BatchSolver(BASE, threads=-1)
    with pytest.raises(ProblemError, match=r"`threads` is 100000; .* at most 1024"):
        orbsoc.BatchSolver(BASE, threads=100_000)
    with pytest.raises(TypeError, match=r"`threads` is 2.5; it must be a whole number"):
        orbsoc.BatchSolver(BASE, threads=2.5)  # type: ignore[arg-type]
    assert len(orbsoc.BatchSolver(BASE, threads=np.int64(2)).solve(**random_rows(3))) == 3
    with pytest.raises(TypeError, match="`problem` is of type list"):
        orbsoc.BatchSolver([])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="tolerance"):
        orbsoc.BatchSolver(BASE, tolerance=1e-3)


def test_a_second_thread_is_told_that_a_solver_is_busy() -> None:
    solver, begun, answered = orbsoc.BatchSolver(BASE), threading.Event(), threading.Event()

    def wait(_: Mapping[str, int]) -> None:
        begun.set()
        assert answered.wait(60.0)

    with ThreadPoolExecutor(1) as pool:
        first = pool.submit(solver.solve, **random_rows(20), callback=wait)
        assert begun.wait(60.0)
        with pytest.raises(RuntimeError, match="already solving"):
            solver.solve(**random_rows(20))
        answered.set()
    assert len(first.result()) == 20


def test_a_solver_goes_on_in_a_forked_process_with_threads_of_its_own() -> None:
    """A fork has none of its parent's threads."""
    solver = orbsoc.BatchSolver(BASE, threads=2)
    data = random_rows(20)
    before = solver.solve(**data).x.tobytes()
    context = multiprocessing.get_context("fork")
    ours, its = context.Pipe()
    child = context.Process(target=lambda: its.send_bytes(solver.solve(**data).x.tobytes()), daemon=True)
    child.start()
    try:
        assert ours.poll(60.0), "the child hangs"
        assert ours.recv_bytes() == before
    finally:
        child.kill()
        child.join()


@pytest.mark.parametrize("threads", [1, 2])
def test_a_callback_sees_the_batch_grow_and_may_stop_it(threads: int) -> None:
    count, seen = 100_000, []
    data = random_rows(count)

    def stop(progress: Mapping[str, int]) -> bool:
        seen.append(progress["ended"])
        assert progress["count"] == count
        return progress["ended"] >= 16

    solver = orbsoc.BatchSolver(BASE, threads=threads)
    batch = solver.solve(**data, callback=stop)
    assert seen == sorted(seen)
    assert sum(ended >= 16 for ended in seen) == 1
    stopped = np.array([status is orbsoc.Status.INTERRUPTED for status in batch.status])
    assert 0 < stopped.sum() <= count - 16
    not_begun = stopped & (batch.iterations == 0)
    assert np.isnan(batch.x[not_begun]).all()
    whole = solver.solve(**data)
    same = ~stopped & (batch.iterations == whole.iterations)
    assert same.sum() >= 16
    assert batch.x[same].tobytes() == whole.x[same].tobytes()


@pytest.mark.parametrize("threads", [1, 2])
def test_a_callbacks_exception_comes_out_and_ctrl_c_in_it_is_a_status(threads: int) -> None:
    def fail(_: object) -> None:
        raise ZeroDivisionError

    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    solver, data = orbsoc.BatchSolver(BASE, threads=threads), random_rows(4000)
    with pytest.raises(TypeError, match="`callback` is 3; it must be callable"):
        solver.solve(**data, callback=3)  # type: ignore[arg-type]
    with pytest.raises(ZeroDivisionError):
        solver.solve(**data, callback=fail)
    assert orbsoc.Status.INTERRUPTED in solver.solve(**data, callback=interrupt).status


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_that_no_row_tells_of_is_raised(threads: int) -> None:
    """It comes when the callback sees that all have ended."""

    def interrupt(progress: Mapping[str, int]) -> None:
        if progress["ended"] == progress["count"]:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        orbsoc.solve_batch(BASE, **random_rows(9), threads=threads, callback=interrupt)


@pytest.mark.parametrize("threads", [1, 2])
def test_the_exception_of_a_signals_handler_comes_out(threads: int) -> None:
    def expire(*_: object) -> None:
        raise TimeoutError

    data = random_rows(100_000)
    before = signal.signal(signal.SIGALRM, expire)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        with pytest.raises(TimeoutError):
            orbsoc.solve_batch(BASE, **data, threads=threads)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_stops_a_batch_and_keeps_what_has_ended(threads: int) -> None:
    """The signal comes from a thread of its own; where it missed the rows' solving, it is sent earlier or later."""
    solver, data = orbsoc.BatchSolver(BASE, threads=threads), random_rows(100_000)
    delay_s = solver.solve(**data).solve_s / 2.0
    for _ in range(8):
        killer = threading.Timer(delay_s, signal.raise_signal, [signal.SIGINT])
        killer.start()
        try:
            batch = solver.solve(**data)
            killer.join()
        except KeyboardInterrupt:  # all rows had ended
            delay_s /= 2.0
            continue
        assert len(batch) == 100_000
        stopped = np.array([status is orbsoc.Status.INTERRUPTED for status in batch.status])
        assert stopped.any()
        if not stopped.all():
            return
        delay_s *= 1.5
    pytest.fail("no signal came while rows were being solved")
