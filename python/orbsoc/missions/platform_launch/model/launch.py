"""A launch: a server is pushed out of its tube, and the platform recoils and turns.

Motion is planar and free; the axes are those of the target's local frame, x along its motion and z outward, taken as
inertial for the second that a launch takes. Coordinates are q = (x, z, θ, s): the platform's centre of mass, its yaw,
counter-clockwise with x to the right and z up, and how far the server has slid. They count from the platform's own
uniform motion before the launch, so that x, z and their rates are what the launch does to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin
from typing import Any, cast

import numpy as np
from scipy.integrate import solve_ivp  # pyright: ignore[reportUnknownVariableType]
from scipy.optimize import brentq

from orbsoc.orbit.array import Array

from .rack import Assembly, Rack, Slot

NODES, WEIGHTS = np.polynomial.legendre.leggauss(48)
TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
"""By a right angle, counter-clockwise."""
RTOL = 1e-13
FARTHEST = 1e3
"""Strokes that a server may have slid at a given time."""


class LaunchError(ValueError):
    """The server does not leave its tube; the message says why."""


def axes(yaw: float) -> Array:
    """The body's axes as columns, (2, 2)."""
    return np.array([[cos(yaw), -sin(yaw)], [sin(yaw), cos(yaw)]])


def integrated(rate: Callable[[Array], Array], start: Array, times_s: Array, rtol: float = RTOL) -> Array:
    """States (K, n) at increasing times (K,), the first of them the start, by DOP853. Raises LaunchError."""
    times = np.asarray(times_s, np.float64)
    run: Any = cast(Any, solve_ivp)  # published without types
    span = times[0], times[-1]
    found = run(lambda _, y: rate(y), span, start, method="DOP853", t_eval=times, rtol=rtol, atol=0.01 * rtol)
    if not found.success:
        raise LaunchError(f"the launch cannot be integrated: {found.message}")
    return np.asarray(found.y.T)


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """The assembly and the server in its tube; forces and torque in body axes, `thrust_n` at the platform's centre."""

    assembly: Assembly
    server_mass_kg: float
    server_inertia_kg_m2: float
    place_m: Array
    """Of the server's centre of mass before it slides, from the platform's."""
    force_n: float
    thrust_n: Array
    torque_n_m: float
    yaw_rad: float
    yaw_rate_rad_s: float

    @classmethod
    def of(
        cls,
        rack: Rack,
        slot: Slot,
        force_n: float,
        *,
        yaw_rad: float,
        yaw_rate_rad_s: float,
        thrust_n: tuple[float, float] = (0.0, 0.0),
        torque_n_m: float = 0.0,
    ) -> Pair:
        """The server of `slot` in a rack that has it."""
        return cls(
            rack.without(slot).assembly(), rack.server_mass_kg, rack.server_inertia_kg_m2, rack.place(slot),
            force_n, np.array(thrust_n), torque_n_m, yaw_rad, yaw_rate_rad_s,
        )  # fmt: skip

    @property
    def free(self) -> bool:
        """Whether nothing acts from outside, so that momentum, angular momentum and energy give the motion."""
        return not self.thrust_n.any() and self.torque_n_m == 0.0

    @property
    def start(self) -> Array:
        """q and its rates before the launch, (8,)."""
        return np.array([0.0, 0.0, self.yaw_rad, 0.0, 0.0, 0.0, self.yaw_rate_rad_s, 0.0])


def closed_form(pair: Pair, slides_m: Array) -> tuple[Array, Array]:
    """Times (K,) at which the server has slid by `slides_m` (K,) ≥ 0, and q with its rates there, (K, 8).

    With H the angular momentum about the common centre of mass, the reduced mass μ, and D(s) the inertia about it:
    Dθ̇ + μ r_x ṡ = H and the energy Dθ̇²/2 + μ r_x ṡθ̇ + μṡ²/2 = fs + H²/2D(0) give both rates by s; time and yaw are
    integrals over √s, which are smooth. Needs a pair that is `free`. Raises LaunchError where the server does not get.
    """
    slides = np.asarray(slides_m, np.float64)
    body, m = pair.assembly, pair.server_mass_kg
    reduced, total = m * body.mass_kg / (m + body.mass_kg), m + body.mass_kg
    across, along = pair.place_m - body.centre_m

    def inertia(s: Array) -> Array:
        own = body.inertia_kg_m2 + pair.server_inertia_kg_m2
        return np.asarray(own + reduced * (across**2 + (along + s) ** 2))

    first = float(inertia(np.zeros(1))[0])
    momentum = first * pair.yaw_rate_rad_s

    def rates(root: Array) -> tuple[Array, Array]:
        """ṡ/√s and θ̇, by √s."""
        s = root**2
        d = inertia(s)
        push = pair.force_n + 0.5 * momentum**2 * reduced * (2.0 * along + s) / (first * d)
        square = 2.0 * push / (reduced * (1.0 - reduced * across**2 / d))
        if not square.min(initial=np.inf) > 0.0:
            raise LaunchError(
                f"force_n = {pair.force_n:g}: the platform's rotation holds the server in its tube"
            )
        slope = np.sqrt(square)
        return slope, np.asarray((momentum - reduced * across * root * slope) / d)

    roots = np.sqrt(slides)
    inner = 0.5 * roots[:, None] * (NODES + 1.0)
    slope, turning = rates(inner)
    times = np.sum(WEIGHTS * roots[:, None] / slope, axis=1)
    yaws = pair.yaw_rad + np.sum(WEIGHTS * roots[:, None] * turning / slope, axis=1)
    slope, turning = rates(roots)
    speeds = roots * slope
    found = np.empty((slides.size, 8))
    # The common centre of mass moves uniformly, at the speed that the yaw rate gives it beside the platform's.
    origin = axes(pair.yaw_rad) @ (body.mass_kg * body.centre_m + m * pair.place_m) / total
    drift = pair.yaw_rate_rad_s * TURN @ origin
    for k, (t, yaw, rate) in enumerate(zip(times, yaws, turning, strict=True)):
        body_axes = axes(yaw)
        moved = pair.place_m + np.array([0.0, slides[k]])
        offset = body_axes @ (body.mass_kg * body.centre_m + m * moved) / total
        found[k, :2] = origin + drift * t - offset
        found[k, 4:6] = drift - rate * TURN @ offset - m / total * speeds[k] * body_axes[:, 1]
    found[:, 2], found[:, 3], found[:, 6], found[:, 7] = yaws, slides, turning, speeds
    return times, found


def slide_after(pair: Pair, time_s: float, stroke_m: float) -> float:
    """How far the server of a `free` pair has slid at a time, m. Raises LaunchError beyond `FARTHEST` strokes."""

    def late(slide: float) -> float:
        return float(closed_form(pair, np.array([slide]))[0][0]) - time_s

    far = stroke_m
    while late(far) < 0.0:
        far *= 2.0
        if far > FARTHEST * stroke_m:
            raise LaunchError(f"stop_s = {time_s:g}: the server has slid beyond {FARTHEST:g} strokes by then")
    return float(brentq(late, 0.0, far, xtol=1e-15, rtol=1e-14))


def released(pair: Pair, q: Array, time_s: float, platform: Array) -> Array:
    """The server's state (4,), x, z and rates, where the platform's before the launch is `platform` (4,)."""
    body_axes = axes(q[2])
    offset = body_axes @ (pair.place_m + np.array([0.0, q[3]]))
    position = platform[:2] + platform[2:] * time_s + q[:2] + offset
    velocity = platform[2:] + q[4:6] + q[6] * TURN @ offset + q[7] * body_axes[:, 1]
    return np.concatenate([position, velocity])
