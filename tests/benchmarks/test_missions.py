"""Random missions whose answer is known: they are what they are called, they repeat, and their file is taken up again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import missions
from orbsoc.orbit import elements_from_state


def plane(state: np.ndarray) -> np.ndarray:
    normal = np.cross(state[:3], state[3:])
    return np.asarray(normal / np.linalg.norm(normal))


@pytest.mark.parametrize("number", range(30))
def test_a_mission_keeps_the_limits_of_its_class(number: int) -> None:
    made = missions.mission(9, number)
    vehicle, start, end = (
        made.scenario.vehicle, made.scenario.initial.vector(), made.scenario.target.vector(),
    )  # fmt: skip
    assert 200.0 <= vehicle.mass_kg <= 2e5
    assert 0.3 <= vehicle.thrust_n / vehicle.mass_kg <= 30.0
    left = 1.0 - vehicle.mass_flow_kg_s * made.burn_s / vehicle.mass_kg
    assert -vehicle.thrust_n / vehicle.mass_flow_kg_s * np.log(left) <= missions.LARGEST_DELTA_V_M_S
    assert made.burn_s < vehicle.longest_burn_s
    assert np.arccos(np.clip(plane(start) @ plane(end), -1.0, 1.0)) <= missions.LARGEST_TILT
    first, last = (elements_from_state(x[:3], x[3:]) for x in (start, end))
    if made.kind == "escape":
        assert last.ecc > 1.0
    if made.kind == "deorbit":
        assert last.perigee_height_m() < 100e3
    if made.kind == "circularise":
        assert last.ecc < first.ecc


def test_a_mission_depends_on_seed_and_number_alone() -> None:
    [*_, last] = missions.missions(3, 5)
    assert last.scenario == missions.mission(3, 4).scenario
    assert last.scenario != missions.mission(4, 4).scenario


def test_what_the_file_has_is_not_planned_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planned: list[str] = []
    plan = missions.answer

    def counted(made: missions.Mission) -> missions.Answer:
        planned.append(made.scenario.name)
        return plan(made)

    monkeypatch.setattr(missions, "answer", counted)
    arguments = ["--seed", "2", "--out", str(tmp_path), "--count"]
    assert missions.main([*arguments, "2"]) == 0
    assert missions.main([*arguments, "4"]) == 0
    assert planned == ["raise-2-0", "lower-2-1", "plane-2-2", "circularise-2-3"]
