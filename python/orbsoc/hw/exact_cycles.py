"""Exact schedules for the hardware model: from `hw.schedules` to `hw_model.timing.schedules` and its unit tracks."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError
from hw_model.timing.control_program import members
from hw_model.timing.schedules import Engine, Schedule, engine_of, scheduled
from hw_model.timing.stage_cycles import Memory, Microcode, StageCycles
from hw_model.timing.unit_schedules import UnitSchedule, UnitSchedules
from orbsoc import _core
from orbsoc.conic.settings import Settings

from .schedules import MODEL_MICROCODE_WORDS, EngineError, Streams, pl_program
from .schedules import Engine as Parameters

if TYPE_CHECKING:
    from hw_model import Platform, Trace
    from orbsoc.conic.problem import Problem

    from .schedules import Segment

    _Shape = tuple[Parameters, int]
    """An engine, and problems that every segment of its program works on."""
    _Made = tuple[Mapping[str, Segment], int] | EngineError
    """Segments of a program and the words of storage that it needs, or why there is none."""
    _Demands = Mapping[str, Callable[[Memory], int]]
    """Of each segment the cycles with its lines from memory."""


def exact_cycles(
    problems: Sequence[Problem],
    expected: Iterable[Engine] = (),
    settings: Sequence[Settings] = (),
    address_bits: int | None = None,
) -> StageCycles:
    """Cycles of the stages of a trace whose patterns are those of `problems`, in its order, solved with these settings.
    `address_bits` of the engines: the fewest that hold a problem by default.

    They equal the RTL's, cycle for cycle, in the microcode's format that the platform names, with as many problems of a
    pattern in each segment as it interleaves. Those of the engines `expected` are made side by side, when the first with the same streams is asked for. Raises `hw_model.HwModelError` for latencies
    that are not the RTL's, for which there is no schedule, and `hw.schedules.EngineError` for an engine that cannot exist.
    """
    awaited = {_shape(engine, address_bits) for engine in expected}
    begun: set[Streams] = set()
    made: dict[tuple[int, _Shape, Streams], _Made] = {}
    demands: dict[tuple[int, _Shape, Streams], _Demands] = {}

    def program_of(pattern: int, shape: _Shape, streams: Streams) -> _Made:
        if (pattern, shape, streams) not in made:
            others = awaited if streams not in begun else ()
            begun.add(streams)
            made.update(_side_by_side(problems, {shape, *others}, settings, streams))
        return made[pattern, shape, streams]

    @cache
    def exact(shape: _Shape, streams: Streams) -> _Shape:
        """With rows for the pattern that needs most: one engine has the schedules of all."""
        parameters, copies = shape
        programs = [program_of(pattern, shape, streams) for pattern in range(len(problems))]
        words = max(program[1] for program in programs if not isinstance(program, EngineError))
        return replace(parameters, rows=-(-words // parameters.banks)), copies

    def source(pattern: int, stage: str, engine: Engine) -> Schedule:
        shape, streams = _shape(engine, address_bits), _streams(engine)
        program = program_of(pattern, shape, streams)
        if engine.exact_depth and not isinstance(program, EngineError):
            shape = exact(shape, streams)
            program = program_of(pattern, shape, streams)
        if isinstance(program, EngineError):
            raise program
        segments, words = program
        if shape[0].rows is not None:
            words = shape[0].rows * shape[0].banks
        found = segments["_".join(members(stage))]
        causes, bits, streamed = found.causes, found.flat_bits, None
        if engine.compressed:
            causes, bits = found.compressed_causes, found.compressed_bits
        if engine.streamed:
            if (pattern, shape, streams) not in demands:
                chosen = shaping(settings, pattern)
                demands[pattern, shape, streams] = _demands(problems[pattern], chosen, shape, streams)
            streamed = demands[pattern, shape, streams][found.stage]
        code = Microcode(found.words, found.flat_bits, bits, streamed)
        return Schedule(causes, found.lower_bound, found.bottleneck, code, words)

    return scheduled(source)


def exact_units(problems: Sequence[Problem], settings: Sequence[Settings] = ()) -> UnitSchedules:
    """What every lane and divider executes in the same segments. Raises as `exact_cycles` does."""
    return _Units(problems, settings)


@dataclass(frozen=True, slots=True)
class _Units:
    problems: Sequence[Problem]
    settings: Sequence[Settings]
    streams: Streams = ()

    def of_program(self, streams: tuple[str, ...]) -> _Units:
        return _Units(self.problems, self.settings, tuple(members(name) for name in streams))

    def __call__(self, trace: Trace, platform: Platform, pattern: int, stage: str) -> UnitSchedule:
        engine, name = engine_of(platform, trace.datapath), "_".join(members(stage))
        chosen = shaping(self.settings, pattern)
        parameters, copies = _shape(engine)
        program = pl_program(self.problems[pattern], chosen, parameters, None, self.streams, copies)
        began, units, operations = program.core.issues(name, "compressed" if engine.compressed else "flat")
        startup = program.segments[name].causes["startup"]
        return UnitSchedule(
            engine.lanes,
            began.astype(int) + startup,
            units,
            operations,
            tuple(program.core.operation_names()),
        )


def _side_by_side(
    problems: Sequence[Problem],
    shapes: Iterable[_Shape],
    settings: Sequence[Settings],
    streams: Streams,
) -> dict[tuple[int, _Shape, Streams], _Made]:
    """The segments of each problem's schedule on each engine, or why there are none, by all cores; Ctrl-C begins no
    further ones."""
    keys = list(product(range(len(problems)), shapes, [streams]))
    pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))
    try:
        programs = pool.map(
            lambda key: _segments(problems[key[0]], shaping(settings, key[0]), key[1], key[2]), keys
        )
        return dict(zip(keys, programs, strict=True))
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def shaping(settings: Sequence[Settings], pattern: int) -> Settings:
    """Of a pattern's settings those that shape its operations; of the others a program is independent."""
    if not settings:
        return Settings()
    return Settings(ordering=settings[pattern].ordering, ruiz_passes=settings[pattern].ruiz_passes)


def _segments(problem: Problem, settings: Settings, shape: _Shape, streams: Streams) -> _Made:
    parameters, copies = shape
    try:
        program = pl_program(problem, settings, parameters, None, streams, copies)
        return program.segments, program.core.least_storage_words
    except EngineError as error:
        return error


def _demands(problem: Problem, settings: Settings, shape: _Shape, streams: Streams) -> _Demands:
    """Of the program that was scheduled last, which is kept."""
    parameters, copies = shape
    program = pl_program(problem, settings, parameters, None, streams, copies)
    return {name: _streamed(program.core.demand(name)) for name in program.segments}


def _streamed(demand: _core.SegmentDemand) -> Callable[[Memory], int]:
    """Its cycles, made once for each memory. Raises HwModelError for ports that its lines cannot be divided among."""

    @cache
    def cycles(memory: Memory) -> int:
        try:
            return demand.cycles(**memory._asdict())
        except _core.HardwareError as error:
            raise HwModelError(
                f"`pl.stream_ports` = {memory.ports} of {memory.beat_bits} bits: {error}"
            ) from error

    return cycles


def _streams(engine: Engine) -> Streams:
    return tuple(members(name) for name in engine.streams)


def _shape(engine: Engine, address_bits: int | None = None) -> _Shape:
    parameters = Parameters(
        fp=64 if engine.datapath == "f64" else 32,
        lanes=engine.lanes,
        dividers=engine.dividers,
        banks=engine.banks,
        clusters=engine.clusters,
        address_bits=address_bits,
        microcode_words=MODEL_MICROCODE_WORDS,
    )
    return parameters, engine.interleaved
