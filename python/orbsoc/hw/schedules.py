"""The PL's share of a problem, scheduled exactly: cycles, causes and microcode of every segment on one engine.

Schedules depend on the sparsity pattern and on the engine, never on numbers. The engine and its microcode are described in docs/pl-machine.md; `orbsoc hw validate` runs the same schedules on the RTL.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from numbers import Integral
from threading import Lock
from typing import Any, Literal

from hw_model.errors import HwModelError
from orbsoc import _core
from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings

SCHEMA = "orbsoc.pl-cycles/1"
_KEPT = 8
_LEAST_ADDRESS_BITS, _MOST_ADDRESS_BITS = 10, 20
_MOST = (1 << 32) - 1
"""Largest number of any field of an engine; the scheduler limits each field further."""


MODEL_MICROCODE_WORDS = 1 << 25
"""Microcode memory of engines that are priced: a schedule does not depend on it, and whether a device holds it is the
budget's question."""


class EngineError(HwModelError):
    """An engine that cannot exist, or that is too small for a problem; names the field, its value, what is allowed."""


class EngineTooSmallError(EngineError):
    """The engine's microcode memory does not hold the problem's schedules; says what is needed, and what it holds."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Engine:
    """One PL engine. `address_bits`: words of storage as a power of two; None: the fewest that hold the problem. `rows`: of each
    bank, where they are fewer than addresses reach; None: as many.

    Raises EngineError for a field that is no whole number, or a negative one. The scheduler refuses what else no engine
    can have.
    """

    fp: Literal[64, 32] = 64
    lanes: int = 4
    dividers: int = 1
    banks: int = 16
    clusters: int = 1
    address_bits: int | None = None
    microcode_words: int = 1 << 20
    rows: int | None = None

    def __post_init__(self) -> None:
        for field in fields(self):
            value: object = getattr(self, field.name)
            if value is None and field.name in ("address_bits", "rows"):
                continue
            if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= int(value) <= _MOST:
                raise EngineError(f"`{field.name}` = {value!r}: allowed is a whole number from 0 to {_MOST}")
            object.__setattr__(self, field.name, int(value))


@dataclass(frozen=True, slots=True)
class Segment:
    """One stage on the engine. All in PL cycles unless the name says otherwise.

    `lower_bound` is L0: no schedule is shorter, and `bottleneck` names the resource. `causes` sum to `cycles`,
    `lane_causes` to `cycles` times lanes. `compressed_cycles` is the time with compressed microcode, and
    `compressed_causes` sum to it.
    """

    stage: str
    module: str
    cycles: int
    lower_bound: int
    bottleneck: str
    operations: int
    lane_operations: int
    utilisation: float
    words: int
    flat_bits: int
    compressed_bits: int
    compressed_cycles: int
    causes: dict[str, int]
    compressed_causes: dict[str, int]
    lane_causes: dict[str, int]


@dataclass(frozen=True, slots=True, eq=False)
class PlProgram:
    """All segments of one sparsity pattern on one engine (whose `address_bits` are settled)."""

    engine: Engine
    segments: Mapping[str, Segment]
    home_words: int
    """Words of storage that buffers and literals take; temporaries come on top, up to `storage_words`."""
    storage_words: int
    interleaved: int
    """Problems that every segment works on, each with words of its own."""
    core: _core.HardwareProgram

    def document(self) -> dict[str, Any]:
        """As JSON, schema orbsoc.pl-cycles/1."""
        return {
            "schema": SCHEMA,
            "provenance": "modelled, equal to the RTL cycle for cycle",
            "engine": asdict(self.engine),
            "home_words": self.home_words,
            "storage_words": self.storage_words,
            "interleaved": self.interleaved,
            "segments": {name: asdict(segment) for name, segment in self.segments.items()},
        }


def with_exact_depth(program: PlProgram) -> Engine:
    """A program's engine, with no more rows in a bank than its schedules need: the same schedules fit, from fewer words."""
    rows = -(-program.core.least_storage_words // program.engine.banks)
    return replace(program.engine, rows=rows)


@dataclass(frozen=True, slots=True)
class Stream:
    """Stages that are scheduled as one stream, so that each may begin while those before it still run.

    With `leaves`, only as much of them as makes the words of these buffers. Its segment has the stages' names, joined
    by underscores. Raises EngineError for no stages, no buffers, what is no tuple of names, or a buffer that none of the
    stages writes; names that no stage or buffer has are the scheduler's to refuse.
    """

    stages: tuple[str, ...]
    leaves: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        for field, names in (("stages", self.stages), ("leaves", self.leaves)):
            if (field, names) != ("leaves", None) and not _are_names(names):
                raise EngineError(f"stream `{field}` = {names!r}: allowed is a tuple of one name or more")
        _require_written(self.stages, self.leaves or ())

    @property
    def name(self) -> str:
        """The segment's."""
        return "_".join(self.stages)

    @property
    def module(self) -> str | None:
        """The module of its first stage, whose its segment counts as; None where there is no such stage."""
        first = _core.stages().get(self.stages[0])
        return None if first is None else first.module


def _are_names(names: object) -> bool:
    """A tuple with strings in it, and nothing else."""
    return isinstance(names, tuple) and bool(names) and all(isinstance(name, str) for name in names)


def _require_written(stages: tuple[str, ...], leaves: tuple[str, ...]) -> None:
    known = _core.stages()
    buffers = {name for stage in known.values() for name in (*stage.reads, *stage.writes)}
    written = {name for stage in stages if stage in known for name in known[stage].writes}
    unwritten = [name for name in leaves if name in buffers - written]
    if unwritten and all(stage in known for stage in stages):
        allowed = ", ".join(sorted(written))
        raise EngineError(
            f"stream `leaves` = {leaves!r}: {unwritten[0]!r} is written by none of {', '.join(stages)}; allowed: {allowed}"
        )


KKT_SOLVES = Stream(("factorize", "solve_pair"), ("factor_l", "pivot_inverse", "pair_solution"))
"""Factorization and two substitutions, without the residuals and norms that `solve_pair` leaves beside them."""


Streams = tuple[tuple[str, ...], ...]
"""Of a whole program the stages of each segment, in order; (): the six modules stage by stage."""

_programs: OrderedDict[tuple[bytes, Settings, Engine, Stream | None, Streams, int], PlProgram] = OrderedDict()
_keeping = Lock()


def pl_program(
    problem: Problem,
    settings: Settings | None = None,
    engine: Engine | None = None,
    stream: Stream | None = None,
    streams: Streams = (),
    copies: int = 1,
) -> PlProgram:
    """Schedule every stage of the six PL modules, one stream of some, or a program of streams; cached by pattern and engine.

    `copies`: problems of the pattern that every segment works on at once, their operations interleaved.

    The stages of the module `statistics` are scheduled only where a stream names one; then the storage has its words.

    Raises EngineError if the engine cannot exist or is too small, or a stage or buffer of the stream does not exist.
    """
    settings, engine = settings or Settings(), engine or Engine()
    key = (pattern_digest(problem), settings, engine, stream, streams, copies)
    found = _programs.get(key) or scheduled(problem, settings, engine, stream, streams, copies=copies)
    with _keeping:
        _programs[key] = found
        _programs.move_to_end(key)
        if len(_programs) > _KEPT:
            _programs.popitem(last=False)
    return found


def scheduled(
    problem: Problem,
    settings: Settings,
    engine: Engine,
    stream: Stream | None = None,
    streams: Streams = (),
    *,
    copies: int = 1,
    misread: tuple[str, int] | None = None,
) -> PlProgram:
    """As `pl_program`, made anew; its `core` writes validation cases on this very problem's numbers.

    `misread`: a unit (add, mul, div, sqrt, simple) or div_interval, sqrt_interval, and by how many cycles the scheduler is wrong about it: a mutation of
    the model. It needs `engine.address_bits`.
    """
    bits = engine.address_bits
    if bits is None and engine.rows is not None:
        bits = max(_LEAST_ADDRESS_BITS, (engine.rows * engine.banks - 1).bit_length())
    if bits is not None:
        return _made(problem, settings, engine, stream, streams, bits, copies, misread)
    if misread is not None:
        raise EngineError(
            "`address_bits` = None: a scheduler that misreads its table needs the words of storage"
        )
    for bits in range(_LEAST_ADDRESS_BITS, _MOST_ADDRESS_BITS):
        try:
            return _made(problem, settings, engine, stream, streams, bits, copies)
        except EngineError as error:
            if "`address_bits`" not in str(error):
                raise
    return _made(problem, settings, engine, stream, streams, _MOST_ADDRESS_BITS, copies)


def _made(
    problem: Problem,
    settings: Settings,
    engine: Engine,
    stream: Stream | None,
    streams: Streams,
    address_bits: int,
    copies: int = 1,
    misread: tuple[str, int] | None = None,
) -> PlProgram:
    fields = asdict(engine) | {"address_bits": address_bits}
    parts = [list(stages) for stages in (streams if stream is None else (stream.stages,))]
    leaves = None if stream is None or stream.leaves is None else list(stream.leaves)
    try:
        core = _core.HardwareProgram(
            problem, settings, **fields, streams=parts, leaves=leaves, misread=misread, copies=copies
        )
    except _core.HardwareError as error:
        too_small = "`microcode_words`" in str(error) and "are needed" in str(error)
        raise (EngineTooSmallError if too_small else EngineError)(str(error)) from error
    segments = {name: Segment(name, **described) for name, described in core.segments().items()}
    home, used = core.storage_words
    return PlProgram(Engine(**fields), segments, home, used, copies, core)
