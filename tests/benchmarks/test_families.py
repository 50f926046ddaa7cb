"""The families are what they say: the same every time, solvable, and of the sizes announced."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from benchmarks.families import FAMILIES, Instance, instances

GENERATED = [name for name in FAMILIES if name != "mission004"]


def smallest(name: str) -> Instance:
    return min(instances([name]), key=lambda instance: instance.problem.n)


@pytest.mark.parametrize("name", GENERATED)
def test_a_family_is_the_same_every_time(name: str) -> None:
    first, second = instances([name]), instances([name])
    assert len({instance.name for instance in first}) == len(first) >= 10
    for a, b in zip(first, second, strict=True):
        assert a.name == b.name
        for matrix in ("P", "A", "G"):
            assert np.array_equal(getattr(a.problem, matrix).data, getattr(b.problem, matrix).data)
        for vector in ("c", "b", "h"):
            assert np.array_equal(getattr(a.problem, vector), getattr(b.problem, vector))


@pytest.mark.parametrize("name", GENERATED)
def test_its_smallest_problem_has_a_verified_solution(name: str) -> None:
    problem = smallest(name).problem
    solution = orbsoc.solve(problem)
    assert solution.status is orbsoc.Status.SOLVED
    assert orbsoc.verify(problem, solution).worst <= 1e-7


def test_the_small_lps_are_dense_with_128_rows() -> None:
    problem = smallest("small_lp").problem
    assert (problem.n, problem.m, problem.G.nnz) == (16, 128, 16 * 128)


def test_powered_descent_has_the_size_of_its_docstring() -> None:
    sizes = {instance.group: instance.problem.n for instance in instances(["powered_descent"])}
    assert sizes == {f"powered descent, {nodes} nodes": 11 * nodes + 7 for nodes in (10, 20, 50)}


def test_an_unknown_family_is_named() -> None:
    with pytest.raises(ValueError, match=r"'landing'.*powered_descent"):
        instances(["landing"])
