"""What `docs/plan.md` says of plans that leave J2 out, flown with it on their coasts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.missions.reachable_insertion import TwoBurnPlan, load_scenario, plan
from orbsoc.missions.reachable_insertion.search.setup import InsertionSetup
from orbsoc.missions.reachable_insertion.two_burns import verification as two_burns
from orbsoc.missions.reachable_insertion.two_burns.flight import sensitivities
from orbsoc.missions.reachable_insertion.two_burns.motion import Motion
from orbsoc.missions.reachable_insertion.verification import verify
from orbsoc.orbit import EARTH, elements_from_state
from tests.missions.reachable_insertion.test_coast import scenario
from tests.printed import near

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "plan.md").read_text(encoding="utf-8")
LATE = {"target.raan_deg": 357.5, "burn.ignition": "free", "burn.latest_ignition_s": 40000.0}


def flown(name: str, settings: dict[str, Any]) -> tuple[float, float, float]:
    """Perigee and apogee height (km) of the end with J2, and its angle to the target plane (°)."""
    found = plan(load_scenario(ROOT / "scenarios" / f"{name}.toml", {"axes": "eci"} | settings))
    assert isinstance(found, TwoBurnPlan)
    assert found.transfer is not None
    oblate = found.scenario.with_changes(burn={"coast_j2": True})
    end = sensitivities(Motion.of(InsertionSetup.of(found.scenario)), found.transfer).end
    judged = two_burns.verify(oblate, found.target, found.transfer, end)
    assert not judged.verified
    reached = elements_from_state(*np.split(judged.flight.end, 2))
    radii = np.array([1.0 - reached.ecc, 1.0 + reached.ecc]) * reached.sma_m
    perigee, apogee = (radii - EARTH.earth_radius_m) / 1e3
    return float(perigee), float(apogee), float(np.rad2deg(judged.plane_rad))


@pytest.mark.parametrize(
    ("row", "name", "settings", "of"),
    [
        ("`raise_two_burns.toml`", "raise_two_burns", {}, (0, 1, 2)),
        ("`turn_two_burns.toml`", "turn_two_burns", {}, (0, 1)),
        ("the raise, node 2.5° to the west, ignition within 11.1 h", "raise_two_burns", LATE, (2,)),
    ],
)
def test_two_burns(row: str, name: str, settings: dict[str, Any], of: tuple[int, ...]) -> None:
    [told] = re.findall(rf"^\| {re.escape(row)} \|.*\| ([^|]*): refused \|$", TEXT, flags=re.MULTILINE)
    found = flown(name, settings)
    shown = re.findall(r"\d+(?:\.\d+)?", told)
    assert len(shown) == len(of)
    assert all(near(one, f"{found[k]:.9g}", 1e-9) for one, k in zip(shown, of, strict=True)), found


def test_one_burn_that_waits() -> None:
    found = plan(scenario())
    missed = verify(scenario(coast_j2=True), found.target, found.iterate, ignition_s=found.ignition_s)
    [told] = re.findall(r"misses the target plane by (\d\.\d\d)°: refused", TEXT)
    assert near(told, f"{np.rad2deg(missed.plane_rad):.9g}", 1e-9), missed.plane_rad
