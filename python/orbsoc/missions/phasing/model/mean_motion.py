"""Equinoctial elements of many states at once, and the motion of mean ones: J2 turns node and perigee at secular rates.

Elements (..., 6) are a (m), f + i g = e exp(i ϖ), h + i k = tan(i/2) exp(i Ω), and the mean longitude ℓ = Ω + ω + M, which
counts whole turns. They have no singularity but at i = 180°. Source: Broucke & Cefola 1972; the rates: Vallado, 4th ed., section 9.6.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import tau

import numpy as np
from numpy.typing import ArrayLike

from orbsoc.orbit import EARTH, Elements
from orbsoc.orbit.anomalies import mean_from_true
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import EARTH_J2, Force, fast_coast

MU, RADIUS_M = EARTH.mu_m3_s2, EARTH.earth_radius_m
SAMPLES = 48
"""Of a revolution, over which osculating elements are averaged."""
STEPS = np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 1e-3])
"""Of positions (m) and velocities (m/s), by which elements are differenced."""


def wrapped(angle: ArrayLike) -> Array:
    """In [−π, π)."""
    return np.asarray((np.asarray(angle) + np.pi) % tau - np.pi)


def equinoctial(states: Array) -> Array:
    """Elements (..., 6) of states [r_m, v_m_s] (..., 6), ℓ in [−π, π); NaN of a hyperbola."""
    r, v = states[..., :3], states[..., 3:]
    radius = np.linalg.norm(r, axis=-1)
    sma = 1.0 / (2.0 / radius - np.einsum("...i,...i->...", v, v) / MU)
    momentum = _cross(r, v)
    pole = momentum / np.linalg.norm(momentum, axis=-1)[..., None]
    h, k = -pole[..., 1] / (1.0 + pole[..., 2]), pole[..., 0] / (1.0 + pole[..., 2])
    one, two = _axes(h, k)
    ecc = _cross(v, momentum) / MU - r / radius[..., None]
    f, g, x, y = (np.einsum("...i,...i->...", a, b) for a, b in ((ecc, one), (ecc, two), (r, one), (r, two)))
    with np.errstate(invalid="ignore"):
        root = np.sqrt(1.0 - f**2 - g**2)
    beta = 1.0 / (1.0 + root)
    cosine = f + ((1.0 - f**2 * beta) * x - f * g * beta * y) / (sma * root)
    sine = g + ((1.0 - g**2 * beta) * y - f * g * beta * x) / (sma * root)
    return np.stack([sma, f, g, h, k, wrapped(np.arctan2(sine, cosine) + g * cosine - f * sine)], axis=-1)


def _cross(a: Array, b: Array) -> Array:
    """As `numpy.cross`, a few times as fast for few vectors."""
    return np.asarray(a[..., [1, 2, 0]] * b[..., [2, 0, 1]] - a[..., [2, 0, 1]] * b[..., [1, 2, 0]])


def states_of(elements: Array) -> Array:
    """States (..., 6) of elements (..., 6)."""
    sma, f, g, h, k, longitude = (elements[..., k] for k in range(6))
    eccentric = longitude.copy()
    for _ in range(
        8
    ):  # Newton's method on ℓ = F + g cos F − f sin F; it ends at rounding by e < 0.1 after four
        sine, cosine = np.sin(eccentric), np.cos(eccentric)
        eccentric -= (eccentric + g * cosine - f * sine - longitude) / (1.0 - g * sine - f * cosine)
    sine, cosine = np.sin(eccentric), np.cos(eccentric)
    beta = 1.0 / (1.0 + np.sqrt(1.0 - f**2 - g**2))
    x = sma * ((1.0 - g**2 * beta) * cosine + f * g * beta * sine - f)
    y = sma * ((1.0 - f**2 * beta) * sine + f * g * beta * cosine - g)
    rate = np.sqrt(MU / sma) / (1.0 - f * cosine - g * sine)
    x_rate = rate * (f * g * beta * cosine - (1.0 - g**2 * beta) * sine)
    y_rate = rate * ((1.0 - f**2 * beta) * cosine - f * g * beta * sine)
    one, two = _axes(h, k)
    parts = (x[..., None] * one + y[..., None] * two, x_rate[..., None] * one + y_rate[..., None] * two)
    return np.concatenate(parts, axis=-1)


def _axes(h: Array, k: Array) -> tuple[Array, Array]:
    """Of the orbit's plane, (..., 3) each, the first as far from the node as the node from the x axis."""
    size = (1.0 + h**2 + k**2)[..., None]
    one = np.stack([1.0 + h**2 - k**2, 2.0 * h * k, -2.0 * k], axis=-1)
    two = np.stack([2.0 * h * k, 1.0 - h**2 + k**2, 2.0 * h], axis=-1)
    return one / size, two / size


def secular_rates(elements: Array) -> Array:
    """Of node, argument of perigee and mean anomaly, rad/s, (..., 3)."""
    sma, f, g, h, k, _ = (elements[..., k] for k in range(6))
    shape, tilt = 1.0 - f**2 - g**2, h**2 + k**2
    cosine = (1.0 - tilt) / (1.0 + tilt)
    motion = np.sqrt(MU / sma**3)
    by_j2 = 1.5 * EARTH_J2 * (RADIUS_M / (sma * shape)) ** 2 * motion
    anomaly = motion + by_j2 * np.sqrt(shape) * (1.5 * cosine**2 - 0.5)
    return np.stack([-by_j2 * cosine, by_j2 * (2.5 * cosine**2 - 0.5), anomaly], axis=-1)


def drifted(elements: Array, dt_s: ArrayLike, rates: Array | None = None) -> Array:
    """Mean elements (..., 6) after a time (...), at their secular rates or at those given."""
    rates_of = secular_rates(elements) if rates is None else rates
    node, perigee, anomaly = (rates_of[..., k] for k in range(3))
    dt = np.asarray(dt_s)
    by_node, by_perigee = node * dt, (node + perigee) * dt
    sma, f, g, h, k, longitude = (elements[..., k] for k in range(6))
    return np.stack(
        np.broadcast_arrays(
            sma,
            f * np.cos(by_perigee) - g * np.sin(by_perigee),
            g * np.cos(by_perigee) + f * np.sin(by_perigee),
            h * np.cos(by_node) - k * np.sin(by_node),
            k * np.cos(by_node) + h * np.sin(by_node),
            longitude + (node + perigee + anomaly) * dt,
        ),
        axis=-1,
    )


def secular(orbit: Elements, dt_s: Array) -> Array:
    """Equinoctial elements (..., 6) some time after those of an orbit: J2 turns node and perigee, Kepler's law the anomaly.

    Source: the rules of the 9th Global Trajectory Optimisation Competition, by which its debris moves.
    """
    anomaly = mean_from_true(orbit.true_anomaly_rad, orbit.ecc)
    longitude, tilt = orbit.argp_rad + orbit.raan_rad, np.tan(0.5 * orbit.inc_rad)
    first = np.array(
        [orbit.sma_m, orbit.ecc * np.cos(longitude), orbit.ecc * np.sin(longitude),
         tilt * np.cos(orbit.raan_rad), tilt * np.sin(orbit.raan_rad), longitude + anomaly]
    )  # fmt: skip
    rates = secular_rates(first)
    rates[2] = np.sqrt(MU / orbit.sma_m**3)
    return drifted(np.broadcast_to(first, (*np.shape(dt_s), 6)), dt_s, rates)


def mean_elements(states: Array, forces: Sequence[Force]) -> Array:
    """Mean elements (B, 6) of osculating states (B, 6) near one orbit: those of a revolution from each, averaged."""
    first = equinoctial(states)
    times = np.arange(SAMPLES) / SAMPLES * tau / float(secular_rates(first).sum(axis=-1).mean())
    found = equinoctial(fast_coast(states, times, forces))
    rates = secular_rates(found.mean(axis=0))
    back = drifted(found, -times[:, None], rates[None])
    back[..., 5] = first[:, 5] + wrapped(back[..., 5] - first[:, 5])
    return np.asarray(back.mean(axis=0))


def element_lengths(radius_m: float) -> Array:
    """That make metres of differences of elements, (6,)."""
    return np.array([1.0, *[radius_m] * 5])


def element_rows(states: Array) -> Array:
    """Derivatives (..., 6, 6) of the elements by a state (..., 6)."""
    first = equinoctial(states)

    def near(each: Array) -> Array:
        found = equinoctial(each)
        found[..., 5] = wrapped(found[..., 5] - first[..., 5])
        return found

    return differences(near, states, STEPS)


def differences(function: Callable[[Array], Array], at: Array, steps: Array) -> Array:
    """Derivatives (..., 6, m) of a function of vectors (..., m), by central differences of these steps (m,)."""
    changes = np.diag(steps).reshape(steps.size, *(1,) * (at.ndim - 1), steps.size)
    apart = function(at + changes) - function(at - changes)
    return np.asarray(np.moveaxis(apart, 0, -1) / (2.0 * steps))
