"""The paper's launch for the tests, and the same with other numbers."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from orbsoc.missions.platform_launch import Scenario, load_scenario

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@cache
def paper() -> Scenario:
    """As its figures have it: 300 N, stopped at 1.45 s."""
    return load_scenario(SCENARIOS / "paper002.toml")


def launched(force_n: float = 300.0, **changes: Any) -> Scenario:
    """Stopped by the stroke."""
    return paper().with_changes(**{"force_n": force_n, "stop": "stroke", "stop_s": None, **changes})
