"""Independent verification: its formulas against a second, dense writing of them, and its certificates against true bounds."""

from __future__ import annotations

import dataclasses
import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from orbsoc.conic.problem import Cones, Problem, ProblemError
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import (
    Residuals,
    check_certificate,
    dual_infeasibility_radius,
    primal_infeasibility_radius,
    project,
    verify,
)
from tests.strategies import Array, Point, cones, point
from tests.zoo import cases
from tests.zoo.false_claims import powell_20_with_100
from tests.zoo.known import complementary_pair

SEEDS = st.integers(0, 2**32 - 1)
INF = float("inf")
CASES = {case.name: case for case in cases()}


def optimum(seed: int, l: int = 4, q: tuple[int, ...] = (3, 5)) -> tuple[Problem, Point]:
    """A quadratic cone program built around its optimal point."""
    rng = np.random.default_rng(seed)
    kind = Cones(l, q)
    A, G, factor = rng.normal(size=(2, 6)), rng.normal(size=(kind.m, 6)), rng.normal(size=(3, 6))
    x, y = rng.normal(size=6), rng.normal(size=2)
    s, z = complementary_pair(rng, kind, "b")
    P = factor.T @ factor
    c = -P @ x - A.T @ y - G.T @ z
    return Problem(P=P, c=c, A=A, b=A @ x, G=G, h=G @ x + s, cones=kind), Point(x, y, z, s)


@given(cones(), SEEDS, st.floats(-3, 3))
def test_projection_is_moreaus_decomposition(kind: Cones, seed: int, decade: float) -> None:
    """v = Π_K(v) − Π_K(−v) with orthogonal parts, both in K: that is the projection on a self-dual cone."""
    v = np.random.default_rng(seed).normal(size=kind.m) * 10.0**decade
    inside, outside = project(v, kind), project(-v, kind)
    size = 1.0 + float(np.linalg.norm(v))
    np.testing.assert_allclose(inside - outside, v, rtol=0, atol=1e-14 * size)
    assert abs(inside @ outside) <= 1e-14 * size**2
    for part in (inside, outside):
        assert np.all(part[: kind.l] >= 0.0)
        for rows in kind.second_order():
            assert np.linalg.norm(part[rows][1:]) <= part[rows][0] + 1e-14 * size


def dense_distance(v: Array, kind: Cones) -> float:
    """‖v − Π_K(v)‖∞ from the eigenvalues t ± ‖u‖ of each block and their eigenvectors ½(1, ±u/‖u‖)."""
    worst = max((0.0, *(-float(entry) for entry in v[: kind.l])))
    for rows in kind.second_order():
        t, u = float(v[rows][0]), v[rows][1:]
        norm = float(np.linalg.norm(u))
        direction = u / norm if norm > 0.0 else np.zeros_like(u)
        removed = np.zeros(u.size + 1)
        for eigenvalue, sign in ((t + norm, 1.0), (t - norm, -1.0)):
            removed += min(eigenvalue, 0.0) * 0.5 * np.concatenate([[1.0], sign * direction])
        worst = max(worst, float(np.abs(removed).max()))
    return worst


@given(SEEDS, st.floats(-6, 1))
def test_verify_is_the_published_formula(seed: int, decade: float) -> None:
    problem, best = optimum(seed)
    rng = np.random.default_rng(seed + 1)
    x, y, z = (v + 10.0**decade * rng.normal(size=v.size) for v in (best.x, best.y, best.z))
    P, A, G = problem.P.toarray(), problem.A.toarray(), problem.G.toarray()
    b, h, c = problem.b, problem.h, problem.c
    primal = max(np.abs(A @ x - b).max(), dense_distance(h - G @ x, problem.cones))
    dual = max(np.abs(P @ x + c + A.T @ y + G.T @ z).max(), dense_distance(z, problem.cones))
    p, d = 0.5 * x @ P @ x + c @ x, -0.5 * x @ P @ x - b @ y - h @ z
    found = verify(problem, Point(x, y, z, np.full(problem.m, np.nan)))  # the slack is not looked at
    assert found.pres == pytest.approx(
        primal / (1 + max(np.abs(b).max(), np.abs(h).max())), rel=1e-9, abs=1e-15
    )
    assert found.dres == pytest.approx(dual / (1 + np.abs(c).max()), rel=1e-9, abs=1e-15)
    assert found.gap == pytest.approx(abs(p - d) / (1 + min(abs(p), abs(d))), rel=1e-9, abs=1e-13)
    assert found.worst == max(found.pres, found.dres, found.gap)


@given(SEEDS)
def test_an_optimal_point_passes_and_supports_solved(seed: int) -> None:
    problem, best = optimum(seed)
    assert verify(problem, best).worst <= 1e-13
    assert check_certificate(problem, best).supports(Status.SOLVED, 1e-13)


@given(SEEDS, st.sampled_from(["x", "y", "z", "s"]), st.integers(0, 11))
def test_a_change_of_any_entry_is_seen(seed: int, name: str, place: int) -> None:
    problem, best = optimum(seed)
    changed = getattr(best, name).copy()
    changed[place % changed.size] += 1e-3
    wrong = dataclasses.replace(best, **{name: changed})
    assert check_certificate(problem, wrong).worst_line()[1] > 1e-6
    if name != "s":
        assert verify(problem, wrong).worst > 1e-6


@pytest.mark.parametrize("name", ["x", "y", "z", "s"])
@pytest.mark.parametrize("poison", [np.nan, INF, -INF])
def test_a_point_that_is_not_finite_supports_nothing(name: str, poison: float) -> None:
    problem, best = optimum(3)
    vector = getattr(best, name).copy()
    vector[-1] = poison
    wrong = dataclasses.replace(best, **{name: vector})
    assert not check_certificate(problem, wrong).supports(Status.SOLVED, 1e300)
    if name != "s":
        assert verify(problem, wrong).worst == INF
    for status in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE):
        residuals = check_certificate(problem, dataclasses.replace(wrong, status=status))
        assert not residuals.supports(status, 1e-8)


def test_a_cone_of_one_row_that_is_not_a_number_is_infinitely_far() -> None:
    problem = Problem(c=[1.0], G=[[-1.0]], h=[0.0], cones=Cones(q=[1]))
    assert verify(problem, point(problem, [0.0], z=[np.nan])).dres == INF


def test_rows_that_do_not_constrain_take_no_part_but_must_have_no_multiplier() -> None:
    problem = Problem(c=[1.0, 0.0], G=-np.eye(2), h=[0.0, INF], cones=Cones(l=2))
    best = point(problem, [0.0, -1e6], z=[1.0, 0.0])
    assert verify(problem, best).worst == 0.0
    assert check_certificate(problem, best).supports(Status.SOLVED, 0.0)
    assert verify(problem, point(problem, [0.0, 0.0], z=[1.0, 0.5])).dres >= 0.25


def test_a_residual_is_attributed_to_its_line() -> None:
    problem = Problem(c=[0.0, 0.0], A=[[1.0, 0.0]], b=[1.0], G=-np.eye(2), h=[0.0, 0.0], cones=Cones(0, [2]))
    good = Point(np.array([1.0, 0.0]), np.zeros(1), np.zeros(2), np.array([1.0, 0.0]))
    assert check_certificate(problem, good).worst_line()[1] == 0.0
    lines = {
        "equality": {"x": np.array([3.0, 0.0]), "s": np.array([3.0, 0.0])},
        "inequality": {"s": np.array([4.0, 0.0])},
        "slack_cone": {"x": np.array([1.0, 3.0]), "s": np.array([1.0, 3.0])},
        "stationarity": {"y": np.array([0.0]), "z": np.array([2.0, 0.0])},
        "dual_cone": {"z": np.array([-9.0, 0.0])},
        "gap": {"y": np.array([1.0]), "z": np.array([1.0, 0.0])},
    }
    for line, change in lines.items():
        residuals = check_certificate(problem, dataclasses.replace(good, **change))
        assert getattr(residuals, line) > 0.0, line
    ratios = check_certificate(problem, dataclasses.replace(good, **lines["equality"]))
    assert ratios.equality == 2.0 / (1.0 + 3.0)
    assert ratios.worst_line() == ("equality", 0.5)


def test_points_of_integers_and_lists_are_judged_as_those_of_arrays() -> None:
    problem = Problem(c=[1.0, 2.0], A=[[1.0, 1.0]], b=[3.0], G=-np.eye(2), h=[0.0, 0.0], cones=Cones(l=2))
    plain = SimpleNamespace(x=[3, 0], y=[-1], z=np.array([0, 1]))
    assert verify(problem, plain).worst == 0.0
    with pytest.raises(
        ProblemError, match=r"`solution\.y` has entries of type object; they must be real numbers"
    ):
        verify(problem, SimpleNamespace(x=[3, 0], y=None, z=[0, 1]))


@pytest.mark.parametrize("name", ["x", "y", "z", "s"])
def test_vectors_of_a_wrong_size_are_refused_by_name(name: str) -> None:
    problem, best = optimum(4)
    wrong = dataclasses.replace(best, **{name: np.zeros(1)})
    with pytest.raises(ProblemError, match=re.escape(f"`solution.{name}` has shape (1,)")):
        check_certificate(problem, wrong)


def test_the_radius_of_crossed_bounds_is_what_one_computes_by_hand() -> None:
    """x ≥ 1 and x ≤ 0 with multipliers (1, 1.01): gain 1, remainder 0.01, hence no feasible |x| < 100."""
    problem = Problem(c=[0.0], G=[[-1.0], [1.0]], h=[-1.0, 0.0], cones=Cones(l=2))
    assert primal_infeasibility_radius(problem, np.zeros(0), np.array([1.0, 1.0])) == INF
    assert primal_infeasibility_radius(problem, np.zeros(0), np.array([1.0, 1.01])) == pytest.approx(100.0)
    assert primal_infeasibility_radius(problem, np.zeros(0), np.array([1.0, -5.0])) == 1.0  # −5 is projected
    assert primal_infeasibility_radius(problem, np.zeros(0), np.array([0.0, 1.0])) == 0.0


def test_the_radius_of_a_falling_ray_is_what_one_computes_by_hand() -> None:
    """min −x, x ≥ 0 with x₁ ≤ 1 beside it: the ray (1, 0.02) breaks that bound by 0.02, hence 50."""
    problem = Problem(c=[-1.0, 0.0], G=[[-1.0, 0.0], [0.0, 1.0]], h=[0.0, 1.0], cones=Cones(l=2))
    assert dual_infeasibility_radius(problem, np.array([1.0, 0.0])) == INF
    assert dual_infeasibility_radius(problem, np.array([1.0, 0.02])) == pytest.approx(50.0)
    assert dual_infeasibility_radius(problem, np.array([-1.0, 0.0])) == 0.0


@given(cones(), SEEDS, st.floats(-3, 3))
def test_no_pair_certifies_a_radius_beyond_a_feasible_point(kind: Cones, seed: int, decade: float) -> None:
    """x = −t·sign(Aᵀy + Gᵀz) with s = 0 is the feasible point that the certified radius just reaches."""
    rng = np.random.default_rng(seed)
    A, G = rng.normal(size=(2, 5)), rng.normal(size=(kind.m, 5))
    y, z = rng.normal(size=2), project(rng.normal(size=kind.m), kind)
    x = -(10.0**decade) * np.sign(A.T @ y + G.T @ z)
    largest = float(np.abs(x).max())

    def radius(s: Array) -> float:
        feasible = Problem(c=np.zeros(5), A=A, b=A @ x, G=G, h=G @ x + s, cones=kind)
        return primal_infeasibility_radius(feasible, y, z)

    assert radius(np.zeros(kind.m)) == pytest.approx(largest, rel=1e-9)
    s, _ = complementary_pair(rng, kind, "s")
    assert radius(s) <= largest * (1.0 + 1e-9)


@given(SEEDS)
def test_no_ray_certifies_a_radius_beyond_a_dual_feasible_point(seed: int) -> None:
    problem, best = optimum(seed)
    ray = np.random.default_rng(seed + 1).normal(size=problem.n)
    largest = max(float(np.abs(v).max()) for v in (best.x, best.y, best.z))
    assert dual_infeasibility_radius(problem, ray) <= largest * (1.0 + 1e-9)


def test_the_false_certificate_of_powell_20_does_not_support_a_claim() -> None:
    """Multipliers near 1 on a feasible problem: rounding leaves a radius far below 50 times the scale."""
    problem = powell_20_with_100().problem
    rng = np.random.default_rng(1)
    for noise in (0.0, 1e-12, 1e-9, 1e-6):
        z = 1.0 + noise * rng.normal(size=problem.m)
        claim = point(problem, np.zeros(problem.n), z=z, status=Status.PRIMAL_INFEASIBLE)
        residuals = check_certificate(problem, claim)
        assert residuals.own_radius < 1.0
        assert not residuals.supports(Status.PRIMAL_INFEASIBLE, 1e-8)


def test_a_claim_needs_fifty_times_the_problems_own_scale() -> None:
    numbers = dict.fromkeys(("equality", "inequality", "slack_cone", "stationarity", "dual_cone", "gap"), 1.0)
    for status in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE):
        assert Residuals(**numbers, radius=1.0, own_radius=50.0).supports(status, 1e-8)
        assert not Residuals(**numbers, radius=1e9, own_radius=49.9).supports(status, 1e-8)
    assert not Residuals(**numbers, radius=INF, own_radius=INF).supports(Status.SOLVED, 0.999)
    assert Residuals(**numbers, radius=float("nan"), own_radius=float("nan")).supports(
        Status.SOLVED_INACCURATE, 1.0
    )


@pytest.mark.parametrize("name", ["lp_open_quadrant", "lp_crossed_bounds", "socp_disjoint_balls"])
def test_the_optimal_looking_origin_supports_no_claim(name: str) -> None:
    problem = CASES[name].problem
    for status in (Status.SOLVED, Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE):
        origin = point(problem, np.zeros(problem.n), status=status)
        assert not check_certificate(problem, origin).supports(status, 1e-5)


def test_what_is_no_problem_or_no_point_is_a_type_error() -> None:
    problem, optimal = optimum(0)
    with pytest.raises(TypeError, match="`solution` is of type int; it must have x, y and z"):
        verify(problem, 3)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=re.escape("`problem` is of type int; it must be an orbsoc.Problem")):
        verify(3, optimal)  # type: ignore[arg-type]
