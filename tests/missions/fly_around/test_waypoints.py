"""The paper's flight: 19 pulses by exact errors, 20 at equal intervals, and the rule that explains both."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.missions.fly_around.model.flight import fly
from orbsoc.missions.fly_around.model.waypoints import (
    adaptive_times,
    arc_error,
    counts_by_rule,
    equal_times,
    through_waypoints,
)
from orbsoc.missions.fly_around.paper import printed_times

from .baseline import scenario

PAPER = scenario()
FLIGHT, START = PAPER.flight, PAPER.start_state


def test_the_rule_of_the_curvature_counts_18_036_and_19_981_intervals() -> None:
    assert counts_by_rule(FLIGHT, 1800.0, 2.0) == pytest.approx((18.0356, 19.9813), abs=1e-3)


@pytest.mark.parametrize(
    ("times", "pulses", "error_m", "dv_m_s", "absolutes_m_s", "speeds_m_s"),
    [
        (adaptive_times(FLIGHT, START[:3], 1800.0, 2.0), 19, 2.0, 3.3150, 4.534, 11.434),
        (equal_times(FLIGHT, START[:3], 1800.0, 2.0), 20, 1.9911, 3.2374, 4.469, 12.230),
        (np.linspace(0.0, 1800.0, 20), 19, 2.2051, 3.2261, 4.448, 11.613),
    ],
    ids=["adaptive", "equal", "19 equal"],
)
def test_pulses_errors_and_velocity_changes_of_the_paper(
    times: np.ndarray, pulses: int, error_m: float, dv_m_s: float, absolutes_m_s: float, speeds_m_s: float
) -> None:
    programme = through_waypoints(FLIGHT, START, times)
    flown = fly(FLIGHT, START, programme, 1800.0)
    dense = fly(FLIGHT, START, programme, 1800.0, 2000)
    assert len(programme) == pulses
    assert dense.largest_error_m == pytest.approx(error_m, abs=1e-4)
    assert flown.largest_error_m == pytest.approx(dense.largest_error_m, abs=2e-6)
    assert programme.total_m_s == pytest.approx(dv_m_s, abs=1e-4)
    assert programme.total_absolutes_m_s == pytest.approx(absolutes_m_s, abs=1e-3)
    assert flown.post_burn_speeds_m_s == pytest.approx(speeds_m_s, abs=1e-3)


def test_18_arcs_miss_the_end_by_the_last_seconds_and_a_little_more_tolerance_saves_a_pulse() -> None:
    times = adaptive_times(FLIGHT, START[:3], 1800.0, 2.0)
    assert times[-2] == pytest.approx(1798.4, abs=0.1)
    assert len(adaptive_times(FLIGHT, START[:3], 1800.0, 2.05)) - 1 == 18


@pytest.mark.parametrize(
    ("along", "pulses", "error_m"), [(5.0, 11, 14.7), (0.0, 14, 4.0)], ids=["as printed", "A = 0"]
)
def test_the_papers_rule_as_printed_gives_neither_its_count_nor_its_error(
    along: float, pulses: int, error_m: float
) -> None:
    times = printed_times(FLIGHT, 1800.0, 2.0, along=along)
    flown = fly(FLIGHT, START, through_waypoints(FLIGHT, START, times), 1800.0)
    assert len(times) - 1 == pulses
    assert flown.largest_error_m == pytest.approx(error_m, abs=0.05)


def test_one_interval_fewer_is_too_few_where_the_rule_says_one_more() -> None:
    """A large ellipse: the rule says 15, the exact errors 14."""
    period = 0.8 * scenario().motion.period_s
    large = scenario(ellipse={"semi_axes_m": [2000.0, 1000.0], "period_s": period}, tolerance_m=200.0)
    flight, start = large.flight, large.start_state[:3]
    for tolerance in (20.0, 60.0, 200.0):
        times = equal_times(flight, start, period, tolerance)
        count = len(times) - 1

        def worst(count: int) -> float:
            step = period / count
            return max(
                arc_error(flight, flight.ellipse.position(k * step), k * step, step) for k in range(count)
            )

        assert worst(count) <= tolerance
        assert period / (count - 1) >= flight.longest_transfer_s or worst(count - 1) > tolerance


def test_the_natural_ellipse_needs_three_intervals_for_the_transfers_alone() -> None:
    period = scenario().motion.period_s
    flight = scenario(
        ellipse={"semi_axes_m": [200.0, 100.0], "angles_deg": [0.0, 0.0, 0.0], "period_s": period}
    ).flight
    times = adaptive_times(flight, flight.ellipse.position(0.0), period, 2.0)
    assert len(times) - 1 == 3
    assert np.diff(times).max() < flight.longest_transfer_s
