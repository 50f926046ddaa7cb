"""Fewest pulses with the first one at any time: starts in motion, where a coast comes first."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.missions.fly_around import audit, plan
from orbsoc.missions.fly_around.model.flight import fly
from orbsoc.missions.fly_around.search.coasting import coasting_bound
from orbsoc.missions.fly_around.search.fewest import coast_end, even_bound, partition
from orbsoc.missions.fly_around.search.times import least_error
from orbsoc.missions.fly_around.search.tube import Revolution, Tube

from .baseline import scenario

FOUR = [
    (140.85255447864947, -0.09881937215327784, 0.10122804393746997, 0.588717566204989),
    (580.8891804160489, -0.10633824692020483, 0.5029302581911099, -0.17746317613132592),
    (969.0292092367757, 0.05204465301716862, 0.008211765626264753, -0.7516299028598117),
    (1383.0748565738636, 0.14725638815042172, -0.4753531367635141, -0.017809829428390763),
]
"""Times, s, and pulses, m/s, of four whose flight strays 19.397 m."""


def moving(axes: tuple[float, float] = (200.0, 150.0), share: float = 1.0, **changes: Any) -> Any:
    """A fly-around that starts with a share of the path's own velocity."""
    speed = -axes[1] * 2.0 * pi / 1800.0 * share
    base: dict[str, Any] = {
        "impulses": "fewest",
        "tolerance_m": 20.0,
        "truth": {"excess_share": 0.0},
        "target": {"altitude_km": 500.0, "inc_deg": 30.0},
        "ellipse": {"semi_axes_m": list(axes), "angles_deg": [60.0, 45.0, 30.0], "period_s": 1800.0},
        "start": {"x_m": axes[0], "y_m": 0.0, "z_m": 0.0, "vz_m_s": speed},
    }
    return scenario(**(base | changes))


def test_a_start_in_motion_needs_4_pulses_and_3_are_proved_too_few() -> None:
    found = plan(moving())
    assert found.search is not None
    assert (found.search.pulses, found.search.impossible, found.search.certified) == (4, 3, True)
    assert found.to_dict()["pulses"] == 4
    assert found.verification is not None
    assert found.verification.flown.largest_error_m <= 20.0 + 1e-4
    assert [each.number for each in found.verification.cut_burns] == [1, 2, 3, 4]


def test_a_programme_given_has_as_many_pulses_as_it_fires() -> None:
    rows = np.array(FOUR)
    found = audit(moving(), ImpulseProgramme(rows[:, 0], rows[:, 1:]))
    assert found.to_dict()["pulses"] == 4
    assert found.verification is not None
    assert found.verification.flown.largest_error_m == pytest.approx(19.397, abs=1e-3)
    assert "4 pulses" in str(found.verdict)


@pytest.mark.parametrize("seed", range(20))
def test_no_flight_after_a_coast_beats_either_bound(seed: int) -> None:
    """Random starts, numbers of pulses and times of the first one: the best flight found strays no less."""
    random = np.random.default_rng(seed)
    axes = (float(random.uniform(100.0, 250.0)), float(random.uniform(80.0, 200.0)))
    given = moving(axes, float(random.uniform(0.0, 1.2)))
    flight, start, end_s = given.flight, given.start_state, given.duration_s
    pulses = int(random.integers(2, 5))
    level = even_bound(flight, start[:3], end_s, pulses, solve=orbsoc.solve).bound_m
    left = coast_end(flight, start, end_s, level)
    assert left < end_s
    simple = min(level, even_bound(flight, None, end_s, pulses, solve=orbsoc.solve, from_s=left).bound_m)
    finer = coasting_bound(flight, start, end_s, pulses, left, level, solve=orbsoc.solve)
    assert 0.0 < max(simple, finer) <= level
    for share in (0.02, 0.5, 0.98):
        times = np.append(0.0, partition(flight, end_s, np.ones(pulses), share * left)[:-1])
        best = least_error(Revolution(flight, start, end_s, orbsoc.solve, coast=True), times)
        assert isinstance(best, Tube)
        assert not best.programme.dv_m_s[0].any()
        strays = fly(flight, start, best.programme, end_s, 2000).largest_error_m
        assert max(simple, finer) <= strays + 1e-5
