"""Orbits of many end states, and whether flights confirm plans: predictions, planes and bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from orbsoc.orbit import EARTH
from orbsoc.orbit.array import Array, Flags
from orbsoc.orbit.planes import in_plane_axes, orbit_normal, plane_error

from ..batch import Batch, column
from ..direct.terminal import LargestOrbit
from .propagation import Flights

Limit = Array | float
N = TypeVar("N", float, Array)

RADIUS_M = EARTH.earth_radius_m
"""One canonical length."""


def canonical_radius(height_km: N) -> N:
    """Radius of a height over the equatorial radius, canonical; of a number or an array."""
    return 1.0 + 1e3 * height_km / RADIUS_M


@dataclass(frozen=True, slots=True, eq=False)
class Orbits:
    """Elements (B,) of end states, canonical: semi-major axis (negative on a hyperbola), eccentricity, perigee radius,
    argument of perigee in [0, 2π) counted from the node of the point's plane."""

    sma: Array
    ecc: Array
    perigee: Array
    argp: Array

    @classmethod
    def of(cls, ends: Array, normal: Array) -> Orbits:
        """Orbits through end states (B, 6) that lie in the planes of normals (B, 3) or very near."""
        r, v = ends[:, :3], ends[:, 3:]
        norm = np.sqrt((r * r).sum(axis=1))
        vv, rv = (v * v).sum(axis=1), (r * v).sum(axis=1)
        sma = 1.0 / (2.0 / norm - vv)
        laplace = (vv - 1.0 / norm)[:, None] * r - rv[:, None] * v
        ecc = np.sqrt((laplace * laplace).sum(axis=1))
        square = norm**2 * vv - rv**2
        node, ahead = in_plane_axes(normal)
        argp = np.arctan2((laplace * ahead).sum(axis=1), (laplace * node).sum(axis=1))
        return cls(sma, ecc, square / (1.0 + ecc), np.mod(argp, 2.0 * np.pi))

    def turned_from(self, direction: Array | None, normal: Array) -> Array:
        """|e − |e|d| (B,), by how much the eccentricity vectors are turned away from directions d (B, 3) in the planes of
        normals (B, 3); 0 for None."""
        if direction is None:
            return np.zeros(len(self.sma))
        node, ahead = in_plane_axes(normal)
        wanted = np.arctan2((direction * ahead).sum(axis=1), (direction * node).sum(axis=1))
        return np.asarray(2.0 * self.ecc * np.abs(np.sin(0.5 * (self.argp - wanted))))


@dataclass(slots=True, eq=False)
class Flown(Batch):
    """What B flown plans reached and by how much they miss: everything (B,), canonical lengths, radians.

    `normal` (B, 3) is the unit normal of the plane reached. `sma_error` is relative to the prediction; `perigee_short` and `altitude_short` are how far a bound is missed, 0 where
    it is kept (a perigee to be at its bound counts both ways), `direction_error` by how much the eccentricity vector is turned away from
    the requested direction, |Δe|, 0 where none is. `raw_most` and `raw_least` are the extremes of the programme's
    length between its nodes; the flight normalises it, but a length above 1 betrays a grid that is too coarse.
    """

    sma: Array = column()
    ecc: Array = column()
    perigee: Array = column()
    argp: Array = column()
    normal: Array = column(np.nan, 3)
    lowest: Array = column()
    sma_error: Array = column()
    plane_error: Array = column()
    perigee_short: Array = column()
    altitude_short: Array = column()
    direction_error: Array = column()
    raw_most: Array = column()
    raw_least: Array = column()

    @classmethod
    def compare(
        cls, flights: Flights, predicted_sma: Array, target: LargestOrbit, lowest_allowed: float
    ) -> Flown:
        """Compare flights with their predictions and bounds."""
        orbits = Orbits.of(flights.ends, target.normal)
        short = target.perigee - orbits.perigee
        return cls(
            sma=orbits.sma,
            ecc=orbits.ecc,
            perigee=orbits.perigee,
            argp=orbits.argp,
            normal=orbit_normal(flights.ends),
            lowest=flights.lowest,
            sma_error=np.abs(orbits.sma / predicted_sma - 1.0),
            plane_error=plane_error(flights.ends, target.normal),
            perigee_short=np.abs(short) if target.perigee_at_bound else np.maximum(short, 0.0),
            altitude_short=np.maximum(lowest_allowed - flights.lowest, 0.0),
            direction_error=orbits.turned_from(target.perigee_direction, target.normal),
            raw_most=flights.raw_most,
            raw_least=flights.raw_least,
        )

    def kept(self, *, sma_rel: Limit, plane_rad: Limit, bound: Limit, raw_excess: float) -> Flags:
        """Whether every prediction and bound is kept within tolerances, one for all or (B,); False where a number is missing."""
        flown = (self.sma_error <= sma_rel) & (self.plane_error <= plane_rad)
        flown &= (self.perigee_short <= bound) & (self.altitude_short <= bound)
        flown &= self.direction_error <= plane_rad
        return np.asarray(flown & (self.raw_most <= 1.0 + raw_excess))
