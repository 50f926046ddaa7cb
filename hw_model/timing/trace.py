"""What a recorded solve hands to the hardware model: the trace schema "orbsoc.trace/2", validated.

A trace holds patterns (sizes, buffers in words, and per stage its operations, critical path, reads and
writes) and solves (which stages ran, in order). No numerical value of the problem is in it. A stage that
updates a buffer in place lists it under both reads and writes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    PrivateAttr,
    StrictStr,
    ValidationError,
    field_validator,
    model_validator,
)

from hw_model.errors import TraceError, describe
from hw_model.vocabulary import MODULES, OPCODES, Datapath, Module, Opcode

SCHEMA = "orbsoc.trace/2"
Count = Annotated[int, Field(ge=0, le=2**53, strict=True)]
"""What JSON carries exactly; so no time of a damaged trace leaves the range of its arithmetic."""


class _Record(BaseModel):
    # A key that this model does not know would be ignored in silence; a later writer changes the schema's number.
    model_config = ConfigDict(frozen=True, extra="forbid")


class Method(_Record):
    """The step lists that the solves ran, as (stage,) or (repeated stage, stage that decides), and the stages that decide.

    `flags`: of each of these, whether its flag asks to "repeat" or to "stop".
    """

    startup: tuple[tuple[StrictStr, ...], ...]
    warm_startup: tuple[tuple[StrictStr, ...], ...]
    iteration: tuple[tuple[StrictStr, ...], ...]
    closing: tuple[tuple[StrictStr, ...], ...]
    flags: dict[StrictStr, Literal["repeat", "stop"]]


class Cones(_Record):
    """R₊ˡ and second-order cones of sizes q."""

    l: Count
    q: tuple[Annotated[int, Field(ge=1, le=2**53, strict=True)], ...]


class Stage(_Record):
    """One stage of a pattern: its module, data flow, operations and longest dependent chain."""

    module: Module
    reads: tuple[StrictStr, ...]
    writes: tuple[StrictStr, ...]
    operations: dict[StrictStr, Count]
    critical_path: dict[StrictStr, Count]

    @field_validator("module", mode="before")
    @classmethod
    def _known_module(cls, module: object) -> object:
        if module not in MODULES:
            raise ValueError(f"{module!r} is no module; allowed: {', '.join(MODULES)}")
        return module

    @field_validator("operations")
    @classmethod
    def _all_counts(cls, operations: dict[str, int]) -> dict[str, int]:
        missing = [code for code in OPCODES if code not in operations]
        unknown = [code for code in operations if code not in OPCODES]
        if missing or unknown:
            raise ValueError(
                f"missing counts: {', '.join(missing) or 'none'}; unknown operations: "
                f"{', '.join(unknown) or 'none'}; required: {', '.join(OPCODES)}"
            )
        return operations

    def count(self, *codes: Opcode) -> int:
        """How many operations of these codes the stage performs."""
        return sum(self.operations[code] for code in codes)


class Pattern(_Record):
    """One sparsity pattern: n variables, p equalities, m cone rows; buffer sizes in words."""

    n: Count
    p: Count
    m: Count
    cones: Cones
    nnz_kkt: Count
    nnz_l: Count
    buffers: dict[StrictStr, Count]
    stages: dict[StrictStr, Stage]
    _streams: dict[str, Stage] = PrivateAttr(default_factory=dict[str, Stage])

    def stage(self, name: str) -> Stage:
        """A stage, or the stages of a stream, as one: what it reads before it writes it, and all that it does."""
        found = self.stages.get(name) or self._streams.get(name)
        if found is None:
            found = self._streams[name] = self._joined(name.split("+"))
        return found

    def _joined(self, names: list[str]) -> Stage:
        stages = [self.stages[name] for name in names]
        reads: dict[str, None] = {}
        written: set[str] = set()
        for stage in stages:
            reads |= dict.fromkeys(buffer for buffer in stage.reads if buffer not in written)
            written |= set(stage.writes)
        presets = stages[0].critical_path
        return Stage.model_construct(
            module="joined" if len({stage.module for stage in stages}) > 1 else stages[0].module,
            reads=tuple(reads),
            writes=tuple(dict.fromkeys(buffer for stage in stages for buffer in stage.writes)),
            operations={code: sum(stage.operations[code] for stage in stages) for code in OPCODES},
            critical_path={name: sum(stage.critical_path[name] for stage in stages) for name in presets},
        )

    @model_validator(mode="after")
    def _consistent(self) -> Pattern:
        rows = self.cones.l + sum(self.cones.q)
        if rows != self.m:
            raise ValueError(f"cones.l + sum(cones.q) = {rows}, but m = {self.m}")
        for name, stage in self.stages.items():
            for way in ("reads", "writes"):
                for buffer in getattr(stage, way):
                    if buffer not in self.buffers:
                        known = ", ".join(sorted(self.buffers)) or "none"
                        raise ValueError(f"stages.{name}.{way} names {buffer!r}; buffers: {known}")
        return self


class Solve(_Record):
    """One solve of a pattern; `events` are (stage, iteration) in execution order."""

    pattern: Count
    status: StrictStr
    iterations: Count
    events: tuple[tuple[StrictStr, Count], ...]
    resident: tuple[StrictStr, ...] | None = None
    """Where the PL controlled the solve, the segments that it ran by itself, in order."""


class Work(_Record):
    """What a core executes around the solves: instructions of aarch64, and among them divisions and roots of doubles."""

    instructions: Count
    divisions: Count
    roots: Count


class OuterLoop(_Record):
    """Before the first solve of a plan, between two, and after the last; `source` says how it was counted."""

    works: tuple[Work, ...]
    source: StrictStr


class Trace(_Record):
    """Everything that ran, in order."""

    schema_: Literal["orbsoc.trace/2"] = Field(alias="schema")
    datapath: Datapath
    """Of the PL and of what crosses the link."""
    ps_datapath: Datapath | None = None
    """Of the PS, where it is another."""
    method: Method | None = None
    """Without it, no streams and no resident control can be priced."""
    patterns: tuple[Pattern, ...]
    solves: tuple[Solve, ...]
    outer_loop: OuterLoop | None = None
    """Without it, each problem's generation is assumed, and nothing else around the solves is priced."""

    @model_validator(mode="after")
    def _events_exist(self) -> Trace:
        if not self.solves:
            raise ValueError("solves is empty: a trace holds at least one")
        if self.outer_loop is not None and len(self.outer_loop.works) != len(self.solves) + 1:
            raise ValueError(
                f"outer_loop.works has {len(self.outer_loop.works)} entries; {len(self.solves)} solves need one more than"
                " there are solves"
            )
        for s, solve in enumerate(self.solves):
            if solve.pattern >= len(self.patterns):
                raise ValueError(
                    f"solves.{s}.pattern = {solve.pattern}: the trace has {len(self.patterns)} pattern(s), from 0"
                )
            stages = self.patterns[solve.pattern].stages
            for e, (stage, _) in enumerate(solve.events):
                if stage not in stages:
                    raise ValueError(
                        f"solves.{s}.events.{e} names stage {stage!r}; stages of pattern "
                        f"{solve.pattern}: {', '.join(stages) or 'none'}"
                    )
        return self


def parse_trace(data: Mapping[str, Any] | Trace) -> Trace:
    """A validated trace from plain data. Raises TraceError naming the field, its value and what is allowed."""
    if isinstance(data, Trace):
        return data
    if not isinstance(data, Mapping):  # pyright: ignore[reportUnnecessaryIsInstance] — data comes from files
        raise TraceError(f"a trace is a mapping with the key `schema`, not {type(data).__name__}")
    if data.get("schema") != SCHEMA:
        raise TraceError(f"`schema` = {data.get('schema')!r}: this model reads {SCHEMA!r} only")
    if data.get("datapath") not in get_args(Datapath):
        raise TraceError(
            f"`datapath` = {data.get('datapath')!r}: allowed are {', '.join(get_args(Datapath))}"
        )
    try:
        return Trace.model_validate(dict(data))
    except ValidationError as error:
        raise TraceError(f"trace: {describe(error, Trace)}") from error


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON, which by itself would let the last of equal keys win."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise TraceError(f"trace: key {key!r} is set twice")
        found[key] = value
    return found


def load_trace(path: str | Path) -> Trace:
    """A validated trace from a JSON file."""
    try:
        data = json.loads(Path(path).read_text(encoding="utf-8"), object_pairs_hook=_each_once)
    except OSError as error:
        raise TraceError(f"trace {path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise TraceError(f"trace {path}: not JSON: {error}") from error
    return parse_trace(data)
