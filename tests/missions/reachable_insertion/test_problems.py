"""The linearised, collocated burn: derivatives against finite differences, collocation against propagation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orbsoc.conic.builder import ConicBuilder
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import Burn, Trajectory, add_burn, derivative, linearise
from orbsoc.missions.reachable_insertion.model.problems import (
    Iterate,
    MaxEnergyFixedPerigee,
    MaxEnergyFreePerigee,
    MinTime,
)
from orbsoc.missions.reachable_insertion.scenario import load_scenario
from orbsoc.missions.reachable_insertion.starts.directions import propagated, towards_plane
from orbsoc.missions.reachable_insertion.targets.target_orbit import LargestOrbit, LinearVectors, TargetOrbit
from orbsoc.orbit import EARTH, CanonicalUnits, angular_momentum, laplace_vector

SCENARIO = load_scenario(Path(__file__).resolve().parents[3] / "scenarios" / "rec1.toml")
UNITS = CanonicalUnits.of(EARTH)
START_SI = SCENARIO.initial.vector()
THRUSTER = SCENARIO.vehicle.thruster()
BURN = Burn.of(START_SI, THRUSTER, SCENARIO.vehicle.longest_burn_s, UNITS)
TARGET = TargetOrbit.through(UNITS.state_from_si(SCENARIO.target.vector()))
LARGEST = LargestOrbit.about(UNITS.state_from_si(SCENARIO.target.vector()), 150e3, is_direction_free=False)


def guess(nodes: int = 12) -> Trajectory:
    return propagated(START_SI, THRUSTER, lambda _t_s, state: state[3:], 63.0, legendre_gauss(nodes))


def crooked(nodes: int = 6) -> Trajectory:
    """A trajectory that satisfies nothing, so that no term of a derivative vanishes by luck."""
    noise = np.random.default_rng(7)
    at = guess(nodes)
    return replace(
        at,
        states=at.states + 0.05 * noise.standard_normal(at.states.shape),
        controls=noise.standard_normal(at.controls.shape),
    )


def no_figures(_trajectory: Trajectory) -> dict[str, float]:
    return {}


def test_derivatives_equal_central_differences_including_the_lightening_of_a_longer_burn() -> None:
    at, step = crooked(), 1e-6
    linear = linearise(BURN, at, free_duration=True)
    for node in range(at.grid.size):
        for k in range(6):
            moved = [at.states.copy(), at.states.copy()]
            moved[0][node, k] -= step
            moved[1][node, k] += step
            low, high = (derivative(BURN, replace(at, states=x)) for x in moved)
            slope = (high - low) / (2 * step)
            np.testing.assert_allclose(linear.by_state[node, :, k], slope[node], atol=1e-9)
            assert np.abs(np.delete(slope, node, axis=0)).max() == 0.0
    longer, shorter = (replace(at, duration=at.duration + s) for s in (step, -step))
    slope = (derivative(BURN, longer) - derivative(BURN, shorter)) / (2 * step)
    np.testing.assert_allclose(linear.by_duration, slope, atol=1e-9)
    assert np.abs(slope - derivative(BURN, at) / at.duration).max() > 1e-4  # the term elimination may lose
    thrust = derivative(BURN, at) - derivative(BURN, replace(at, controls=np.zeros_like(at.controls)))
    np.testing.assert_allclose(linear.by_control[:, None] * at.controls, thrust[:, 3:], atol=1e-14)


@pytest.mark.parametrize("free_duration", [True, False])
def test_linearisation_is_exact_at_its_reference(free_duration: bool) -> None:
    at = crooked()
    linear = linearise(BURN, at, free_duration=free_duration)
    value = (
        linear.constant
        + np.einsum("nij,nj->ni", linear.by_state, at.states)
        + linear.by_duration * at.duration
    )
    value[:, 3:] += linear.by_control[:, None] * at.controls
    np.testing.assert_allclose(value, derivative(BURN, at), atol=1e-13)
    if not free_duration:
        assert np.all(linear.by_duration == 0.0)


@pytest.mark.parametrize("free_duration", [True, False])
def test_a_propagated_burn_satisfies_the_collocated_equations(free_duration: bool) -> None:
    """Spectral accuracy: 12 nodes hold a smooth 63 s burn to 1e-12; the equations share nothing with DOP853."""
    at, builder = guess(12), ConicBuilder()
    variables = add_burn(builder, BURN, at, free_duration=free_duration)
    problem = builder.build()
    x = np.zeros(problem.n)
    x[variables.states.index], x[variables.controls.index] = at.states, at.controls
    x[variables.end.index] = at.end
    if variables.duration is not None:
        x[variables.duration.index] = at.duration
    assert np.abs(problem.A @ x - problem.b).max() < 1e-12
    assert (problem.h - problem.G @ x)[: problem.cones.l].min(initial=0.0) >= 0.0
    for rows in problem.cones.second_order():
        head, *tail = (problem.h - problem.G @ x)[rows]
        assert np.linalg.norm(tail) == pytest.approx(head, abs=1e-12)  # unit thrust, on the cone


def test_duration_is_bounded_by_the_trust_region_and_by_the_propellant() -> None:
    at = guess(4)
    for longest, bound in ((BURN.longest, 2.0 * at.duration), (1.2 * at.duration, 1.2 * at.duration)):
        builder = ConicBuilder()
        add_burn(builder, replace(BURN, longest=longest), at, free_duration=True)
        problem = builder.build()
        np.testing.assert_allclose(problem.h[:2], [0.0, bound])


def test_free_perigee_problem_has_the_size_and_pattern_of_the_specification() -> None:
    reference = Iterate(guess())
    problem = MaxEnergyFreePerigee(BURN, LARGEST, None, no_figures)(reference).problem
    assert (problem.n, problem.p, problem.m) == (114, 80, 51)
    assert problem.cones.l == 0
    assert problem.cones.q == (4,) * 12 + (3,)
    diagonal, blocks = 114 + 80 + 51, 12 * 6 + 3
    assert problem.A.nnz + problem.G.nnz + diagonal + blocks == 1616  # upper triangle of the KKT matrix


@pytest.mark.parametrize(
    "linearisation",
    [
        MinTime(BURN, TARGET, 100.0, no_figures),
        MaxEnergyFixedPerigee(BURN, LARGEST, 100.0, no_figures),
        MaxEnergyFreePerigee(BURN, LARGEST, None, no_figures),
        MaxEnergyFreePerigee(BURN, LARGEST, 100.0, no_figures),
    ],
    ids=["min_time", "fixed", "free", "free_with_slack"],
)
def test_pattern_does_not_depend_on_the_numbers_even_where_they_vanish(
    linearisation: MinTime | MaxEnergyFixedPerigee | MaxEnergyFreePerigee,
) -> None:
    here = guess(5)
    planar = replace(
        here,
        states=here.states * [1, 1, 0, 1, 1, 0],
        controls=here.controls * [1, 1, 0],
        end=here.end * [1, 1, 0, 1, 1, 0],
    )
    a, b = (linearisation(Iterate(at)).problem for at in (here, planar))
    for one, other in ((a.A, b.A), (a.G, b.G)):
        assert np.array_equal(one.indptr, other.indptr)
        assert np.array_equal(one.indices, other.indices)


def test_six_terminal_rows_have_rank_five_and_the_five_used_have_rank_five() -> None:
    end = guess().end
    linear = LinearVectors.about(end)
    six = np.vstack([linear.momentum_jacobian, linear.laplace_jacobian])
    assert np.linalg.matrix_rank(six, tol=1e-9) == 5
    n, l, q = TARGET.normal, TARGET.perigee, TARGET.ahead
    five = np.vstack(
        [np.array([l, q, n]) @ linear.momentum_jacobian, np.array([l, q]) @ linear.laplace_jacobian]
    )
    assert np.linalg.matrix_rank(five, tol=1e-9) == 5
    consistent = np.linalg.lstsq(six, np.concatenate([
        TARGET.momentum * n - linear.momentum_value, TARGET.eccentricity * l - linear.laplace_value
    ]), rcond=None)[0]  # fmt: skip
    left = six @ consistent + np.concatenate([linear.momentum_value, linear.laplace_value])
    left -= np.concatenate([TARGET.momentum * n, TARGET.eccentricity * l])
    assert np.abs(left).max() > 1e-9  # the paper's six rows contradict each other about a propagated guess


def test_linear_vectors_keep_the_offset_that_the_paper_leaves_out() -> None:
    end = guess().end
    linear = LinearVectors.about(end)
    h, laplace = angular_momentum(end[:3], end[3:]), laplace_vector(end[:3], end[3:], 1.0)
    np.testing.assert_allclose(linear.momentum_value + linear.momentum_jacobian @ end, h, atol=1e-14)
    np.testing.assert_allclose(linear.laplace_value + linear.laplace_jacobian @ end, laplace, atol=1e-14)


def test_target_directions_are_orthonormal_and_a_circular_target_still_has_some() -> None:
    circular = TargetOrbit.through(np.array([1.1, 0.0, 0.0, 0.0, 0.0, 1.1**-0.5]))
    assert circular.is_circular
    for target in (TARGET, circular):
        frame = np.vstack([target.perigee, target.ahead, target.normal])
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(frame) == pytest.approx(1.0)
    with pytest.raises(ValueError, match="parallel"):
        TargetOrbit.through(np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0]))


def test_cold_start_towards_the_plane_mirrors_the_normal_velocity() -> None:
    steering = towards_plane(np.array([0.0, 0.0, 1.0]), UNITS)
    speed = UNITS.speed_m_s
    thrust = steering(0.0, np.array([7e6, 0.0, 0.0, 0.0, 0.8 * speed, 0.6 * speed]))
    np.testing.assert_allclose(thrust, [0.0, 0.8, 0.6 - 1.2])
