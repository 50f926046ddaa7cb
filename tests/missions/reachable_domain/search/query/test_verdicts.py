"""Orbits that a flown burn ends on are never called beyond reach: the first of those in docs/measurements/reach-verdicts.md."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np
import pytest

from benchmarks.reach_verdicts import solved, trials
from orbsoc.missions.reachable_domain.search.continuation.boundary import first_azimuths, solve_boundary
from orbsoc.missions.reachable_domain.search.query.shortest_burn import LONGER_REL
from orbsoc.reach import ReachableDomain

COUNT = 20


@cache
def domain(name: str) -> ReachableDomain:
    return solved(name)


@pytest.mark.parametrize("name", ["kick stage", "short burn"])
def test_no_orbit_that_was_flown_is_beyond_reach(name: str) -> None:
    found = list(islice(trials(name, domain(name), 2 * COUNT, exact_every=COUNT), COUNT))
    assert {trial.kind for trial in found} == {"flown"}
    assert [trial.contradiction for trial in found if trial.contradiction] == []
    assert found[0].exact == "within reach"
    assert found[0].exact_s <= (1.0 + LONGER_REL) * found[0].known_s


def test_an_edge_on_too_few_azimuths_says_how_far_off_it_may_be() -> None:
    whole = domain("short burn").limit
    cut_off = replace(
        domain("short burn"),
        boundary=solve_boundary(domain("short burn").domain, first_azimuths(domain("short burn").domain)),
    ).limit
    tip = whole.azimuth_deg[whole.table[:, 0].argmax()]
    missing = whole(tip, 440.0) - cut_off(tip, 440.0)
    assert missing > 0.1
    assert missing <= cut_off.error_deg(tip, 440.0)


def test_a_domain_a_hundred_times_as_long_as_wide_keeps_its_length() -> None:
    """100 m/s across the orbit of a 20 s burn turn it by 0.76 degrees; 0.31 on 48 equal azimuths."""
    limit = domain("short burn").limit
    assert limit.table[:, 0].max() / limit.table[:, 0].min() > 100.0
    vehicle, burn_s = domain("short burn").scenario.vehicle, 20.0
    left = vehicle.mass_kg - vehicle.mass_flow_kg_s * burn_s
    delta_v = vehicle.thrust_n / vehicle.mass_flow_kg_s * np.log(vehicle.mass_kg / left)
    speed = float(np.linalg.norm(domain("short burn").scenario.initial_eci()[3:]))
    assert limit.table[:, 0].max() == pytest.approx(np.rad2deg(np.arctan2(delta_v, speed)), rel=0.01)
