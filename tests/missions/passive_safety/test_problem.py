"""The conic problems against their known optima, Clarabel, dense sampling and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.impulses import Impulses
from orbsoc.guidance.safety import drift_clearance, states_after
from orbsoc.interfaces import clarabel
from orbsoc.missions.passive_safety.model.approach import Approach, after_half_orbit, cone_rows
from orbsoc.missions.passive_safety.model.problem import CAPTURE, assemble, drift_name
from orbsoc.missions.passive_safety.search.timing import equal_times
from orbsoc.orbit.relative import ClohessyWiltshire, DriftEllipse
from tests.missions.passive_safety.cases import CASES, Case

FORMS = {
    "samples": {"safety": "samples", "cost": "absolutes"},
    "cones": {"safety": "cone", "cost": "absolutes"},
    "norms": {"safety": "cone", "cost": "norms"},
}


def solved(approach: Approach, times: np.ndarray | None = None) -> tuple[Impulses, orbsoc.Solution]:
    impulses = assemble(approach, equal_times(approach) if times is None else times)
    return impulses, orbsoc.solve(impulses.builder.build(), tol=1e-9)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("case", CASES, ids=str)
def test_optima_are_the_known_ones_and_clarabels(case: Case, form: str) -> None:
    impulses, found = solved(case.approach(**FORMS[form]))
    other = clarabel.solve(impulses.builder.build(), tol=1e-9)
    assert found.status is other.status is orbsoc.Status.SOLVED
    assert found.objective == pytest.approx(other.objective, abs=1e-6)
    known = getattr(case, form)
    assert found.objective == pytest.approx(known, abs=1e-6 if form == "samples" else 5.1e-5)


def test_pulses_of_the_fitted_rows() -> None:
    known = [
        (0.2400, 0.0973, 0.1974, 0.0121),
        (0.2656, 0.1368, 0.1343, 0.0002),
        (0.1822, 0.0668, 0.0606, 0.0000),
        (0.2600, 0.1738, 0.0059, 0.0000),
        (0.4900, 0.1897, 0.3188, 0.4124),
        (0.6014, 0.3057, 0.3584, 0.0002),
        (0.4112, 0.1335, 0.1757, 0.0000),
        (0.5100, 0.3004, 0.0019, 0.0000),
    ]
    for case, pulses in zip(CASES[:8], known, strict=True):
        impulses, found = solved(case.approach(**FORMS["samples"]))
        sums = np.abs(impulses.programme(found).dv_m_s).sum(axis=1)
        assert sums == pytest.approx(pulses, abs=1e-4)


def test_sizes_are_those_of_the_paper() -> None:
    """M(N − 1) + 5 rows besides those of the cost: 3 equalities, 2 of the first impulse, 36 a later drift."""
    problem = assemble(CASES[0].approach(**FORMS["samples"]), [0.0, 900.0, 1800.0, 2700.0]).builder.build()
    assert (problem.n, problem.p, problem.m - 2 * 8) == (16, 3, 110)
    cones = assemble(CASES[0].approach(), [0.0, 900.0, 1800.0, 2700.0]).builder.build()
    assert (cones.n, cones.p, cones.m, len(cones.cones.q)) == (12, 3, 23, 7)


def test_the_cone_is_exact_for_all_time() -> None:
    for case in CASES[::3]:
        approach = case.approach()
        impulses, found = solved(approach)
        after = states_after(impulses.programme(found), approach.start, approach.motion)
        depths = [-DriftEllipse.of(state, approach.mean_motion_rad_s).highest_r_m for state in after[1:]]
        assert min(depths) == pytest.approx(approach.keep_out_m, abs=1e-4)  # and some drift touches
        nearest = drift_clearance(after, approach.mean_motion_rad_s).distance_m
        assert nearest.min() > approach.keep_out_m - 1e-3


def test_rows_are_the_coefficients_of_the_drift() -> None:
    state, n = np.array([30.0, -700.0, 0.0, 0.1, -0.05, 0.0]), 1.1e-3
    c, a, b = cone_rows(n) @ state
    for t in (0.0, 500.0, 4000.0):
        there = ClohessyWiltshire(n).transition(t, 0.0) @ state
        assert there[0] == pytest.approx(c + a * np.cos(n * t) + b * np.sin(n * t), abs=1e-9)
    half = ClohessyWiltshire(n).transition(np.pi / n, 0.0) @ state
    assert after_half_orbit(n) @ state == pytest.approx(half[1], abs=1e-9)


def test_beyond_is_exact_where_the_papers_bound_is_not() -> None:
    """From 300 m with a keep-out of 50 m, (8) takes 0.09490 m/s, which passes at 49.476 m; 0.09507 passes at 50 m."""
    near = Case(False, -300.0, 3600.0, "beyond", 0, 0, 0, 0, 0)
    firsts = []
    for safety in ("samples", "cone"):
        approach = near.approach(safety=safety)
        impulses, found = solved(approach)
        dv = abs(impulses.programme(found).dv_m_s[0, 0])
        state = approach.start.copy()
        state[3] -= dv
        firsts.append((dv, drift_clearance(state, approach.mean_motion_rad_s).distance_m[0]))
    assert firsts[0] == pytest.approx((0.09490, 49.476), abs=5e-3)
    assert firsts[0][0] == pytest.approx(0.09490, abs=2e-5)
    assert firsts[1][0] == pytest.approx(0.09507, abs=2e-5)
    assert firsts[1][1] == pytest.approx(50.0, abs=2e-3)


def test_the_mirrored_approach_costs_the_same() -> None:
    behind = CASES[0]
    ahead = behind.approach(start={"x_m": 1000.0}, capture={"x_m": 0.0, "z_m": -60.0})
    impulses, found = solved(ahead)
    other, reference = solved(behind.approach())
    assert found.objective == pytest.approx(reference.objective, abs=1e-8)
    mirrored = impulses.programme(found).dv_m_s * [-1, -1, 1]
    assert mirrored == pytest.approx(other.programme(reference).dv_m_s, abs=1e-6)


@pytest.mark.parametrize(
    ("start", "cost"), [({"y_m": 80.0}, 0.24214), ({"vy_m_s": 0.1}, 0.26729), ({}, 0.24163)]
)
def test_out_of_plane_costs_what_is_known(start: dict[str, float], cost: float) -> None:
    approach = CASES[10].approach(start={"x_m": -1000.0, **start})
    impulses, found = solved(approach)
    assert found.objective == pytest.approx(cost, abs=1e-5)
    end = states_after(impulses.programme(found), approach.start, approach.motion)[-1]
    there = approach.motion.transition(4200.0, 3150.0) @ end
    assert there[:3] == pytest.approx(approach.capture, abs=1e-4)


def test_a_plain_rendezvous_needs_no_conditions() -> None:
    scenario = CASES[0].scenario(
        keep_out_m=0.0,
        condition="none",
        capture={"x_m": 0.0, "z_m": 0.0, "vx_m_s": 0.0},
        impulses={"count": 2},
    )
    approach = Approach.of(scenario)
    assert equal_times(approach).tolist() == [0.0, 3600.0]
    impulses, found = solved(approach)
    programme = impulses.programme(found)
    motion = approach.motion
    matrix = motion.transition(3600.0, 0.0)
    first = np.linalg.solve(matrix[:2, 3:5], -matrix[:2] @ approach.start)
    assert programme.dv_m_s[0, :2] == pytest.approx(first, abs=1e-7)
    end = states_after(programme, approach.start, motion)[-1]
    assert end == pytest.approx(np.zeros(6), abs=1e-4)


def test_infeasible_names_the_conditions_that_contradict() -> None:
    impulses, found = solved(CASES[0].approach(impulses={"count": 2}))
    assert found.status is orbsoc.Status.PRIMAL_INFEASIBLE
    words = impulses.builder.why(found)
    assert CAPTURE in words
    assert drift_name(2) in words
