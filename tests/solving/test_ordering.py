"""The order of elimination: each has bits of its own, the same on every path, and its own shape of the factor."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from benchmarks.guidance import rendezvous
from orbsoc import PsScheduler, _core, solve, solve_batch
from orbsoc.conic.settings import ORDERINGS, Settings
from tests.integration.small_problem import small_problem

RENDEZVOUS = rendezvous(40, 0, approach_cone=False)
FILED = Path(__file__).resolve().parents[2] / "scenarios" / "rendezvous_40.json"


def shape(ordering: str, problem: orbsoc.Problem = RENDEZVOUS) -> tuple[int, int, int]:
    """Height of the elimination tree, entries of L, multiply-adds."""
    return _core.factor_shape(problem, Settings(ordering=ordering))


def test_the_filed_rendezvous_is_the_one_that_is_made_here() -> None:
    filed = orbsoc.Problem.load(FILED)
    for name in ("c", "b", "h"):
        np.testing.assert_allclose(getattr(filed, name), getattr(RENDEZVOUS, name), rtol=0.0, atol=1e-12)
    for name in ("A", "G"):
        assert abs(getattr(filed, name) - getattr(RENDEZVOUS, name)).max() <= 1e-12
    assert filed.cones == RENDEZVOUS.cones


def test_dissection_in_time_gives_a_shallow_tree_for_more_operations() -> None:
    (height, _, fewest), (shallow, _, more) = shape("amd"), shape("nested_dissection")
    assert height > 4 * shallow
    assert fewest < more < 4 * fewest
    assert shape("automatic") == shape("amd")  # one core has no use for a shallow tree


def test_where_no_separator_shortens_the_chain_the_order_is_minimum_degree() -> None:
    problem = small_problem()
    one, other = (solve(problem, ordering=name) for name in ("amd", "nested_dissection"))
    assert shape("nested_dissection", problem)[0] <= shape("amd", problem)[0]
    assert one.status is other.status


@pytest.mark.parametrize("ordering", ORDERINGS)
def test_an_order_has_the_same_bits_on_every_path(ordering: str) -> None:
    problem = rendezvous(8, 1)
    plain = solve(problem, ordering=ordering)
    assert plain.status is orbsoc.Status.SOLVED
    driven = PsScheduler(ordering=ordering)(problem)
    costs = np.stack([problem.c, problem.c])
    batch: Any = solve_batch(problem, c=costs, ordering=ordering)
    for name in ("x", "y", "s", "z"):
        assert getattr(driven, name).tobytes() == getattr(plain, name).tobytes()
        assert getattr(batch, name)[1].tobytes() == getattr(plain, name).tobytes()
    assert driven.iterations == plain.iterations


def test_both_orders_reach_the_same_optimum() -> None:
    found = [solve(RENDEZVOUS, ordering=name) for name in ORDERINGS]
    assert {solution.status.name for solution in found} == {"SOLVED"}
    for one, other in pairwise(found):
        assert one.objective == pytest.approx(other.objective, rel=1e-7)
        assert one.iterations == other.iterations


def test_an_unknown_order_is_refused_by_name() -> None:
    with pytest.raises(
        ValueError, match=r"ordering = 'metis' must be one of amd, nested_dissection, automatic"
    ):
        Settings(ordering="metis")
    with pytest.raises(TypeError, match="ordering = 3 must be a string"):
        Settings(ordering=3)  # type: ignore[arg-type]
