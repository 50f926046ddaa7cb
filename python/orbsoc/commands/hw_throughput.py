"""`orbsoc hw throughput`: how many problems of a pattern the chip solves a second, with sets of engines and without."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import hw_options as options
from .failures import FAILED, exit_handling
from .hw_progress import Progress

if TYPE_CHECKING:
    from hw_model.report.bands import Band
    from hw_model.report.throughput_study import EngineSet

DEFAULT_SHAPES = "2x1x16x1,4x1x16x1,8x2x32x1,16x4x32x8"
OPTIONS = {
    "pl.lanes": "--shapes", "pl.dividers": "--shapes", "pl.banks": "--shapes", "pl.clusters": "--shapes",
    "pl.interleaved": "--copies",
}  # fmt: skip


def throughput(
    workload: options.WorkloadArgument,
    device: options.DeviceOption = "zu9eg",
    partition: Annotated[
        str, typer.Option(help="what runs on the PL; several problems in one engine need resident control")
    ] = "resident",
    shapes: Annotated[
        str, typer.Option(help="engines to try, each LANESxDIVIDERSxBANKSxCLUSTERS")
    ] = DEFAULT_SHAPES,
    copies: Annotated[str, typer.Option(help="problems interleaved in each engine")] = "1,2,4,8,16",
    engines: Annotated[str, typer.Option(help="engines side by side")] = "1,2,3,4",
    pattern: Annotated[
        str | None,
        typer.Option(
            help="the solves of one pattern alone: its number, or most: the one that is solved most often",
            show_default="all",
        ),
    ] = None,
    settings: options.SetOption = None,
    exact: options.ExactOption = None,
    ordering: options.OrderingOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Solves a second of sets of engines against all cores of the PS, a problem each.

    The solves of the workload count as independent problems. Exit codes: 0 a set fits, 1 none does, 2 bad input.
    """
    with exit_handling(as_json):
        from hw_model import HwModelError
        from hw_model.figures.throughput import throughput_figure
        from hw_model.platform.partition import load_partition
        from hw_model.report.throughput_study import EngineSet, Question, best_of
        from hw_model.report.usage import THROUGHPUT_USAGE, require_used
        from hw_model.timing.ps import price_words

        chosen = options.parsed_settings(settings, OPTIONS)
        platform = options.computer(device, chosen)
        grid = (
            options.listed(shapes, "--shapes", _shape),
            _counts(copies, "--copies"),
            _counts(engines, "--engines"),
        )
        split = load_partition(partition)
        if not split.uses_pl:
            raise HwModelError(f"--partition {partition!r}: has nothing on the PL; allowed is one that has")
        record = options.recorded(workload, ordering, platform, partition, exact=exact)
        if pattern is not None:
            record = record.of_pattern(pattern)
        cycles = options.stage_cycles(record, exact=exact)
        reading = THROUGHPUT_USAGE.of(record.trace, split, platform, cycles)
        widest = platform.with_value("pl.interleaved", max(grid[1]))
        require_used(chosen, [(widest, reading)])
        question = Question(record.trace, platform, split, load_partition("all_ps"), cycles)
        tell, sets = Progress(), list[EngineSet]()
        size = len(grid[0]) * len(grid[1]) * len(grid[2])
        tell(f"{size} sets of engines for {record.origin}")
        for each in question.sets(*grid):
            sets.append(each)
            tell.now_and_then(f"{len(sets)} of {size} sets of engines")
        best = best_of(sets)
        gains = (
            [] if best is None else [(price_words(priced.ps), band) for priced, band in question.gains(best)]
        )
        title = f"{split.name} on {platform.name}, {platform.pl.clock_mhz.value:g} MHz"
        verdict = f"modelled: {title}: {_verdict(best, gains)}"
        document = {
            "schema": "orbsoc.hardware-throughput/1",
            "provenance": "modelled",
            "headline": verdict,
            "workload": record.origin,
            "sets": [each.row() for each in sets],
            "best": best and best.row(),
            "gains": {price: asdict(band) for price, band in gains},
            "assumptions": options.echoed(platform, reading),
        }
        folder = out or Path("out") / f"hw-throughput-{record.name}"
        options.write_all(
            folder,
            {
                "throughput.json": options.as_json_text(document),
                "throughput.csv": options.as_csv_text([each.row() for each in sets]),
            },
        )
        throughput_figure(sets, title, folder / "throughput.png")
        options.print_report([*_table(sets), verdict], document, folder, as_json=as_json)
        raise typer.Exit(0 if best else FAILED)


def _shape(text: str) -> tuple[int, int, int, int]:
    lanes, dividers, banks, clusters = map(int, text.split("x"))
    return lanes, dividers, banks, clusters


def _counts(text: str, option: str) -> list[int]:
    """Whole numbers of one or more. Raises HwModelError for others."""
    from hw_model import HwModelError

    found: list[int] = options.listed(text, option, int)
    for value in found:
        if value < 1:
            raise HwModelError(f"{option} {text!r}: {value}: allowed are whole numbers from 1")
    return found


_SHOWN = 12


def _table(sets: list[EngineSet]) -> list[str]:
    """The sets with the most solves a second, those that fit first."""
    ranked = sorted(sets, key=lambda each: (not each.fits, -each.found.solves_per_s))
    lines = ["engines  lanes  dividers  banks  clusters  interleaved   solves/s  over all cores  tightest"]
    for each in ranked[:_SHOWN]:
        lanes, dividers, banks, clusters = each.shape
        use = each.tightest
        lines.append(
            f"{each.found.engines:7d} {lanes:6d} {dividers:9d} {banks:6d} {clusters:9d} {each.copies:12d}"
            f" {each.found.solves_per_s:10.0f} {each.found.gain:15.2f}  {use.kind} {100 * use.share:.0f} % of"
            f" {100 * use.ceiling:.0f} %{'' if each.fits else ', DOES NOT FIT'}"
        )
    left = len(ranked) - _SHOWN
    return [*lines, *([f"… and {left} more in throughput.csv"] if left > 0 else [])]


def _verdict(best: EngineSet | None, gains: list[tuple[str, Band]]) -> str:
    """Whether the PL makes more of it than the cores, at either price and over the bands."""
    if best is None:
        return "NO SET FITS"
    said = "; ".join(
        f"{band.nominal:.2f} ({band.low:.2f} to {band.high:.2f}) {price}" for price, band in gains
    )
    lows, highs = [band.low for _, band in gains], [band.high for _, band in gains]
    word = "MORE" if min(lows) > 1.0 else "LESS" if max(highs) < 1.0 else "MAY BE MORE OR LESS"
    return f"{word} than {best.found.cores} cores, with {best.words}: times as many solves a second: {said}"
