"""Blocks of rows by name: their multipliers, and their shares of an infeasibility certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from .csc import Array
from .outcome import Status

Kind = Literal["equality", "nonnegative", "cone"]
OTHER = "other rows"
LEAST_SHARE = 5e-3
"""Smaller shares are the solver's, not the problem's."""


class HasDuals(Protocol):
    """Anything with multipliers `y` of the equalities and `z` of the rows in K, a `Solution` for one."""

    @property
    def y(self) -> Array: ...
    @property
    def z(self) -> Array: ...


class HasStatus(HasDuals, Protocol):
    """Multipliers, and what they are worth."""

    @property
    def status(self) -> Status: ...


@dataclass(frozen=True, slots=True)
class NamedBlock:
    """`count` rows of one kind from `start` on, counted within the kind; `size` is that of their cones."""

    kind: Kind
    start: int
    count: int
    size: int = 1

    def of(self, equalities: Array, cone_rows: Array, nonnegative: int) -> Array:
        """Its part of a vector over the equalities, or over the rows in K, of which `nonnegative` come first."""
        start = self.start + (nonnegative if self.kind == "cone" else 0)
        found = (equalities if self.kind == "equality" else cone_rows)[start : start + self.count]
        return found.reshape(-1, self.size) if self.kind == "cone" else found

    def total(self, equalities: Array, cone_rows: Array, nonnegative: int) -> float:
        """The sum of its part of such a vector."""
        return float(np.sum(self.of(equalities, cone_rows, nonnegative)))


@dataclass(frozen=True, slots=True, eq=False)
class TwoSidedBlock:
    """`count` rows with a lower and an upper bound: of each part, the rows that it holds, and the sign of their multipliers."""

    count: int
    parts: tuple[tuple[NamedBlock, NDArray[np.intp], float], ...]

    def of(self, equalities: Array, cone_rows: Array, nonnegative: int) -> Array:
        """Multipliers of the rows, (count,): positive where the upper bound holds the row, negative where the lower does."""
        out = np.zeros(self.count)
        for block, rows, sign in self.parts:
            out[rows] += sign * block.of(equalities, cone_rows, nonnegative)
        return out

    def total(self, equalities: Array, cone_rows: Array, nonnegative: int) -> float:
        """The sum of its parts of a vector over the equalities, or over the rows in K."""
        return sum(block.total(equalities, cone_rows, nonnegative) for block, _, _ in self.parts)


def shares(
    blocks: Mapping[str, NamedBlock | TwoSidedBlock], solution: HasDuals, b: Array, h: Array, nonnegative: int
) -> dict[str, float]:
    """Of each block in the certificate (y, z), its Σ|bᵀy| + Σ|hᵀz| relative to that of all rows, largest first.

    A certificate has Aᵀy + Gᵀz = 0, z ∈ K and bᵀy + hᵀz < 0: blocks pull either way, and both take part in the
    conflict. Rows without a name are `OTHER`.
    """
    finite = np.where(np.isfinite(h), h, 0.0)
    pull_y, pull_z = b * solution.y, finite * solution.z
    pulls = {name: block.total(pull_y, pull_z, nonnegative) for name, block in blocks.items()}
    pulls[OTHER] = float(np.sum(pull_y) + np.sum(pull_z)) - sum(pulls.values())
    total = sum(map(abs, pulls.values()))
    if not total > 0.0:
        return {}
    return dict(
        sorted(((name, abs(pull) / total) for name, pull in pulls.items()), key=lambda item: -item[1])
    )


def conflict(found: dict[str, float]) -> str:
    """Shares as a sentence."""
    named = [f"{name} ({100 * share:.0f} %)" for name, share in found.items() if share >= LEAST_SHARE]
    if not named:
        return "the certificate names no rows with a right-hand side: the constraints contradict each other alone"
    together = " and ".join(filter(None, [", ".join(named[:-1]), named[-1]]))
    return f"the constraints cannot be met together: {together} of the conflict"
