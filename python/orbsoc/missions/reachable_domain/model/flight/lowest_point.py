"""The lowest point of propagated arcs, between the steps' ends too.

A step's arc is taken as the polynomial of degree 5 through position, velocity and acceleration at both its ends. A minimum
of |r| inside a step shows in the radial velocity, which changes its sign there, or, where it dips and comes back, in the
signs of its slope; only such steps are looked into.
"""

from __future__ import annotations

import numpy as np

from orbsoc.orbit.array import Array
from orbsoc.orbit.runge_kutta import RungeKuttaArc

SAMPLES = 33
"""Points of a step that is looked into; a parabola through the lowest three of them gives the minimum."""


def lowest_radius(arc: RungeKuttaArc) -> Array:
    """Smallest |r| (B,) along arcs; NaN for an arc that is NaN anywhere."""
    r, v, a = arc.positions, arc.velocities, arc.accelerations
    out = np.sqrt(np.einsum("kdb,kdb->kb", r, r).min(axis=0))
    climb = np.einsum("kdb,kdb->kb", r, v)
    slope = np.einsum("kdb,kdb->kb", v, v) + np.einsum("kdb,kdb->kb", r, a)
    turns = (climb[:-1] < 0.0) & (climb[1:] > 0.0)
    turns |= (np.sign(climb[:-1]) == np.sign(climb[1:])) & (slope[:-1] * slope[1:] < 0.0)
    step, column = np.nonzero(turns)
    if step.size:
        ends = [(x[step, :, column].T, x[step + 1, :, column].T) for x in (r, v, a)]
        inside = _minimum(_inside(*ends, length=np.diff(arc.ends)[step]))
        np.minimum.at(out, column, np.sqrt(inside))
    return np.asarray(out)


def _inside(
    r: tuple[Array, Array], v: tuple[Array, Array], a: tuple[Array, Array], *, length: Array
) -> Array:
    """|r|² (SAMPLES, M) at equal intervals of M steps, of `length` (M,), whose ends have r, v and a (d, M)."""
    s = np.linspace(0.0, 1.0, SAMPLES)[:, None, None]
    gap = r[1] - r[0] - length * v[0] - 0.5 * length**2 * a[0]
    rate = length * (v[1] - v[0]) - length**2 * a[0]
    bend = length**2 * (a[1] - a[0])
    third, fourth, fifth = (
        10 * gap - 4 * rate + bend / 2,
        -15 * gap + 7 * rate - bend,
        6 * gap - 3 * rate + bend / 2,
    )
    at = r[0] + s * (length * v[0] + s * (0.5 * length**2 * a[0] + s * (third + s * (fourth + s * fifth))))
    return np.asarray(np.einsum("kdm,kdm->km", at, at))


def _minimum(values: Array) -> Array:
    """The least value (M,) of columns (K, M) at equal intervals, by a parabola through the lowest and its neighbours."""
    k = np.clip(values.argmin(axis=0), 1, len(values) - 2)
    m = np.arange(values.shape[1])
    before, here, after = values[k - 1, m], values[k, m], values[k + 1, m]
    bend = before - 2.0 * here + after
    rise = 0.5 * (after - before)
    turned = (bend > 0.0) & (np.abs(rise) <= bend)
    lowest = here - 0.5 * rise**2 / np.where(turned, bend, 1.0)
    return np.asarray(np.where(turned, lowest, values.min(axis=0)))
