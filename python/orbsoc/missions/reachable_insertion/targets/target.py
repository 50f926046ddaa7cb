"""What every target orbit answers to: rows that an end state has to meet, their derivatives, and distances; canonical units."""

from __future__ import annotations

from typing import Protocol

from orbsoc.orbit import Elements
from orbsoc.orbit.array import Array

from .rows import Row


class Target(Protocol):
    """A target in the axes of plans: given whole, with elements left free, or as large as it gets."""

    @property
    def rows(self) -> tuple[Row, ...]:
        """The name of each condition, in their order."""
        ...

    @property
    def energy(self) -> float | None:
        """v²/2 − 1/r; None where it is free."""
        ...

    def conditions(self, ends: Array) -> Array:
        """The rows at end states (B, 6) → (B, K): 0 on the orbit."""
        ...

    def linear_rows(self, end: Array) -> tuple[Array, Array]:
        """Block (K, 6) and right-hand side (K,) of the rows to first order about an end state (6,)."""
        ...

    def misses(self, end: Array) -> tuple[tuple[Row, float], ...]:
        """Each row at an end state (6,), as the sequence's slack has it."""
        ...

    def words(self, row: Row, value: float, end: Array, scales: tuple[float, float]) -> str:
        """What a row that is violated by `value` at an end state (6,) means, of S_H and S_L times the target's vectors."""
        ...

    def there(self, states: Array) -> tuple[Array, Array]:
        """Positions and velocities (K, 3) on the orbit, or nearest to it, where it passes states (K, 6)."""
        ...

    def impulse(self, state: Array) -> Array:
        """The change of velocity (3,) that leads onto the orbit at a state (6,), or comes closest."""
        ...

    def promised(self, end: Array, scales: tuple[float, float] = (1.0, 1.0)) -> tuple[Array, Array]:
        """H and L (3,) that a flight to a planned end state (6,) is held against."""
        ...

    def plane_error(self, momentum: Array) -> float:
        """Angle (rad) of an angular momentum (3,) from what is given of the plane."""
        ...

    def momentum_gap(self, momentum: Array) -> float:
        """The least |ΔH| from an angular momentum (3,) to one that the target allows."""
        ...

    def errors(self, orbit: Elements) -> list[tuple[str, float, str]]:
        """What an orbit, ECI, misses beside H and L, each with the name of its limit in `[verification]`."""
        ...
