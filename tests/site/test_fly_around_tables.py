"""Tables of `docs/fly-around.md` that no single plan makes: bounds and errors by the number of pulses, and 500 flights with errors."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from orbsoc.missions.fly_around import load_scenario, plan
from orbsoc.missions.fly_around.record import later_errors_m
from orbsoc.missions.fly_around.search.fewest import even_bound
from orbsoc.missions.fly_around.search.times import least_error
from orbsoc.missions.fly_around.search.tube import Revolution, Tube
from orbsoc.missions.fly_around.verification import fly_truth
from tests.missions.fly_around.baseline import FEWEST, SCENARIOS, scenario
from tests.printed import near

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "fly-around.md").read_text(encoding="utf-8")
PULSES = (12, 13, 14, 15, 16, 18, 20)
PLANS: dict[str, tuple[str, dict[str, Any]]] = {
    "paper, 19 adaptive": ("paper001_adaptive", {}),
    "equal, 20": ("paper001_equal", {}),
    "fewest, 13": ("paper001_fewest", {}),
    "16, planned to 1.6 m": ("paper001_fewest", {"impulses": 16, "tolerance_m": 1.6}),
    "fewest with 3 σ, 17": ("paper001_margin", {}),
    "18 with 3 σ": ("paper001_margin", {"impulses": 18}),
    "20 with 3 σ": ("paper001_margin", {"impulses": 20}),
}
FLIGHTS, SAMPLES = 500, 16
ALLOWED_M = 2.0
RELATIVE = 1e-4
"""Times of the pulses end where a step gains less."""


def cells(row: str) -> list[str]:
    """Of the one row that begins so, what follows."""
    [found] = re.findall(rf"^\| {re.escape(row)} \|(.*)\|$", TEXT, flags=re.MULTILINE)
    return [cell.strip().removesuffix(" %") for cell in found.split("|")]


@pytest.mark.parametrize("pulses", PULSES)
def test_pulses_need_and_stray_what_the_page_says(pulses: int) -> None:
    paper = scenario()
    bound = even_bound(paper.flight, paper.start_state[:3], 1800.0, pulses, solve=orbsoc.solve)
    best = least_error(Revolution(paper.flight, paper.start_state, 1800.0, orbsoc.solve), bound.times_s[:-1])
    assert isinstance(best, Tube)
    [needed, found] = re.findall(rf"^\| {pulses} \| (\d\.\d+) \| (\d\.\d+) \|", TEXT, flags=re.MULTILINE)[0]
    assert near(needed, f"{bound.bound_m:.9g}", RELATIVE), bound.bound_m
    assert near(found, f"{best.error_m:.9g}", RELATIVE), best.error_m


@pytest.mark.parametrize("row", PLANS)
def test_flights_with_errors_stray_what_the_page_says(row: str) -> None:
    name, settings = PLANS[row]
    planned = plan(load_scenario(SCENARIOS / f"{name}.toml", settings))
    errors = load_scenario(FEWEST.with_name("paper001_margin.toml")).uncertainty
    assert planned.verification is not None
    assert errors is not None
    flights = fly_truth(planned.scenario, planned.verification.flown, uncertainty=errors, runs=FLIGHTS, samples=SAMPLES)  # fmt: skip
    largest = flights.largest_errors_m
    expected = [
        planned.to_dict()["largest_error_m"], largest.mean(), np.quantile(largest, 0.95), 100.0 * np.mean(largest > ALLOWED_M),
        100.0 * np.mean(later_errors_m(flights) > ALLOWED_M), flights.totals_m_s.mean(),
    ]  # fmt: skip
    shown = cells(row)
    assert all(near(*pair, RELATIVE) for pair in zip(shown, [f"{each:.9g}" for each in expected], strict=True)), expected  # fmt: skip
