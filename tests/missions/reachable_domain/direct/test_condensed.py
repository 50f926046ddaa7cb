"""The condensed subproblem: against the form that keeps the states, and its pieces against finite differences."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import Trajectory
from orbsoc.missions.reachable_domain.direct.altitude import altitude_rows
from orbsoc.missions.reachable_domain.direct.arcs import Arcs
from orbsoc.missions.reachable_domain.direct.condensed import condense
from orbsoc.missions.reachable_domain.direct.guess import resampled, towards_planes
from orbsoc.missions.reachable_domain.direct.terminal import LargestOrbit, LargestTilt
from orbsoc.missions.reachable_domain.indirect.conditions import conditions, curvature
from orbsoc.missions.reachable_insertion.problems import Iterate, MaxEnergyFreePerigee
from orbsoc.missions.reachable_insertion.target import TargetOrbit
from orbsoc.orbit.planes import TiltFrame, cross, in_plane_axes, inclination_and_node, normals, plane_error
from tests.missions.reachable_domain.cases import domain, paper, perigees

PLANES = normals(np.deg2rad([28.18, 20.3, 33.3]), np.deg2rad([335.36, 322.25, 340.25]))
PERIGEES = perigees(100.0, 250.0, 400.0)
TARGET = LargestOrbit(PLANES, PERIGEES)
TILT = LargestTilt(domain().frame, np.array([0.3, 2.0, 5.0]), PERIGEES)
COLLOCATION = domain().tools.collocation(12)
GUESS = towards_planes(COLLOCATION, PLANES)


def full_form(k: int, about: Arcs) -> tuple[orbsoc.Problem, MaxEnergyFreePerigee]:
    """The subproblem of plane k with states, controls and end state as unknowns."""
    first, second = in_plane_axes(PLANES[k])
    target = TargetOrbit(PLANES[k], first, second, 1.0, 0.1)
    model = MaxEnergyFreePerigee(COLLOCATION.burn, target, float(PERIGEES[k]), None, lambda _trajectory: {})
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


def test_the_end_map_meets_the_collocation_equations() -> None:
    """D R + d₀r₀ = hV and D V + d₀v₀ = h(ĝ + G(R − R̂) + kU), and the quadrature of the end."""
    linear = COLLOCATION.end_map(GUESS)
    controls = np.random.default_rng(1).normal(size=GUESS.controls.shape)
    found = COLLOCATION.arcs(linear, controls)
    grid, half, start = COLLOCATION.grid, 0.5 * COLLOCATION.duration, COLLOCATION.burn.start
    radius = np.linalg.norm(GUESS.positions, axis=2)[..., None]
    away = found.positions - GUESS.positions
    pull = -GUESS.positions / radius**3 - away / radius**3
    pull += 3.0 * GUESS.positions * (GUESS.positions * away).sum(axis=2)[..., None] / radius**5
    rate = pull + COLLOCATION.thrust[:, None] * controls
    v = COLLOCATION.velocities(found.positions)
    left = grid.differentiation[:, 1:] @ v + np.outer(grid.differentiation[:, 0], start[3:])
    np.testing.assert_allclose(left, half * rate, atol=1e-11)
    np.testing.assert_allclose(
        found.ends[:, 3:], start[3:] + half * np.einsum("n,bni->bi", grid.weights, rate), atol=1e-11
    )
    np.testing.assert_allclose(
        found.ends[:, :3], start[:3] + half * np.einsum("n,bni->bi", grid.weights, v), atol=1e-11
    )


@pytest.mark.parametrize("target", [TARGET, TILT], ids=["orbit", "tilt"])
def test_terminal_rows_are_the_first_order_expansion(target: LargestOrbit | LargestTilt) -> None:
    """Rows at the reference have the value of the exact conditions, and their slope."""
    ends = GUESS.ends
    rows, exact = target.rows(ends), conditions(target, ends)
    np.testing.assert_allclose(-rows.cost, exact.objective, atol=1e-13)
    np.testing.assert_allclose(rows.equal, exact.gradients[:, : rows.equal.shape[1]], atol=1e-13)
    at_reference = (rows.equal @ ends[:, :, None])[..., 0] - rows.equal_rhs
    np.testing.assert_allclose(at_reference, exact.values[:, : rows.equal.shape[1]], atol=1e-13)
    head = rows.cone_rhs - (rows.cone @ ends[:, :, None])[..., 0]
    momentum = cross(ends[:, :3], ends[:, 3:])
    laplace = cross(ends[:, 3:], momentum) - ends[:, :3] / np.linalg.norm(ends[:, :3], axis=1)[:, None]
    normal = (
        target.normal
        if isinstance(target, LargestOrbit)
        else target.frame.tilted(target.tilts(ends), target.azimuth)
    )
    np.testing.assert_allclose(
        head[:, 0], (momentum * normal).sum(axis=1) ** 2 / target.perigee - 1.0, atol=1e-12
    )
    in_plane = laplace - (laplace * normal).sum(axis=1)[:, None] * normal
    np.testing.assert_allclose(
        np.linalg.norm(head[:, 1:], axis=1), np.linalg.norm(in_plane, axis=1), atol=1e-12
    )


@pytest.mark.parametrize("target", [TARGET, TILT, LargestOrbit(PLANES, PERIGEES, in_plane_axes(PLANES)[0])])
def test_gradients_and_curvature_agree_with_finite_differences(target: LargestOrbit | LargestTilt) -> None:
    ends, step = GUESS.ends, 1e-6
    multipliers = np.random.default_rng(3).normal(size=(3, 4))
    here, bend = conditions(target, ends), curvature(target, ends, multipliers)
    for j in range(6):
        nudge = step * np.eye(6)[j]
        ahead, behind = conditions(target, ends + nudge), conditions(target, ends - nudge)
        slope = (ahead.values - behind.values) / (2 * step)
        np.testing.assert_allclose(here.gradients[:, :, j], slope, atol=1e-8)
        total = [c.objective + (multipliers[:, :, None] * c.gradients).sum(axis=1) for c in (ahead, behind)]
        np.testing.assert_allclose(bend[:, :, j], (total[0] - total[1]) / (2 * step), atol=1e-7)


def test_altitude_rows_bound_the_projected_radius() -> None:
    linear = COLLOCATION.end_map(GUESS)
    rows, rhs = altitude_rows(COLLOCATION, linear, GUESS, np.full(3, 1.01))
    found = COLLOCATION.arcs(linear, GUESS.controls)
    outward = GUESS.positions / np.linalg.norm(GUESS.positions, axis=2)[..., None]
    slack = rhs - (rows @ GUESS.controls.reshape(3, -1, 1))[..., 0]
    np.testing.assert_allclose(slack, (outward * found.positions).sum(axis=2) - 1.01, atol=1e-12)


def test_planes_survive_the_way_there_and_back() -> None:
    inc, raan = inclination_and_node(PLANES)
    np.testing.assert_allclose(normals(inc, raan), PLANES, atol=1e-15)
    frame: TiltFrame = domain().frame
    tilt, azimuth = frame.tilt_and_azimuth(PLANES)
    np.testing.assert_allclose(frame.tilted(tilt, azimuth), PLANES, atol=1e-14)
    current_inc, current_raan = np.rad2deg(inclination_and_node(frame.normal))
    assert current_inc == pytest.approx(28.18, abs=1e-3)
    assert current_raan == pytest.approx(335.36, abs=1e-3)
    higher, _node = np.rad2deg(inclination_and_node(frame.tilted(0.01, 0.0)))
    assert higher == pytest.approx(current_inc + np.rad2deg(0.01), abs=1e-9)


def test_a_guess_resampled_to_a_finer_grid_is_the_same_arc() -> None:
    fine = domain().tools.collocation(24)
    there = resampled(COLLOCATION, GUESS, fine)
    back = resampled(fine, there, COLLOCATION)
    np.testing.assert_allclose(back.positions, GUESS.positions, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(there.controls, axis=2), 1.0, atol=1e-12)
    assert plane_error(GUESS.ends, PLANES).max() < 0.2


def test_the_scenario_is_the_papers() -> None:
    grid = paper().grid
    assert grid.inclination_deg.count * grid.raan_deg.count * grid.perigee_height_km.count == 33825
    assert 4500.0 * np.log(160.0 / 88.0) == pytest.approx(2690.0, abs=0.5)
