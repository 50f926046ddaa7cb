"""The front: more safety never costs less, more time never costs more."""

from __future__ import annotations

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.missions.passive_safety.planner import Analysis
from orbsoc.missions.passive_safety.search import front
from tests.missions.passive_safety.cases import CASES


def test_the_front_falls_with_time_and_rises_with_safety(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in (("DURATIONS", 3), ("SECONDS", 12), ("CANDIDATES", 16)):
        monkeypatch.setattr(front, name, value)
    approach = CASES[2].approach(impulses={"timing": "generated"}, interruption_orbits=1)
    points = front.interruption_front(approach, orbsoc.solve)
    costs = np.array([point.cost for point in points]).reshape(3, 3)  # by orbits, by duration
    assert (np.diff(costs, axis=0) >= -1e-6).all()
    assert (np.diff(costs, axis=1) < 0.0).all()
    assert costs[0, 0] == pytest.approx(0.2570, abs=0.01)
    assert points[0].to_dict() == {"duration_s": 4200.0, "interruption_orbits": 0, "cost": costs[0, 0]}


def test_what_is_not_asked_for_is_not_computed() -> None:
    approach = CASES[2].approach()
    analysis = Analysis(approach, ImpulseProgramme([0.0], [[0.0, 0.1, 0.0]]))
    assert analysis.front == ()
    assert analysis.flights == {}
