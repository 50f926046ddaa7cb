"""Settings that are refused say what was meant."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest

import orbsoc
from orbsoc.conic.settings import Settings

NEAREST = [
    ("max_iters", "max_iterations"),
    ("max_iter", "max_iterations"),
    ("tolerance", "tol"),
    ("max_time", "max_time_s"),
    ("verbos", "verbose"),
]


@pytest.mark.parametrize(("name", "meant"), NEAREST)
def test_an_unknown_setting_names_the_nearest(name: str, meant: str) -> None:
    problem = orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[0.0], cones=orbsoc.Cones(l=1))
    unknown: dict[str, Any] = {name: 1}
    for use in (lambda: Settings(**unknown), lambda: orbsoc.solve(problem, **unknown)):
        with pytest.raises(TypeError, match=f"unknown setting '{name}'; did you mean '{meant}'"):
            use()


def test_a_setting_like_no_other_lists_those_that_there_are() -> None:
    with pytest.raises(TypeError, match="unknown setting 'colour'; known are tol, tol_inaccurate"):
        Settings(colour=1)


def test_settings_are_copied_with_their_values() -> None:
    settings = Settings(tol=1e-6, max_iterations=7)
    assert pickle.loads(pickle.dumps(settings)) == settings == copy.deepcopy(settings)


@pytest.mark.parametrize("bound", [1e20, 1e300, float("inf")])
def test_rows_that_do_not_constrain_are_named_in_the_outcome(bound: float) -> None:
    problem = orbsoc.Problem(c=[1.0], G=[[-1.0], [1.0]], h=[0.0, bound], cones=orbsoc.Cones(l=2))
    assert "1 row does not constrain, h being 1e20 or more: 1" in orbsoc.solve(problem).message


def test_a_proof_without_a_limit_names_none() -> None:
    """0 ≤ −1: no x is feasible, and nothing is left of the rows."""
    problem = orbsoc.Problem(c=[0.0], A=[[0.0]], b=[1.0])
    solution = orbsoc.solve(problem)
    assert solution.status is orbsoc.Status.PRIMAL_INFEASIBLE
    assert "inf" not in solution.message.replace("infeasible", "")
