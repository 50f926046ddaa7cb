"""What the paper prints for this mission, beside what was computed, with the reason where they differ."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orbsoc.guidance.mission import BROKEN, PaperRow

from .model.flight import fly
from .model.waypoints import through_waypoints
from .planner import Checked, FlyAround
from .printed import printed_times
from .scenario import Scenario

SECTION = "section 3"
CLOSE_M = 2e-3
"""Beyond 2 m, for errors that the paper prints as at most 2 m."""
FUEL_M_S = 0.05
"""Of a printed 11.1 or 12.2 m/s."""

_NO_VELOCITY_CHANGE = (
    "no velocity change: the sum of the velocities after the pulses, which the text calls pulses, gives"
)
_RULE = "eq. (15) drops the curvature of the ellipse, its largest term; the exact arc error, as a norm, gives the paper's 19"


def is_papers(scenario: Scenario) -> bool:
    """Whether a scenario has the paper's data, table by table."""
    table = scenario.ellipse
    return (
        scenario.target.altitude_km == 500.0
        and scenario.target.inc_deg == 30.0
        and table.semi_axes_m == (200.0, 150.0)
        and np.allclose(table.angles_deg, (60.0, 45.0, 30.0), rtol=0.0, atol=1e-12)
        and (table.start_deg, table.period_s, table.direction) == (0.0, 1800.0, 1)
        and scenario.tolerance_m == 2.0
        and scenario.start is None
        and scenario.disturbance is None
    )


def compare(plan: FlyAround) -> tuple[PaperRow, ...]:
    """Rows for what the paper prints about this way of flying; empty for other data or without a programme."""
    scenario, found = plan.scenario, plan.verification
    if found is None or plan.audited or not is_papers(scenario):
        return ()
    if scenario.impulses == "adaptive":
        return tuple(_adaptive(scenario, found))
    if scenario.impulses == "equal":
        return tuple(_equal(found))
    if scenario.impulses == "fewest" and scenario.uncertainty is None:
        return tuple(_fewest(plan, found))
    return ()


def _adaptive(scenario: Scenario, found: Checked) -> Iterator[PaperRow]:
    yield _pulses(found, 19, "figure 4c")
    yield _error(found, "figure 4b")
    total = found.programme.total_m_s
    yield PaperRow(
        "fuel, fly-around 1",
        SECTION,
        "11.1 m/s",
        f"{total:.3f} m/s",
        "not reproduced",
        f"{_NO_VELOCITY_CHANGE} {found.flown.post_burn_speeds_m_s:.2f} m/s, and without the last pulse"
        f" {found.flown.post_burn_speeds_m_s - _last_speed(found):.2f} m/s",
        f"±{FUEL_M_S:g} m/s",
    )
    for name, along, known in (("as printed", 5.0, 11), ("with A = 0", 0.0, 14)):
        times = printed_times(scenario.flight, scenario.duration_s, scenario.tolerance_m, along=along)
        programme = through_waypoints(scenario.flight, scenario.start_state, times)
        flown = fly(scenario.flight, scenario.start_state, programme, scenario.duration_s)
        yield PaperRow(
            f"pulses by eq. (15) {name}",
            "eq. (15), (16)",
            "19",
            f"{len(programme)}, which stray {flown.largest_error_m:.1f} m",
            "misprint" if len(programme) == known else BROKEN,
            _RULE,
            "±0",
        )


def _equal(found: Checked) -> Iterator[PaperRow]:
    yield _pulses(found, 20, "figure 4d", "≥ 20")
    yield _error(found, "figure 4b")
    ours = found.flown.post_burn_speeds_m_s
    near = abs(ours - 12.2) <= FUEL_M_S
    yield PaperRow(
        "fuel, fly-around 2",
        SECTION,
        "12.2 m/s",
        f"{found.programme.total_m_s:.3f} m/s",
        "inferred" if near else BROKEN,
        f"{_NO_VELOCITY_CHANGE} {ours:.3f} m/s",
        f"±{FUEL_M_S:g} m/s",
    )


def _fewest(plan: FlyAround, found: Checked) -> Iterator[PaperRow]:
    assert plan.search is not None
    proof = (
        f"{plan.search.impossible} are proved too few, for they stray {plan.search.impossible_below_m:.4f} m"
        if plan.search.certified
        else "that fewer cannot do is not proved"
    )
    yield PaperRow(
        "fewest pulses",
        "abstract, section 3",
        "19",
        str(len(found.programme)),
        "not reproduced",
        f"the paper's waypoints are on the ellipse and its arcs stray to one side; free within the tube, {proof}",
        "±0",
    )


def _pulses(found: Checked, printed: int, where: str, text: str = "") -> PaperRow:
    same = len(found.programme) == printed
    reason = "" if same else f"with the paper's data it is known to be {printed}"
    return PaperRow(
        "pulses",
        f"{SECTION}, {where}",
        text or str(printed),
        str(len(found.programme)),
        "reproduced" if same else BROKEN,
        reason,
        "±0",
    )


def _error(found: Checked, where: str) -> PaperRow:
    ours = found.flown.largest_error_m
    same = ours <= 2.0 + CLOSE_M
    return PaperRow(
        "largest error",
        f"{SECTION}, {where}",
        "≤ 2 m",
        f"{ours:.4f} m; with J2 and drag {float(found.truth.largest_errors_m[0]):.4f} m",
        "reproduced" if same else BROKEN,
        "" if same else "with the paper's data it is known to be 2 m",
        f"+{CLOSE_M:g} m",
    )


def _last_speed(found: Checked) -> float:
    return float(np.linalg.norm(found.flown.before[-2, 3:] + found.programme.dv_m_s[-1]))
