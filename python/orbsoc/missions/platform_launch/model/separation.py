"""The instant at which a server leaves its tube, and three independent ways to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit.array import Array

from . import kane, two_body
from .launch import Pair, closed_form, released, slide_after

SAMPLES = 121
"""Instants of a history."""


@dataclass(frozen=True, slots=True, eq=False)
class Separation:
    """When the server leaves, what the launch has done to the platform, q and its rates (8,), and the server's state.

    `platform` (4,) is the platform's x, z and rates before the launch.
    """

    pair: Pair
    time_s: float
    q: Array
    platform: Array

    @property
    def server(self) -> Array:
        """x along the target's motion, z outward, and rates, (4,)."""
        return released(self.pair, self.q, self.time_s, self.platform)

    @property
    def state(self) -> Array:
        """The server's, (6,), in (R, T, N)."""
        x, z, vx, vz = self.server
        return np.array([z, x, 0.0, vz, vx, 0.0])

    def times(self) -> Array:
        """At which histories are told, (SAMPLES,), from the start to the separation."""
        return np.linspace(0.0, self.time_s, SAMPLES)


def separated(pair: Pair, stroke_m: float, stop_s: float | None, platform: Array) -> Separation:
    """The separation at the end of the stroke, or at a time. Raises LaunchError where it never comes."""
    if stop_s is not None:
        if pair.free:
            stroke_m = slide_after(pair, stop_s, stroke_m)
        else:
            return Separation(pair, stop_s, kane.integrate(pair, np.array([0.0, stop_s]))[-1], platform)
    if pair.free:
        times, states = closed_form(pair, np.array([stroke_m]))
        return Separation(pair, float(times[0]), states[0], platform)
    return Separation(pair, *kane.until(pair, stroke_m), platform)


def disagreement(found: Separation) -> tuple[float, float]:
    """How far Kane's equations, and the two bodies with their reaction, are from the separation: the largest difference
    of q and its rates, SI, over the largest of them where that is above 1. With thrust or torque the first is 0, for
    the separation itself is by Kane's equations."""
    span, size = np.array([0.0, found.time_s]), max(1.0, float(np.abs(found.q).max()))
    ways = kane.integrate(found.pair, span), two_body.integrate(found.pair, span).states
    by_kane, by_forces = (float(np.abs(way[-1] - found.q).max()) / size for way in ways)
    return by_kane, by_forces


def in_rotating_frame(found: Separation, rate_rad_s: float) -> tuple[Array, Array]:
    """The same launch with the Clohessy–Wiltshire accelerations on both bodies: the server's state (4,) at the same
    time, and the platform's q and rates (8,), which hold its own motion about the target. What "the local frame is
    inertial" leaves out."""
    span = np.array([0.0, found.time_s])
    bodies = two_body.integrate(found.pair, span, platform=found.platform, rate_rad_s=rate_rad_s)
    q = bodies.states[-1]
    return released(found.pair, q, 0.0, np.zeros(4)), q
