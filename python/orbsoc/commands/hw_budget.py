"""`orbsoc hw budget`: what an engine takes of a device, against its ceilings."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from . import hw_options as options
from .failures import FAILED, exit_handling

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.area.budget import Budget


def budget(
    workload: options.WorkloadArgument,
    device: options.DeviceOption = "zu9eg",
    partition: options.PartitionOption = "paper",
    settings: options.SetOption = None,
    exact: options.ExactOption = None,
    ordering: options.OrderingOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Compare LUT, FF, DSP and block RAM of engine, storage and microcode with what the device may give.

    Exit codes: 0 it fits, 1 it does not, 2 bad input.
    """
    with exit_handling(as_json):
        from hw_model.area.budget import budget as priced
        from hw_model.figures.area import area_figure
        from hw_model.report.best import chosen_partition
        from hw_model.report.clock_of_shape import clock_of_shape
        from hw_model.report.loading import loading
        from hw_model.report.remedies import remedies
        from hw_model.report.usage import BUDGET_USAGE, require_used
        from hw_model.vocabulary import count_of

        chosen = options.parsed_settings(settings)
        platform = options.computer(device, chosen, interleaves=True)
        options.check_partition(partition)
        record = options.recorded(workload, ordering, platform, partition, exact=exact)
        cycles = options.stage_cycles(record, exact=exact)
        split = chosen_partition(partition, record.trace, platform, cycles)
        reading = BUDGET_USAGE.of(record.trace, split, platform, cycles)
        require_used(chosen, [(platform, reading)])
        found = priced(record.trace, platform, split, cycles)
        loads = loading(platform, found.programs)
        ways = remedies(record.trace, platform, split, cycles)
        clock = clock_of_shape(platform, record.trace.datapath) if split.uses_pl else None
        title = f"{split.name} on {platform.name}, {count_of(platform.pl.lanes.value, 'lane')}"
        verdict = (
            f"modelled: {title}: {'FITS' if found.fits else 'DOES NOT FIT'}; tightest is {found.tightest.kind},"
            f" {100 * found.tightest.share:.0f} % of the device against a ceiling of {100 * found.tightest.ceiling:.0f} %"
        )
        document = {
            "schema": "orbsoc.hardware-budget/1",
            "provenance": "modelled",
            "headline": verdict,
            "workload": record.origin,
            "fits": found.fits,
            "remedies": [asdict(remedy) for remedy in ways],
            **asdict(found),
            "loading": asdict(loads),
            "clock_of_shape": None if clock is None else asdict(clock),
            "assumptions": options.echoed(platform, reading),
        }
        folder = out or Path("out") / f"hw-budget-{record.name}"
        options.write_all(folder, {"budget.json": options.as_json_text(document)})
        area_figure(found, title, folder / "budget.png")
        lines = [
            "resource      used  available  share  ceiling",
            *(
                f"{use.kind:8s} {use.used:9d} {use.available:10d} {100 * use.share:5.1f} % {100 * use.ceiling:6.0f} %"
                f"{'' if use.fits else '  over'}"
                for use in found.uses
            ),
            f"storage {found.storage_words} words in three replicas: the buffers{_of_all(platform)}, and a quarter more as an allowance for temporaries",
            _microcode(found, platform),
            loads.words,
            *([] if clock is None else [clock.words]),
            *(f"would fit: {remedy.words}" for remedy in ways),
            verdict,
        ]
        options.print_report(lines, document, folder, as_json=as_json)
        raise typer.Exit(0 if found.fits else FAILED)


def _of_all(platform: Platform) -> str:
    copies = platform.pl.interleaved.value
    return f" of {copies} interleaved problems" if copies > 1 else ""


def _microcode(found: Budget, platform: Platform) -> str:
    """Words, stored bits and block RAMs; whether the bits were counted or assumed."""
    if not found.microcode_words and found.microcode_bram36:
        return f"microcode none on the chip: streamed from memory, through buffers of {found.microcode_bram36} BRAM36"
    if not found.microcode_words:
        return "no microcode: nothing is on the PL"
    if platform.pl.microcode_format.value == "flat":
        how = "flat"
    elif found.microcode_origin == "schedule":
        ratio = found.microcode_flat_bits / found.microcode_bits
        how = f"compressed {ratio:.1f} times, counted in the schedules' own microcode"
    else:
        how = f"compressed {platform.pl.microcode_compression.value:g} times, which is assumed"
    return (
        f"microcode {found.microcode_words} words, {found.microcode_bits / 1e6:.2f} Mbit in"
        f" {found.microcode_bram36} BRAM36: {how}"
    )
