"""Two burns with J2 on the coasts: against an integration of the textbook's equation, and what plans without J2 are worth."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import BarycentricInterpolator

from benchmarks.two_burn_missions import transfer, unreachable_transfer
from orbsoc.missions.reachable_insertion import PlanStatus, ScenarioError, TwoBurnPlan, load_scenario, plan
from orbsoc.missions.reachable_insertion.model.proof import proof_of_infeasibility
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.two_burns.flight import sensitivities
from orbsoc.missions.reachable_insertion.two_burns.motion import Motion
from orbsoc.missions.reachable_insertion.two_burns.search import proof_for_two_burns
from orbsoc.missions.reachable_insertion.two_burns.verdict import verdict
from orbsoc.missions.reachable_insertion.two_burns.verification import verify
from orbsoc.orbit import EARTH

Array = NDArray[np.float64]
RAISE = Path(__file__).resolve().parents[4] / "scenarios" / "raise_two_burns.toml"
WAIT: dict[str, Any] = {"burn.ignition": "free", "burn.latest_ignition_s": 40000.0}


@cache
def planned(*, j2: bool, wait: bool) -> TwoBurnPlan:
    """The shipped raise; `wait`: with the target's node 2.5° to the west, and eleven hours until the first ignition."""
    settings: dict[str, Any] = {"axes": "eci", "burn.coast_j2": j2}
    if wait:
        settings |= {**WAIT, "target.raan_deg": 357.5}
    found = plan(load_scenario(RAISE, settings))
    assert isinstance(found, TwoBurnPlan)
    assert found.status is PlanStatus.VERIFIED, verdict(found)
    return found


def flown(found: TwoBurnPlan, *, j2: bool) -> Array:
    """The end of a plan by SciPy: r̈ of the textbook (Vallado, section 8.6), the thrust by SciPy's interpolation of the nodes."""
    vehicle, transfer = found.scenario.vehicle, found.transfer
    assert transfer is not None
    state, mass, now = found.scenario.initial.vector(), vehicle.mass_kg, 0.0

    def rate(t: float, x: Array, oblate: bool, mass: float, steering: Any, duration: float) -> Array:
        r, radius = x[:3], float(np.linalg.norm(x[:3]))
        pull = -EARTH.mu_m3_s2 * r / radius**3
        if oblate:
            k = 1.5 * 1.08262668e-3 * EARTH.mu_m3_s2 * EARTH.earth_radius_m**2 / radius**5
            pull += k * r * (5.0 * (r[2] / radius) ** 2 - np.array([1.0, 1.0, 3.0]))
        if steering is not None:
            u = steering(2.0 * t / duration - 1.0)
            pull += vehicle.thrust_n / (mass - vehicle.mass_flow_kg_s * t) * u / np.linalg.norm(u)
        return np.concatenate([x[3:], pull])

    for burn, controls in zip(found.burns, transfer.controls, strict=True):
        steering = BarycentricInterpolator(transfer.grid.nodes, controls)
        for time, arguments in (
            (burn.ignition_s - now, (j2, mass, None, 0.0)),
            (burn.duration_s, (False, mass, steering, burn.duration_s)),
        ):
            ran = solve_ivp(rate, (0.0, time), state, method="DOP853", rtol=1e-12, atol=1e-6, args=arguments)
            state = ran.y[:, -1]
        now, mass = burn.ignition_s + burn.duration_s, mass - burn.propellant_kg
    return np.asarray(state)


def missed(found: TwoBurnPlan, *, j2: bool) -> float:
    units = InsertionSetup.of(found.scenario).units
    return float(np.abs(found.target.conditions(units.state_from_si(flown(found, j2=j2))[None])).max())


def test_a_plan_ends_on_its_orbit_by_an_integration_of_the_textbooks_equation() -> None:
    found = planned(j2=True, wait=True)
    assert missed(found, j2=True) < 1e-8
    assert missed(found, j2=False) > 1e-3
    assert found.to_dict()["forces"] == {"coast": ["point mass", "J2"], "burn": ["point mass"]}
    assert "J2 acts on the coasts, and not on the burns" in verdict(found)


def test_half_an_orbit_with_j2_tilts_the_plane_of_a_plan_without_it() -> None:
    found = planned(j2=False, wait=False)
    oblate = found.scenario.with_changes(burn={"coast_j2": True})
    assert found.transfer is not None
    end = sensitivities(Motion.of(InsertionSetup.of(found.scenario)), found.transfer).end
    judged = verify(oblate, found.target, found.transfer, end)
    assert not judged.verified
    assert np.deg2rad(0.05) < judged.plane_rad < np.deg2rad(0.2)
    assert judged.laplace_rel > 1e-3


def test_a_coast_that_waits_for_the_node_turns_the_plane_for_nothing() -> None:
    """Hohmann's impulses in the plane take 375.4 m/s; a point mass pays 406.8 m/s for the turn, with the same wait."""
    found = planned(j2=True, wait=True)
    assert found.ignition_s > 20000.0
    assert found.delta_v_m_s < 380.0


def test_a_transfer_with_j2_that_is_feasible_by_construction_is_verified() -> None:
    made = transfer(2026, 3, oblate=True)
    found = plan(made.scenario)
    assert found.status is PlanStatus.VERIFIED, found.message
    assert found.time_of_flight_s <= 1.005 * made.burn_s


@pytest.mark.parametrize("number", range(6))
def test_no_bound_proves_a_transfer_with_j2_infeasible_that_is_feasible(number: int) -> None:
    """With the construction's burns as all the propellant."""
    made = transfer(7, number, oblate=True)
    vehicle = made.scenario.vehicle
    dry = vehicle.mass_kg - vehicle.mass_flow_kg_s * made.burn_s
    ready = InsertionSetup.of(made.scenario.with_changes(vehicle={"dry_mass_kg": dry}))
    assert proof_for_two_burns(ready) is None


def test_the_proof_allows_for_what_j2_does_to_the_energy() -> None:
    """What two coasts may give is taken off what the target needs: 3μJ₂/R of w² each, some 25 m/s of w = 8.1 km/s."""
    made = load_scenario(RAISE, WAIT | {"burn.coast_j2": True})
    ready = InsertionSetup.of(made.with_changes(vehicle={"dry_mass_kg": 990.0}))
    proof = proof_for_two_burns(ready)
    sharp = proof_of_infeasibility(ready.burn, ready.target, ready.burn.longest, coasts=True)
    assert proof is not None
    assert sharp is not None
    speed = ready.units.speed_m_s
    assert 20.0 < speed * (sharp.needed - proof.needed) < 30.0
    assert "two burns and their coasts with J2" in verdict(plan(ready.scenario))  # type: ignore[arg-type]


def test_an_energy_beyond_reach_is_proved_to_be_with_j2() -> None:
    assert plan(unreachable_transfer(2026, 0, oblate=True).scenario).status is PlanStatus.INFEASIBLE


def test_one_burn_from_now_has_no_coast_for_j2() -> None:

    one = {"burn.coast_j2": True, "burn.count": 1, "burn.duration_s": 60.0}
    with pytest.raises(ScenarioError, match=r"burn\.coast_j2 = true: needs .* or burn\.count = 2"):
        load_scenario(RAISE, one)
