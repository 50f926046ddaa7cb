"""`orbsoc hw run`: one workload on one engine, scheduled exactly."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from . import hw_options as options
from .failures import BAD_INPUT, exit_handling, exit_with

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.timing.trace import Pattern
    from orbsoc.hw.schedules import Engine, PlProgram


def run(
    workload: Annotated[
        Path,
        typer.Argument(
            help="SCENARIO.toml (planned once) or PROBLEM.json (solved once)",
            metavar="WORKLOAD",
            show_default=False,
        ),
    ],
    device: options.DeviceOption = "zu9eg",
    lanes: Annotated[int | None, typer.Option(help="lanes of the engine; the device's by default")] = None,
    banks: Annotated[int | None, typer.Option(help="banks of storage; the device's by default")] = None,
    fp: Annotated[int, typer.Option(help="word of the datapath: 64 or 32")] = 64,
    settings: options.SetOption = None,
    ordering: options.OrderingOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Schedule every segment of a workload's pattern: cycles, utilisation, what the rest went to, microcode, and whether
    the device has block RAM for it.

    Exit codes: 0 done, 2 bad input.
    """
    with exit_handling(as_json):
        from hw_model.report.usage import SCHEDULE_USAGE, require_used
        from hw_model.timing.schedules import engine_of
        from orbsoc.hw.exact_cycles import shaping
        from orbsoc.hw.schedules import KKT_SOLVES, pl_program
        from orbsoc.hw.utilisation_figure import utilisation_figure

        given = {"pl.lanes": lanes, "pl.banks": banks}
        own = {key: value for key, value in given.items() if value is not None}
        chosen = options.parsed_settings(settings, {key: f"--{key[3:]}" for key in own})
        platform = options.computer(device, chosen | own, interleaves=True)
        copies = platform.pl.interleaved.value
        engine = _engine(platform, fp)
        reading = replace(SCHEDULE_USAGE, datapaths=frozenset({"f64" if engine.fp == 64 else "f32"}))
        require_used(chosen, [(platform, reading)])
        engine_of(platform, "f64")
        record = options.recorded(workload, ordering, platform, "paper")
        if not record.problems:
            exit_with(
                BAD_INPUT, f"{workload}: a trace holds no problem to schedule; name the scenario", as_json
            )
        patterns = [(problem, shaping(record.settings, k)) for k, problem in enumerate(record.problems)]
        programs = [
            pl_program(problem, chosen_settings, engine, copies=copies)
            for problem, chosen_settings in patterns
        ]
        energies = [
            _energies(program, pattern, platform)
            for program, pattern in zip(programs, record.trace.patterns, strict=True)
        ]
        streams = [
            pl_program(problem, chosen_settings, engine, KKT_SOLVES, copies=copies)
            for problem, chosen_settings in patterns
        ]
        folder = out or Path("out") / f"hw-run-{record.name}"
        document = {
            "schema": "orbsoc.hw-run/1",
            "workload": record.origin,
            "device": platform.name,
            "clock_mhz": platform.pl.clock_mhz.value,
            "patterns": [program.document() for program in programs],
            "memory": [asdict(_memory(program, platform)) for program in programs],
            "energy_nj": energies,
            "kkt_solves": [stream.document() for stream in streams],
            "assumptions": options.echoed(platform, reading),
        }
        rows = [
            {"pattern": p} | _row(program, name) | energies[p][name]
            for p, program in enumerate(programs)
            for name in program.segments
        ]
        files = {"run.json": options.as_json_text(document), "run.csv": options.as_csv_text(rows)}
        options.write_all(folder, files)
        shown = [(programs[0], "factorize"), (programs[0], "solve_pair"), (streams[0], KKT_SOLVES.name)]
        utilisation_figure(shown, folder / "utilisation.png")
        lines = [
            line
            for program, stream, energy in zip(programs, streams, energies, strict=True)
            for line in (*_table(program, platform), _energy_line(energy), _of_stream(stream))
        ]
        options.print_report(lines, document, folder, as_json=as_json)


def _energies(program: PlProgram, pattern: Pattern, platform: Platform) -> dict[str, dict[str, float]]:
    """Dynamic energy of one run of each segment in flat microcode, its work on all interleaved problems."""
    from hw_model.energy.joules import segment_nanojoules

    datapath: Literal["f64", "f32"] = "f64" if program.engine.fp == 64 else "f32"
    return {
        name: dict(
            zip(
                ("energy_low_nj", "energy_nj", "energy_high_nj"),
                segment_nanojoules(
                    pattern.stages[name], datapath, segment.flat_bits, platform.energy, program.interleaved
                ),
                strict=True,
            )
        )
        for name, segment in program.segments.items()
    }


def _energy_line(energy: dict[str, dict[str, float]]) -> str:
    """All segments once, and the one that takes most."""
    low, nominal, high = (
        sum(row[key] for row in energy.values()) / 1e3
        for key in ("energy_low_nj", "energy_nj", "energy_high_nj")
    )
    most = max(energy, key=lambda name: energy[name]["energy_nj"])
    return (
        f"modelled dynamic energy of every segment once: {nominal:.1f} µJ ({low:.1f}–{high:.1f}),"
        f" {most} {energy[most]['energy_nj'] / 1e3:.1f} µJ of it"
    )


def _engine(platform: Platform, fp: int) -> Engine:
    from orbsoc.hw.schedules import MODEL_MICROCODE_WORDS, Engine, EngineError

    bits: Literal[64, 32]
    if fp == 64:
        bits = 64
    elif fp == 32:
        bits = 32
    else:
        raise EngineError(f"`fp` = {fp}: allowed is 64 or 32")
    return Engine(
        fp=bits,
        lanes=platform.pl.lanes.value,
        dividers=platform.pl.dividers.value,
        banks=platform.pl.banks.value,
        clusters=platform.pl.clusters.value,
        microcode_words=MODEL_MICROCODE_WORDS,
    )


def _row(program: PlProgram, name: str) -> dict[str, object]:
    """A segment as a row of CSV."""
    segment = program.segments[name]
    return {
        "stage": segment.stage, "module": segment.module, "cycles": segment.cycles,
        "lower_bound": segment.lower_bound, "bottleneck": segment.bottleneck, "operations": segment.operations,
        "utilisation": segment.utilisation, "flat_bits": segment.flat_bits,
        "compressed_bits": segment.compressed_bits, "compressed_cycles": segment.compressed_cycles,
        **{f"cycles_{cause}": cycles for cause, cycles in segment.causes.items()},
    }  # fmt: skip


def _table(program: PlProgram, platform: Platform) -> list[str]:
    """The program in lines: modules, then segments, then what it takes to store."""
    from hw_model.vocabulary import count_of

    engine, segments = program.engine, list(program.segments.values())
    flat = sum(segment.flat_bits for segment in segments)
    cycles = sum(segment.cycles for segment in segments)
    slower = sum(segment.compressed_cycles for segment in segments) / cycles - 1.0
    stored = sum(segment.compressed_bits for segment in segments)
    lines = [
        f"modelled, equal to the RTL cycle for cycle: f{engine.fp}, {count_of(engine.lanes, 'lane')},"
        f" {count_of(engine.dividers, 'divider')}, {count_of(engine.banks, 'bank')}, PL at {platform.pl.clock_mhz.value:g} MHz"
        f" ({platform.pl.clock_mhz.tag}), flat microcode"
        + (
            f", {program.interleaved} problems interleaved in every segment"
            if program.interleaved > 1
            else ""
        ),
        "module          segment            cycles      µs  bound by      of it  used  idle lanes: waiting for",
    ]
    for module in dict.fromkeys(segment.module for segment in segments):
        for segment in (s for s in segments if s.module == module):
            idle = {cause: n for cause, n in segment.lane_causes.items() if cause != "issue" and n}
            most = sorted(idle, key=lambda cause: -idle[cause])[:2]
            shares = [
                f"{cause} {100 * idle[cause] / sum(segment.lane_causes.values()):.0f} %" for cause in most
            ]
            lines.append(
                f"{module:15s} {segment.stage:16s} {segment.cycles:8d} {segment.cycles / platform.pl.clock_mhz.value:7.1f}"
                f"  {segment.bottleneck:10s} {100 * segment.lower_bound / segment.cycles:5.0f} %"
                f" {100 * segment.utilisation:4.0f} %  {', '.join(shares)}"
            )
    lines.append(
        f"storage {program.home_words} words of buffers and literals, 2^{engine.address_bits} with temporaries;"
        f" microcode {flat / 1e6:.2f} Mbit flat, {stored / 1e6:.2f} Mbit compressed ({flat / stored:.1f} times less, and {100 * slower:.1f} % more cycles)"
    )
    return [*lines, _memory(program, platform).line]


@dataclass(frozen=True, slots=True)
class Memory:
    """Block RAMs of a program, in BRAM36, and whether they are within the ceiling. Modelled."""

    available: int
    ceiling: float
    """The share of them that an engine may take."""
    storage: float
    """Three replicas of every word."""
    flat: float
    flat_fits: bool
    """The microcode beside the storage."""
    compressed: float
    compressed_fits: bool

    @property
    def line(self) -> str:
        """What fits, in a line."""
        flat, compressed = (
            f"{name} microcode {bram36:g} {'FITS' if fits else 'DOES NOT FIT'}"
            for name, bram36, fits in (
                ("flat", self.flat, self.flat_fits),
                ("compressed", self.compressed, self.compressed_fits),
            )
        )
        return (
            f"block RAM: storage takes {self.storage:g} BRAM36; beside it {flat}, {compressed}"
            f" ({self.ceiling * self.available:g} of {self.available} may be used)"
        )


def _memory(program: PlProgram, platform: Platform) -> Memory:
    from hw_model.area.engine import Shape, fabric_of, line_bits, storage_bram36

    engine, segments = program.engine, program.segments.values()
    if engine.address_bits is None:
        raise AssertionError("a program's engine has its address bits settled")
    units = (engine.lanes, engine.dividers, engine.banks)
    shape = Shape("f64" if engine.fp == 64 else "f32", *units, engine.address_bits, engine.clusters)
    line = line_bits(shape)
    lines = sum(-(-segment.compressed_bits // line) for segment in segments)
    fabric = fabric_of(platform.area)
    storage = storage_bram36(shape, fabric)
    flat = fabric.bram36(sum(segment.words for segment in segments), shape.microcode_bits)
    compressed = fabric.bram36(lines, line)
    available, ceiling = platform.resources.bram36.value, platform.area.bram36_ceiling.value
    most = ceiling * available
    return Memory(
        available, ceiling, storage, flat, storage + flat <= most, compressed, storage + compressed <= most
    )


def _of_stream(program: PlProgram) -> str:
    """Factorization and two substitutions, had they one segment."""
    (segment,) = program.segments.values()
    return (
        f"factorization and two substitutions as one stream: {segment.cycles} cycles, lanes used"
        f" {100 * segment.utilisation:.1f} %, {segment.operations} operations"
    )
