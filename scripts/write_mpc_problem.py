"""Writes the model-predictive control problem of docs/whole-chip.md: `python scripts/write_mpc_problem.py OUT.json`.

With a number of steps, that of docs/measurements/microcode-loops.md: `python scripts/write_mpc_problem.py OUT.json 40`.
"""

from __future__ import annotations

import argparse
from pathlib import Path

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


def in_three_axes(steps: int) -> Problem:
    """Steps of a double integrator in three axes, quadratic cost: 6 states and 3 accelerations a step, in each step an acceleration of
    norm at most 1 m/s² (a cone of 4) and a speed in the horizontal plane of at most 1.2 m/s (a cone of 3)."""
    dynamics = np.kron([[1.0, STEP_S], [0.0, 1.0]], np.eye(3))
    control = np.kron([[0.5 * STEP_S**2], [STEP_S]], np.eye(3))
    states = np.eye(6 * steps) - np.kron(np.eye(steps, k=-1), dynamics)
    first = dynamics @ np.array([2.0, -1.0, 1.0, 0.5, 0.8, -0.3])
    pick, speed = np.vstack([np.zeros((1, 3)), -np.eye(3)]), np.zeros((3, 6))
    speed[1, 3] = speed[2, 4] = -1.0
    rows = [[np.zeros((4 * steps, 6 * steps)), np.kron(np.eye(steps), pick)],
            [np.kron(np.eye(steps), speed), np.zeros((3 * steps, 3 * steps))]]  # fmt: skip
    return Problem(
        P=sparse.csc_array(np.diag(np.r_[np.ones(6 * steps), np.full(3 * steps, 0.1)])),
        c=np.zeros(9 * steps),
        A=sparse.csc_array(np.hstack([states, -np.kron(np.eye(steps), control)])),
        b=np.concatenate([first, np.zeros(6 * (steps - 1))]),
        G=sparse.csc_array(np.block(rows)),
        h=np.concatenate([np.tile([1.0, 0.0, 0.0, 0.0], steps), np.tile([1.2, 0.0, 0.0], steps)]),
        cones=Cones(q=[4] * steps + [3] * steps),
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path)
    parser.add_argument("steps", type=int, nargs="?", help="in three axes")
    chosen = parser.parse_args()
    (mpc() if chosen.steps is None else in_three_axes(chosen.steps)).save(chosen.out)
