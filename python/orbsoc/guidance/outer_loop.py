"""What a mission's program in C does around the solves of a plan: the guess, linearisations, the flight that judges it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple


class Work(NamedTuple):
    """Executed instructions on aarch64, and among them divisions and roots of doubles."""

    instructions: int
    divisions: int
    roots: int


@dataclass(frozen=True, slots=True)
class OuterLoop:
    """Before the first solve of a plan, between two, and after the last: one entry more than there are solves.

    Of a re-plan in flight, whose solves it may count in part, those are the first ones."""

    works: tuple[Work, ...]
    source: str
    """Where the numbers come from: "counted under QEMU, …"."""

    @property
    def solves(self) -> int:
        """How many it is around."""
        return len(self.works) - 1

    def to_dict(self) -> dict[str, Any]:
        """The `outer_loop` of a trace."""
        return {"works": [work._asdict() for work in self.works], "source": self.source}
