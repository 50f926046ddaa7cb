"""A small problem that every hardware command can price."""

from __future__ import annotations

import numpy as np

import orbsoc


def small_problem() -> orbsoc.Problem:
    """8 variables, 3 equalities, 8 bounds and a cone of 4, quadratic objective."""
    random = np.random.default_rng(5)
    return orbsoc.Problem(
        P=np.eye(8), c=random.normal(size=8), A=random.normal(size=(3, 8)), b=np.ones(3),
        G=np.vstack([-np.eye(8), random.normal(size=(4, 8))]), h=np.r_[np.ones(8), 9.0, 0.0, 0.0, 0.0],
        cones=orbsoc.Cones(l=8, q=[4]),
    )  # fmt: skip
