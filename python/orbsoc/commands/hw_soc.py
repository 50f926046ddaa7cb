"""`orbsoc hw soc`: the whole computer in one simulation; cycles of both halves counted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import FAILED, exit_handling

if TYPE_CHECKING:
    from orbsoc.soc.counted import Counted
    from orbsoc.soc.table import Comparison

    from .hw_progress import Progress

SCHEMA = "orbsoc.soc/1"


def soc(
    workload: Annotated[
        Path,
        typer.Argument(
            help="SCENARIO.toml (planned now) or PROBLEM.json", metavar="WORKLOAD", show_default=False
        ),
    ],
    partition: Annotated[
        str,
        typer.Option(
            help="what runs on the PL: name, TOML file, or modules joined by +; `none`: the core alone"
        ),
    ] = "resident",
    ratio: Annotated[
        float, typer.Option(min=1.0, help="clocks of the core in one of the engine; fractions allowed")
    ] = 6.0,
    latency: Annotated[int, typer.Option(min=0, max=65535, help="of memory, in clocks of the core")] = 20,
    lanes: Annotated[int, typer.Option(min=1, help="lanes of the engine")] = 4,
    banks: Annotated[int, typer.Option(min=1, help="banks of its storage")] = 16,
    address_bits: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="its storage holds two to this many words; the fewest that hold the problem by default. Workloads share a model",
        ),
    ] = None,
    solves: Annotated[
        str,
        typer.Option(help="which solves of the workload: `first`, `all`, or their numbers from 1, as 1,3"),
    ] = "first",
    fault: Annotated[
        str | None,
        typer.Option(
            help="spoil the partition's runs: KIND[:SKIP[:TIMES]], KIND of registers, memories, interrupt, reset, endless, clock;"
            " after SKIP events of its sort, TIMES of them, 0 for all",
            metavar="KIND",
        ),
    ] = None,
    limit_clocks: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=2**32 - 1,
            help="of the engine, in a launch: the PL stops one that is busy for more; by default the most that the settings can take",
            metavar="N",
            show_default=False,
        ),
    ] = None,
    trace: Annotated[
        bool,
        typer.Option(
            "--trace",
            help="write waveforms (soc.fst) and a timeline (soc-trace.json) of the first solve chosen",
        ),
    ] = False,
    trace_clocks: Annotated[
        str,
        typer.Option(help="of the waveforms: first clock of the core, and how many", metavar="FIRST:COUNT"),
    ] = "0:500000",
    modelled: Annotated[
        bool,
        typer.Option("--modelled", help="what the model of this chip says of the same runs, beside them"),
    ] = False,
    rtl: Annotated[
        Path | None, typer.Option(help="folder of the RTL; that of the source tree by default", metavar="DIR")
    ] = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Run the flight code on a RISC-V core in RTL, beside the engine in RTL, and count the cycles of both.

    The same solves run on the core alone. A finished run is kept, so that an interrupted command goes on where it was.
    Exit codes: 0 all bits are the host's, 1 any is not, 2 bad input, no Verilator, no core's RTL.
    """
    with exit_handling(as_json, interrupted="interrupted; finished runs are kept, call it again to go on"):
        from hw_model import load_partition
        from hw_model.report.perfetto import as_text
        from orbsoc.hw.schedules import Engine
        from orbsoc.hw.workload import solves_of
        from orbsoc.rtl.validation import rtl_folder
        from orbsoc.soc.errors import SocError
        from orbsoc.soc.faults import Fault
        from orbsoc.soc.machine import Waveform, core_sources
        from orbsoc.soc.runs import counted
        from orbsoc.soc.table import Comparison, table
        from orbsoc.soc.timeline import traced

        from .hw_progress import Progress

        folder = rtl_folder(rtl)
        core_sources()
        spoilt = Fault.parsed(fault) if fault is not None else None
        engine = Engine(lanes=lanes, banks=banks, address_bits=address_bits)
        window = _window(trace_clocks)
        on_pl = partition != "none" and load_partition(partition).uses_pl
        if limit_clocks is not None and not on_pl:
            raise SocError(
                f"--limit-clocks = {limit_clocks}: partition {partition!r} has nothing on the PL to stop; leave it out"
            )
        where = out or Path("out") / "hw-soc"
        options.write_all(where, {})  # what cannot be written ends the run here
        progress = Progress()
        progress(f"plan {workload}")
        posed = solves_of(workload)
        try:
            chosen = _chosen(solves, len(posed))
        except ValueError as error:
            raise SocError(str(error)) from None

        def runs(split: str | None) -> tuple[Counted, ...]:
            found = []
            for number in chosen:
                name = f"solve {number} of {len(posed)}, {split or 'core alone'}"
                progress(f"{name}: begins")
                arguments: dict[str, Any] = {
                    "ratio": ratio,
                    "latency": latency,
                    "tell": _told(progress, name),
                    "fault": spoilt if split else None,
                    "limit_clocks": limit_clocks if split else None,
                }
                found.append(counted(posed[number - 1], folder, partition=split, engine=engine, **arguments))
            return tuple(found)

        # the partition first: what its engine cannot hold is told before minutes of simulation
        split = runs(partition) if on_pl else ()
        compared = Comparison(runs(None), split)
        lines = table(compared.alone, f"core alone, {len(chosen)} of {len(posed)} solves")
        if compared.split:
            lines += ["", *table(compared.split, f"partition {partition}, {lanes} lanes")]
        if modelled:
            solved = [posed[number - 1] for number in chosen]
            lines += _modelled(compared, solved, partition, engine, ratio, latency)
        lines += ["", *_verdict(compared, partition, ratio, latency)]
        document = _document(
            compared, workload, partition, chosen,
            engine=asdict(engine), ratio=ratio, latency=latency, fault=str(spoilt) if spoilt else None,
            limit_clocks=limit_clocks,
        )  # fmt: skip
        options.write_all(
            where, {"soc.json": options.as_json_text(document), "soc.txt": "\n".join(lines) + "\n"}
        )
        if trace:
            waveform = Waveform(where / "soc.fst", *window)
            name = f"trace of solve {chosen[0]}, {partition if on_pl else 'core alone'}"
            timeline = traced(
                posed[chosen[0] - 1], folder, partition=partition if on_pl else None, engine=engine,
                ratio=ratio, latency=latency, limit_clocks=limit_clocks, waveform=waveform, tell=_told(progress, name),
            )  # fmt: skip
            options.write_all(where, {"soc-trace.json": as_text(timeline)})
        options.print_report(lines, document, where, as_json=as_json)
        raise typer.Exit(0 if compared.same_bits else FAILED)


def _modelled(
    compared: Comparison, solves: list[Any], partition: str, engine: Any, ratio: float, latency: int
) -> list[str]:
    """Tables of the model beside the chip; a line why there is none."""
    from orbsoc.soc.compare import LATENCY, lines_of, pairs

    if latency != LATENCY:
        return ["", f"Modelled  nothing: the model is of --latency {LATENCY}, not {latency}"]
    lines = [
        "",
        *lines_of(pairs(compared.alone, solves, None, engine, ratio), "core alone, modelled beside counted"),
    ]
    if compared.split:
        rows = pairs(compared.split, solves, partition, engine, ratio)
        lines += ["", *lines_of(rows, f"partition {partition}, modelled beside counted")]
    return lines


def _told(progress: Progress, name: str) -> Callable[[str], None]:
    return lambda line: progress.now_and_then(f"{name}: {line}")


def _chosen(solves: str, count: int) -> list[int]:
    """Numbers of solves. Raises ValueError naming the option, its value and what is allowed."""
    if solves == "first":
        return [1]
    if solves == "all":
        return list(range(1, count + 1))
    numbers = [int(part) if part.strip().isdigit() else 0 for part in solves.split(",")]
    if not all(1 <= number <= count for number in numbers):
        raise ValueError(
            f"--solves = {solves!r}: allowed is first, all, or numbers from 1 to {count}, as 1,3"
        )
    return numbers


def _window(text: str) -> tuple[int, int]:
    """First clock and count. Raises SocError."""
    from orbsoc.soc.errors import SocError

    first, _, count = text.partition(":")
    if not (first.isdigit() and count.isdigit() and int(count) > 0):
        raise SocError(
            f"--trace-clocks = {text!r}: allowed is FIRST:COUNT in clocks of the core, as 0:500000"
        )
    return int(first), int(count)


def _verdict(compared: Comparison, partition: str, ratio: float, latency: int) -> list[str]:
    """What a reader wants first, last on the terminal."""
    bits = "every word is the host's" if compared.same_bits else "OTHER BITS THAN THE HOST'S"
    lines = [f"Bits      {'EQUAL' if compared.same_bits else 'DIFFERENT'}  {bits}"]
    if compared.speedup is not None:
        lines += [
            f"Speedup   {compared.speedup:.2f} x, counted: core alone over {partition}, its program loaded before",
            f"Load      {compared.loaded_cycles} clocks of the core, once a pattern",
        ]
    for place in dict.fromkeys(place for run in compared.split for place in run.places):
        tries = f"first try: {place.events[0]}; second: {place.events[1]}"
        lines.append(f"Ran on    {place.where}; {tries}")
    return [*lines, f"Clocks    an engine's clock is {ratio:g} of the core's; memory answers after {latency}"]


def _document(
    compared: Comparison, workload: Path, partition: str, chosen: list[int], **settings: Any
) -> dict[str, Any]:
    from orbsoc.soc.table import added, summed

    def part(runs: tuple[Counted, ...]) -> dict[str, Any]:
        return {
            "core_cycles": sum(run.core_cycles for run in runs),
            "instructions": sum(run.instructions for run in runs),
            "parts": [asdict(row) for row in summed(runs)],
            "within": [asdict(row) for row in added([part for run in runs for part in run.within])],
            "places": [asdict(place) for run in runs for place in run.places],
        }

    return {
        "schema": SCHEMA,
        "provenance": "counted: Rocket core and engine in one simulation under Verilator",
        "workload": str(workload),
        "partition": partition,
        "solves": chosen,
        **settings,
        "alone": part(compared.alone),
        "split": part(compared.split) if compared.split else None,
        "loaded_cycles": compared.loaded_cycles,
        "speedup": compared.speedup,
        "same_bits": compared.same_bits,
    }
