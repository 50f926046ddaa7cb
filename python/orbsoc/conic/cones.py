"""The cone of a problem: a nonnegative orthant and second-order cones."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from .errors import ProblemError


@dataclass(frozen=True, slots=True)
class Cones:
    """K = R₊ˡ × Q^q₁ × … × Q^q_k with Q^q = {(t, u): ‖u‖₂ ≤ t}, in the order of the rows of G.

    Raises ProblemError if l < 0 or a cone is smaller than 1.
    """

    l: int = 0
    q: Sequence[int] = ()

    def __post_init__(self) -> None:
        try:
            object.__setattr__(self, "l", operator.index(self.l))
            object.__setattr__(self, "q", tuple(map(operator.index, self.q)))
        except TypeError as error:
            raise ProblemError(f"`cones` must hold integers, not l = {self.l!r}, q = {self.q!r}") from error
        if self.l < 0:
            raise ProblemError(f"`cones.l` is {self.l}; it must be 0 or more")
        if self.q and min(self.q) < 1:
            k = next(k for k, size in enumerate(self.q) if size < 1)
            raise ProblemError(f"`cones.q[{k}]` is {self.q[k]}; a second-order cone has size 1 or more")

    @property
    def m(self) -> int:
        """Rows of G that the cones need."""
        return self.l + sum(self.q)

    def second_order(self) -> Iterator[slice]:
        """The rows of each second-order cone, in order."""
        start = self.l
        for size in self.q:
            yield slice(start, start + size)
            start += size
