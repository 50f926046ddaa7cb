"""OpenSCvx's public prox-ops data with thrust as it has it: an acceleration of at most 0.1 m/s² an axis, held between nodes.

`python -m benchmarks.station_proxops`: 6778 km, from 100 m behind on the V-bar at 2 m/s into a cone of 20° about the R-bar, entered at
25 m or more, at rest on the target at the end, 177 s. One conic problem: the least time integral of the acceleration, whose norm is
counted; the cone holds at the nodes from `entry` on. The flight is then integrated by DOP853, and the cone is judged at 1 ms.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from math import radians, tan

import numpy as np
from scipy.integrate import solve_ivp

import orbsoc
from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.solution import Status
from orbsoc.guidance.impulses import Impulses
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire

RATE = float(np.sqrt(3.986004418e14 / 6.778e6**3))
LIMIT_M_S2, ENTRY_M, HALF_ANGLE = 0.1, 25.0, radians(20.0)
START = np.array([0.0, -100.0, 0.0, 0.0, 2.0, 0.0])
"""(R, T, N); the R-bar points down, so that the cone is about −R."""
LAST_S, ENTRY_S = 177.0, 120.0
ROOM_M = 1e-3
"""By which the cone is kept better at nodes."""


@dataclass(frozen=True, slots=True)
class Flown:
    """Velocity change, how far outside the cone the flight was at most, its miss, and the largest acceleration of an axis."""

    delta_v_m_s: float
    outside_m: float
    miss_m: float
    largest_m_s2: float


def planned(step_s: float) -> tuple[Array, Array]:
    """Times (K,) at which an acceleration begins, and the velocity changes (K, 3) until the next."""
    times = np.arange(0.0, LAST_S - 1e-9, step_s)
    ends = np.append(times[1:], LAST_S)
    builder = ConicBuilder()
    impulses = Impulses(builder, ClohessyWiltshire(RATE), times, START, linked=True, until_s=ends)
    impulses.cost("norms")
    most = LIMIT_M_S2 * np.repeat(ends - times, 3)
    builder.bounds(impulses.dv, -most, most)
    along, steps = np.array([-1.0, 0.0, 0.0]), tan(HALF_ANGLE)
    rows = np.zeros((3, 6))
    rows[0, :3], rows[1, 1], rows[2, 2] = steps * along, 1.0, 1.0
    inside = ends[(ends >= ENTRY_S - 1e-9) & (ends < LAST_S)]
    impulses.below(float(inside[0]), np.eye(6)[:1], -ENTRY_M, before=True, name="entry")
    for t in inside.tolist():
        impulses.cone(t, rows, [-ROOM_M * min(1.0, (LAST_S - t) / 20.0), 0.0, 0.0], name=f"cone at {t:g}")
    impulses.meet(LAST_S, np.zeros(6), before=True, name="rest on the target")
    solution = orbsoc.solve(builder.build(), tol=1e-9)
    if solution.status is not Status.SOLVED:
        raise SystemExit(f"the solve ended with {solution.status.name}")
    return times, impulses.programme(solution).dv_m_s


def flown(times: Array, dv: Array) -> Flown:
    """Integrated by the equations of motion, each acceleration held until the next."""
    ends = np.append(times[1:], LAST_S)
    state, outside = START, -np.inf
    for a, b, change in zip(times.tolist(), ends.tolist(), dv, strict=True):
        push = change / (b - a)

        def rate(_: float, s: Array, push: Array = push) -> Array:
            pull = [3.0 * RATE**2 * s[0] + 2.0 * RATE * s[4], -2.0 * RATE * s[3], -(RATE**2) * s[2]]
            return np.concatenate([s[3:], pull + push])

        fine = np.linspace(a, b, max(2, round(1000.0 * (b - a)) + 1))
        found = solve_ivp(rate, (a, b), state, method="DOP853", t_eval=fine, rtol=1e-11, atol=1e-11)
        if a >= ENTRY_S - 1e-9:
            places = found.y[:3]
            across = np.linalg.norm(places[1:], axis=0)
            outside = max(outside, float((np.cos(HALF_ANGLE) * (across + places[0] * tan(HALF_ANGLE))).max()))
        state = found.y[:, -1]
    largest = float(np.abs(dv / (ends - times)[:, None]).max())
    total = float(np.linalg.norm(dv, axis=1).sum())
    return Flown(total, outside, float(np.linalg.norm(state[:3])), largest)


def main() -> None:
    """A line a node spacing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=float, nargs="*", default=[20.0, 10.0, 3.0, 1.0], help="seconds")
    for step in parser.parse_args().steps:
        found = flown(*planned(step))
        sys.stdout.write(
            f"{step:g} s: {found.delta_v_m_s:.4f} m/s, outside the cone {found.outside_m:.5f} m, missed by"
            f" {found.miss_m:.1e} m, at most {found.largest_m_s2:.4f} m/s² an axis\n"
        )


if __name__ == "__main__":
    main()
