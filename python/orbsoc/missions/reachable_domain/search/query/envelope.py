"""The out-of-plane envelope of a domain; of the paper's own case beside its table 2, and why the numbers differ."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import pairwise

import numpy as np

from orbsoc.guidance.scenario_file import checked
from orbsoc.guidance.shipped import shipped_scenarios
from orbsoc.orbit.array import Array
from orbsoc.orbit.planes import inclination_and_node

from ...scenario import Scenario
from ..continuation.boundary import edge_note
from .results import ReachableDomain

PAPER = {"inclination": (16.31, 39.31), "node": (318.27, 349.27)}
"""Li et al. 2025, table 2, degrees."""
PAPER_BOX = {"inclination": (16.30, 40.30), "node": (318.25, 350.25)}
"""Its section 3.1: the ranges it searched."""

PAPER_CASE = "paper004_reach"
"""The shipped scenario of its table 1; it prints no dry mass, and bounds no altitude."""
PAPER_PERIGEE_KM = 100.0
"""The lowest perigee height of its section 3.1."""
SIDES = tuple((name, side) for name in ("inclination", "node") for side in (0, 1))
"""Which limits, lowest first."""
CURVE_STEPS = 6
"""Points of a drawn edge for each azimuth that was solved."""
SAME = 1e-6
"""Relative difference up to which a state is the paper's."""


@dataclass(frozen=True, slots=True)
class Limit:
    """One limit of the planes at the lowest perigee bound, degrees, NaN for none: the outermost grid plane reached, the limit
    on the axis through the current plane, and that of the whole set with the error that the edge's own error makes."""

    limit: str
    grid_deg: float
    axis_deg: float
    whole_deg: float
    whole_error_deg: float


@dataclass(frozen=True, slots=True)
class EnvelopeRow(Limit):
    """A limit beside what the paper prints (degrees), and the reason for the difference."""

    paper_deg: float
    reason: str


def limits(domain: ReachableDomain) -> list[Limit]:
    """Lowest and highest inclination and node at the lowest perigee bound; none where no edge is known."""
    if not domain.limit.height_km.size:
        return []
    height = float(domain.limit.height_km[0])
    inc_now, raan_now = (float(np.rad2deg(x)) for x in inclination_and_node(domain.domain.frame.normal))
    reached = domain.points["status"] == "reached"
    grid = {
        "inclination": domain.points["inc_deg"][reached],
        "node": _near(domain.points["raan_deg"][reached], raan_now),
    }
    note = edge_note(domain.domain)
    none = np.array([np.nan])
    curves = [(none, none)] if note else [edge_curve(domain, height, errors=k) for k in (0.0, -1.0, 1.0)]
    whole = [dict(zip(("inclination", "node"), curve, strict=True)) for curve in curves]
    rows: list[Limit] = []
    for name, side in SIDES:
        start, sign = (inc_now if name == "inclination" else raan_now), (-1.0 if side == 0 else 1.0)
        pick = (np.min, np.max)[side]
        ends = [float(pick(curve[name])) for curve in whole]
        axis = float("nan") if note else _along_axis(domain, height, name, inc_now, raan_now, sign)
        rows.append(
            Limit(
                limit=f"{('lowest', 'highest')[side]} {name}",
                grid_deg=float(pick(grid[name])) if grid[name].size else float("nan"),
                axis_deg=start + axis,
                whole_deg=ends[0],
                whole_error_deg=max(abs(end - ends[0]) for end in ends),
            )
        )
    return rows


def envelope(domain: ReachableDomain, own: list[Limit]) -> list[EnvelopeRow]:
    """The limits beside the paper's table 2; none unless vehicle, state, burn and lowest perigee bound are the paper's."""
    if not own or not is_paper_case(domain.scenario):
        return []
    if abs(domain.limit.height_km[0] - PAPER_PERIGEE_KM) > 1e-9:
        return []
    note = edge_note(domain.domain)
    return [
        EnvelopeRow(
            **asdict(row), paper_deg=PAPER[name][side], reason=note or _reason(name, side, row.whole_deg)
        )
        for (name, side), row in zip(SIDES, own, strict=True)
    ]


def is_paper_case(scenario: Scenario) -> bool:
    """Whether vehicle, initial state and burn are those of the paper's table 1."""
    paper = checked(Scenario, shipped_scenarios()[PAPER_CASE].document(), source=PAPER_CASE)
    if (scenario.vehicle, scenario.burn) != (paper.vehicle, paper.burn):
        return False
    state, printed = scenario.initial_eci().reshape(2, 3), paper.initial_eci().reshape(2, 3)
    off = np.linalg.norm(state - printed, axis=1) / np.linalg.norm(printed, axis=1)
    return bool(off.max() <= SAME)


def edge_curve(domain: ReachableDomain, height_km: float, *, errors: float = 0.0) -> tuple[Array, Array]:
    """Inclinations and nodes (degrees, nodes near the current one) along the edge at a perigee height, closed, moved outwards
    by that number of its stated errors. Steps are finest where the azimuths of the edge lie closest."""
    known = np.append(domain.limit.azimuth_deg, domain.limit.azimuth_deg[0] + 360.0)
    places = np.linspace(0.0, len(known) - 1.0, CURVE_STEPS * (len(known) - 1) + 1)
    azimuth = np.interp(places, np.arange(len(known)), known)
    tilt_deg = domain.limit(azimuth, height_km)
    if errors:
        tilt_deg = np.maximum(tilt_deg + errors * domain.limit.error_deg(azimuth, height_km), 0.0)
    tilt = np.deg2rad(tilt_deg)
    inc, raan = inclination_and_node(domain.domain.frame.tilted(tilt, np.deg2rad(azimuth)))
    raan_now = float(np.rad2deg(inclination_and_node(domain.domain.frame.normal)[1]))
    return np.rad2deg(inc), _near(np.rad2deg(raan), raan_now)


def _near(node_deg: Array, now_deg: float) -> Array:
    """Nodes within half a turn of the current one."""
    return np.asarray(np.mod(node_deg - now_deg + 180.0, 360.0) + now_deg - 180.0)


def _along_axis(
    domain: ReachableDomain, height: float, name: str, inc_now: float, raan_now: float, sign: float
) -> float:
    """How far inclination, or node, can change alone (degrees, signed); NaN when the edge is not met within 90."""

    def inside(change: float) -> float:
        inc = inc_now + (sign * change if name == "inclination" else 0.0)
        raan = raan_now + (sign * change if name == "node" else 0.0)
        tilt, azimuth = domain.tilt_and_azimuth_deg(inc, raan)
        return float(domain.limit(azimuth, height)) - tilt

    from scipy.optimize import brentq

    steps = np.arange(0.0, 90.0, 0.5)
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
