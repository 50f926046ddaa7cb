"""Warm starts from Python: bits, bundles, fall-backs, and what is no point to start from."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import orbsoc
from benchmarks.batches import perturbed
from benchmarks.guidance import powered_descent, rendezvous
from benchmarks.recorded import insertion
from orbsoc.solving.bundle import read_bundle
from tests.fuzz_budget import fuzz_budget
from tests.strategies import problems
from tests.zoo import ZooCase, cases

FIELDS = ("x", "y", "z", "s")


def entries(solution: orbsoc.Solution) -> tuple[object, ...]:
    arrays = tuple(getattr(solution, name).tobytes() for name in FIELDS)
    return (*arrays, solution.status, solution.iterations, solution.refinements, solution.warm_start)


def moved(problem: orbsoc.Problem, share: float, seed: int = 0) -> orbsoc.Problem:
    """The problem with each number of b, c and h moved by up to `share` of itself."""
    rng = np.random.default_rng(seed)
    new = {name: getattr(problem, name).copy() for name in "bch"}
    for values in new.values():
        values *= 1.0 + share * rng.uniform(-1.0, 1.0, values.size)
    return orbsoc.Problem(P=problem.P, A=problem.A, G=problem.G, cones=problem.cones, **new)


@pytest.mark.parametrize("generate", [powered_descent, rendezvous])
def test_a_change_of_one_per_cent_takes_less_than_six_tenths_of_the_iterations(
    generate: Callable[[int, int], orbsoc.Problem],
) -> None:
    warm_total = cold_total = 0
    for seed in range(4):
        problem = generate(20, seed)
        new = moved(problem, 0.01, seed)
        cold, warm = orbsoc.solve(new), orbsoc.solve(new, warm_start=orbsoc.solve(problem))
        assert warm.status is cold.status is orbsoc.Status.SOLVED
        assert orbsoc.verify(new, warm).worst <= 1e-7
        assert warm.iterations <= cold.iterations + 1
        warm_total, cold_total = warm_total + warm.iterations, cold_total + cold.iterations
    assert warm_total < 0.6 * cold_total


def test_a_newton_step_out_of_the_cones_is_no_reason_to_give_up() -> None:
    """One per cent of each entry of b is another trajectory here: heights of up to 1e2."""
    problem = next(problem for name, _, problem in insertion(12, 1) if name == "insertion B-12-0")
    before = orbsoc.solve(problem)
    for new in perturbed(problem, 0.01, 4, seed=0):
        warm = orbsoc.solve(new, warm_start=before)
        assert (warm.status, warm.warm_start) == (orbsoc.Status.SOLVED, "used")
        assert orbsoc.verify(new, warm).worst <= 1e-7
        assert warm.iterations <= orbsoc.solve(new).iterations + 1


@pytest.mark.parametrize("case", cases(), ids=lambda case: case.name)
def test_the_emulated_computer_starts_warm_with_the_same_bits(case: ZooCase) -> None:
    problem = case.problem
    before = orbsoc.solve(moved(problem, 0.01), max_iterations=30)
    rust = orbsoc.solve(problem, warm_start=before)
    assert entries(orbsoc.PsScheduler()(problem, warm_start=before)) == entries(rust)
    cold = orbsoc.solve(problem)
    assert rust.status is cold.status
    assert rust.iterations <= cold.iterations + 1 or rust.warm_start == "fell_back"


def test_a_solver_starts_from_its_last_solution() -> None:
    problem = powered_descent(10, 0)
    solver = orbsoc.Solver(problem)
    first = solver.solve(warm_start=True)
    assert first.warm_start == "none"
    new = moved(problem, 1e-3)
    solver.update(b=new.b, c=new.c, h=new.h)
    again = solver.solve(warm_start=True)
    assert entries(again) == entries(orbsoc.solve(new, warm_start=first))
    assert again.warm_start == "used"
    assert again.iterations < first.iterations
    assert entries(solver.solve()) == entries(orbsoc.solve(new)), "a cold start remembers nothing"


def test_an_explicit_point_is_a_start_and_a_hopeless_one_falls_back() -> None:
    problem = powered_descent(10, 1)
    cold = orbsoc.solve(problem)
    point = orbsoc.Start(cold.x, cold.y, cold.z, cold.s)
    assert entries(orbsoc.solve(problem, warm_start=point)) == entries(orbsoc.solve(problem, warm_start=cold))
    far = orbsoc.Start(cold.x + 1e6, cold.y, cold.z, cold.s)
    given_up = orbsoc.solve(problem, warm_start=far)
    assert given_up.warm_start == "fell_back"
    assert given_up.x.tobytes() == cold.x.tobytes()


def test_a_certificate_is_no_start_but_no_error_either() -> None:
    infeasible = orbsoc.Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=orbsoc.Cones(l=2))
    solver = orbsoc.Solver(infeasible)
    assert solver.solve().status is orbsoc.Status.PRIMAL_INFEASIBLE
    solver.update(h=[-2.0, 3.0])
    feasible = solver.solve(warm_start=True)
    assert (feasible.status, feasible.warm_start) == (orbsoc.Status.SOLVED, "fell_back")


@pytest.mark.parametrize(
    ("start", "error", "words_"),
    [
        ("cold", TypeError, "`warm_start` is of type str"),
        (np.ones(3), TypeError, "`warm_start` is of type ndarray"),
        (orbsoc.Start(np.ones(2), np.ones(0), np.ones(1), np.ones(1)), orbsoc.ProblemError, "`warm_start.x` has shape"),
        (orbsoc.Start(np.ones(1), np.ones(0), np.ones(1), np.ones(3)), orbsoc.ProblemError, "`warm_start.s` has shape"),
        (orbsoc.Start([1j], [], [1], [1]), orbsoc.ProblemError, "`warm_start.x` has entries of type complex128"),
    ],
)  # fmt: skip
def test_what_is_no_start_is_refused_by_name(start: object, error: type[Exception], words_: str) -> None:
    problem = orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=orbsoc.Cones(l=1))
    with pytest.raises(error, match=words_):
        orbsoc.Solver(problem).solve(warm_start=start)  # type: ignore[arg-type]


def test_a_start_of_lists_and_integers_is_one_of_arrays() -> None:
    problem = orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=orbsoc.Cones(l=1))
    plain = orbsoc.solve(problem, warm_start=orbsoc.Start([2], [], [1], np.zeros(1, dtype=np.float32)))
    arrays = orbsoc.solve(
        problem, warm_start=orbsoc.Start(np.array([2.0]), np.zeros(0), np.ones(1), np.zeros(1))
    )
    assert entries(plain) == entries(arrays)


def test_a_bundle_of_a_warm_start_replays_it_bit_for_bit(tmp_path: Path) -> None:
    problem = powered_descent(10, 2)
    new = moved(problem, 0.01)
    before = orbsoc.solve(problem)
    limited = orbsoc.solve(new, warm_start=before, max_iterations=2, bundle=tmp_path / "b.json")
    bundle = read_bundle(tmp_path / "b.json")
    assert bundle.start is not None
    assert entries(orbsoc.solve(bundle.problem, bundle.settings, warm_start=bundle.start)) == entries(limited)
    assert entries(bundle.solution) == entries(limited)


def test_the_callback_and_the_clock_rule_over_both_starts() -> None:
    problem = powered_descent(10, 3)
    before = orbsoc.solve(problem)
    stopped = orbsoc.solve(moved(problem, 0.01), warm_start=before, callback=lambda p: p["iteration"] >= 1)
    assert stopped.status is orbsoc.Status.INTERRUPTED
    late = orbsoc.solve(moved(problem, 0.01), warm_start=before, max_time_s=1e-9)
    assert late.status is orbsoc.Status.MAX_TIME
    assert np.isfinite(late.x).all()


@given(
    problems(), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-6, 1.0, 1e8, 1e300, math.inf, math.nan])
)
@fuzz_budget(60)
def test_from_any_point_the_status_is_no_worse_than_from_cold(
    problem: orbsoc.Problem, seed: int, size: float
) -> None:
    rng = np.random.default_rng(seed)
    lengths = (problem.n, problem.p, problem.m, problem.m)
    start = orbsoc.Start(*(size * rng.normal(size=length) for length in lengths))
    cold, warm = (
        orbsoc.solve(problem, max_iterations=40),
        orbsoc.solve(problem, max_iterations=40, warm_start=start),
    )
    if cold.status in (orbsoc.Status.SOLVED, orbsoc.Status.PRIMAL_INFEASIBLE, orbsoc.Status.DUAL_INFEASIBLE):
        assert warm.status not in (orbsoc.Status.NUMERICAL_LIMIT, orbsoc.Status.MAX_ITERATIONS)
    if not np.isfinite(size):
        assert entries(warm)[:-1] == entries(cold)[:-1]
