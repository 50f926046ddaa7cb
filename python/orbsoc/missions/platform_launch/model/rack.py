"""A platform with a rack of tubes: where the servers stand, and the mass properties with some of them gone.

Body axes: x to the right, z along the tubes, towards their mouths; positions are from the platform's own centre of mass.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from orbsoc.orbit.array import Array

Slot = tuple[int, int]
"""Column from the left and row from the bottom, from 1."""


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """The platform and the servers that stay, as one rigid body: mass, centre (2,), moment of inertia about it."""

    mass_kg: float
    centre_m: Array
    inertia_kg_m2: float


@dataclass(frozen=True, slots=True)
class Rack:
    """columns × rows tubes. `cm_m` is from a server's bottom to its centre of mass, `gap_m` is below a server."""

    columns: int
    rows: int
    length_m: float
    cm_m: float
    diameter_m: float
    wall_m: float
    gap_m: float
    mass_kg: float
    inertia_kg_m2: float
    server_mass_kg: float
    server_inertia_kg_m2: float
    gone: frozenset[Slot] = frozenset()

    def place(self, slot: Slot) -> Array:
        """Centre of mass (2,) of the server of a slot. The paper, eq. (7)."""
        column, row = slot
        x = (column - 0.5 - self.columns / 2) * (self.diameter_m + 2.0 * self.wall_m)
        z = self.cm_m - self.length_m + (row - self.rows / 2) * (self.length_m + self.gap_m)
        return np.array([x, z])

    def stroke_m(self, slot: Slot) -> float:
        """How far a server slides until its bottom passes the mouth of the tube, m."""
        return (self.rows - slot[1]) * (self.length_m + self.gap_m) + self.length_m

    def servers(self) -> Iterator[Slot]:
        """Those that are there."""
        for column in range(1, self.columns + 1):
            for row in range(1, self.rows + 1):
                if (column, row) not in self.gone:
                    yield column, row

    def ready(self) -> tuple[Slot, ...]:
        """Of each column, the server with no other above it."""
        top = dict(self.servers())  # rows rise within a column: the last one stays
        return tuple(top.items())

    def without(self, slot: Slot) -> Rack:
        """The rack after the launch of a server."""
        return replace(self, gone=self.gone | {slot})

    def assembly(self) -> Assembly:
        """Mass properties of platform and servers. The paper, eqs. (8) to (14)."""
        places = np.array([self.place(slot) for slot in self.servers()]).reshape(-1, 2)
        mass = self.mass_kg + self.server_mass_kg * len(places)
        centre = self.server_mass_kg * places.sum(axis=0) / mass
        inertia = self.inertia_kg_m2 + self.mass_kg * float(centre @ centre)
        inertia += len(places) * self.server_inertia_kg_m2
        inertia += self.server_mass_kg * float(((places - centre) ** 2).sum())
        return Assembly(mass, centre, inertia)
