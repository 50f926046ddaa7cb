"""Problems and settings with which solve attempts stall, for the tests of restarts."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings

STALLING = Settings(static_regularization=1e-2, refinement_share=30.0)
"""With this much regularisation and this little refinement some attempts stall."""
STALLING_REFINED = Settings(static_regularization=1e-2, refinement_share=3.0)
STALLING_REGULARIZED = Settings(static_regularization=1e-1, refinement_share=3.0)
STALLING_LIGHT = Settings(static_regularization=1e-4, refinement_share=3.0)
RECOVERED, STALLED = (40, 58, 91), 209
"""Seeds of `badly_scaled` that the first restart solves, and one of which all attempts stall."""
LEVEL = 3e-9
WEAK = Settings(static_regularization=LEVEL)
"""Regularisation that rounding hides in `recovered_at_third_attempt`."""
WEAK_REGULARIZED = Settings(static_regularization=10.0 * LEVEL, refinement_share=0.1 * 0.03)


def badly_scaled(seed: int) -> Problem:
    """Rows over four orders of magnitude, some of them active without a multiplier."""
    rng = np.random.default_rng(seed)
    n, p, l, q = 6, 2, 8, 4
    A, x = rng.normal(size=(p, n)), rng.normal(size=n)
    G = rng.normal(size=(l + q, n)) * 10.0 ** rng.uniform(-2.0, 2.0, (l + q, 1))
    s, z = np.zeros(l + q), np.zeros(l + q)
    s[:l], s[l] = np.maximum(0.0, rng.normal(size=l)), 2.0
    z[:l] = np.where(s[:l] == 0.0, rng.uniform(size=l) * (rng.uniform(size=l) > 0.5), 0.0)
    c = -(G.T @ z + A.T @ rng.normal(size=p))
    return Problem(c=c, A=A, b=A @ x, G=G, h=G @ x + s, cones=Cones(l=l, q=[q]))


def columns_apart(seed: int, smaller: float, n: int = 40, m: int = 150, together: int = 40) -> Problem:
    """An LP with an equality of the first variables; half the columns of the inequalities are scaled by `smaller`."""
    rng = np.random.default_rng(seed)
    G, A = rng.standard_normal((m, n)), rng.standard_normal((1, n))
    G[:, : n // 2] *= smaller
    A[:, together:] = 0.0
    x, s = rng.standard_normal(n), rng.random(m) * (rng.random(m) < 0.7)
    z = rng.random(m) * (s == 0.0)
    c = -(G.T @ z + A.T @ rng.standard_normal(1))
    return Problem(c=c, A=A, b=A @ x, G=G, h=G @ x + s, cones=Cones(l=m))


def recovered_at_third_attempt() -> Problem:
    """Two attempts stall with the settings WEAK, the third solves it."""
    return columns_apart(2, 1e-6, n=8, m=16, together=4)


def unstable_dynamics(seed: int) -> Problem:
    """Quadratic control of x⁺ = Ax + Bu with small inputs and eigenvalues up to 2: feasible, with states of some 1e3."""
    rng = np.random.default_rng(seed)
    steps, states = int(rng.integers(5, 40)), int(rng.integers(1, 5))
    A = rng.normal(size=(states, states)) * rng.uniform(0.3, 1.2)
    stride, dynamics = states + 1, np.hstack([rng.normal(size=(states, 1)), -np.eye(states)])
    rows, b = np.zeros((steps * states, steps * stride)), np.zeros(steps * states)
    for t in range(steps):
        here = slice(t * states, (t + 1) * states)
        rows[here, t * stride : (t + 1) * stride] = dynamics
        if t:
            rows[here, (t - 1) * stride + 1 : t * stride] = A
    b[:states] = -A @ rng.normal(size=states)
    inputs = np.eye(steps * stride)[::stride]
    return Problem(
        P=np.diag(np.tile(np.append(0.01, np.ones(states)), steps)),
        c=np.zeros(steps * stride),
        A=rows,
        b=b,
        G=np.vstack([inputs, -inputs]),
        h=np.full(2 * steps, 0.01),
        cones=Cones(l=2 * steps),
    )
