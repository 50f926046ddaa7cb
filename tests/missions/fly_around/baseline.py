"""The paper's fly-around, and what tests change of it."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from orbsoc.guidance.scenario_file import checked, merged, read_toml
from orbsoc.missions.fly_around import Plan, Scenario, plan

Array = NDArray[np.float64]
SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"
FEWEST = SCENARIOS / "paper001_fewest.toml"


def scenario(**changes: Any) -> Scenario:
    """The paper's data with other values, tables merged."""
    return checked(Scenario, merged(read_toml(FEWEST), changes), source="changed")


@cache
def planned(impulses: str | int) -> Plan:
    """The plan of the paper's data in one of the ways, made once."""
    return plan(scenario(impulses=impulses))


def integrated(state: Array, dt_s: float, mean_motion_rad_s: float, push: Any = None) -> Array:
    """Clohessy–Wiltshire motion by DOP853 with an acceleration, constant or a function of time."""
    n = mean_motion_rad_s
    constant = np.zeros(3) if push is None or callable(push) else push
    force = push if callable(push) else (lambda _: constant)

    def rate(t: float, x: Array) -> Array:
        pull = np.array([2 * n * x[4] + 3 * n * n * x[0], -2 * n * x[3], -n * n * x[2]])
        return np.concatenate([x[3:], pull + force(t)])

    if dt_s == 0.0:
        return state
    return np.asarray(solve_ivp(rate, (0.0, dt_s), state, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1])
