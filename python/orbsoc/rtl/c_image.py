"""A program for the RTL as C source: the tables that the driver in rtl/driver loads, and where buffers lie in storage."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace

from hw_model.area.engine import Shape, line_bits
from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.program import ControlProgram
from orbsoc.ps.registers import STREAM_ALIGN, WORD_BITS, WORD_MASK, Module
from orbsoc.ps.segments import Method, Segment

from .digest import program_digest
from .session import control_words
from .validation import Format

_A_LINE = 8
"""Numbers in a line of C."""


def c_source(
    problem: Problem,
    settings: Settings | None = None,
    *,
    engine: Engine | None = None,
    form: Format = "flat",
    resident: bool = True,
    name: str = "image",
    modules: Collection[str] | None = None,
    stream: int = 0,
) -> str:
    """Microcode, templates, literals, segments and control program of a problem's pattern as an `orbsoc_pl_image`.

    Beside `name` there are `name_buffers`, an `orbsoc_pl_buffer` for each buffer in the order of its flag, with an enumerator each,
    and under resident control `name_cold` and `name_warm`. `modules`: those on the PL, where it has not all; the program is
    of their stages alone, and under the PS's control. `stream`: for an engine that streams compressed microcode by that number of ports,
    whose parts of the lines lie one behind the other. Raises EngineError as `pl_program` does.
    """
    control, streams = control_of(modules, resident=resident)
    program = pl_program(problem, settings, engine, None, streams)
    image = _core.program_image(program.core, form, stream=stream)
    method = placed(modules, resident=resident)
    width = _code_width(program.engine, form)
    lines = [list(_pieces(int(line, 16), width)) for line in image.microcode]
    templates = [int(word, 16) for word in image.templates]
    pieces = _parts(lines, stream) if stream else [piece for line in lines for piece in line]
    addresses, literals = image.literals
    order = addresses.argsort()  # the map that they come from has none
    addresses, literals = addresses[order], literals[order]
    instructions = list(control_words(image, method, control)) if control else []
    numbered = sorted(_segments(method, control), key=lambda each: each.number)
    parts = [
        '#include "orbsoc.h"\n',
        "_Alignas(ORBSOC_STREAM_ALIGN) " * bool(stream) + _array("uint32_t", f"{name}_microcode", pieces),
        _array("uint32_t", f"{name}_templates", templates),
        _array("uint32_t", f"{name}_literal_addresses", addresses.tolist()),
        _array("uint64_t", f"{name}_literals", literals.tolist()),
        _rows("orbsoc_pl_segment", f"{name}_segments", (_segment(each, image) for each in numbered)),
        _rows("orbsoc_pl_instruction", f"{name}_instructions", instructions),
        f"const orbsoc_pl_image {name} = {{\n"
        f"  {int(program.engine.fp == 64)}u, {program.engine.address_bits}u, {width}u,\n"
        f"  {name}_microcode, {len(image.microcode)}u, {name}_templates, {len(image.templates)}u,\n"
        f"  {name}_literal_addresses, {name}_literals, {len(literals)}u,\n"
        f"  {name}_segments, {len(numbered)}u, {name}_instructions, {len(instructions)}u,\n"
        f"  {_number(image.identity)}, {_number(program_digest(templates, [] if stream else lines))},\n}};\n",
        *(_attempts(name, method, control) if control else ()),
        *_buffers(name, method, image),
    ]
    return "\n".join(parts)


def control_of(
    modules: Collection[str] | None, *, resident: bool
) -> tuple[ControlProgram | None, tuple[tuple[str, ...], ...]]:
    """The control program of `c_source`, if any, and the segments that it schedules."""
    control = resident_program() if resident and modules is None else None
    return control, control.streams if control else _alone(modules)


def placed(modules: Collection[str] | None, *, resident: bool) -> Method:
    """The method's segments with those of modules that are not on the PL under the PS's number."""
    if modules is None:
        return Method.from_core(_core, resident=resident)
    method = Method.from_core(_core, resident=True)
    here = {name: Module.PS for name, info in _core.stages().items() if info.module not in modules}
    segments = (replace(each, module=here.get(each.stage, each.module)) for each in method.segments)
    return replace(method, segments=tuple(segments))


def _alone(modules: Collection[str] | None) -> tuple[tuple[str, ...], ...]:
    """Each stage of some modules a segment; (): of the six, without a list."""
    if modules is None:
        return ()
    return tuple((name,) for name, info in _core.stages().items() if info.module in modules)


def _code_width(engine: Engine, form: Format) -> int:
    """Bits of a line of microcode. `engine` has its address bits settled."""
    assert engine.address_bits is not None
    units = (engine.lanes, engine.dividers, engine.banks)
    shape = Shape("f64" if engine.fp == 64 else "f32", *units, engine.address_bits, engine.clusters)
    return line_bits(shape) if form == "compressed" else shape.microcode_bits


def _pieces(line: int, width: int) -> Iterator[int]:
    for low in range(0, width, WORD_BITS):
        yield line >> low & WORD_MASK


def _parts(lines: list[list[int]], ports: int) -> list[int]:
    """The words of each port's parts of all lines, from a multiple of STREAM_ALIGN bytes on."""
    words, whole = len(lines[0]) // ports, STREAM_ALIGN // 4
    parts = list[int]()
    for port in range(ports):
        parts += [0] * (-len(parts) % whole)
        parts += [word for line in lines for word in line[port * words : (port + 1) * words]]
    return parts


def _segments(method: Method, control: ControlProgram | None) -> Iterable[Segment]:
    return method.segments if control is None else method.numbered(control).values()


def _segment(segment: Segment, image: _core.ProgramImage) -> tuple[int, ...]:
    start, _ = image.entries.get(segment.stage, (0, 0))
    return int(segment.module), start, segment.reads, segment.writes, segment.stales


def _attempts(name: str, method: Method, control: ControlProgram) -> Iterator[str]:
    """Where attempts begin, what their last stages write, and what they may write at all."""
    by_stage = {segment.stage: segment for segment in method.segments}
    closing = 0
    for step in method.closing:
        closing |= by_stage[step[0]].writes
    for kind, entry in (("cold", control.cold), ("warm", control.warm)):
        _, written = method.attempt(warm=kind == "warm")
        yield f"const orbsoc_pl_attempt {name}_{kind} = {{{entry}u, {_number(closing)}, {_number(written)}}};\n"


def _buffers(name: str, method: Method, image: _core.ProgramImage) -> Iterator[str]:
    names = ", ".join(f"{name}_{buffer}".upper() for buffer in method.buffers)
    yield f"enum {{ {names} }};\n"
    rows = []
    for buffer in method.buffers:
        if buffer not in image.homes:
            rows.append("{0, 0, 0}")
            continue
        indices, addresses = image.homes[buffer]
        yield _array("uint32_t", f"{name}_{buffer}_indices", indices.tolist())
        yield _array("uint32_t", f"{name}_{buffer}_addresses", addresses.tolist())
        rows.append(f"{{{len(indices)}, {name}_{buffer}_indices, {name}_{buffer}_addresses}}")
    yield f"const orbsoc_pl_buffer {name}_buffers[] = {{\n  {f',{chr(10)}  '.join(rows)},\n}};\n"


def _number(value: int) -> str:
    """`value` with the suffix that its size needs in C11."""
    return f"0x{value:x}u" if value <= WORD_MASK else f"0x{value:x}ull"


def _array(kind: str, name: str, values: Iterable[int]) -> str:
    numbers = [_number(value) for value in values] or ["0"]
    lines = [", ".join(numbers[at : at + _A_LINE]) for at in range(0, len(numbers), _A_LINE)]
    return f"static const {kind} {name}[] = {{\n  {f',{chr(10)}  '.join(lines)},\n}};\n"


def _rows(kind: str, name: str, rows: Iterable[tuple[int, ...]]) -> str:
    lines = [f"{{{', '.join(_number(value) for value in row)}}}" for row in rows] or ["{0}"]
    return f"static const {kind} {name}[] = {{\n  {f',{chr(10)}  '.join(lines)},\n}};\n"
