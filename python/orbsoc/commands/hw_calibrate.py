"""`orbsoc hw calibrate`: the PS's throughput from stage times that a user measured on his own core."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from . import hw_options as options
from .failures import exit_handling


def calibrate(
    workload: options.WorkloadArgument,
    measured: Annotated[
        Path, typer.Argument(help="CSV with the columns stage, runs, microseconds", metavar="MEASURED.csv")
    ],
    device: options.DeviceOption = "zu9eg",
    settings: options.SetOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Fit ps.flop_per_cycle to measured stage times and write the platform file that has it.

    Set the clock that you measured at: --set ps.clock_mhz=1200.0.
    """
    with exit_handling(as_json):
        from hw_model.platform.platform_toml import to_toml
        from hw_model.report.usage import CALIBRATION_USAGE, require_used
        from hw_model.timing.calibrate import calibrate as fit
        from hw_model.timing.calibrate import read_measurements
        from orbsoc.hw.workload import load_workload

        chosen = options.parsed_settings(settings)
        platform = options.computer(device, chosen, interleaves=True)
        require_used(chosen, [(platform, CALIBRATION_USAGE)])
        rows = read_measurements(measured)
        record = load_workload(workload)
        found = fit(record.trace, platform, rows, f"calibrated with {measured.name} ({record.origin})")
        was = platform.ps.flop_per_cycle
        verdict = (
            f"measured: {found.flop_per_cycle:.3f} flop/cycle ({found.low:.3f}–{found.high:.3f}, {found.band_words});"
            f" {platform.name} had {was.value:g} ({was.tag})"
        )
        document = {
            "schema": "orbsoc.hardware-calibration/1",
            "headline": verdict,
            "workload": record.origin,
            "flop_per_cycle": found.flop_per_cycle,
            "low": found.low,
            "high": found.high,
            "modules": [asdict(row) | {"error": row.error} for row in found.modules],
            "skipped_stages": list(found.skipped),
            "assumptions": options.echoed(found.platform, CALIBRATION_USAGE),
        }
        folder = out or Path("out") / f"hw-calibrate-{record.name}"
        name = f"{platform.name}-calibrated.toml"
        options.write_all(
            folder, {name: to_toml(found.platform), "calibration.json": options.as_json_text(document)}
        )
        lines = [
            "module            flop/cycle  measured µs  modelled µs   error",
            *(
                f"{row.module:16s} {row.flop_per_cycle:11.3f} {row.measured_us:12.1f} {row.modelled_us:12.1f}"
                f" {100 * row.error:+6.1f} %"
                for row in found.modules
            ),
            *([f"left out, all division or root: {', '.join(found.skipped)}"] if found.skipped else []),
            verdict,
            f"use it with --device {folder / name}",
        ]
        options.print_report(lines, document, folder, as_json=as_json)
