"""The condensed subproblem: against the form that keeps the states, and its pieces against finite differences."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.missions.reachable_domain.model.direct.arcs import Arcs
from orbsoc.missions.reachable_domain.model.direct.condensed import condense
from orbsoc.missions.reachable_insertion.model.problems import Iterate, MaxEnergyFreePerigee
from orbsoc.missions.reachable_insertion.targets.target_orbit import LargestOrbit
from orbsoc.orbit import EARTH
from orbsoc.orbit.planes import in_plane_axes
from tests.missions.reachable_domain.three_planes import COLLOCATION, GUESS, PERIGEES, PLANES, TARGET


def full_form(k: int, about: Arcs) -> tuple[orbsoc.Problem, MaxEnergyFreePerigee]:
    """The subproblem of plane k with states, controls and end state as unknowns."""
    first, second = in_plane_axes(PLANES[k])
    height_m = (float(PERIGEES[k]) - 1.0) * EARTH.earth_radius_m
    target = LargestOrbit(PLANES[k], first, second, 1.0, 0.1, height_m, is_direction_free=True)
    model = MaxEnergyFreePerigee(COLLOCATION.burn, target, None, lambda _trajectory: {})
    velocities = COLLOCATION.velocities(about.positions)[k]
    states = np.hstack([about.positions[k], velocities])
    trajectory = Trajectory(
        legendre_gauss(12), states, about.controls[k], about.ends[k], COLLOCATION.duration
    )
    return model(Iterate(trajectory)).problem, model


@pytest.mark.parametrize("k", range(3))
def test_condensed_and_full_form_have_one_solution(k: int) -> None:
    linear = COLLOCATION.end_map(GUESS)
    batch = condense(linear, TARGET.rows(GUESS.ends))
    condensed, (full, _model) = batch.problem(k), full_form(k, GUESS)
    assert (full.n, full.p, full.m) == (114, 80, 51)
    assert (condensed.n, condensed.p, condensed.m) == (36, 2, 51)
    mine = orbsoc.solve(condensed, tol=1e-10)
    theirs = orbsoc.solve(full, tol=1e-10)
    assert mine.status is theirs.status is orbsoc.Status.SOLVED
    constant = TARGET.rows(GUESS.ends).cost[k] @ linear.constant[k]
    assert mine.objective + constant == pytest.approx(theirs.objective, rel=1e-9)
    np.testing.assert_allclose(mine.x, theirs.x[72:108], atol=1e-4)  # flat optimum: ‖u‖ = 1 at a gap of 1e-10
    moved = COLLOCATION.arcs(linear, mine.x.reshape(1, 12, 3).repeat(3, axis=0))
    np.testing.assert_allclose(moved.positions[k], theirs.x[:72].reshape(12, 6)[:, :3], atol=1e-4)
    np.testing.assert_allclose(moved.ends[k], theirs.x[108:], atol=1e-4)
