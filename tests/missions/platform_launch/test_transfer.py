"""Two impulses: every minimum of their cost, the series in the orbital rate, and the conic problems."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

import orbsoc
from orbsoc.missions.platform_launch.model.perturbation import (
    Approximation,
    PerturbationError,
    approximations,
    series,
)
from orbsoc.missions.platform_launch.model.transfer import (
    PLANE,
    Transfers,
    cost_of,
    flat_interval,
    in_plane,
    programme,
    singularity,
    stationary_minima,
)
from orbsoc.missions.platform_launch.search.rendezvous import Rendezvous, rendezvous
from orbsoc.orbit.relative import ClohessyWiltshire
from tests.missions.platform_launch.data import launched, paper

STATE, MOTION = paper().separation().state, paper().motion


def test_two_impulses_end_at_rest_at_the_target() -> None:
    found = programme(MOTION, in_plane(STATE), 920.95)
    state = STATE.copy()
    state[3:] += found.dv_m_s[0]
    end = MOTION.transition(920.95, 0.0) @ state
    end[3:] += found.dv_m_s[1]
    assert end == pytest.approx(np.zeros(6), abs=1e-9)


@pytest.mark.parametrize(
    ("force_n", "time_s", "cost", "first", "last"),
    [(500.0, 684.036, 1.20430, 0.8935, 0.6372), (300.0, 927.576, 0.61505, 0.6333, 0.4626)],
)
def test_the_optimum_by_force(force_n: float, time_s: float, cost: float, first: float, last: float) -> None:
    state = in_plane(launched(force_n).separation().state)
    best = Transfers.of(MOTION, MOTION.period_s).best(state)
    assert best.time_s == pytest.approx(time_s, abs=5e-3)
    assert best.cost == pytest.approx(cost, abs=5.1e-6)
    assert programme(MOTION, state, best.time_s).sizes_m_s == pytest.approx([first, last], abs=5.1e-5)


def test_all_minima_to_five_orbits() -> None:
    found = Transfers.of(MOTION, 5.0 * MOTION.period_s).minima(in_plane(STATE))
    times = [920.95, 6119, 8443, 11678, 14187, 17231, 19817, 22782, 25411]
    values = [0.62488, 1.469, 1.139, 1.440, 1.240, 1.430, 1.286, 1.425, 1.312]
    assert [each.time_s for each in found] == pytest.approx(times, abs=0.55)
    assert [each.cost for each in found] == pytest.approx(values, abs=5.1e-4)


@pytest.mark.parametrize("rate_rad_s", [MOTION.mean_motion_rad_s, 7.2921e-5])
@pytest.mark.parametrize("number", range(4))
def test_the_scan_misses_no_minimum(number: int, rate_rad_s: float) -> None:
    """Of any state, beside polynomials that have all of them; far out the wells beside singular times are narrow."""
    motion, random = ClohessyWiltshire(rate_rad_s), np.random.default_rng(number)
    state = np.concatenate([random.uniform(-800.0, 800.0, 2), random.uniform(-1.5, 1.5, 2)])
    longest = 4.0 * motion.period_s
    transfers = Transfers.of(motion, longest)
    scanned = [each for each in transfers.minima(state) if each.time_s < longest * (1.0 - 1e-6)]
    known = stationary_minima(motion, state, longest)
    assert [each.time_s for each in scanned] == pytest.approx(known, abs=1e-5 * motion.period_s)
    assert transfers.best(state).cost == pytest.approx(min(each.cost for each in transfers.minima(state)))


def test_the_cost_is_flat_about_its_least() -> None:
    best = Transfers.of(MOTION, MOTION.period_s).best(in_plane(STATE))
    assert flat_interval(MOTION, in_plane(STATE), best) == pytest.approx((800.4, 1070.1), abs=0.06)
    value = cost_of(MOTION, in_plane(STATE), "squares")
    table = {200: 7.400, 500: 0.979, 800: 0.637, 1200: 0.663, 3000: 1.511, 5000: 5.972}
    assert [value(float(t)) for t in table] == pytest.approx(list(table.values()), abs=5.1e-4)


def test_a_short_search_is_wrong_in_geostationary_orbit() -> None:
    """The least is at 1.41 orbits, not in the first well, whose time the series has to five milliseconds."""
    scenario = launched(orbit={"altitude_km": 35_786.0})
    found, motion = scenario.separation(), scenario.motion
    transfers = Transfers.of(motion, 5.0 * motion.period_s)
    first, *_ = transfers.minima(in_plane(found.state))
    best = transfers.best(in_plane(found.state))
    assert (first.time_s, first.cost) == (pytest.approx(696.476, abs=5e-4), pytest.approx(1.0618, abs=5e-5))
    assert (best.time_s / motion.period_s, best.cost) == pytest.approx((1.4147, 1.0392), abs=5.1e-5)
    times = [series(found.server, motion.mean_motion_rad_s, order)[0] for order in (0, 2)]
    assert times == pytest.approx([695.289, 696.48], abs=6e-4)


def test_singular_times_are_whole_revolutions_and_those_between() -> None:
    between = [
        brentq(lambda a: np.tan(a) - 0.75 * a, k * np.pi + 0.1, (k + 0.5) * np.pi - 1e-6) for k in (1, 2)
    ]
    assert between[0] / np.pi == pytest.approx(1.41, abs=5e-3)
    for half in (np.pi, 2.0 * np.pi, *between):
        assert abs(singularity(MOTION, 2.0 * half / MOTION.mean_motion_rad_s)) < 1e-9
    assert abs(singularity(MOTION, 0.1659 * MOTION.period_s)) > 0.05


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_series_falls_by_one_power_more_with_every_order(order: int) -> None:
    """Time and impulses against the exact optimum, as the orbital rate is halved."""
    server = np.array([30.0, -480.0, 0.9, 1.4])
    errors = []
    for rate in (2e-5, 1e-5):
        motion = ClohessyWiltshire(rate)
        plane = server[[1, 0, 3, 2]]
        best = Transfers(motion, *_around(motion, series(server, rate, 2)[0])).best(plane)
        _, first, last, cost = series(server, rate, order)
        exact = programme(motion, plane, best.time_s).dv_m_s[:, [1, 0]]
        errors.append(abs(cost - best.cost) + float(np.abs(np.array([first, last]) - exact).max()))
    assert np.log2(errors[0] / errors[1]) > order + 0.8
    assert errors[1] < 10.0 ** (-2 * order - 1)


def _around(motion: ClohessyWiltshire, time_s: float) -> tuple[np.ndarray, np.ndarray]:
    known = Transfers.of(motion, 3.0 * time_s)
    return known.times_s, known.matrices


def test_the_papers_series_is_worth_little_and_a_good_guess() -> None:
    zero, one, two = approximations(paper().separation().server, MOTION)
    assert (zero.time_s, one.time_s, two.time_s) == pytest.approx((692.43, 692.43, 976.70), abs=5e-3)
    assert zero.time_s == one.time_s  # the first order does not move the time
    assert [each.true_cost for each in (zero, one, two)] == pytest.approx(
        [0.6821, 0.6821, 0.6269], abs=5.1e-5
    )
    runs = [optimised(each) for each in (zero, one, two)]
    assert [time_s for time_s, _ in runs] == pytest.approx([920.954] * 3, abs=5e-3)
    assert all(iterations <= 15 for _, iterations in runs)


def optimised(guess: Approximation) -> tuple[float, int]:
    """The paper's nonlinear programme, five unknowns and four equalities, from a guess: its time, and iterations."""
    n = MOTION.mean_motion_rad_s
    start = in_plane(STATE)

    def miss(y: np.ndarray) -> np.ndarray:
        state = start + np.array([0.0, 0.0, y[1], y[0]])
        end = MOTION.transition(float(y[4]) * guess.time_s, 0.0)[np.ix_(PLANE, PLANE)] @ state
        return np.asarray(end * np.array([n, n, 1.0, 1.0]) + np.array([0.0, 0.0, y[3], y[2]]))

    found = minimize(
        lambda y: float(y[:4] @ y[:4]), np.concatenate([guess.first_m_s, guess.last_m_s, [1.0]]), method="SLSQP",
        constraints={"type": "eq", "fun": miss}, options={"ftol": 1e-12},
    )  # fmt: skip
    return float(found.x[4]) * guess.time_s, int(found.nit)


def test_a_server_that_moves_away_has_no_series() -> None:
    with pytest.raises(PerturbationError, match=r"r · v = 500 m²/s: must be below 0"):
        series([0.0, 500.0, 0.0, 1.0], 1e-3, 0)


def met(**options: object) -> Rendezvous:
    defaults = {"cost": "norms", "longest_s": 5.0 * MOTION.period_s, "time_s": None, "generated": False}
    return rendezvous(STATE, MOTION, **(defaults | options), solve=orbsoc.solve)  # type: ignore[arg-type]


def test_two_impulses_are_optimal_up_to_their_best_time_and_no_longer() -> None:
    best = met()
    assert (best.time_s, best.value) == (pytest.approx(1064.3, abs=0.05), pytest.approx(1.0958, abs=5e-5))
    assert best.primer(np.linspace(0.0, best.time_s, 201)).max() <= 1.0 + 1e-9
    later = met(time_s=MOTION.period_s * 0.9)
    assert later.primer(np.linspace(0.0, later.time_s, 201)).max() > 1.05


@pytest.mark.parametrize(
    ("orbits", "known", "above"),
    [(0.15, None, 0.0), (1.0, 0.9793, 2.5e-4), (1.5, 0.7226, 5e-4), (3.0, 0.7223, 2e-4)],
)
def test_generated_impulses_reach_their_bound(orbits: float, known: float | None, above: float) -> None:
    """No worse than the known optima on a grid of times, and better by no more than the grid explains."""
    found = met(time_s=orbits * MOTION.period_s, generated=True)
    assert found.value - found.lower_bound < 2e-6 * found.value
    assert len(found.subproblems) <= 12
    if known is not None:
        assert known - above <= found.value <= known
    else:
        assert len(found.programme) == 2


def test_the_duals_of_the_squares_are_the_papers_multipliers() -> None:
    """λ_v = −2 Δv_f: the multiplier of the velocity at the target."""
    found = met(cost="squares")
    dual = found.impulses.builder.dual(found.solution, "rest at the target")
    np.testing.assert_allclose(dual[2:], -2.0 * found.programme.dv_m_s[1, :2], atol=1e-8)
    assert found.value == pytest.approx(0.62488, abs=5.1e-6)
