"""Targets with elements left free: what is given is reached, what is free is used, and wrong combinations are told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.made_missions import Mission
from benchmarks.missions import ANGLES, freed, mission
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.missions.reachable_insertion import PlanStatus, Scenario, load_scenario, plan
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.missions.reachable_insertion.search.setup import target_of
from orbsoc.missions.reachable_insertion.targets.free_target import FreeTarget
from orbsoc.missions.reachable_insertion.targets.rows import Row
from orbsoc.missions.reachable_insertion.targets.table import STATE
from orbsoc.orbit import EARTH, CanonicalUnits, Elements, state_from_elements

from .test_scenario import SCENARIOS

UNITS = CanonicalUnits.of(EARTH)


def targeted(base: Scenario, **target: Any) -> Scenario:
    return base.with_changes(target={"position_m": None, "velocity_m_s": None} | target)


def elements(orbit: Elements) -> dict[str, float]:
    angles = np.rad2deg([orbit.inc_rad, orbit.raan_rad, orbit.argp_rad]).tolist()
    return {"sma_km": orbit.sma_m / 1e3, "ecc": orbit.ecc, **dict(zip(ANGLES, angles, strict=True))}


@pytest.mark.parametrize(
    ("number", "free", "shape"),
    [
        (0, ("raan_deg",), ""),
        (1, ("argp_deg",), ""),
        (3, ("raan_deg", "argp_deg"), ""),
        (7, ANGLES, ""),
        (2, ("argp_deg", "shape"), "sma_km"),
        (4, (*ANGLES, "shape"), "sma_km"),
        (9, (*ANGLES, "shape"), "ecc"),
        (12, ("shape",), "perigee_height_km"),
    ],
)
def test_a_free_element_makes_no_burn_longer_and_what_is_given_is_flown(
    number: int, free: tuple[str, ...], shape: str
) -> None:
    """A programme flown forward ends on the orbit, so that its burn bounds the shortest one from above."""
    made = freed(mission(11, number), free, shape)
    target = made.scenario.target
    found = plan(made.scenario)
    assert found.status is PlanStatus.VERIFIED
    assert found.time_of_flight_s <= 1.001 * made.burn_s
    assert found.verification is not None
    flown = elements(found.verification.propagated_orbit)
    height = (found.verification.propagated_orbit.perigee_radius_m - EARTH.earth_radius_m) / 1e3
    flown["perigee_height_km"] = height
    for key, ours in flown.items():
        asked = getattr(target, key)
        by = max(flown["ecc"], 1e-3) if key == "argp_deg" else 1.0
        assert asked is None or ours == pytest.approx(asked, rel=1e-6, abs=1e-5 / by), key


def test_the_whole_orbit_that_a_free_target_chose_takes_the_same_burn() -> None:
    """Planned with the vectors H and L, which share no row with free targets; the engine's own deorbit takes 300.5 s."""
    base = load_scenario(SCENARIOS / "deorbit.toml")
    free = plan(targeted(base, free=list(ANGLES), perigee_height_km=50.0, apogee_height_km=500.0))
    assert free.verification is not None
    whole = plan(targeted(base, **elements(free.verification.propagated_orbit)))
    assert whole.time_of_flight_s == pytest.approx(free.time_of_flight_s, rel=1e-6)
    assert free.time_of_flight_s == pytest.approx(
        290.067, abs=2e-3
    )  # that of the best ignition: the shape alone
    freer = plan(targeted(base, free=[*ANGLES, "shape"], perigee_height_km=50.0))
    assert freer.time_of_flight_s < free.time_of_flight_s


def test_the_rows_slopes_are_those_of_differences_and_vanish_on_the_orbit() -> None:
    orbit = Elements(7.2e6, 0.05, 0.9, 1.0, 0.3, 2.1)
    end_si = np.concatenate(state_from_elements(orbit))
    end = UNITS.state_from_si(end_si)
    base = load_scenario(SCENARIOS / "deorbit.toml")
    for free in (
        ("raan_deg",),
        ("argp_deg",),
        ANGLES,
        ("inc_deg", "raan_deg", "argp_deg", "shape"),
        ("shape",),
    ):
        on_it = base.with_changes(target=dict(zip(STATE, end_si.reshape(2, 3).tolist(), strict=True)))
        target = target_of(freed(Mission("", on_it, 0.0), free, "perigee_height_km").scenario, UNITS)
        assert isinstance(target, FreeTarget)
        assert np.abs(target.conditions(end[None])).max() < 1e-12
        near = end + 0.01 * np.array([1.0, -2.0, 0.5, 0.3, 0.7, -0.4])
        steps = 1e-6 * np.eye(6)
        by_differences = (target.conditions(near + steps) - target.conditions(near - steps)).T / 2e-6
        np.testing.assert_allclose(target.jacobians(near[None])[0], by_differences, atol=1e-8)


def test_what_is_missed_is_told_in_its_own_unit() -> None:
    base = load_scenario(SCENARIOS / "deorbit.toml")
    free = {"free": ["raan_deg", "argp_deg", "shape"], "inc_deg": 85.0}
    little = base.with_changes(vehicle={"dry_mass_kg": 980.0}, burn={"duration_s": 50.0})
    found = plan(targeted(little, **free))
    assert target_of(found.scenario, UNITS).rows == (Row.INCLINATION,)
    assert found.status is PlanStatus.INFEASIBLE  # proved: 61 m/s turn no plane by 10 degrees
    weak = base.with_changes(vehicle={"dry_mass_kg": 100.0, "thrust_n": 20.0})
    found = plan(targeted(weak, **free))
    assert found.status is not PlanStatus.VERIFIED
    assert "inclination too" in details(found)


@pytest.mark.parametrize(
    ("target", "complaint"),
    [
        ({"free": ["inc_deg", "raan_deg", "shape"], "argp_deg": 1.0}, r"target\.argp_deg = 1\.0: needs target\.inc_deg"),
        ({"free": ["inc_deg", "argp_deg", "shape"], "raan_deg": 1.0}, r"target\.raan_deg = 1\.0: needs target\.inc_deg"),
        ({"free": [*ANGLES, "shape"]}, r"target\.free = .*leaves nothing to reach"),
        ({"free": [*ANGLES, "shape"], "sma_km": 7e3, "ecc": 0.1}, r"target = sma_km, ecc: with \"shape\" in target\.free"),
        ({"free": list(ANGLES), "sma_km": 7e3}, r"target = sma_km: must be two of"),
        ({"free": [*ANGLES, "inc_deg"], "sma_km": 7e3, "ecc": 0.1}, r"target\.free = .*each at most once"),
        ({"free": list(ANGLES), "inc_deg": 3.0, "sma_km": 7e3, "ecc": 0.1}, r"target\.inc_deg = 3\.0: is in target\.free"),
        ({"free": ["node"], "sma_km": 7e3, "ecc": 0.1}, r"target\.free"),
    ],
)  # fmt: skip
def test_wrong_combinations_are_refused_by_key(target: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ScenarioError, match=complaint):
        targeted(load_scenario(SCENARIOS / "deorbit.toml"), **target)


def test_a_guess_that_no_step_moves_is_left_without_a_warning() -> None:
    shipped = load_scenario(SCENARIOS / "deorbit_by_elements.toml")
    heavy = shipped.with_changes(
        vehicle={"mass_kg": 3000.0}
    )  # no coefficient of its first law moves a condition
    assert plan(heavy).status is PlanStatus.VERIFIED
