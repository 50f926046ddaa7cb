"""The control program of an attempt, as the operation control runs it; who makes the trace's readers makes it, too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol


class Instruction(Protocol):
    """`run` a stream of stages; jump to `target` `if` the flag of a stage is raised, or `unless` it is; `end`."""

    @property
    def op(self) -> Literal["run", "if", "unless", "end"]: ...
    @property
    def stream(self) -> tuple[str, ...]: ...
    @property
    def flag(self) -> str: ...
    @property
    def target(self) -> int: ...


@dataclass(frozen=True, slots=True)
class BusyClocks:
    """Clocks of the PL for which a launch is busy: of each segment, by its stages; and of the operation control beside one that is
    launched, beside one that a control program runs, at a branch, at the end of an attempt."""

    segments: Mapping[tuple[str, ...], int]
    launch: int
    run: int
    branch: int
    end: int


class ControlProgram(Protocol):
    """Instructions, and where a cold and a warm attempt begin."""

    @property
    def instructions(self) -> Sequence[Instruction]: ...
    @property
    def cold(self) -> int: ...
    @property
    def warm(self) -> int: ...


def instruction_clocks(instruction: Instruction, clocks: BusyClocks) -> int:
    """Of one instruction of a control program, with the segment that it runs."""
    if instruction.op == "run":
        return clocks.segments[instruction.stream] + clocks.run
    return clocks.end if instruction.op == "end" else clocks.branch
