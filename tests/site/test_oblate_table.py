"""The table of `docs/approach.md` on J2 in the model is that of flights without corrections: at the gate, at the last point, and what corrections cost.

An ellipse takes longer; its two rows are for `make long`.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orbsoc.guidance.relative_flight import TRUTHS, fly
from orbsoc.missions import approach
from orbsoc.orbit import state_from_elements
from tests.missions.approach.cases import station
from tests.printed import near

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "approach.md").read_text(encoding="utf-8")
ROWS: dict[str, tuple[str, dict[str, Any]]] = {
    "station_rbar": ("station_rbar", {}),
    "station_vbar, from 600 m": ("station_vbar", {"start__x_m": -600.0}),
    "elliptic_servicing": ("elliptic_servicing", {}),
}
RELATIVE = 1e-3
"""Of a sequence that ends where a step costs within 1e-4 of the last."""


def shown(name: str, j2: bool) -> list[list[str]]:
    """The numbers of a row: flown without J2, with it, and of the corrections (mm/s)."""
    [cells] = re.findall(rf"^\| {name} \| {'yes' if j2 else 'no'} \|(.*)\|$", TEXT, flags=re.MULTILINE)
    return [re.findall(r"\d+\.\d+", cell) for cell in cells.split("|")]


@pytest.mark.parametrize("j2", [False, True])
@pytest.mark.parametrize("row", ROWS)
def test_a_row_is_that_of_its_plan(row: str, j2: bool) -> None:
    name, changes = ROWS[row]
    plan = approach.plan(station(name, **changes, model__j2=j2))
    assert plan.programme is not None
    assert plan.verification is not None
    gate, *_, last = plan.scenario.points.values()
    assert gate.arrive_s is not None
    target = np.concatenate(state_from_elements(plan.approach.orbit()))
    spent = float(plan.verification.corrected.delta_v_m_s[0]) - plan.programme.total_m_s
    expected = []
    for forces in ("two_body", "j2"):
        times = [0.0, gate.arrive_s, plan.approach.duration_s]
        states = fly(plan.programme, plan.approach.start, target, times, TRUTHS[forces]).states[1:, :3]
        expected.append([float(np.linalg.norm(at - point.position())) for at, point in zip(states, (gate, last), strict=True)])  # fmt: skip
    without, with_, corrections = shown(row, j2)
    assert len(without) == (0 if j2 else 2)
    assert len(with_) == 2
    pairs = [*zip(without, expected[0], strict=False), *zip(with_, expected[1], strict=True), (corrections[0], 1e3 * spent)]  # fmt: skip
    assert all(near(told, f"{value:.9g}", RELATIVE) for told, value in pairs), pairs
