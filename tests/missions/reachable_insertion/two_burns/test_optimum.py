"""How short the burns are: against Hohmann's impulses, a shared plane change, and a shooting method with SciPy's optimiser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import minimize, minimize_scalar

from orbsoc.missions.reachable_insertion import PlanStatus, Scenario, TwoBurnPlan, load_scenario, plan
from orbsoc.missions.reachable_insertion.search.setup import target_of
from orbsoc.orbit import EARTH, CanonicalUnits

Array = NDArray[np.float64]
SCENARIOS = Path(__file__).resolve().parents[4] / "scenarios"
RAISE, TURN = SCENARIOS / "raise_two_burns.toml", SCENARIOS / "turn_two_burns.toml"
MU = EARTH.mu_m3_s2


def planned(scenario: Scenario) -> TwoBurnPlan:
    found = plan(scenario)
    assert isinstance(found, TwoBurnPlan)
    assert found.status is PlanStatus.VERIFIED
    return found


def hohmann_m_s(inner_m: float, outer_m: float, turns_rad: tuple[float, float] = (0.0, 0.0)) -> float:
    """Two impulses between circles, each of which also turns the plane."""
    sma = 0.5 * (inner_m + outer_m)
    circular = [np.sqrt(MU / radius) for radius in (inner_m, outer_m)]
    passing = [np.sqrt(MU * (2.0 / radius - 1.0 / sma)) for radius in (inner_m, outer_m)]
    return float(
        sum(
            np.sqrt(c**2 + v**2 - 2.0 * c * v * np.cos(turn))
            for c, v, turn in zip(circular, passing, turns_rad, strict=True)
        )
    )


@pytest.mark.parametrize(
    ("thrust_n", "losses"), [(20000.0, 1e-5), (5000.0, 1e-4), (500.0, 0.02)], ids=["high", "shipped", "low"]
)
def test_a_raise_costs_hohmanns_impulses_and_the_losses_of_finite_burns(
    thrust_n: float, losses: float
) -> None:
    scenario = load_scenario(RAISE)
    flow = scenario.vehicle.mass_flow_kg_s * thrust_n / scenario.vehicle.thrust_n
    found = planned(scenario.with_changes(vehicle={"thrust_n": thrust_n, "mass_flow_kg_s": flow}))
    impulses = hohmann_m_s(6678137.0, 7378137.0)
    assert impulses * (1.0 - 1e-9) <= found.delta_v_m_s <= impulses * (1.0 + losses)


def test_a_turn_is_shared_between_the_burns_as_the_best_impulses_share_it() -> None:
    """With the node free the inclination is the turn; high thrust leaves almost nothing to gravity."""
    scenario = load_scenario(TURN)
    vehicle = {"thrust_n": 200000.0, "mass_flow_kg_s": 10.0 * scenario.vehicle.mass_flow_kg_s}
    found = planned(scenario.with_changes(vehicle=vehicle))
    total = np.deg2rad(55.0 - 51.6)
    best: Any = minimize_scalar(
        lambda first: hohmann_m_s(6778137.0, 7278137.0, (first, total - first)),
        bounds=(0.0, total),
        method="bounded",
    )
    assert best.fun * (1.0 - 1e-6) <= found.delta_v_m_s <= best.fun * (1.0 + 1e-3)


def shot(scenario: Scenario, x: Array, units: CanonicalUnits) -> Array:
    """The end of ignition, coast, durations, and two angles a burn with their rates, by SciPy's own integrator; canonical (6,)."""
    vehicle = scenario.vehicle
    acceleration = vehicle.thrust_n / vehicle.mass_kg / units.acceleration_m_s2
    flow = vehicle.mass_flow_kg_s / vehicle.mass_kg * units.time_s
    state = units.state_from_si(scenario.launch_inertial(scenario.initial))
    mass, oblate = 1.0, scenario.burn.coast_j2
    for k in range(2):
        coast, duration, *angles = x[8 * k : 8 * k + 8]

        def rate(
            t: float, s: Array, thrust: float, mass: float, angles: list[float], duration: float
        ) -> Array:
            tau = 2.0 * t / duration - 1.0 if thrust else 0.0
            right = angles[0] + angles[1] * tau + angles[2] * tau**2
            up = angles[3] + angles[4] * tau + angles[5] * tau**2
            u = np.array([np.cos(right) * np.cos(up), np.sin(right) * np.cos(up), np.sin(up)])
            radius = float(np.linalg.norm(s[:3]))
            pull = -s[:3] / radius**3
            if oblate and not thrust:
                shape = 5.0 * (s[2] / radius) ** 2 - np.array([1.0, 1.0, 3.0])
                pull += 1.5 * 1.08262668e-3 * s[:3] / radius**5 * shape
            return np.concatenate([s[3:], pull + thrust / (mass - flow * t) * u])

        for thrust, time in ((0.0, coast), (acceleration, duration)):
            ran: Any = solve_ivp(
                rate,
                (0.0, time),
                state,
                method="DOP853",
                rtol=1e-11,
                atol=1e-12,
                args=(thrust, mass, angles, duration),
            )
            state = ran.y[:, -1]
        mass -= flow * duration
    return np.asarray(state)


SLOW: dict[str, Any] = {
    "limits.attitude_rate_deg_s": 0.02, "burn.coast_j2": True, "vehicle.thrust_n": 500.0,
    "target.inc_deg": 0.0, "initial.velocity_m_s": [0.0, 7725.760633, 0.0],
}  # fmt: skip
"""On the equator, where a turn at a constant rate is linear in the first angle."""


def room(scenario: Scenario, x: Array, units: CanonicalUnits) -> Array:
    """1 − (rate/bound)² of both burns, at nine times each."""
    assert scenario.limits.attitude_rate_deg_s is not None
    bound = np.deg2rad(scenario.limits.attitude_rate_deg_s) * units.time_s
    tau, found = np.linspace(-1.0, 1.0, 9), []
    for duration, *angles in (x[1:8], x[9:16]):
        up = angles[3] + angles[4] * tau + angles[5] * tau**2
        right_rate, up_rate = (angles[k] + 2.0 * angles[k + 1] * tau for k in (1, 4))
        square = (right_rate * np.cos(up)) ** 2 + up_rate**2
        found.append(1.0 - square * (2.0 / (duration * bound)) ** 2)
    return np.concatenate(found)


@pytest.mark.parametrize(
    ("path", "settings"),
    [(RAISE, {}), (TURN, {}), (RAISE, SLOW)],
    ids=["raise", "turn", "raise with J2 at 0.02 deg/s"],
)
def test_a_shooting_method_from_another_start_finds_no_shorter_burns(
    path: Path, settings: dict[str, Any]
) -> None:
    scenario = load_scenario(path, settings)
    found = planned(scenario)
    units = CanonicalUnits.of(EARTH)
    target = target_of(scenario, units)
    free = scenario.burn.ignition == "free"
    assert found.transfer is not None
    random = np.random.default_rng(3)
    start: list[float] = []
    for coast, duration, controls in zip(
        found.transfer.coasts, found.transfer.durations, found.transfer.controls, strict=True
    ):
        middle = controls.mean(axis=0) / np.linalg.norm(controls.mean(axis=0))
        right, up = np.arctan2(middle[1], middle[0]), np.arcsin(middle[2])
        moved = random.uniform(-0.05, 0.05, 4)  # directions by up to 3 degrees, burns by 5 %, coasts by 40 s
        start += [
            max(coast + moved[0], 0.0), duration * (1.0 + moved[1]), right + moved[2], 0.0, 0.0, up + moved[3], 0.0, 0.0,
        ]  # fmt: skip
    start[0] = start[0] if free else 0.0
    bounds: list[tuple[float | None, float | None]] = [(None, None)] * 16
    bounds[0], bounds[8] = (0.0, 20.0 if free else 0.0), (0.0, 20.0)
    bounds[1] = bounds[9] = (1e-3, 1.0)
    unit = found.transfer.burning
    best: Any = minimize(
        lambda x: (x[1] + x[9]) / unit,
        np.array(start),
        method="SLSQP",
        bounds=bounds,
        constraints=[
            {"type": "eq", "fun": lambda x: target.conditions(shot(scenario, x, units)[None])[0]},
            *(
                []
                if scenario.limits.attitude_rate_deg_s is None
                else [{"type": "ineq", "fun": lambda x: room(scenario, x, units)}]
            ),
        ],
        options={"maxiter": 100, "ftol": 1e-10},
    )
    missed = np.abs(target.conditions(shot(scenario, best.x, units)[None])).max()
    assert missed < 1e-6
    assert best.fun >= 1.0 - 2e-5
    assert best.fun <= 1.0 + 2e-3, "the shooting method should come close, or it proves nothing"
