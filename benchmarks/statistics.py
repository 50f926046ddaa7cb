"""Linear and quadratic programmes: portfolio selection, sparse regression, small dense LPs."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse as _sparse

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Cones, Problem

sparse: Any = _sparse  # published without types


def portfolio(assets: int, seed: int) -> Problem:
    """min ½(xᵀDx + ‖y‖²) − γ μᵀx with y = Fᵀx (a factor for every ten assets), Σx = 1, x ≥ 0."""
    random = np.random.default_rng(4000 * assets + seed)
    factors = assets // 10
    loadings = random.standard_normal((assets, factors)) * (random.random((assets, factors)) < 0.5)
    b = ConicBuilder()
    x, y = b.variable("x", assets), b.variable("y", factors)
    b.cost(x, -2.0 * random.uniform(0.0, 0.1, assets))
    b.quadratic_cost(x, sparse.diags_array(random.uniform(0.1, 1.0, assets) * np.sqrt(factors)))
    b.quadratic_cost(y, sparse.eye_array(factors))
    b.equality([(x, loadings.T), (y, -np.eye(factors))], np.zeros(factors))
    b.equality([(x, np.ones((1, assets)))], [1.0])
    b.nonnegative([(x, -np.eye(assets))], np.zeros(assets))
    return b.build()


def lasso(features: int, seed: int) -> Problem:
    """min ½‖Ax − b‖² + λΣt, −t ≤ x ≤ t, with three samples to a feature and a tenth of the truth nonzero."""
    random = np.random.default_rng(5000 * features + seed)
    samples = 3 * features
    design = random.standard_normal((samples, features)) * (random.random((samples, features)) < 0.3)
    truth = random.standard_normal(features) * (random.random(features) < 0.1)
    measured = design @ truth + 0.1 * random.standard_normal(samples)
    weight = 0.1 * float(np.max(np.abs(design.T @ measured)))
    b = ConicBuilder()
    x, t, r = b.variable("x", features), b.variable("t", features), b.variable("r", samples)
    b.cost(t, weight)
    b.quadratic_cost(r, sparse.eye_array(samples))
    b.equality([(x, design), (r, -np.eye(samples))], measured)
    eye = np.eye(features)
    b.nonnegative([(x, eye), (t, -eye)], np.zeros(features))
    b.nonnegative([(x, -eye), (t, -eye)], np.zeros(features))
    return b.build()


def small_lp(variables: int, seed: int, *, rows: int) -> Problem:
    """min cᵀx, Gx ≤ h, G dense: feasible at a point drawn, bounded because c = −Gᵀz with z ≥ 0 drawn."""
    random = np.random.default_rng(6000 * variables + seed)
    G = random.standard_normal((rows, variables))
    z = random.random(rows) * (random.random(rows) < 0.5)
    h = G @ random.standard_normal(variables) + random.random(rows)
    return Problem(c=-G.T @ z, G=G, h=h, cones=Cones(l=rows))
