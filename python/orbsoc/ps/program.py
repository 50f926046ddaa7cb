"""The control program of an attempt, as the operation control runs it; who makes the trace's readers makes it, too."""

from __future__ import annotations

from collections.abc import Sequence
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


class ControlProgram(Protocol):
    """Instructions, and where a cold and a warm attempt begin."""

    @property
    def instructions(self) -> Sequence[Instruction]: ...
    @property
    def cold(self) -> int: ...
    @property
    def warm(self) -> int: ...
