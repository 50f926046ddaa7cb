"""The families are what they say: the same every time, solvable, and of the sizes announced."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial

import numpy as np
import pytest

import orbsoc
from benchmarks.batch_measure import stacked
from benchmarks.batches import BATCHES, SIZE, perturbed
from benchmarks.estimation import robust_kalman
from benchmarks.families import FAMILIES, Instance, instances
from benchmarks.guidance import powered_descent, quadrotor, rendezvous
from benchmarks.large_cones import sum_of_norms
from benchmarks.recorded import first_insertions
from benchmarks.regression import group_lasso, huber, svm
from benchmarks.six_dof import first_reference, landing, linearised, six_dof
from benchmarks.statistics import lasso, portfolio, small_lp
from orbsoc.conic.problem import Problem

MAKERS: dict[str, Callable[[int, int], Problem]] = {
    "powered_descent": partial(powered_descent),
    "six_dof": six_dof,
    "rendezvous": rendezvous,
    "quadrotor": quadrotor,
    "portfolio": lambda size, seed: portfolio(10 * size, seed),
    "lasso": lasso,
    "huber": huber,
    "svm": svm,
    "group_lasso": lambda size, seed: group_lasso(size // 5, seed),
    "robust_kalman": robust_kalman,
    "large_cones": lambda size, seed: sum_of_norms(8 * size, seed, cones=3),
    "small_lp": lambda size, seed: small_lp(16, seed, rows=10 * size),
}


@cache
def generated(name: str) -> list[Instance]:
    return instances([name])


@pytest.mark.parametrize("name", MAKERS)
def test_a_problem_is_the_same_every_time_and_another_with_another_seed(name: str) -> None:
    first, second, other = MAKERS[name](10, 1), MAKERS[name](10, 1), MAKERS[name](10, 2)
    for matrix in ("P", "A", "G"):
        assert np.array_equal(getattr(first, matrix).data, getattr(second, matrix).data)
    numbers = [np.concatenate([p.c, p.A.data, p.b, p.G.data, p.h]) for p in (first, second, other)]
    assert np.array_equal(numbers[0], numbers[1])
    assert not np.array_equal(numbers[0], numbers[2])


@pytest.mark.parametrize("name", MAKERS)
def test_its_solution_verifies(name: str) -> None:
    problem = MAKERS[name](10, 0)
    solution = orbsoc.solve(problem)
    assert solution.status is orbsoc.Status.SOLVED
    assert orbsoc.verify(problem, solution).worst <= 1e-7


@pytest.mark.parametrize("name", FAMILIES)
def test_every_problem_of_a_family_ends_solved_and_verified(name: str) -> None:
    """Among them a landing whose factors overflow when pivots of the wrong sign become too small (decision 0004)."""
    for instance in generated(name):
        solution = orbsoc.solve(instance.problem)
        assert solution.status is orbsoc.Status.SOLVED, instance.name
        assert orbsoc.verify(instance.problem, solution).worst <= 1e-8, instance.name


@pytest.mark.parametrize("name", sorted(set(FAMILIES) - {"mission004", "orbit_insertion"}))
def test_a_family_has_names_of_its_own_and_groups_of_one_size(name: str) -> None:
    found = generated(name)
    assert len({instance.name for instance in found}) == len(found) >= 10
    sizes: dict[str, set[tuple[int, int, int]]] = {}
    for instance in found:
        p = instance.problem
        sizes.setdefault(instance.group, set()).add((p.n, p.p, p.m))
    assert all(len(group) == 1 for group in sizes.values())


def test_the_small_lps_are_dense_with_100_to_150_rows() -> None:
    sizes = {(i.problem.n, i.problem.m, i.problem.G.nnz) for i in generated("small_lp")}
    assert sizes == {(16, rows, 16 * rows) for rows in (100, 112, 128, 150)}


def test_powered_descent_has_the_size_of_its_docstring() -> None:
    sizes = {instance.group: instance.problem.n for instance in generated("powered_descent")}
    assert sizes == {f"powered descent, {nodes} nodes": 11 * nodes + 7 for nodes in (10, 20, 50, 100)}


def test_large_cones_reach_2475() -> None:
    assert {q for i in generated("large_cones") for q in i.problem.cones.q} == {61, 151, 531, 1275, 2475}


def test_the_landing_is_linearised_exactly() -> None:
    reference = first_reference(5, 3)
    [step, *_], [slope, *_] = linearised(reference)
    change = 1e-6
    for column, name in ((2, "states"), (8, "states"), (15, "controls")):
        values = getattr(reference, name).copy()
        values[0, column - (14 if name == "controls" else 0)] += change
        moved = type(reference)(
            **{
                "states": reference.states,
                "controls": reference.controls,
                "duration": reference.duration,
                name: values,
            }
        )
        found = (linearised(moved)[0][0] - step) / change
        assert found == pytest.approx(slope[:, column], abs=1e-5)


def test_successive_subproblems_of_a_landing_share_their_pattern_and_need_no_virtual_control() -> None:
    problems = list(landing(10, seed=0, count=5))
    stacked(problems)  # raises where a pattern differs
    solution = orbsoc.solve(problems[-1])
    virtual = solution.x[10 * 17 + 1 :][: 9 * 14]
    assert np.max(np.abs(virtual)) < 1e-6


@pytest.mark.parametrize("name", ["powered descent, 10 nodes", "portfolio, 100 assets", "LP, 16 × 100"])
def test_a_batch_is_of_one_pattern_with_numbers_that_differ(name: str) -> None:
    problems = BATCHES[name].generate()
    assert len(problems) == SIZE
    arrays = stacked(problems)
    assert arrays
    assert all(len(np.unique(rows, axis=0)) == SIZE for rows in arrays.values())


def test_first_subproblems_of_insertions_differ_in_numbers_only() -> None:
    problems = first_insertions(12, 4)
    assert "A" in stacked(problems)
    assert all(orbsoc.solve(p).status is orbsoc.Status.SOLVED for p in problems)


def test_a_perturbed_problem_keeps_rows_that_do_not_constrain() -> None:
    base = Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, np.inf], cones=orbsoc.Cones(l=2))
    [other] = perturbed(base, 0.01, 1, seed=0)
    assert other.h[1] == np.inf
    assert 0.0 < abs(other.h[0] + 2.0) <= 0.02


def test_an_unknown_family_is_named() -> None:
    with pytest.raises(ValueError, match=r"'landing'.*powered_descent"):
        instances(["landing"])
