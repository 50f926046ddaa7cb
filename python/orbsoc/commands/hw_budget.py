"""`orbsoc hw budget`: what an engine takes of a device, against its ceilings."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import typer

from orbsoc.commands import hw_options as options
from orbsoc.commands.ending import FAILED, spoken


def budget(
    workload: options.WorkloadArgument,
    device: options.DeviceOption = "zu9eg",
    partition: options.PartitionOption = "paper",
    settings: options.SetOption = None,
    exact: options.ExactOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Compare LUT, FF, DSP and block RAM of engine, storage and microcode with what the device may give.

    Exit codes: 0 it fits, 1 it does not, 2 bad input.
    """
    with spoken(as_json):
        from hw_model.area_figure import area_figure
        from hw_model.partition import load_partition
        from hw_model.resources import budget as priced
        from orbsoc.workload import load_workload

        machine, split = options.computer(device, settings), load_partition(partition)
        record = load_workload(workload)
        found = priced(record.trace, machine, split, options.stage_cycles(record, exact=exact))
        title = f"{split.name} on {machine.name}, {machine.pl.lanes.value} lanes"
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
            **asdict(found),
            "assumptions": options.echoed(machine, record.trace.datapath),
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
            f"storage {found.storage_words} words in three replicas; microcode {found.microcode_words} words,"
            f" {found.microcode_bram36} BRAM36 after compression by {machine.pl.microcode_compression.value:g}",
            verdict,
        ]
        options.say(lines, document, folder, as_json=as_json)
        raise typer.Exit(0 if found.fits else FAILED)
