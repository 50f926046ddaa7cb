"""What the operation control runs by itself: streams of stages, and the control program of an attempt.

Both are made from the step lists that a trace carries, which are those of the solver. A stream is a run of stages that is
scheduled, and launched, as one; it ends at the latest where a stage decides. Under resident control a program of a few
instructions runs the streams, reads the flag that each decision leaves, and branches.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Literal, NamedTuple

from hw_model.errors import TraceError

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition

    from .trace import Method, Pattern, Trace

Stream = tuple[str, ...]
"""Stages that run as one, in order."""

Block = tuple[Stream, str, Stream]
"""Stages without a decision among them, how the last decides ("repeat", "stop" or ""), and what is repeated."""

SEPARATOR = "+"
"""Between the stages in the name of a stream."""

OpCode = Literal["run", "if", "unless", "end"]

RUN_CYCLES = 3
"""PL cycles of the operation control beside a segment: fetch, check and start, and the end noticed."""
FLAG_CYCLES = 7
"""PL cycles in which it reads a flag from the storage and branches."""
END_CYCLES, LAUNCH_CYCLES = 2, 1
"""PL cycles of the end of an attempt; and beside a segment that the processing system launches."""


class Instruction(NamedTuple):
    """One instruction: `run` a stream; jump to `target` `if` a stage's flag is not zero, or `unless` it is not; `end`.

    Where the flag is one to stop by, the stop bit of the processing system counts as raised.
    """

    op: OpCode
    stream: Stream = ()
    flag: str = ""
    """The stage that leaves the flag."""
    target: int = 0


@dataclass(frozen=True, slots=True)
class ControlProgram:
    """The instructions of an attempt, with the entry of a cold one and of a warm one."""

    instructions: tuple[Instruction, ...]
    cold: int
    warm: int

    @property
    def streams(self) -> tuple[Stream, ...]:
        """What it runs, each once, in the order of their first place."""
        return tuple(dict.fromkeys(each.stream for each in self.instructions if each.op == "run"))


def partition_streams(method: Method, modules: Mapping[str, str], partition: Partition) -> tuple[Stream, ...]:
    """The segments of a program in which stages share streams, or that has the seventh module; () of all others.

    `modules`: of each stage its module. A program of the six modules stage by stage needs no list. Stage by stage, all
    partitions share the program of six modules or that of seven, and run of it what they have on the PL.
    """
    on_pl = {stage for stage, module in modules.items() if partition.modules[module] == "pl"}  # type: ignore[index]
    if partition.control == "pl":
        return control_program(method, joined=partition.streams == "iteration").streams
    if partition.streams == "stage" or not on_pl:
        return tuple((stage,) for stage in modules) if partition.modules["statistics"] == "pl" else ()
    blocks = _blocks(method, method.iteration, on_pl)
    outside = _stages((*method.startup, *method.warm_startup, *method.closing))
    inside = [body for _, _, body in blocks if body] + [main for main, _, _ in blocks]
    alone = [(stage,) for stage in outside if stage in on_pl]
    return tuple(dict.fromkeys([*alone, *(stream for stream in inside if stream)]))


def streams_of(trace: Trace, partition: Partition) -> tuple[str, ...]:
    """The names of `partition_streams` for the stages of a trace."""
    modules = {name: stage.module for name, stage in trace.patterns[0].stages.items()}
    if not partition.uses_pl or trace.method is None:
        return ()
    return tuple(SEPARATOR.join(stream) for stream in partition_streams(trace.method, modules, partition))


def segments_on_pl(trace: Trace, pattern: Pattern, partition: Partition) -> list[str]:
    """The names of the segments that the PL runs of a pattern."""
    names = streams_of(trace, partition) or pattern.stages
    return [name for name in names if partition.side(pattern.stage(name).module) == "pl"]


def control_program(method: Method, *, joined: bool) -> ControlProgram:
    """The program that runs whole attempts; with `joined`, an iteration's stages share streams.

    What precedes the iteration's first decision is joined to its end, as its next turn.
    """
    code: list[Instruction] = []

    def run(stages: Sequence[str], *, apart: bool) -> None:
        streams = [(stage,) for stage in stages] if apart else [tuple(stages)]
        code.extend(Instruction("run", stream) for stream in streams)

    def decide(kind: str, stage: str, body: Stream = ()) -> list[int]:
        """The branches after a decision; the places of jumps to the closing."""
        if kind == "stop":
            code.append(Instruction("if", flag=stage))
            return [len(code) - 1]
        skip, begin = len(code), len(code) + 1
        code.append(Instruction("unless", flag=stage))
        run(body, apart=not joined)
        code.append(Instruction("if", flag=stage, target=begin))
        code[skip] = Instruction("unless", flag=stage, target=len(code))
        return []

    def straight(blocks: Sequence[Block], *, apart: bool) -> list[int]:
        exits: list[int] = []
        for main, kind, body in blocks:
            run(main, apart=apart)
            if kind:
                exits += decide(kind, main[-1], body)
        return exits

    def finish() -> None:
        straight(_blocks(method, method.closing, None), apart=True)
        code.append(Instruction("end"))

    (head, stops, _), *rest = _blocks(method, method.iteration, None)
    *warm_steps, last = _blocks(method, method.warm_startup, None)
    if stops != "stop" or last[1] != "stop":
        raise TraceError(
            "method: iteration must begin with, and warm_startup end with, a stage whose flag stops"
        )
    exits = straight(_blocks(method, method.startup, None), apart=True)
    turn = len(code)
    run(head, apart=True)
    exits += decide("stop", head[-1])
    loop = len(code)
    exits += straight(rest[:-1], apart=not joined)
    run(rest[-1][0] + head, apart=not joined)
    code.append(Instruction("unless", flag=head[-1], target=loop))
    closing = len(code)
    finish()
    warm = len(code)
    exits += straight(warm_steps, apart=True)
    run(last[0], apart=True)
    code.append(Instruction("unless", flag=last[0][-1], target=turn))
    finish()
    for place in exits:
        code[place] = code[place]._replace(target=closing)
    return ControlProgram(tuple(code), 0, warm)


def split(events: Sequence[str], streams: Iterable[Stream]) -> Iterator[Stream]:
    """Events as runs of streams, the longest that fits first; a stage that no stream begins with runs alone."""
    by_first: dict[str, list[Stream]] = {}
    for stream in sorted(streams, key=len, reverse=True):
        by_first.setdefault(stream[0], []).append(stream)
    at = 0
    while at < len(events):
        fitting = (s for s in by_first.get(events[at], ()) if tuple(events[at : at + len(s)]) == s)
        found = next(fitting, (events[at],))
        yield found
        at += len(found)


def _blocks(method: Method, steps: Sequence[Sequence[str]], on_pl: set[str] | None) -> list[Block]:
    """Steps as blocks. `on_pl`: the stages on the PL, where others end a block, too; None: all."""
    blocks: list[Block] = []
    stages: list[str] = []

    def end(kind: str = "", body: Stream = ()) -> None:
        if stages or body:
            blocks.append((tuple(stages), kind, body))
        stages.clear()

    def here(stage: str) -> bool:
        return on_pl is None or stage in on_pl

    for stage, *until in steps:
        if until:
            if here(until[0]):
                stages.append(until[0])
            body = tuple(each for each in (stage, until[0]) if here(each))
            end("repeat", body)
        elif here(stage):
            stages.append(stage)
            if method.flags.get(stage) == "stop":
                end("stop")
        else:
            end()
    end()
    return blocks


def attempt_stages(method: Method, *, warm: bool) -> list[str]:
    """All stages that an attempt may run, in order."""
    return _stages((*(method.warm_startup if warm else method.startup), *method.iteration, *method.closing))


def _stages(steps: Iterable[Sequence[str]]) -> list[str]:
    return [stage for step in steps for stage in reversed(step)]


@cache
def members(name: str) -> Stream:
    """The stages of a stream by its name."""
    return tuple(name.split(SEPARATOR))


def control_cycles(stream: Stream, method: Method) -> int:
    """PL cycles that the operation control adds to one run of a stream."""
    return RUN_CYCLES + (FLAG_CYCLES if stream[-1] in method.flags else 0)
