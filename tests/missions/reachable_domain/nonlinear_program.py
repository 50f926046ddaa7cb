"""Independent verification of the reachable domain, without its code: the whole nonlinear problem, by IPOPT.

Direct collocation of constant-thrust flight on Radau points of many short intervals, unit thrust vectors as unknowns,
one nonlinear program; no linearisation, no elimination, no multipliers, no shared code but the constants. The perigee
condition is (|H|²/ρ − 1)² ≥ |L|² in squares of vectors. Needs CasADi, a test extra.

`python -m tests.missions.reachable_domain.nonlinear_program` solves the recorded points again and writes `data/nonlinear_program.json`.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

MU, RADIUS = 3.986004418e14, 6378137.0
SPEED = np.sqrt(MU / RADIUS)
TIME = RADIUS / SPEED
START = np.array([-4780421.0, 4388673.2, 1069366.2, -4944.1088, -4692.4264, -3389.3615])
MASS, THRUST, FLOW, BURN_S = 160000.0, 270000.0, 60.0, 1200.0
INTERVALS, DEGREE = 64, 4
RECORD = Path(__file__).resolve().parent / "data" / "nonlinear_program.json"


@dataclass(frozen=True)
class Answer:
    """What IPOPT found: whether it converged, and the value sought (a in km, or a tilt in degrees)."""

    converged: bool
    value: float


class NonlinearProgram:
    """`tilt=False`: the largest semi-major axis on a plane. `tilt=True`: the largest tilt at an azimuth."""

    def __init__(self, *, tilt: bool, intervals: int = INTERVALS) -> None:
        import casadi as ca

        self._tilt, self._intervals = tilt, intervals
        self._points = np.array([0.0, *ca.collocation_points(DEGREE, "radau")])
        slopes, _end = self._basis()
        step = BURN_S / TIME / intervals
        x = ca.MX.sym("x", 6, intervals * DEGREE + 1)
        u = ca.MX.sym("u", 3, intervals * DEGREE)
        data = ca.MX.sym("p", 10)  # three axes of the plane (or tilt frame) and the perigee radius
        rules, low, high = [x[:, 0] - START / np.repeat([RADIUS, SPEED], 3)], [0.0] * 6, [0.0] * 6
        for k in range(intervals):
            for j in range(1, DEGREE + 1):
                column = k * DEGREE + j
                time_s = (k + self._points[j]) / intervals * BURN_S
                push = THRUST / (MASS - FLOW * time_s) / (SPEED / TIME)
                r, v = x[:3, column], x[3:, column]
                rate = ca.vertcat(v, -r / ca.norm_2(r) ** 3 + push * u[:, column - 1])
                slope = sum(slopes[i, j] * x[:, k * DEGREE + i] for i in range(DEGREE + 1))
                rules += [slope - step * rate, ca.sumsqr(u[:, column - 1]) - 1.0]
                low += [0.0] * 7
                high += [0.0] * 7
        r, v = x[:3, -1], x[3:, -1]
        momentum = ca.cross(r, v)
        laplace = ca.cross(v, momentum) - r / ca.norm_2(r)
        first, second, normal = data[:3], data[3:6], data[6:9]
        rules.append(ca.dot(momentum, first))
        low.append(0.0)
        high.append(0.0)
        if not tilt:
            rules.append(ca.dot(momentum, second))
            low.append(0.0)
            high.append(0.0)
        reach = ca.sumsqr(momentum) / data[9] - 1.0
        rules += [reach**2 - ca.sumsqr(laplace), reach]
        low += [0.0, 0.0]
        high += [np.inf, np.inf]
        energy = ca.sumsqr(v) / 2.0 - 1.0 / ca.norm_2(r)
        objective = ca.atan2(ca.dot(momentum, second), ca.dot(momentum, normal)) if tilt else energy
        options = {
            "print_time": False,
            "ipopt": {"print_level": 0, "tol": 1e-10, "max_iter": 500, "sb": "yes"},
        }
        program = {"x": ca.veccat(x, u), "p": data, "f": -objective, "g": ca.vertcat(*rules)}
        self._solver = ca.nlpsol("referee", "ipopt", program, options)
        self._low, self._high = low, high

    def __call__(self, axes: np.ndarray, perigee_km: float, steer_to: np.ndarray) -> Answer:
        """Solve with the rows of `axes` (3, 3) as the plane's two axes and normal (or hinge, direction and current
        normal), from a flight along the velocity that leans to the plane of normal `steer_to`."""
        guess = self._flight(steer_to)
        data = np.concatenate([axes.ravel(), [1.0 + 1e3 * perigee_km / RADIUS]])
        found = self._solver(x0=guess, p=data, lbg=self._low, ubg=self._high)
        objective = -float(found["f"])
        value = float(np.rad2deg(objective)) if self._tilt else -RADIUS / 2e3 / objective
        return Answer(bool(self._solver.stats()["success"]), value)

    def _basis(self) -> tuple[np.ndarray, np.ndarray]:
        """Slopes of the Lagrange polynomials at the points, [i, j] = L_i'(τ_j), and their end values."""
        count = len(self._points)
        slopes, end = np.zeros((count, count)), np.zeros(count)
        for i in range(count):
            polynomial = np.poly1d([1.0])
            for k in range(count):
                if k != i:
                    root = np.poly1d([1.0, -self._points[k]])
                    polynomial *= root / (self._points[i] - self._points[k])
            slopes[i] = np.polyder(polynomial)(self._points)
            end[i] = polynomial(1.0)
        return slopes, end

    def _flight(self, normal: np.ndarray) -> np.ndarray:
        """Euler–Cauchy flight with v̂ − 2(v·n)n: a guess needs no digits."""
        count = self._intervals * DEGREE
        step = BURN_S / TIME / count
        x, states, controls = START / np.repeat([RADIUS, SPEED], 3), [], []

        def rate(at: np.ndarray, time_s: float) -> tuple[np.ndarray, np.ndarray]:
            v = at[3:]
            lean = v / np.linalg.norm(v) - 2.0 * (v @ normal) * normal
            lean /= np.linalg.norm(lean)
            push = THRUST / (MASS - FLOW * time_s) / (SPEED / TIME)
            return np.concatenate([v, -at[:3] / np.linalg.norm(at[:3]) ** 3 + push * lean]), lean

        states.append(x)
        for k in range(count):
            time_s = (k + 0.5) * step * TIME
            middle = x + 0.5 * step * rate(x, time_s)[0]
            slope, lean = rate(middle, time_s)
            x = x + step * slope
            states.append(x)
            controls.append(lean)
        return np.concatenate([np.ravel(states), np.ravel(controls)])


def plane_axes(inc_deg: float, raan_deg: float) -> np.ndarray:
    """Node, the direction ahead of it, and the normal of a plane, as rows."""
    inc, raan = np.deg2rad([inc_deg, raan_deg])
    node = np.array([np.cos(raan), np.sin(raan), 0.0])
    normal = np.array([np.sin(inc) * np.sin(raan), -np.sin(inc) * np.cos(raan), np.cos(inc)])
    return np.array([node, np.cross(normal, node), normal])


def tilt_axes(azimuth_deg: float) -> np.ndarray:
    """Hinge, direction of the azimuth, and current normal, as rows; azimuth 0 raises the inclination."""
    normal = np.cross(START[:3], START[3:])
    normal /= np.linalg.norm(normal)
    inc, raan = np.arccos(normal[2]), np.arctan2(normal[0], -normal[1])
    up = np.array([np.cos(inc) * np.sin(raan), -np.cos(inc) * np.cos(raan), -np.sin(inc)])
    beta = np.deg2rad(azimuth_deg)
    towards = np.cos(beta) * up + np.sin(beta) * np.cross(normal, up)
    return np.array([np.cross(normal, towards), towards, normal])


def drawn_points() -> list[tuple[float, float, float]]:
    """Forty planes anywhere in the domain and twenty within a degree of its edge, at random perigee bounds.

    Drawn with the code under test, because only it knows the edge; the nonlinear program does not use it.
    """
    from orbsoc.missions.reachable_domain.model.direct.terminal import LargestTilt
    from orbsoc.missions.reachable_domain.search.continuation.largest_tilt import largest_tilts
    from orbsoc.orbit.planes import inclination_and_node
    from tests.missions.reachable_domain.cases import domain, perigees

    draw = np.random.default_rng(2025)
    azimuth, height = draw.uniform(0.0, 2.0 * np.pi, 60), draw.uniform(100.0, 500.0, 60).round(1)
    found = domain()
    edge = largest_tilts(found.tools, LargestTilt(found.frame, azimuth, perigees(*height))).tilt
    tilt = np.where(np.arange(60) < 40, edge * np.sqrt(draw.uniform(0.0, 1.0, 60)), edge)
    tilt[40:] -= np.deg2rad(draw.uniform(0.03, 1.0, 20))
    inc, raan = np.rad2deg(inclination_and_node(found.frame.tilted(tilt, azimuth)))
    return [
        (round(float(i), 3), round(float(o), 3), float(h)) for i, o, h in zip(inc, raan, height, strict=True)
    ]


def nearest_miss(energy: NonlinearProgram, tilt: NonlinearProgram) -> dict[str, Any]:
    """The plane of the 1° grid that is missed by least at 100 km: whether a burn onto it was found, the azimuth and tilt at
    which it lies, and the furthest tilt there."""
    inc, raan, height = 16.3, 332.25, 100.0
    axes, level = plane_axes(inc, raan), tilt_axes(0.0)
    hinge, ahead, current = level
    azimuth = np.rad2deg(np.arctan2(axes[2] @ hinge, axes[2] @ ahead)) % 360.0
    about = tilt_axes(azimuth)
    lean = np.deg2rad(10.0)
    furthest = tilt(about, height, np.cos(lean) * about[2] + np.sin(lean) * about[1])
    return {
        "inc_deg": inc,
        "raan_deg": raan,
        "perigee_km": height,
        "found": energy(axes, height, axes[2]).converged,
        "azimuth_deg": round(float(azimuth), 6),
        "at_tilt_deg": round(float(np.rad2deg(np.arccos(axes[2] @ current))), 6),
        "converged": furthest.converged,
        "furthest_tilt_deg": round(furthest.value, 6),
    }


def main() -> None:
    """Record the answers of the nonlinear program."""
    energy, tilt = NonlinearProgram(tilt=False), NonlinearProgram(tilt=True)
    points: list[dict[str, Any]] = []
    for inc, raan, height in drawn_points():
        axes = plane_axes(inc, raan)
        answer = energy(axes, height, axes[2])
        points.append({"inc_deg": inc, "raan_deg": raan, "perigee_km": height, "converged": answer.converged})
        points[-1]["a_km"] = round(answer.value, 6)
        sys.stderr.write(f"{points[-1]}\n")
    edge: list[dict[str, Any]] = []
    for height in (100.0, 300.0, 500.0):
        for azimuth in range(0, 360, 30):
            axes = tilt_axes(azimuth)
            lean = np.deg2rad(10.0)
            answer = tilt(axes, height, np.cos(lean) * axes[2] + np.sin(lean) * axes[1])
            edge.append({"azimuth_deg": azimuth, "perigee_km": height, "converged": answer.converged})
            edge[-1]["tilt_deg"] = round(answer.value, 6)
            sys.stderr.write(f"{edge[-1]}\n")
    about = {"intervals": INTERVALS, "degree": DEGREE, "method": "Radau collocation, IPOPT through CasADi"}
    record = {
        "about": about,
        "points": points,
        "boundary": edge,
        "nearest_miss": nearest_miss(energy, tilt),
    }
    RECORD.parent.mkdir(exist_ok=True)
    RECORD.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
