"""Flights of transfers, their sensitivities, and their restoration, against finite differences and the independent integrator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.two_burn_missions import transfer
from orbsoc.guidance.collocation import legendre_gauss
from orbsoc.guidance.powered_flight import Burn
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.targets.target_orbit import TargetOrbit
from orbsoc.missions.reachable_insertion.two_burns.flight import ends_of, lowest_point, sensitivities
from orbsoc.missions.reachable_insertion.two_burns.limits import Limits
from orbsoc.missions.reachable_insertion.two_burns.motion import Motion, OblateCoast, TwoBodyCoast
from orbsoc.missions.reachable_insertion.two_burns.restoration import restored
from orbsoc.missions.reachable_insertion.two_burns.search import limits_of
from orbsoc.missions.reachable_insertion.two_burns.starts import as_burns, guesses
from orbsoc.missions.reachable_insertion.two_burns.transfer import Transfer, rotated
from orbsoc.missions.reachable_insertion.two_burns.verification import fly
from orbsoc.orbit import CanonicalUnits

Array = NDArray[np.float64]
BURN = Burn(np.array([1.05, 0.0, 0.0, 0.0, 0.98, 0.1]), 0.3, 0.1, 5.0)
LATITUDE = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])
"""The pole of J2 is not an axis of the plan."""
MOTIONS = {
    "point mass": Motion(BURN, TwoBodyCoast()),
    "J2": Motion(BURN, OblateCoast(LATITUDE, CanonicalUnits.of())),
}
STEP = 1e-5

both_fields = pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)


def made() -> Transfer:
    random = np.random.default_rng(4)
    controls = np.array([[1.0, 0.2, -0.4]]) + 0.03 * random.standard_normal((2, 12, 3))
    grid = legendre_gauss(12)
    return Transfer(grid, np.array([0.3, 2.0]), np.array([0.5, 0.8]), controls).directed


def slope(motion: Motion, one: Transfer, other: Transfer) -> Array:
    ends = ends_of(motion, [one, other])
    return np.asarray((ends[0, -1] - ends[1, -1]) / (2.0 * STEP))


@both_fields
@pytest.mark.parametrize("k", range(2))
def test_the_end_follows_coasts_and_durations_as_differences_say(k: int, motion: Motion) -> None:
    transfer, step = made(), STEP * np.eye(2)[k]
    found = sensitivities(motion, transfer)
    np.testing.assert_allclose(found.end, ends_of(motion, [transfer])[0, -1], atol=1e-12)
    by_coast = slope(
        motion,
        replace(transfer, coasts=transfer.coasts + step),
        replace(transfer, coasts=transfer.coasts - step),
    )
    by_duration = slope(
        motion,
        replace(transfer, durations=transfer.durations + step),
        replace(transfer, durations=transfer.durations - step),
    )
    np.testing.assert_allclose(found.last.by_times[:, k], by_coast, atol=1e-7)
    np.testing.assert_allclose(found.last.by_times[:, 2 + k], by_duration, atol=1e-7)


@both_fields
@pytest.mark.parametrize("k", range(2))
def test_the_end_follows_the_thrust_as_differences_say(k: int, motion: Motion) -> None:
    """A turn of all directions together, of which the interpolant's length does not change."""
    transfer = made()
    turn = np.array([0.3, -0.5, 0.7])
    found = sensitivities(motion, transfer)
    swept = np.cross(turn, transfer.controls[k])
    turns = np.zeros((2, 3))
    turns[k] = STEP * turn
    by_turn = slope(motion, transfer.moved(np.zeros(4), turns), transfer.moved(np.zeros(4), -turns))
    np.testing.assert_allclose(
        np.einsum("ina,na->i", found.last.by_controls[:, k], swept), by_turn, rtol=2e-3, atol=1e-5
    )


@both_fields
@pytest.mark.parametrize("k", range(2))
def test_directions_turn_as_the_way_to_the_ignition_does(k: int, motion: Motion) -> None:
    transfer = made()
    found = sensitivities(motion, transfer)
    for j in range(4):
        times = STEP * np.eye(4)[j]
        later = sensitivities(motion, transfer.moved(times, np.zeros((2, 3)))).ignitions[k, :3]
        now = found.ignitions[k, :3]
        expected = np.cross(now, (later - now) / STEP) / (now @ now)
        np.testing.assert_allclose(found.turns[k, :, j], expected, atol=1e-4)


@both_fields
@pytest.mark.parametrize("coast", [0.4, 2.0, 5.0], ids=["falling", "past the perigee", "a revolution"])
def test_the_lowest_point_follows_times_and_thrust_as_differences_say(motion: Motion, coast: float) -> None:
    transfer = replace(made(), coasts=np.array([0.3, coast]))
    found = sensitivities(motion, transfer)
    lowest = lowest_point(motion, transfer, found)
    way = motion.coast.way(found.cut_offs[0].state, np.linspace(0.0, coast, 4001))
    assert np.linalg.norm(way[:, :3], axis=1).min() == pytest.approx(lowest.radius, abs=1e-6)
    assert lowest.radius <= np.linalg.norm(way[:, :3], axis=1).min() + 1e-12

    def radius(times: Array, turn: Array) -> float:
        moved = transfer.moved(times, np.array([turn, np.zeros(3)]))
        return lowest_point(motion, moved, sensitivities(motion, moved)).radius

    still = np.zeros(3)
    for j in range(4):
        times = STEP * np.eye(4)[j]
        slope = (radius(times, still) - radius(-times, still)) / (2.0 * STEP)
        assert lowest.by_times[j] == pytest.approx(slope, abs=2e-6)
    turn = np.array([0.3, -0.5, 0.7])
    slope = (radius(np.zeros(4), STEP * turn) - radius(np.zeros(4), -STEP * turn)) / (2.0 * STEP)
    swept = np.cross(turn, transfer.controls[0])
    by_turn = float(np.einsum("na,na->", lowest.by_controls[0], swept))
    assert by_turn == pytest.approx(slope, rel=2e-3, abs=1e-5)
    assert not lowest.by_controls[1].any()


@both_fields
def test_a_coast_that_is_too_low_is_lifted(motion: Motion) -> None:
    transfer = replace(made(), coasts=np.array([0.3, 5.0]))
    found = sensitivities(motion, transfer)
    lowest = lowest_point(motion, transfer, found).radius
    target = TargetOrbit.through(found.end)
    limits = Limits(1.0, 10.0, 5.0, lowest + 0.01)
    lifted = restored(motion, target, limits, transfer)
    assert lifted.held
    assert lifted.reaches
    assert lifted.lowest.radius >= limits.lowest - 1e-9
    assert np.abs(target.conditions(sensitivities(motion, lifted.transfer).end[None])).max() < 1e-9


def test_a_rotation_is_orthogonal_and_composes() -> None:
    vectors = np.random.default_rng(1).standard_normal((5, 3))
    turn = np.array([0.4, -1.1, 0.3])
    once = rotated(vectors, turn)
    np.testing.assert_allclose(np.linalg.norm(once, axis=1), np.linalg.norm(vectors, axis=1))
    np.testing.assert_allclose(rotated(once, -turn), vectors, atol=1e-14)
    np.testing.assert_allclose(rotated(vectors, 0.0 * turn), vectors)


@pytest.mark.parametrize("oblate", [False, True])
@pytest.mark.parametrize("number", range(4))
def test_a_restored_start_ends_on_the_orbit_by_the_independent_integrator(number: int, oblate: bool) -> None:
    scenario = transfer(77, number, oblate=oblate).scenario
    ready = InsertionSetup.of(scenario)
    motion = Motion.of(ready)
    limits = limits_of(ready)
    starts = [as_burns(ready.burn, limits, pair, 12) for pair in guesses(motion, ready.target, limits)[:3]]
    found = [restored(motion, ready.target, limits, each) for each in starts]
    reaching = [each for each in found if each.reaches]
    assert reaching
    for each in reaching:
        end = ready.units.state_from_si(fly(scenario, each.transfer).end)
        assert np.abs(ready.target.conditions(end[None])).max() < 1e-8
        assert each.transfer.coasts[0] <= limits.ignition
        assert each.transfer.burning <= limits.burning * (1.0 + 1e-12)
