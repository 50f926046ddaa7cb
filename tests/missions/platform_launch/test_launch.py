"""The launch: mass properties, and its motion by Kane's equations, in closed form and by two bodies with their reaction."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orbsoc.missions.platform_launch.model import kane, two_body
from orbsoc.missions.platform_launch.model.launch import LaunchError, Pair, closed_form
from orbsoc.missions.platform_launch.model.rack import Rack
from orbsoc.missions.platform_launch.model.separation import disagreement, in_rotating_frame
from tests.missions.platform_launch.data import launched, paper


def test_mass_properties_are_those_of_the_paper() -> None:
    rack = paper().rack
    assert rack.place((1, 2)) == pytest.approx([-0.4, 0.7])
    assembly = rack.without((1, 2)).assembly()
    assert (assembly.mass_kg, assembly.inertia_kg_m2) == (2400.0, pytest.approx(1545.0, abs=1e-9))
    assert assembly.centre_m == pytest.approx([0.05, -0.05])
    assert (rack.stroke_m((1, 2)), rack.stroke_m((1, 1))) == (1.2, 2.5)


def racks() -> st.SearchStrategy[Rack]:
    size, length = st.integers(1, 4), st.floats(0.2, 2.0)

    def made(columns: int, rows: int, long: float, mass: float, gone: set[tuple[int, int]]) -> Rack:
        there = frozenset(slot for slot in gone if slot[0] <= columns and slot[1] <= rows)
        return Rack(columns, rows, long, 0.4 * long, 0.3, 0.05, 0.1, mass, 0.5 * mass, 120.0, 15.0, there)

    slots = st.sets(st.tuples(size, size), max_size=8)
    return st.builds(made, size, size, length, st.floats(200.0, 3000.0), slots)


@given(racks())
def test_an_assembly_is_the_sum_of_its_bodies(rack: Rack) -> None:
    """By the moments of every body about the platform's centre, moved to the common one."""
    found, places = rack.assembly(), [rack.place(slot) for slot in rack.servers()]
    masses = [rack.mass_kg] + [rack.server_mass_kg] * len(places)
    about = sum(m * float(r @ r) for m, r in zip(masses[1:], places, strict=True))
    about += rack.inertia_kg_m2 + len(places) * rack.server_inertia_kg_m2
    centre = sum((m * r for m, r in zip(masses[1:], places, strict=True)), np.zeros(2)) / sum(masses)
    assert found.mass_kg == pytest.approx(sum(masses))
    assert found.centre_m == pytest.approx(centre, abs=1e-12)
    assert found.inertia_kg_m2 == pytest.approx(about - sum(masses) * float(centre @ centre))


@settings(max_examples=25)
@given(racks(), st.data())
def test_three_ways_to_a_separation_agree(rack: Rack, data: st.DataObject) -> None:
    if not rack.ready():
        return
    slot = data.draw(st.sampled_from(rack.ready()))
    yaw, rate = data.draw(st.floats(-3.0, 3.0)), data.draw(st.floats(-0.2, 0.2))
    pair = Pair.of(rack, slot, data.draw(st.floats(100.0, 900.0)), yaw_rad=yaw, yaw_rate_rad_s=rate)
    slides = np.linspace(0.0, rack.stroke_m(slot), 7)
    times, states = closed_form(pair, slides)
    by_kane, by_forces = kane.integrate(pair, times), two_body.integrate(pair, times).states
    np.testing.assert_allclose(by_kane, states, rtol=0.0, atol=2e-12)
    np.testing.assert_allclose(by_forces, states, rtol=0.0, atol=1e-11)


def test_with_thrust_and_torque_kane_agrees_with_the_forces() -> None:
    pair = replace(launched().pair(), thrust_n=np.array([20.0, -35.0]), torque_n_m=40.0)
    time_s, q = kane.until(pair, 1.2)
    assert q[3] == pytest.approx(1.2, abs=1e-14)
    np.testing.assert_allclose(
        two_body.integrate(pair, np.array([0.0, time_s])).states[-1], q, rtol=0.0, atol=1e-12
    )
    still = kane.until(replace(pair, thrust_n=np.zeros(2), torque_n_m=0.0), 1.2)[1]
    assert abs(q[2] - still[2]) > 1e-3  # the torque is felt


def test_a_server_that_the_platform_outruns_does_not_leave() -> None:
    pair = replace(launched().pair(), thrust_n=np.array([0.0, 1e5]))
    with pytest.raises(LaunchError, match="force_n = 300: the platform's thrust and torque hold the server"):
        kane.until(pair, 1.2)


@pytest.mark.parametrize(
    ("force_n", "time_s", "expected"),
    [  # 500 N and 300 N to the end of the stroke: server's state, absolute yaw (°), turn without the launch taken off
        (500.0, 1.1160, (0.743, -498.266, 0.83095, 1.84915, 4.013, 3.868)),
        (300.0, 1.4407, (1.109, -498.266, 0.89729, 1.43202, 4.051, 3.864)),
    ],
)
def test_the_separation_by_force(force_n: float, time_s: float, expected: tuple[float, ...]) -> None:
    found = launched(force_n).separation()
    assert found.time_s == pytest.approx(time_s, abs=5e-5)
    assert found.server == pytest.approx(expected[:4], abs=5.1e-4)
    assert found.server[2:] == pytest.approx(expected[2:4], abs=5.1e-6)
    turn = degrees(found.q[2] - paper().sight(found.time_s)[0])
    assert (degrees(found.q[2]), turn) == pytest.approx(expected[4:], abs=5.1e-4)
    assert max(disagreement(found)) < 1e-12


def test_a_time_stop_is_where_the_server_is_then() -> None:
    found = paper().separation()
    assert (found.time_s, found.q[3]) == (pytest.approx(1.45, abs=1e-12), pytest.approx(1.21551, abs=5e-6))
    again = kane.integrate(found.pair, np.array([0.0, 1.45]))[-1]
    np.testing.assert_allclose(again, found.q, rtol=0.0, atol=1e-13)


def test_the_frame_is_inertial_to_a_thousandth() -> None:
    found = paper().separation()
    server, q = in_rotating_frame(found, paper().motion.mean_motion_rad_s)
    assert server[2:] - found.server[2:] == pytest.approx([-0.0009, 0.0007], abs=5e-5)
    assert degrees(q[2] - found.q[2]) == pytest.approx(0.010, abs=5e-4)


def test_momentum_and_angular_momentum_are_kept_and_the_push_does_the_work() -> None:
    found = launched(yaw_bias_deg=20.0).separation()
    pair, body = found.pair, found.pair.assembly
    bodies = two_body.integrate(pair, found.times())
    turn, slide = bodies.states[:, 6], bodies.states[:, 7]
    reduced = 300.0 * body.mass_kg / (300.0 + body.mass_kg)
    across, along = pair.place_m - body.centre_m
    inertia = body.inertia_kg_m2 + 36.0 + reduced * (across**2 + (along + bodies.states[:, 3]) ** 2)
    angular = inertia * turn + reduced * across * slide
    np.testing.assert_allclose(angular, angular[0], rtol=1e-10)
    energy = 0.5 * inertia * turn**2 + reduced * across * slide * turn + 0.5 * reduced * slide**2
    np.testing.assert_allclose(energy - energy[0], 300.0 * bodies.states[:, 3], atol=1e-9)


def test_the_couple_turns_the_server_with_the_tube() -> None:
    found = launched().separation()
    bodies = two_body.integrate(found.pair, found.times())
    turning = np.gradient(bodies.states[:, 6], bodies.times_s)
    np.testing.assert_allclose(bodies.couple_n_m[1:-1], 36.0 * turning[1:-1], rtol=2e-3, atol=1e-4)


def test_the_line_of_sight_points_to_the_target() -> None:
    for phase in (0.0, 50.0, 130.0, 260.0):
        scenario = launched(phase_deg=phase)
        x, z, _, _ = scenario.platform_state()
        yaw, rate = scenario.sight()
        assert np.array([-np.sin(yaw), np.cos(yaw)]) == pytest.approx(-np.array([x, z]) / np.hypot(x, z))
        later = scenario.sight(1e-3)[0] - yaw
        assert later / 1e-3 == pytest.approx(rate, rel=1e-5)
    assert paper().sight()[1] == pytest.approx(2.0 * paper().motion.mean_motion_rad_s)
    assert launched(yaw_bias_deg=20.0).pair().yaw_rad == pytest.approx(radians(20.0))
