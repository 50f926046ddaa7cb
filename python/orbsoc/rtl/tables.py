"""What docs/pl-schedules.md prints of mission 004's subproblems: cycles, utilisation and microcode, modelled.

Schedules are the RTL's cycle for cycle; that they are is the matter of `orbsoc hw validate` without options.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import KKT_SOLVES, Engine, Segment, Stream, pl_program

SCHEMA = "orbsoc.pl-tables/1"
WITH_RESIDUALS = Stream(KKT_SOLVES.stages)
"""The same stages with all that they leave: residuals and norms, too."""
SHAPES = ((1, 1), (2, 1), (4, 1), (8, 1), (4, 2), (8, 2))
"""Lanes and dividers of the table of streams."""
LANES = (1, 2, 4, 8)


@dataclass(frozen=True, slots=True)
class Saving:
    """Flat microcode of the fastest schedules against compressed microcode, of some segments.

    Bits are counted once a segment, cycles as often as it runs.
    """

    flat_bits: int
    compressed_bits: int
    flat_cycles: int
    compressed_cycles: int

    @property
    def smaller(self) -> float:
        """How many times."""
        return self.flat_bits / self.compressed_bits

    @property
    def longer(self) -> float:
        """As a share."""
        return self.compressed_cycles / self.flat_cycles - 1


def saving(segments: Iterable[Segment], runs: Mapping[str, int] | None = None) -> Saving:
    """Of segments that run as often as `runs` says of their stages; without it, once each."""
    chosen = [(segment, 1 if runs is None else runs.get(segment.stage, 0)) for segment in segments]
    return Saving(
        sum(segment.flat_bits for segment, _ in chosen),
        sum(segment.compressed_bits for segment, _ in chosen),
        sum(times * segment.cycles for segment, times in chosen),
        sum(times * segment.compressed_cycles for segment, times in chosen),
    )


def stage_runs(problem: Problem, settings: Settings) -> Counter[str]:
    """How often every stage runs in a cold solve."""
    engine = _core.ExactEngine(problem, settings, 64)
    engine.solve()
    return Counter(stage for stage, _ in engine.events())


@dataclass(frozen=True, slots=True)
class StreamRow:
    """Factorization and two solves as one stream, on one shape of the engine; without and with residuals."""

    lanes: int
    dividers: int
    cycles: int
    utilisation: float
    cycles_with_residuals: int
    utilisation_with_residuals: float


def stream_rows(problem: Problem) -> list[StreamRow]:
    """Over `SHAPES`, on 16 banks."""
    rows: list[StreamRow] = []
    for lanes, dividers in SHAPES:
        engine = Engine(lanes=lanes, dividers=dividers)
        alone, whole = (_stream(problem, engine, stream) for stream in (KKT_SOLVES, WITH_RESIDUALS))
        rows.append(
            StreamRow(lanes, dividers, alone.cycles, alone.utilisation, whole.cycles, whole.utilisation)
        )
    return rows


def module_savings(problem: Problem, engine: Engine) -> dict[str, Saving]:
    """Of every module, its segments together, and of all of them under "all"."""
    segments = list(pl_program(problem, engine=engine).segments.values())
    modules = dict.fromkeys(segment.module for segment in segments)
    found = {module: saving(s for s in segments if s.module == module) for module in modules}
    return found | {"all": saving(segments)}


def problem_savings(problem: Problem, lanes: int) -> dict[str, Saving]:
    """On an engine of some lanes: the stream without and with residuals, the program, and a whole solve's cycles."""
    engine, settings = Engine(lanes=lanes), Settings()
    segments = pl_program(problem, settings, engine).segments.values()
    return {
        "L, D and two solutions": saving([_stream(problem, engine, KKT_SOLVES)]),
        "with residuals": saving([_stream(problem, engine, WITH_RESIDUALS)]),
        "program": saving(segments),
        "whole solve": saving(segments, stage_runs(problem, settings)),
    }


def _stream(problem: Problem, engine: Engine, stream: Stream) -> Segment:
    (segment,) = pl_program(problem, engine=engine, stream=stream).segments.values()
    return segment


def tables(problems: Mapping[str, Problem]) -> tuple[dict[str, Any], list[str]]:
    """As JSON and as Markdown: streams of every problem, modules on 4 lanes, savings on every lane count."""
    document: dict[str, Any] = {"schema": SCHEMA, "provenance": "modelled, equal to the RTL cycle for cycle"}
    lines: list[str] = []
    for name, problem in problems.items():
        streams = stream_rows(problem)
        modules = module_savings(problem, Engine(lanes=4))
        savings = {lanes: problem_savings(problem, lanes) for lanes in LANES}
        document[name] = {
            "streams": [asdict(row) for row in streams],
            "modules_on_4_lanes": {module: asdict(found) for module, found in modules.items()},
            "savings_by_lanes": {
                lanes: {what: asdict(found) for what, found in row.items()} for lanes, row in savings.items()
            },
        }
        lines += [f"## {name}", "", *_streams(streams), "", *_modules(modules), "", *_savings(savings), ""]
    return document, lines[:-1]


def _streams(rows: Sequence[StreamRow]) -> list[str]:
    return [
        "| lanes | dividers | L, D and two solutions: cycles | lanes busy | with residuals: cycles | lanes busy |",
        "|---|---|---|---|---|---|",
        *(
            f"| {row.lanes} | {row.dividers} | {_thousands(row.cycles)} | {row.utilisation:.1%} |"
            f" {_thousands(row.cycles_with_residuals)} | {row.utilisation_with_residuals:.1%} |".replace(
                "%", " %"
            )
            for row in rows
        ),
    ]


def _modules(modules: Mapping[str, Saving]) -> list[str]:
    return [
        "| module, 4 lanes | flat, Mbit | compressed | times smaller | cycles more |",
        "|---|---|---|---|---|",
        *(
            f"| {module.replace('_', ' ')} | {found.flat_bits / 1e6:.2f} | {found.compressed_bits / 1e6:.2f} |"
            f" {found.smaller:.1f} | {100 * found.longer:.1f} % |"
            for module, found in modules.items()
        ),
    ]


def _savings(savings: Mapping[int, Mapping[str, Saving]]) -> list[str]:
    """Of a whole solve only the cycles: its bits are the program's."""
    (first, *_) = savings.values()
    return [
        f"| lanes | {' | '.join(first)} |",
        f"|---|{'---|' * len(first)}",
        *(
            f"| {lanes} | "
            + " | ".join(
                f"{100 * found.longer:.1f} %"
                if what == "whole solve"
                else f"{found.smaller:.1f} times, {100 * found.longer:.1f} %"
                for what, found in row.items()
            )
            + " |"
            for lanes, row in savings.items()
        ),
    ]


def _thousands(count: int) -> str:
    return f"{count:,}".replace(",", " ")
