"""`orbsoc hw trace`: the modelled run as a timeline for Perfetto, and as a picture."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from . import hw_options as options
from .failures import exit_handling

if TYPE_CHECKING:
    from hw_model import Timeline, Trace
    from hw_model.area.budget import Budget


def trace(
    workload: options.WorkloadArgument,
    device: options.DeviceOption = "zu9eg",
    partition: options.PartitionOption = "paper",
    settings: options.SetOption = None,
    exact: options.ExactOption = None,
    ordering: options.OrderingOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Lay a recorded run out in time: trace.json for ui.perfetto.dev, gantt.png, and the record itself."""
    with exit_handling(as_json):
        from hw_model import simulate
        from hw_model.area.budget import budget
        from hw_model.figures.gantt import gantt_figure
        from hw_model.platform.partition import load_partition
        from hw_model.report.best import chosen_partition
        from hw_model.report.loading import loading
        from hw_model.report.perfetto import as_text, trace_events
        from hw_model.report.throughput import throughputs
        from hw_model.report.usage import TRACE_USAGE, require_used
        from orbsoc.conic.problem_file import encode_problem
        from orbsoc.hw.exact_cycles import exact_units
        from orbsoc.hw.workload import pattern_file

        chosen = options.parsed_settings(settings)
        computer = options.computer(device, chosen, interleaves=True)
        copies = computer.pl.interleaved.value
        # The timeline is of one problem after the other.
        platform = computer if copies == 1 else computer.with_value("pl.interleaved", 1)
        options.check_partition(partition)
        record = options.recorded(workload, ordering, platform, partition, exact=exact)
        cycles = options.stage_cycles(record, exact=exact)
        split = chosen_partition(partition, record.trace, platform, cycles)
        require_used(chosen, [(computer, TRACE_USAGE.of(record.trace, split, platform, cycles))])
        rows = throughputs(record.trace, computer, split, load_partition("all_ps"), cycles)
        timeline = simulate(record.trace, platform, split, cycles)
        area = budget(record.trace, computer, split, cycles)
        loads = loading(computer, area.programs)
        folder = out or Path("out") / f"hw-trace-{record.name}"
        units = (
            exact_units(record.problems, record.settings)
            if options.takes_schedules(record, exact=exact)
            else None
        )
        document = trace_events(timeline, record.trace, platform, split, cycles, units)
        options.write_all(
            folder,
            {
                "trace.json": as_text(document),
                "recorded.json": record.trace.model_dump_json(by_alias=True),
                **{
                    pattern_file(k): options.as_json_text(encode_problem(problem))
                    for k, problem in enumerate(record.problems)
                },
            },
        )
        gantt_figure(timeline, folder / "gantt.png")
        milliseconds = timeline.makespan_picoseconds / 1e9
        lines = [
            f"modelled: {split.name} on {platform.name}, {record.origin}: {milliseconds:.3f} ms in"
            f" {len(timeline.segments)} segments; open trace.json in ui.perfetto.dev"
        ]
        if split.uses_pl:
            lines += [_verdict(area), loads.words]
        lines += [_of_groups(record.trace, copies)] if copies > 1 else []
        lines += [row.words for row in rows]
        if split.uses_pl:
            lines.append(_of_units(timeline) if units else NO_UNITS)
        options.print_report(
            lines,
            document["otherData"]
            | {
                "folder": str(folder),
                "throughput": [asdict(row) for row in rows],
                "fits": area.fits,
                "area": asdict(area),
                "loading": asdict(loads),
            },
            folder,
            as_json=as_json,
        )


def _verdict(area: Budget) -> str:
    """Whether there is such a computer at all."""
    if area.fits:
        return f"FITS: {area.words}"
    return f"DOES NOT FIT, so no figure here is of a computer that can be built: {area.words}"


def _of_groups(trace: Trace, copies: int) -> str:
    """What the throughput of a workload is about where problems are interleaved."""
    from hw_model.timing.groups import runs_in_group

    if runs_in_group(trace, copies) == 1:
        what = f"groups of {copies} solves of a pattern as they follow, taken as independent problems"
    else:
        what = f"groups of the same solve in {copies} independent runs of the workload, which need the same iterations"
    return f"the timeline is of one problem after the other; the throughput is of {what}"


NO_UNITS = (
    "no tracks of lanes and dividers: these cycles are estimated, and only schedules say what a unit executes"
)


def _of_units(timeline: Timeline) -> str:
    solve, iteration = timeline.longest_iteration()
    return (
        f"each lane and divider has a track: solve {solve}, iteration {iteration}, the longest, operation by operation;"
        " the rest by intervals and what is executed in them"
    )
