"""Independent verification by a nonlinear program: recorded answers of IPOPT, and a few solved anew.

`python -m tests.missions.reachable_domain.nonlinear_program` records them again.
"""

from __future__ import annotations

import json
from functools import cache
from typing import Any

import numpy as np
import pytest

from orbsoc.missions.reachable_domain.model.direct.terminal import LargestTilt
from orbsoc.missions.reachable_domain.search.continuation.largest_tilt import largest_tilts
from orbsoc.missions.reachable_domain.search.continuation.table import PointStatus, PointTable
from orbsoc.orbit.planes import normals
from tests.missions.reachable_domain.cases import domain, perigees
from tests.missions.reachable_domain.nonlinear_program import RECORD, NonlinearProgram, plane_axes, tilt_axes

RECORDED = json.loads(RECORD.read_text(encoding="utf-8"))


def column(rows: list[dict[str, Any]], name: str) -> np.ndarray:
    return np.array([row[name] for row in rows], float)


@cache
def ours() -> list[PointTable]:
    """The recorded points, each solved by itself."""
    rows = RECORDED["points"]
    return [domain().solve_planes([r["inc_deg"]], [r["raan_deg"]], [r["perigee_km"]]) for r in rows]


def edge_at(azimuth_deg: np.ndarray, height_km: np.ndarray) -> np.ndarray:
    """Our furthest tilts, degrees."""
    target = LargestTilt(domain().frame, np.deg2rad(azimuth_deg), perigees(*height_km))
    return np.rad2deg(largest_tilts(domain().tools, target).tilt)


def test_sixty_random_points_agree_with_the_nonlinear_program() -> None:
    """Within 1e-5 of the semi-major axis, none of IPOPT's better by more; twenty of them near the edge."""
    rows = RECORDED["points"]
    assert len(rows) >= 50
    assert all(row["converged"] for row in rows)
    assert [table["status"][0] for table in ours()] == [PointStatus.REACHED.value] * len(rows)
    found = np.array([table["a_km"][0] for table in ours()])
    np.testing.assert_allclose(found, column(rows, "a_km"), rtol=1e-5)
    normal = normals(np.deg2rad(column(rows, "inc_deg")), np.deg2rad(column(rows, "raan_deg")))
    tilt, azimuth = (np.rad2deg(angle) for angle in domain().frame.tilt_and_azimuth(normal))
    gap = edge_at(azimuth, column(rows, "perigee_km")) - tilt
    assert (gap < 1.0).sum() >= 15
    assert np.median(np.abs(found / column(rows, "a_km") - 1.0)) < 1e-7


def test_the_boundary_agrees_with_the_largest_tilts_of_the_nonlinear_program() -> None:
    """Twelve azimuths at three perigee bounds, within 0.02 degrees."""
    rows = RECORDED["boundary"]
    assert len(rows) == 36
    assert all(row["converged"] for row in rows)
    tilts = edge_at(column(rows, "azimuth_deg"), column(rows, "perigee_km"))
    np.testing.assert_allclose(tilts, column(rows, "tilt_deg"), rtol=0, atol=0.02)


def test_the_nonlinear_program_still_says_so() -> None:
    """Two recorded points, the edge point of the paper's grid, and a furthest tilt, solved by IPOPT now."""
    pytest.importorskip("casadi", reason="CasADi, a test extra, is not installed")
    energy, tilt = NonlinearProgram(tilt=False), NonlinearProgram(tilt=True)
    for row in (RECORDED["points"][0], RECORDED["points"][-1]):
        axes = plane_axes(row["inc_deg"], row["raan_deg"])
        answer = energy(axes, row["perigee_km"], axes[2])
        assert answer.converged
        assert answer.value == pytest.approx(row["a_km"], rel=1e-8)
    axes = plane_axes(28.30, 350.25)
    assert energy(axes, 100.0, axes[2]).value == pytest.approx(7628.9296, rel=1e-6)
    row, axes = RECORDED["boundary"][0], tilt_axes(RECORDED["boundary"][0]["azimuth_deg"])
    lean = np.deg2rad(10.0)
    answer = tilt(axes, row["perigee_km"], np.cos(lean) * axes[2] + np.sin(lean) * axes[1])
    assert answer.value == pytest.approx(row["tilt_deg"], abs=1e-6)


def test_the_reached_planes_of_the_1_degree_grid_are_those_within_the_edge() -> None:
    """At 100 km, 825 planes: the sweep's verdicts and the largest tilts at the planes' azimuths agree on every one.

    610 are reached. The nearest miss, i 16.3, Ω 332.25, lies 0.035 degrees beyond the edge, and IPOPT does not find a
    way there either; five reached planes lie within 0.035 degrees.
    """
    inc, raan = domain().planes()
    table = domain().solve_planes(inc, raan, np.array([100.0]))
    assert (table["status"] != PointStatus.SOLVER_FAILED.value).all()
    reached = table.reached()
    gap = edge_at(table["azimuth_deg"], table["perigee_bound_km"]) - table["tilt_deg"]
    np.testing.assert_array_equal(reached, gap > 0.0)
    assert reached.sum() == 610
    close = {
        (round(float(table["inc_deg"][k]), 2), float(table["raan_deg"][k]))
        for k in np.flatnonzero(abs(gap) < 0.02)
    }
    assert close == {(22.3, 346.25), (24.3, 348.25), (37.3, 332.25)}
    assert gap[(np.abs(table["inc_deg"] - 16.3) < 1e-9) & (table["raan_deg"] == 332.25)] == pytest.approx(
        -0.035, abs=1e-3
    )


def test_the_nearest_miss_of_the_grid_is_beyond_the_edge_for_the_nonlinear_program_too() -> None:
    """IPOPT finds no burn onto it, and its furthest tilt there falls as short as ours: 0.033 and 0.035 degrees."""
    miss = RECORDED["nearest_miss"]
    assert miss["converged"]
    assert not miss["found"]
    assert 0.03 < miss["at_tilt_deg"] - miss["furthest_tilt_deg"] < 0.036
    ours = edge_at(np.array([miss["azimuth_deg"]]), np.array([miss["perigee_km"]]))[0]
    assert ours == pytest.approx(miss["furthest_tilt_deg"], abs=0.004)
