"""What solves of one pattern cost, from the stages that they ran: for very many solves that differ in a few stages only.

The sum is that of `timeline.makespan_picoseconds` over `actions.actions_of`, where one thing happens at a time and the PS starts each
segment. What a stage costs then depends on where the buffers are when it begins; these states come again, and are kept with the
cost of every step from one to the next.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from .actions import REPEATED, REWRITTEN, START_UP, Kind, Work, actions_of, before, ending, marked, running
from .control_program import SEPARATOR, members, split, streams_of
from .durations import Durations
from .link import Residency
from .timeline import makespan_picoseconds, tally_of

Events = Sequence[tuple[str, int]]
"""Stages and their iterations, in order, as a solve of a trace has them."""


class Cost(NamedTuple):
    """Of a solve: picoseconds, and cycles in which the PL computes."""

    picoseconds: int
    pl_cycles: int


class _State(NamedTuple):
    """Between two stages: where the buffers are, what the last stage wrote, and what is to come for the first time."""

    residency: Residency
    outputs: tuple[str, ...]
    left: frozenset[Kind]


@dataclass(slots=True, eq=False)
class SolveCosts:
    """Costs of solves of the first pattern of the trace that the durations are of. Of an outer loop in the trace what comes before its
    first solve is in each of them; what comes after the last must be nothing."""

    durations: Durations
    _steps: dict[tuple[int, tuple[str, ...]], tuple[int, int, int]] = field(default_factory=dict)
    _begin: tuple[int, int, int] | None = None
    _streams: list[tuple[str, ...]] = field(default_factory=list)
    _ends: dict[int, Cost] = field(default_factory=dict)
    _states: list[_State] = field(default_factory=list)
    _numbers: dict[tuple[object, ...], int] = field(default_factory=dict)

    def of(self, events: Events) -> Cost:
        """The cost of a solve that ran these stages."""
        if not self.is_additive:
            return self.whole(events)
        if self._begin is None:
            self._begin = self._first()
            self._streams = [
                members(name) for name in streams_of(self.durations.trace, self.durations.partition)
            ]
        state, picoseconds, cycles = self._begin
        streams = self._streams
        names = [name for name, _ in events]
        groups: Iterable[tuple[str, ...]] = split(names, streams) if streams else ((name,) for name in names)
        begun = False
        for stages in groups:
            key = (-1 - state if begun and stages[0] == START_UP else state, stages)
            step = self._steps.get(key)
            if step is None:
                step = self._steps[key] = self._step(state, stages, again=key[0] < 0)
            state, picoseconds, cycles = step[0], picoseconds + step[1], cycles + step[2]
            begun = True
        end = self._ends.get(state)
        if end is None:
            found = self._states[state]
            works = ending(self.durations.partition, 0, found.residency.copy(), found.outputs)
            end = self._ends[state] = self._cost(works, set(found.left))
        return Cost(picoseconds + end.picoseconds, cycles + end.pl_cycles)

    @property
    def is_additive(self) -> bool:
        """Whether one thing happens at a time, and the PS starts each segment."""
        schedule = self.durations.platform.runtime.schedule.value
        return schedule == "serial" and self.durations.partition.control == "ps"

    def whole(self, events: Events) -> Cost:
        """The same from all actions of the solve, one by one."""
        trace, partition = self.durations.trace, self.durations.partition
        solve = trace.solves[0].model_copy(update={"pattern": 0, "events": tuple(events)})
        actions = actions_of(trace.model_copy(update={"solves": (solve,)}), partition)
        tally = tally_of(actions)
        cycles = sum(count * self._pl_cycles(work) for work, count in tally.items())
        return Cost(makespan_picoseconds(actions, self.durations, tally=tally), cycles)

    def _first(self) -> tuple[int, int, int]:
        """The state in which a solve begins, and the cost until then."""
        pattern, partition = self.durations.trace.patterns[0], self.durations.partition
        residency = Residency(name for name, words in pattern.buffers.items() if words)
        works = [before(self.durations.trace, 0)] + partition.uses_pl * [Work("publish", "ps", 0, "")]
        left = set(REPEATED)
        cost = self._cost(works, left)
        return self._number(_State(residency, (), frozenset(left))), cost.picoseconds, cost.pl_cycles

    def _step(self, number: int, stages: tuple[str, ...], *, again: bool) -> tuple[int, int, int]:
        """One run of a stage or stream; `again`: it begins another attempt."""
        partition, state = self.durations.partition, self._states[number]
        residency, works, left = state.residency.copy(), list[Work](), set(state.left)
        if again:
            works += ending(partition, 0, residency, state.outputs)
            residency.written(REWRITTEN, "ps")
            left = set(REPEATED)
        name = SEPARATOR.join(stages)
        stage = self.durations.trace.patterns[0].stage(name)
        side = partition.side(stage.module)
        works += [Work("copy", side, 0, buffer) for buffer in residency.missing(stage.reads, side)]
        works += running(side, 0, name, announced=partition.uses_pl)
        residency.written(stage.writes, side)
        cost = self._cost(works, left)
        after = _State(residency, stage.writes, frozenset(left))
        return self._number(after), cost.picoseconds, cost.pl_cycles

    def _number(self, state: _State) -> int:
        key = (state.residency.holders, state.outputs, state.left)
        if key not in self._numbers:
            self._numbers[key] = len(self._states)
            self._states.append(state)
        return self._numbers[key]

    def _cost(self, works: Iterable[Work], left: set[Kind]) -> Cost:
        picoseconds = cycles = 0
        for work in (marked(work, left) for work in works):
            picoseconds += self.durations.picoseconds(work)
            cycles += self._pl_cycles(work)
        return Cost(picoseconds, cycles)

    def _pl_cycles(self, work: Work) -> int:
        if work.side != "pl" or work.kind not in ("compute", "control"):
            return 0
        return sum(part.cycles for part in self.durations.parts(work))
