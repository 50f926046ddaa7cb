"""The out-of-plane envelope beside the paper's table 2, and why the numbers differ."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from orbsoc.missions.reachable_domain.boundary import edge_note
from orbsoc.missions.reachable_domain.planes import inclination_and_node

from .results import ReachableDomain

Array = NDArray[np.float64]

PAPER = {"inclination": (16.31, 39.31), "node": (318.27, 349.27)}
"""Li et al. 2025, table 2, degrees."""
PAPER_BOX = {"inclination": (16.30, 40.30), "node": (318.25, 350.25)}
"""Its section 3.1: the ranges it searched."""


@dataclass(frozen=True, slots=True)
class EnvelopeRow:
    """One limit: what the paper prints, the outermost grid plane reached, the limit on the axis through the current
    plane, the limit of the whole set (all degrees, NaN for none), and the reason for the difference."""

    limit: str
    paper_deg: float
    grid_deg: float
    axis_deg: float
    whole_deg: float
    reason: str


def envelope(domain: ReachableDomain) -> list[EnvelopeRow]:
    """Lowest and highest inclination and node at the lowest perigee bound."""
    height = float(domain.limit.height_km[0])
    inc_now, raan_now = (float(np.rad2deg(x)) for x in inclination_and_node(domain.domain.frame.normal))
    reached = domain.points["status"] == "reached"
    grid = {
        "inclination": domain.points["inc_deg"][reached],
        "node": np.mod(domain.points["raan_deg"][reached], 360.0),
    }
    note = edge_note(domain.domain)
    inc, raan = edge_curve(domain, height) if not note else (np.array([np.nan]), np.array([np.nan]))
    whole = {"inclination": inc, "node": raan}
    rows = []
    for name in ("inclination", "node"):
        for side, pick in ((0, np.min), (1, np.max)):
            start = inc_now if name == "inclination" else raan_now
            sign = -1.0 if side == 0 else 1.0
            axis = float("nan") if note else _along_axis(domain, height, name, inc_now, raan_now, sign)
            rows.append(
                EnvelopeRow(
                    limit=f"{('lowest', 'highest')[side]} {name}",
                    paper_deg=PAPER[name][side],
                    grid_deg=float(pick(grid[name])) if grid[name].size else float("nan"),
                    axis_deg=start + axis,
                    whole_deg=float(pick(whole[name])),
                    reason=note or _reason(name, side, float(pick(whole[name]))),
                )
            )
    return rows


def edge_curve(domain: ReachableDomain, height_km: float, count: int = 721) -> tuple[Array, Array]:
    """Inclinations and nodes (degrees, nodes near the current one) along the edge at a perigee height, closed."""
    azimuth = np.linspace(0.0, 360.0, count)
    tilt = np.deg2rad(domain.limit(azimuth, height_km))
    inc, raan = inclination_and_node(domain.domain.frame.tilted(tilt, np.deg2rad(azimuth)))
    raan_now = float(np.rad2deg(inclination_and_node(domain.domain.frame.normal)[1]))
    node = np.mod(np.rad2deg(raan) - raan_now + 180.0, 360.0) + raan_now - 180.0
    return np.rad2deg(inc), node


def _along_axis(
    domain: ReachableDomain, height: float, name: str, inc_now: float, raan_now: float, sign: float
) -> float:
    """How far inclination, or node, can change alone (degrees, signed); NaN when the edge is not met within 90."""

    def inside(change: float) -> float:
        inc = inc_now + (sign * change if name == "inclination" else 0.0)
        raan = raan_now + (sign * change if name == "node" else 0.0)
        tilt, azimuth = domain.tilt_and_azimuth_deg(inc, raan)
        return float(domain.limit(azimuth, height)) - tilt

    steps = np.arange(0.5, 90.0, 0.5)
    for low, high in pairwise(steps):
        if inside(high) < 0.0:
            return sign * float(brentq(inside, low, high, xtol=1e-6))
    return float("nan")


def _reason(name: str, side: int, whole: float) -> str:
    paper, box = PAPER[name][side], PAPER_BOX[name][side]
    if side == 0:
        return (
            f"the paper's {paper:g} is the edge of its own search box ({box:g}); the true limit {whole:.2f} lies"
            f" {box - whole:.1f} deg outside the box"
        )
    beyond = "beyond" if whole > box else "inside"
    return (
        f"the paper's {paper:g} is the last but one plane of its box ({box:g}) and may depend on the perigee direction its"
        f" eq. 7 fixes; with that direction free the limit is {whole:.2f}, {abs(whole - box):.1f} deg {beyond} the box"
    )
