"""Where the search sets out: two impulses, each made into a burn about its point of time.

A target with free elements is completed in a few ways, and the impulses are sought to each; the burns then have to meet only
what is given.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from orbsoc.guidance.powered_flight import Burn
from orbsoc.orbit import CanonicalUnits, Elements, elements_from_state, rotate_state, state_from_elements
from orbsoc.orbit.array import Array, Flags

from ..targets.free_target import FreeTarget
from ..targets.target import Target
from ..targets.target_orbit import TargetOrbit
from .impulses import COARSE, FINE, Impulses, Rules, cheapest
from .limits import Limits
from .motion import Motion
from .transfer import Transfer, constant

DEPARTURES, FEW_DEPARTURES = 60, 24
DENSER = 8
"""States of the first orbit for a departure, between which it is interpolated: to some 1e-7 of its speed."""
MOST_REVOLUTIONS = 16.0
"""With J2 no revolution of the first orbit is like the one before; up to this many each have `FEW_DEPARTURES`."""
MANY = 1.5
"""Revolutions, from which on each of them counts."""
NEW_NODES = np.deg2rad([0.0, -20.0, 20.0])
PERIGEES = 6
"""Directions of the perigee that a target with a free one is completed by."""
LEAST_COAST = 1e-3


def guesses(motion: Motion, target: Target, limits: Limits) -> list[Impulses]:
    """The cheapest pairs of impulses, best first, that burns can be made of within the limits.

    The first orbit is that of the coast; the transfers are two-body orbits.
    """
    burn = motion.burn
    if isinstance(target, FreeTarget):
        whole = list(_completed(burn, target))
    else:
        assert isinstance(target, TargetOrbit)
        whole = [target]
    latest = limits.ignition + 0.5 * limits.burning
    turns = revolutions(motion, latest)
    fine = len(whole) == 1 and turns <= MANY
    count = DEPARTURES if fine else int(FEW_DEPARTURES * min(turns, MOST_REVOLUTIONS))
    departures = np.linspace(0.0, latest, count)
    times = np.linspace(0.0, latest, DENSER * count)
    states = motion.coast.way(burn.start, times)
    position = CubicHermiteSpline(times, states[:, :3], states[:, 3:])
    velocity = position.derivative()
    spacing = departures[1]

    def allowed(departure: Array, size: Array) -> Flags:
        ignition = departure - 0.5 * _burn_time(burn, size, 0.0)
        return np.asarray((ignition >= -spacing) & (ignition <= limits.ignition + spacing))

    def first_orbit(times: Array) -> Array:
        return np.concatenate([position(times), velocity(times)], axis=-1)

    rules = Rules(limits.coast + limits.burning, limits.lowest, allowed)
    found: list[Impulses] = []
    for each in whole:
        found += cheapest(departures, first_orbit, each, rules, fineness=FINE if fine else COARSE)
    return sorted(found, key=lambda each: each.cost)


def revolutions(motion: Motion, time: float) -> float:
    """Of the first orbit, that differ, and at least 1: those about a point mass are all alike, and a hyperbola has one."""
    state = motion.burn.start
    inverse = 2.0 / float(np.linalg.norm(state[:3])) - float(state[3:] @ state[3:])  # 1/a
    if not motion.coast.oblate or inverse <= 0.0:
        return 1.0
    return max(1.0, float(time * inverse**1.5 / (2.0 * np.pi)))


def as_burns(burn: Burn, limits: Limits, impulses: Impulses, nodes: int) -> Transfer:
    """Each impulse as a burn of its velocity, half before and half after its point of time."""
    sizes = np.linalg.norm(impulses.velocities, axis=1)
    first = float(_burn_time(burn, sizes[0], 0.0))
    second = float(_burn_time(burn, sizes[1], first))
    coasts = np.array([
        max(impulses.departure - 0.5 * first, 0.0),
        max(impulses.flight - 0.5 * (first + second), LEAST_COAST),
    ])  # fmt: skip
    made = constant(impulses.velocities, coasts, np.array([first, second]), nodes)
    return limits.clipped(made)


def _burn_time(burn: Burn, delta_v: Array | float, elapsed: float) -> Array:
    """Canonical times in which the engine gives velocities, after burning for `elapsed`."""
    exhaust = burn.acceleration / burn.flow
    left = max(1.0 - burn.flow * elapsed, 0.0)
    return np.asarray(-np.expm1(-np.asarray(delta_v) / exhaust) * left / burn.flow)


def _completed(burn: Burn, target: FreeTarget) -> Iterator[TargetOrbit]:
    """Orbits that have what is given of the target, and of what is free values near the first orbit's."""
    units = CanonicalUnits.of(target.constants)
    start = rotate_state(target.to_eci, units.state_to_si(burn.start))
    now = elements_from_state(start[:3], start[3:], target.constants)
    shapes = list(_shapes(target, now, units.length_m))
    inc = now.inc_rad if target.inc is None else target.inc
    nodes = now.raan_rad + NEW_NODES if target.raan is None else np.array([target.raan])
    argps = now.argp_rad + np.linspace(0.0, 2.0 * np.pi, PERIGEES, endpoint=False)
    if target.argp is not None:
        argps = np.array([target.argp])
    for (sma_m, ecc), raan, argp in product(shapes, nodes, argps):
        if ecc < 1e-6 and argp != argps[0]:
            continue
        orbit = Elements(sma_m, ecc, float(inc), float(raan), float(argp), 0.0, constants=target.constants)
        state = rotate_state(target.to_eci.T, np.concatenate(state_from_elements(orbit)))
        yield TargetOrbit.through(units.state_from_si(state), target.constants)


def _shapes(target: FreeTarget, now: Elements, length_m: float) -> Iterator[tuple[float, float]]:
    """Semi-major axes (m) and eccentricities that have what is given of the shape."""
    perigee, apogee = now.perigee_radius_m, now.apogee_radius_m
    tried: list[tuple[float, float]] = []
    if target.energy is not None:
        sma = -0.5 * length_m / target.energy
        known = target.eccentricity
        tried = [
            (sma, 0.0 if sma > 0.0 else 1.0 - perigee / sma),
            (sma, abs(1.0 - perigee / sma)),
            (sma, now.ecc),
        ]
        tried = [(sma, known)] if known is not None else tried
    elif target.eccentricity is not None:
        ecc = target.eccentricity
        tried = [(perigee / (1.0 - ecc), ecc), (apogee / (1.0 + ecc), ecc)]
    elif target.perigee_radius is not None:
        given = length_m * target.perigee_radius
        tried = [
            (0.5 * (given + other), (other - given) / (other + given)) for other in (given, perigee, apogee)
        ]
    elif target.apogee_radius is not None:
        given = length_m * target.apogee_radius
        tried = [
            (0.5 * (given + other), (given - other) / (other + given)) for other in (given, perigee, apogee)
        ]
    else:
        tried = [(now.sma_m, now.ecc)]
    for sma, ecc in dict.fromkeys(tried):
        if np.isfinite(sma) and ecc >= 0.0 and sma * (1.0 - ecc) > 0.0:
            yield sma, ecc
