"""The burn of a given time that ends with the highest perigee: what is left to ask for when an orbit cannot be reached.

r_p = h²/(1 + e) is linearised about the end of a reference; it is no condition of the problem, and so there is always a solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.solution import Solution
from orbsoc.guidance.powered_flight import Burn, add_burn, read_burn
from orbsoc.guidance.scp import Step, Subproblem
from orbsoc.orbit import angular_momentum, angular_momentum_jacobian, laplace_jacobian, laplace_vector
from orbsoc.orbit.array import Array

from .problems import Iterate

ROUND = 1e-6
"""Eccentricity below which the direction of the perigee has no derivative."""


def perigee_radius(end: Array) -> float:
    """Of a canonical state (6,)."""
    h, laplace = angular_momentum(end[:3], end[3:]), laplace_vector(end[:3], end[3:], 1.0)
    return float(h @ h / (1.0 + np.linalg.norm(laplace)))


def perigee_gradient(end: Array) -> Array:
    """Of the radius by a canonical state, (6,): (2 h·∂h − r_p ∂e)/(1 + e)."""
    r, v = end[:3], end[3:]
    h, laplace = angular_momentum(r, v), laplace_vector(r, v, 1.0)
    ecc = float(np.linalg.norm(laplace))
    by_ecc = laplace @ laplace_jacobian(r, v, 1.0) / max(ecc, ROUND)
    by_h = 2.0 * h @ angular_momentum_jacobian(r, v)
    return np.asarray((by_h - float(h @ h) / (1.0 + ecc) * by_ecc) / (1.0 + ecc))


@dataclass(frozen=True, slots=True)
class HighestPerigee:
    """A `linearise` for `orbsoc.guidance.scp`: the burn takes the time of its reference."""

    burn: Burn

    def __call__(self, reference: Iterate) -> Subproblem[Iterate]:
        last, builder = reference.trajectory, ConicBuilder()
        variables = add_burn(builder, self.burn, last, free_duration=False)
        builder.cost(variables.end, -perigee_gradient(last.end))

        def read(solution: Solution) -> Step[Iterate]:
            trajectory = read_burn(builder, solution, last, free_duration=False)
            return Step(Iterate(trajectory), trajectory.change_from(last), 0.0, {})

        return Subproblem(builder.build(), read)
