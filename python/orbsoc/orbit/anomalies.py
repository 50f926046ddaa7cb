"""Mean, eccentric and true anomalies of ellipses and hyperbolas. Radians."""

from __future__ import annotations

from math import asinh, atan, atanh, cbrt, cos, cosh, floor, pi, sin, sinh, sqrt, tan, tanh

ITERATIONS = 100
"""Of Newton's method on Kepler's equation; from the starts below it takes fewer than 20."""


def true_from_eccentric(eccentric_rad: float, ecc: float) -> float:
    """The true anomaly of an eccentric anomaly E, or of a hyperbolic one F where e > 1.

    Source: Battin 1999, eqs. 4.32 and 4.45. Raises ValueError of a parabola, which has none.
    """
    if ecc == 1.0:
        raise ValueError("a parabola has no eccentric anomaly")
    if ecc > 1.0:
        return 2.0 * atan(sqrt((ecc + 1.0) / (ecc - 1.0)) * tanh(0.5 * eccentric_rad))
    turns = floor((eccentric_rad + pi) / (2.0 * pi))
    rest = eccentric_rad - 2.0 * pi * turns
    beta = ecc / (1.0 + sqrt(1.0 - ecc**2))
    return eccentric_rad + 2.0 * atan(beta * sin(rest) / (1.0 - beta * cos(rest)))


def true_from_mean(mean_rad: float, ecc: float) -> float:
    """The true anomaly of a mean anomaly, by Newton's method on Kepler's equation M = E − e sin E (e sinh F − F).

    Raises ValueError of a parabola.
    """
    if ecc == 1.0:
        raise ValueError("a parabola has no mean anomaly")
    if ecc > 1.0:
        return true_from_eccentric(_hyperbolic(mean_rad, ecc), ecc)
    turns = floor((mean_rad + pi) / (2.0 * pi))
    rest = mean_rad - 2.0 * pi * turns
    found = rest if ecc < 0.8 else (pi if rest >= 0.0 else -pi)
    for _ in range(ITERATIONS):
        step = (found - ecc * sin(found) - rest) / (1.0 - ecc * cos(found))
        found -= step
        if abs(step) < 1e-15 * max(1.0, abs(found)):
            break
    return true_from_eccentric(found + 2.0 * pi * turns, ecc)


def mean_from_true(true_rad: float, ecc: float) -> float:
    """The mean anomaly of a true anomaly; of an ellipse in (−π, π], plus its whole turns. Raises ValueError of a parabola."""
    if ecc == 1.0:
        raise ValueError("a parabola has no mean anomaly")
    if ecc > 1.0:
        hyperbolic = 2.0 * atanh(sqrt((ecc - 1.0) / (ecc + 1.0)) * tan(0.5 * true_rad))
        return ecc * sinh(hyperbolic) - hyperbolic
    beta = ecc / (1.0 + sqrt(1.0 - ecc**2))
    eccentric = true_rad - 2.0 * atan(beta * sin(true_rad) / (1.0 + beta * cos(true_rad)))
    return eccentric - ecc * sin(eccentric)


def _hyperbolic(mean_rad: float, ecc: float) -> float:
    """F of e sinh F − F = M, from a start beyond the root: there the function is convex, and no step overshoots.

    (e − 1) F + e F³/6 ≤ M bounds F by the cube root of 6 M/e.
    """
    size = abs(mean_rad)
    found = min(cbrt(6.0 * size / ecc), asinh((size + 1.0) / (ecc - 1.0)))
    for _ in range(ITERATIONS):
        step = (ecc * sinh(found) - found - size) / (ecc * cosh(found) - 1.0)
        found -= step
        if abs(step) < 1e-15 * max(1.0, abs(found)):
            break
    return found if mean_rad >= 0.0 else -found
