"""Second-order cones of many dimensions: the sum of a few long norms."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem

VARIABLES = 20
"""Unknowns, whatever the cones' dimension: a solver whose work is linear in the cone takes time linear in it."""


def sum_of_norms(dimension: int, seed: int, *, cones: int = 1) -> Problem:
    """min Σᵢ‖Fᵢx − gᵢ‖ over `cones` dense Fᵢ of `dimension` − 1 rows, within a box that cuts the minimum off.

    Form: Lobo, Vandenberghe, Boyd & Lebret 1998, §2.2.
    """
    random = np.random.default_rng(12_000 * dimension + 100 * cones + seed)
    b = ConicBuilder()
    x, t = b.variable("x", VARIABLES), b.variable("t", cones)
    b.cost(t, 1.0)
    truth = random.standard_normal(VARIABLES)
    for i in range(cones):
        F = random.standard_normal((dimension - 1, VARIABLES))
        g = F @ truth + random.standard_normal(dimension - 1)
        head = np.zeros((1, VARIABLES))
        upright = np.eye(dimension, 1)
        b.second_order(
            [(t.index[i : i + 1], -upright), (x, -np.vstack([head, F]))], np.concatenate([[0.0], -g])
        )
    eye = np.eye(VARIABLES)
    b.nonnegative([(x, np.vstack([eye, -eye]))], np.ones(2 * VARIABLES))
    return b.build()
