"""What the PS did, in order: register accesses, interrupts, stages, and the buffers it moved."""

from __future__ import annotations

import enum
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple


class Kind(enum.Enum):
    """What a `PsEvent` records; in brackets its `name` and `value`."""

    WRITE = "register write"  # [register, word]
    READ = "register read"  # [register, word]
    INTERRUPT = "interrupt taken"  # [stage, polls waited]
    LAUNCH = "stage launched on the PL"  # [stage, launch counter]
    RUN = "stage run on the PS"  # [stage, launch counter]
    TO_PL = "buffer moved to the PL"  # [buffer, words]
    TO_PS = "buffer moved to the PS"  # [buffer, words]


class PsEvent(NamedTuple):
    """One act of the PS."""

    kind: Kind
    name: str
    value: int


class PsRecord:
    """The acts of the PS in one solve, in order."""

    def __init__(self) -> None:
        self._events: list[PsEvent] = []

    def add(self, kind: Kind, name: str, value: int) -> None:
        """Append one act."""
        self._events.append(PsEvent(kind, name, value))

    def __iter__(self) -> Iterator[PsEvent]:
        return iter(self._events)

    def __len__(self) -> int:
        return len(self._events)

    def after(self, count: int) -> list[PsEvent]:
        """The acts after the first `count`, in order."""
        return self._events[count:]

    def of(self, kind: Kind) -> list[PsEvent]:
        """The acts of one kind, in order."""
        return [event for event in self._events if event.kind is kind]

    def counts(self) -> dict[Kind, int]:
        """How often each kind occurred."""
        found = Counter(event.kind for event in self._events)
        return {kind: found[kind] for kind in Kind}

    def words_moved(self) -> dict[Kind, int]:
        """Words moved to the PL and to the PS."""
        return {kind: sum(event.value for event in self.of(kind)) for kind in (Kind.TO_PL, Kind.TO_PS)}
