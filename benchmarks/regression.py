"""Fitting data: Huber regression, support vector machines, the group lasso."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse as _sparse

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem

Array = NDArray[np.float64]

sparse: Any = _sparse  # published without types

GROUP = 10
"""Variables of one group of the group lasso."""


def huber(features: int, seed: int) -> Problem:
    """min Σ φ(aᵢᵀx − bᵢ), φ quadratic up to 1 and linear beyond; ten samples to a feature, a twentieth corrupted.

    As the QP min ½‖u‖² + Σ(r + s), Ax − b = u + r − s, r, s ≥ 0. Form: Stellato et al. 2020, appendix A.
    """
    random = np.random.default_rng(8000 * features + seed)
    samples = 10 * features
    design = _sparse_design(random, samples, features, share=0.15)
    truth = random.standard_normal(features) / np.sqrt(features)
    corrupted = random.random(samples) < 0.05
    noise = np.where(corrupted, random.uniform(0.0, 10.0, samples), 0.25 * random.standard_normal(samples))
    b = ConicBuilder()
    x, u = b.variable("x", features), b.variable("u", samples)
    over, under = b.variable("over", samples), b.variable("under", samples)
    b.quadratic_cost(u, sparse.eye_array(samples))
    b.cost(over, 1.0)
    b.cost(under, 1.0)
    eye = np.eye(samples)
    b.equality([(x, design), (u, -eye), (over, -eye), (under, eye)], design @ truth + noise)
    b.nonnegative([(over, -eye)], np.zeros(samples))
    b.nonnegative([(under, -eye)], np.zeros(samples))
    return b.build()


def svm(features: int, seed: int) -> Problem:
    """min ½‖x‖² + Σt, t ≥ 1 − lᵢ aᵢᵀx, t ≥ 0: two clouds with labels lᵢ = ±1, ten samples to a feature.

    Form: Stellato et al. 2020, appendix A.
    """
    random = np.random.default_rng(9000 * features + seed)
    samples = 10 * features
    labels = np.where(np.arange(samples) < samples // 2, 1.0, -1.0)
    present = random.random((samples, features)) < 0.15
    cloud = random.standard_normal((samples, features)) / np.sqrt(features) + labels[:, None] / features
    rows = labels[:, None] * np.where(present, cloud, 0.0)
    b = ConicBuilder()
    x, t = b.variable("x", features), b.variable("t", samples)
    b.quadratic_cost(x, sparse.eye_array(features))
    b.cost(t, 1.0)
    eye = np.eye(samples)
    b.nonnegative([(x, -rows), (t, -eye)], -np.ones(samples))
    b.nonnegative([(t, -eye)], np.zeros(samples))
    return b.build()


def group_lasso(groups: int, seed: int) -> Problem:
    """min ½‖Ax − b‖² + λ Σ‖x_g‖ over groups of ten, half of them zero in truth; four samples to a variable.

    Source: Yuan & Lin 2006.
    """
    random = np.random.default_rng(10_000 * groups + seed)
    variables = GROUP * groups
    samples = 4 * variables
    design = _sparse_design(random, samples, variables, share=0.1)
    truth = random.standard_normal((groups, GROUP)) * (np.arange(groups) % 2)[:, None]
    measured = design @ truth.ravel() + 0.3 * random.standard_normal(samples)
    pulls = np.linalg.norm((design.T @ measured).reshape(groups, GROUP), axis=1)
    b = ConicBuilder()
    x, t = b.variable("x", (groups, GROUP)), b.variable("t", groups)
    r = b.variable("r", samples)
    b.quadratic_cost(r, sparse.eye_array(samples))
    b.cost(t, 0.1 * float(pulls.max()))
    b.equality([(x.index.ravel(), design), (r, -np.eye(samples))], measured)
    for g in range(groups):
        b.second_order([([t.index[g], *x.index[g]], -np.eye(GROUP + 1))], np.zeros(GROUP + 1))
    return b.build()


def _sparse_design(random: np.random.Generator, samples: int, features: int, *, share: float) -> Array:
    """Standard normal entries, a `share` of them present."""
    return np.where(
        random.random((samples, features)) < share, random.standard_normal((samples, features)), 0.0
    )
