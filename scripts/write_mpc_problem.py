"""Writes the model-predictive control problem of docs/whole-chip.md: `python scripts/write_mpc_problem.py OUT.json`."""

from __future__ import annotations

import sys

import numpy as np
from scipy import sparse

from orbsoc.conic.cones import Cones
from orbsoc.conic.problem import Problem

STEPS, STEP_S = 10, 0.3


def mpc() -> Problem:
    """Ten steps of a double integrator in two axes, quadratic cost, each step's acceleration of norm at most 1: 60 variables, 40
    equations, ten cones of 3. States come first, positions in m before velocities in m/s, then accelerations in m/s²."""
    dynamics = np.kron([[1.0, STEP_S], [0.0, 1.0]], np.eye(2))
    control = np.kron([[0.5 * STEP_S**2], [STEP_S]], np.eye(2))
    states = np.eye(4 * STEPS) - np.kron(np.eye(STEPS, k=-1), dynamics)
    first = dynamics @ np.array([2.0, -1.0, 0.5, 0.8])
    pick = np.vstack([np.zeros((1, 2)), -np.eye(2)])
    return Problem(
        P=sparse.csc_array(np.diag(np.r_[np.ones(4 * STEPS), np.full(2 * STEPS, 0.1)])),
        c=np.zeros(6 * STEPS),
        A=sparse.csc_array(np.hstack([states, -np.kron(np.eye(STEPS), control)])),
        b=np.concatenate([first, np.zeros(4 * (STEPS - 1))]),
        G=sparse.csc_array(np.hstack([np.zeros((3 * STEPS, 4 * STEPS)), np.kron(np.eye(STEPS), pick)])),
        h=np.tile([1.0, 0.0, 0.0], STEPS),
        cones=Cones(q=[3] * STEPS),
    )


if __name__ == "__main__":
    mpc().save(sys.argv[1])
