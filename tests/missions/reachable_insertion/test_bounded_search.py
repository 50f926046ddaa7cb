"""Burns under a bound on the attitude rate: held by what is flown, against an optimiser of its own, and refused where none is."""

from __future__ import annotations

import csv
import io
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

from orbsoc.guidance.scenario_file import ScenarioError, checked
from orbsoc.missions.reachable_insertion import Plan, PlanStatus, Scenario, load_scenario, plan
from orbsoc.missions.reachable_insertion.plan import details
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.verification import verify

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"
REC1 = load_scenario(SCENARIOS / "rec1.toml")

FREE: dict[str, Any] = {
    "mission": "reachable_insertion",
    "name": "perigee into the air, and a turn of the plane",
    "problem": "min_time",
    "axes": "eci",
    "vehicle": {"mass_kg": 3000.0, "dry_mass_kg": 500.0, "thrust_n": 12000.0, "isp_s": 310.0},
    "initial": {"position_m": [6778137.0, 0.0, 0.0], "velocity_m_s": [0.0, 6640.0, 3834.0]},
    "target": {"perigee_height_km": 50.0, "inc_deg": 30.4, "free": ["raan_deg", "argp_deg", "shape"]},
    "burn": {"duration_s": 100.0},
}
PLANE: dict[str, Any] = {
    "mission": "reachable_insertion",
    "name": "3 degrees of plane near the node",
    "problem": "min_time",
    "axes": "eci",
    "vehicle": {"mass_kg": 5000.0, "dry_mass_kg": 1000.0, "thrust_n": 30000.0, "mass_flow_kg_s": 6.798108086519522},
    "initial": {
        "position_m": [5380250.193766671, 4108009.248538274, -169098.39698543656],
        "velocity_m_s": [-4022.864821789759, 5418.6401782616485, 3657.765964157221],
    },
    "target": {
        "position_m": [5187161.8293655915, 4352545.577877533, 0.0],
        "velocity_m_s": [-4207.085077228394, 5013.808755136429, 4010.8194561412606],
    },
    "burn": {"duration_s": 70.0},
}  # fmt: skip
"""Its shortest burn reverses the thrust."""


def scenario(document: dict[str, Any], bound_deg_s: float | None, **burn: Any) -> Scenario:
    limits = {} if bound_deg_s is None else {"limits": {"attitude_rate_deg_s": bound_deg_s}}
    return checked(Scenario, {**document, **limits, "burn": {**document["burn"], **burn}}, source="test")


@cache
def turning(name: str, bound_deg_s: float | None) -> Plan:
    return plan(scenario({"plane": PLANE, "free": FREE}[name], bound_deg_s))


def flown_rates_deg_s(found: Plan) -> np.ndarray:
    """From the lines of attitude.csv alone: angles between neighbours."""
    text = found.tables().get("attitude.csv")
    assert text is not None
    rows = list(csv.DictReader(io.StringIO(text)))
    t = np.array([float(row["t_s"]) for row in rows])
    u = np.array([[float(row[key]) for key in ("ux_eci", "uy_eci", "uz_eci")] for row in rows])
    chords = np.linalg.norm(np.diff(u, axis=0), axis=1)
    return np.asarray(np.rad2deg(2.0 * np.arcsin(0.5 * chords)) / np.diff(t))


@pytest.mark.parametrize(("name", "bound"), [("plane", 5.0), ("plane", 3.0), ("free", 0.02), ("free", 0.005)])
def test_the_flown_attitude_keeps_the_bound_and_reaches_it(name: str, bound: float) -> None:
    found = turning(name, bound)
    assert found.status is PlanStatus.VERIFIED
    assert 0.999 * bound < flown_rates_deg_s(found).max() <= bound
    document = found.to_dict()["attitude_rate"]
    assert document["bound_deg_s"] == bound
    assert document["active"]
    assert 0.999 * bound < document["peak_deg_s"] <= bound
    assert "which is the bound" in details(found)


def test_the_rate_column_is_the_derivative_of_the_direction() -> None:
    found = turning("plane", 3.0)
    rows = list(csv.DictReader(io.StringIO(found.tables()["attitude.csv"])))
    told = np.array([float(row["rate_deg_s"]) for row in rows])
    middle, flown = 0.5 * (told[1:] + told[:-1]), flown_rates_deg_s(found)
    turns = flown > 0.5  # where the turn changes its sense, its size has a corner
    assert turns.sum() > 300
    np.testing.assert_allclose(middle[turns], flown[turns], atol=0.02)


def test_a_slower_turn_takes_a_longer_burn() -> None:
    by_bound = [turning("plane", bound).time_of_flight_s for bound in (5.0, 3.0)]
    assert 76.4 < by_bound[0] < by_bound[1] < 80.0
    by_bound = [turning("free", bound).time_of_flight_s for bound in (None, 0.02, 0.005)]
    assert by_bound[0] < by_bound[1] < by_bound[2]


@pytest.mark.parametrize("document", [REC1.model_dump(), FREE], ids=["rec1", "free"])
def test_a_bound_that_is_not_reached_changes_no_bit(document: dict[str, Any]) -> None:
    free, bounded = (plan(scenario(document, bound)) for bound in (None, 1.0))
    np.testing.assert_array_equal(free.trajectory.controls, bounded.trajectory.controls)
    assert free.time_of_flight_s == bounded.time_of_flight_s
    assert bounded.to_dict()["attitude_rate"]["active"] is False
    assert free.to_dict()["attitude_rate"]["bound_deg_s"] is None
    assert "1 °/s are allowed" in details(bounded)


def test_a_bound_that_no_burn_keeps_is_not_found_and_the_row_is_named() -> None:
    found = plan(scenario(REC1.model_dump(), 0.01))
    assert found.status is PlanStatus.NOT_FOUND
    [row] = found.to_dict()["violations"]
    assert row["row"] == "attitude rate"
    peak = float(row["words"].split()[4])
    assert peak == pytest.approx(
        0.0160, rel=0.01
    )  # the directions of the shortest burn are flat: 0.01597 to 0.01608
    assert row["words"].startswith(f"the attitude rate at {peak:g} °/s, ")
    assert "limits.attitude_rate_deg_s = 0.01" in details(found)
    assert "not a proof" in details(found)
    assert found.tables() == {}


def test_the_flight_of_a_plan_that_turns_too_fast_is_refused() -> None:
    found = turning("free", None)
    judged = verify(scenario(FREE, 0.01), found.target, found.iterate)
    [failure] = judged.failures
    assert failure.startswith("attitude rate is 0.04282")
    assert failure.endswith(" °/s, allowed 0.01 °/s")


def test_the_largest_orbit_shrinks_with_the_bound() -> None:
    found = [
        plan(REC1.with_changes(problem="max_energy", target={"perigee_direction": "free"}, limits=limits))
        for limits in ({}, {"attitude_rate_deg_s": 0.08}, {"attitude_rate_deg_s": 0.07})
    ]
    assert {each.status for each in found} == {PlanStatus.VERIFIED}
    heights = [each.to_dict()["orbit"]["apogee_height_km"] for each in found]
    assert heights[0] > heights[1] > heights[2] > heights[0] - 0.1
    assert [each.to_dict()["attitude_rate"]["active"] for each in found] == [None, True, True]


def test_a_free_ignition_keeps_the_bound() -> None:
    free, bounded = (plan(scenario(FREE, bound, ignition="free")) for bound in (None, 0.005))
    assert bounded.status is PlanStatus.VERIFIED
    assert bounded.time_of_flight_s > free.time_of_flight_s
    assert 0.999 * 0.005 < flown_rates_deg_s(bounded).max() <= 0.005


KNOTS = 20


def test_the_burn_is_that_of_a_direct_optimisation_of_its_own() -> None:
    """Single shooting of two angles, linear between 21 knots, by Runge–Kutta and SLSQP; it starts 0.1 rad beside the plan."""
    found, bound_deg_s = turning("plane", 3.0), 3.0
    ready = InsertionSetup.of(found.scenario)
    burn, start = ready.burn, ready.burn.start
    up = start[:3] / np.linalg.norm(start[:3])
    side = np.cross(up, start[3:])
    side /= np.linalg.norm(side)
    frame = np.array([up, np.cross(side, up), side])
    bound = np.deg2rad(bound_deg_s) * ready.units.time_s

    def direction(angles: np.ndarray) -> np.ndarray:
        pitch, yaw = angles[..., 0], angles[..., 1]
        local = np.stack([np.cos(yaw) * np.sin(pitch), np.cos(yaw) * np.cos(pitch), np.sin(yaw)], axis=-1)
        return np.asarray(local @ frame)

    def ends(points: np.ndarray) -> np.ndarray:
        angles, time = points[:, :-1].reshape(len(points), KNOTS + 1, 2), points[:, -1:]
        x = np.repeat(start[None], len(points), axis=0)
        h = time / (2 * KNOTS)

        def rate(x: np.ndarray, at: float) -> np.ndarray:
            k = min(int(at), KNOTS - 1)
            u = direction(angles[:, k] + (at - k) * (angles[:, k + 1] - angles[:, k]))
            push = burn.acceleration / (1.0 - burn.flow * time * at / KNOTS) * u
            radius = np.linalg.norm(x[:, :3], axis=1, keepdims=True)
            return np.hstack([x[:, 3:], push - x[:, :3] / radius**3])

        for step in range(2 * KNOTS):
            at = 0.5 * step
            a = rate(x, at)
            b = rate(x + h / 2 * a, at + 0.25)
            c = rate(x + h / 2 * b, at + 0.25)
            x = x + h / 6 * (a + 2 * b + 2 * c + rate(x + h * c, at + 0.5 - 1e-12))
        return x

    def slopes(of: Any, z: np.ndarray) -> np.ndarray:
        moved = 1e-6 * np.eye(z.size)
        values = of(np.vstack([z + moved, z - moved]))
        return np.asarray((values[: z.size] - values[z.size :]).T / 2e-6)

    def missed(points: np.ndarray) -> np.ndarray:
        return np.asarray(100.0 * found.target.conditions(ends(points)))

    def room(points: np.ndarray) -> np.ndarray:
        angles = points[:, :-1].reshape(len(points), KNOTS + 1, 2)
        turn = np.diff(angles, axis=1) * KNOTS / points[:, -1, None, None]
        both = [np.cos(angles[:, knots, 1]) ** 2 for knots in (slice(None, -1), slice(1, None))]
        return np.hstack([1.0 - (each * turn[:, :, 0] ** 2 + turn[:, :, 1] ** 2) / bound**2 for each in both])

    arc = found.trajectory
    u = arc.grid.interpolate(arc.controls, np.linspace(-1.0, 1.0, KNOTS + 1)) @ frame.T
    angles = np.column_stack(
        [np.unwrap(np.arctan2(u[:, 0], u[:, 1])), np.arcsin(np.clip(u[:, 2], -1.0, 1.0))]
    )
    angles += 0.1 * np.random.default_rng(1).standard_normal(angles.shape)
    best = minimize(
        lambda z: 100.0 * z[-1],
        np.append(angles.ravel(), arc.duration),
        jac=lambda z: np.append(np.zeros(z.size - 1), 100.0),
        constraints=[
            {"type": "eq", "fun": lambda z: missed(z[None])[0], "jac": lambda z: slopes(missed, z)},
            {"type": "ineq", "fun": lambda z: room(z[None])[0], "jac": lambda z: slopes(room, z)},
        ],
        method="SLSQP",
        options={"maxiter": 300, "ftol": 1e-8},
    )  # fmt: skip
    assert best.success
    assert np.abs(missed(best.x[None])).max() < 1e-6
    # Of 21 knots the turn has coarser corners than the polynomial's; 81 of them gain 0.04 % on the plan at 4 °/s.
    assert found.time_of_flight_s == pytest.approx(best.x[-1] * ready.units.time_s, rel=5e-3)
    assert found.time_of_flight_s < 1.001 * best.x[-1] * ready.units.time_s


BAD = {
    "zero": ({"attitude_rate_deg_s": 0.0}, r"limits\.attitude_rate_deg_s = 0\.0: .*greater than 0"),
    "negative": ({"attitude_rate_deg_s": -1.0}, r"limits\.attitude_rate_deg_s = -1\.0: .*greater than 0"),
    "NaN": ({"attitude_rate_deg_s": float("nan")}, r"limits\.attitude_rate_deg_s = nan: .*"),
    "text": ({"attitude_rate_deg_s": "1"}, r"limits\.attitude_rate_deg_s = '1': .*number"),
    "another unit": (
        {"attitude_rate_rad_s": 1.0},
        r"limits\.attitude_rate_rad_s = 1\.0: unknown key; allowed here: attitude_rate_deg_s, lowest_altitude_km",
    ),
    "below the ground": ({"lowest_altitude_km": -1.0}, r"limits\.lowest_altitude_km = -1\.0: .*equal to 0"),
    "above the start": (
        {"lowest_altitude_km": 500.0},
        r'limits\.lowest_altitude_km = 500: with burn\.ignition = "free" must be at most \d+',
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_with_the_key_is_said(name: str) -> None:
    limits, words = BAD[name]
    burn = {**FREE["burn"], "ignition": "free"}
    with pytest.raises(ScenarioError, match=words):
        checked(Scenario, {**FREE, "limits": limits, "burn": burn}, source="test")
