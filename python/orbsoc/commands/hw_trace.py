"""`orbsoc hw trace`: the modelled run as a timeline for Perfetto, and as a picture."""

from __future__ import annotations

from pathlib import Path

from orbsoc.commands import hw_options as options
from orbsoc.commands.ending import spoken


def trace(
    workload: options.WorkloadArgument,
    device: options.DeviceOption = "zu9eg",
    partition: options.PartitionOption = "paper",
    settings: options.SetOption = None,
    exact: options.ExactOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Lay a recorded run out in time: trace.json for ui.perfetto.dev, gantt.png, and the record itself."""
    with spoken(as_json):
        from hw_model import simulate
        from hw_model.gantt_figure import gantt_figure
        from hw_model.partition import load_partition
        from hw_model.perfetto import trace_events
        from orbsoc.workload import load_workload

        machine, split = options.computer(device, settings), load_partition(partition)
        record = load_workload(workload)
        timeline = simulate(record.trace, machine, split, options.stage_cycles(record, exact=exact))
        folder = out or Path("out") / f"hw-trace-{record.name}"
        document = trace_events(timeline, machine, record.trace.datapath)
        options.write_all(
            folder,
            {
                "trace.json": options.as_json_text(document),
                "recorded.json": record.trace.model_dump_json(by_alias=True),
            },
        )
        gantt_figure(timeline, folder / "gantt.png")
        milliseconds = timeline.makespan_picos / 1e9
        line = (
            f"modelled: {split.name} on {machine.name}, {record.origin}: {milliseconds:.3f} ms in"
            f" {len(timeline.segments)} segments; open trace.json in ui.perfetto.dev"
        )
        options.say([line], document["otherData"] | {"folder": str(folder)}, folder, as_json=as_json)
