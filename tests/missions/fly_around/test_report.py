"""The pages of plans of every kind: they are written, and say what the document says."""

from __future__ import annotations

import html
import json
import re
from pathlib import Path
from typing import Any

import pytest

import orbsoc

from .baseline import FEWEST, SCENARIOS


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({}, ("<h2>Proof</h2>", "12 pulses, one of them at 0 s, cannot do with less than <strong>2.2997 m</strong>", "The 12 intervals", "primer vector")),
        ({"impulses": 12}, ("12 pulses stray ≥ 2.2329 m, proved", "<h2>Proof</h2>")),
        ({"impulses": "equal"}, ("20 pulses, <strong>3.2374 m/s</strong>", "no velocity change: the sum of the velocities")),
        (
            {"impulses": 16, "uncertainty": {"position_m": 0.01, "velocity_m_s": 1e-4, "runs": 5}, "front": [20]},
            ("<h2>Errors of navigation and execution</h2>", "5 flights: ", "<h2>The price of a pulse</h2>"),
        ),
        (
            {"impulses": 14, "disturbance": {"acceleration_m_s2": [1e-6, 0.0, 0.0]}},
            ("a constant acceleration of 1e-06, 0.0, 0.0 m/s²",),
        ),
    ],
    ids=["fewest", "impossible", "equal", "uncertain", "disturbed"],
)  # fmt: skip
def test_a_plan_has_its_page(settings: dict[str, Any], says: tuple[str, ...], tmp_path: Path) -> None:
    orbsoc.plan_file(FEWEST, settings=settings, out=tmp_path / "out", device="none")
    page = html.unescape((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    document = json.loads((tmp_path / "out" / "plan.json").read_text(encoding="utf-8"))
    text = re.sub(r"\s+", " ", page)
    for words in (*says, document["details"]):
        assert words in text
    assert "http" not in text.replace("http://www.w3.org", "")


def test_the_cycle_budget_of_the_fewest_pulses_is_on_its_page(tmp_path: Path) -> None:
    """Its largest problem has 8 samples an arc so that the engine's tables fit."""
    run = orbsoc.plan_file(SCENARIOS / "paper001_fewest.toml", out=tmp_path / "out")
    assert run.succeeded
    assert run.budget is not None
    assert run.budget.area.fits
    assert len(run.budget.report.solves) == len(run.plan.subproblems)
    assert "Cycle budget" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
