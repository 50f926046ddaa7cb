"""Precedence constraints: what must end before an action may begin, and on which resource it runs.

Serial: each action waits for the one before it, as in the paper's protocol. Overlapped: an action waits for the data
it needs, for readers of what it overwrites, for the last decision of the PS, and for its turn on its resource, where
program order rules. No choice is made at run time, so every end is a maximum of sums of durations: a longer duration
never makes a run shorter, and the worst case is the run in which every jitter is at its bound.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import TYPE_CHECKING, Literal, TypeVar

from hw_model.vocabulary import Side

from .actions import OUTER, PROBLEM, RESULT

if TYPE_CHECKING:
    from .actions import Action, Work
    from .trace import Stage, Trace

Time = TypeVar("Time")
Resource = Literal["core", "control", "pl", "dma"]
"""`core`: the cores that compute; `control`: the core that runs the protocol (the same, when serial)."""


@dataclass(frozen=True, slots=True)
class Precedence:
    """For each action its resource and the actions that it waits for, all of them earlier in the list."""

    resources: tuple[Resource, ...]
    before: tuple[tuple[int, ...], ...]

    def ends(self, durations: Sequence[Time], later: Callable[[Time, Time], Time]) -> list[Time]:
        """End of each action. A duration is an integer, or an array of those of many runs; `later` is their maximum."""
        ends: list[Time] = []
        for before, duration in zip(self.before, durations, strict=True):
            if before:
                start = reduce(later, (ends[k] for k in before))
                ends.append(start + duration)  # type: ignore[operator]
            else:
                ends.append(duration)
        return ends

    def critical(self, ends: Sequence[int]) -> list[int]:
        """Actions of one longest path, in order; each starts when the one before it ends, so they tile the run."""
        if not ends:
            return []
        path = [max(range(len(ends)), key=lambda k: ends[k])]
        while self.before[path[-1]]:
            path.append(max(self.before[path[-1]], key=lambda k: ends[k]))
        return path[::-1]


def serial(actions: Sequence[Action]) -> Precedence:
    """One thing at a time."""
    resources = tuple(_place(action.work, lambda _: True) for action in actions)
    return Precedence(resources, tuple((k - 1,) if k else () for k in range(len(actions))))


def overlapped(actions: Sequence[Action], trace: Trace, by_dma: Callable[[Work], bool]) -> Precedence:
    """PS, PL and DMA side by side; `by_dma` says of a copy whether the DMA engine or the controlling core does it."""
    resources = tuple(_place(action.work, by_dma) for action in actions)
    progress = _Progress()
    before: list[tuple[int, ...]] = []
    for k, action in enumerate(actions):
        pattern = trace.patterns[trace.solves[action.solve].pattern]
        stage = None if action.stage in (PROBLEM, RESULT, OUTER) else pattern.stage(action.stage)
        waits = progress.waits(action, stage) | progress.turn(resources[k])
        progress.done(k, action, stage, resources[k])
        before.append(tuple(sorted(waits)))
    return Precedence(resources, tuple(before))


def _place(work: Work, by_dma: Callable[[Work], bool]) -> Resource:
    match work.kind:
        case "compute" | "control" if work.side == "pl":
            return "pl"
        case "compute" | "build" | "outer":
            return "core"
        case "copy" if by_dma(work):
            return "dma"
        case _:
            return "control"


class _Progress:
    """What has happened to each side's copy of each buffer, and the last action on each resource."""

    def __init__(self) -> None:
        self._last: dict[Resource, int] = {}
        self._made: dict[tuple[Side, str], int] = {}
        """The action after which a side holds its version of a buffer."""
        self._readers: defaultdict[tuple[Side, str], set[int]] = defaultdict(set)
        """Actions that have read a side's version since it was made."""
        self._gate: set[int] = set()
        """The last decision of the PS: what comes next is not known before."""
        self._event: list[int] = []
        """Actions so far of the event under way."""
        self._position = (0, -2)

    def turn(self, resource: Resource) -> set[int]:
        """The action before on the same resource."""
        return {self._last[resource]} if resource in self._last else set()

    def waits(self, action: Action, stage: Stage | None) -> set[int]:
        """What `action` waits for, its resource apart."""
        if (action.solve, action.event) != self._position:
            self._event, self._position = [], (action.solve, action.event)
        kind, side, buffer = action.work.kind, action.work.side, action.work.what
        if kind in ("build", "outer", "rest"):  # a solve begins, or ends, when all before it has ended
            return set(self._last.values())
        if kind == "copy":
            other: Side = "ps" if side == "pl" else "pl"
            return self._gate | self._version(other, buffer) | self._unused(side, buffer)
        if kind == "compute" and stage is not None:
            waits = self._gate | set(self._event)
            for name in stage.reads:
                waits |= self._version(side, name)
            for name in stage.writes:
                waits |= self._unused(side, name)
            return waits
        return self._gate | set(self._event)

    def done(self, k: int, action: Action, stage: Stage | None, resource: Resource) -> None:
        """Record action `k`."""
        self._last[resource] = k
        self._event.append(k)
        kind, side, buffer = action.work.kind, action.work.side, action.work.what
        if kind in ("build", "outer", "rest"):
            self._gate = {k}
        elif kind == "copy":
            other: Side = "ps" if side == "pl" else "pl"
            self._readers[other, buffer].add(k)
            self._make(k, side, [buffer])
        elif kind == "compute" and stage is not None:
            for name in stage.reads:
                self._readers[side, name].add(k)
            if side == "ps":
                self._make(k, side, stage.writes)
                self._gate = {k}
        elif (
            kind == "flags" and stage is not None
        ):  # from now on the PS knows that the PL's results are valid
            self._make(k, "pl", stage.writes)

    def _make(self, k: int, side: Side, buffers: Iterable[str]) -> None:
        for name in buffers:
            self._made[side, name] = k
            self._readers[side, name] = set()

    def _version(self, side: Side, buffer: str) -> set[int]:
        return {self._made[side, buffer]} if (side, buffer) in self._made else set()

    def _unused(self, side: Side, buffer: str) -> set[int]:
        """Actions that make or read a side's old version."""
        return self._version(side, buffer) | self._readers[side, buffer]
