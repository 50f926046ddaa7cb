"""`orbsoc hw explain`: why two configurations differ, cause by cause."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import exit_handling

if TYPE_CHECKING:
    from hw_model import Platform, Trace
    from hw_model.report.explain import Configuration
    from hw_model.timing.stage_cycles import StageCycles

_FORM = "DEVICE:PARTITION[:KEY=VALUE,…]"


def explain(
    workload: options.WorkloadArgument,
    a: Annotated[str, typer.Argument(help=f"{_FORM}, e.g. zu9eg:paper", metavar="A")],
    b: Annotated[str, typer.Argument(help=f"{_FORM}, e.g. zu9eg:paper:pl.lanes=8", metavar="B")],
    exact: options.ExactOption = None,
    ordering: options.OrderingOption = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Say what B takes more or less time for than A, cause by cause and module by module.

    Both eliminate in one order: by default the one that B is fastest in.
    """
    with exit_handling(as_json):
        from hw_model.figures.difference import difference_figure
        from hw_model.figures.gantt import iterations_figure
        from hw_model.report.explain import explain as compare
        from hw_model.report.run import simulate
        from hw_model.report.usage import EXPLAIN_USAGE, require_used

        _parts(a)
        platform, _, partition = _parts(b)
        record = options.recorded(workload, ordering, platform, partition, exact=exact)
        cycles = options.stage_cycles(record, exact=exact)
        (one, set_in_one), (other, set_in_other) = (
            _configuration(text, record.trace, cycles) for text in (a, b)
        )
        assumptions: dict[str, list[dict[str, Any]]] = {}
        for side, chosen, keys in (("a", one, set_in_one), ("b", other, set_in_other)):
            reading = EXPLAIN_USAGE.of(record.trace, chosen.partition, chosen.platform, cycles)
            require_used(keys, [(chosen.platform, reading)])
            assumptions[side] = options.echoed(chosen.platform, reading)
        found = compare(record.trace, one, other, cycles)
        document = found.to_dict() | {"workload": record.origin, "assumptions": assumptions}
        folder = out or Path("out") / f"hw-explain-{record.name}"
        options.write_all(folder, {"explain.json": options.as_json_text(document)})
        difference_figure(found, folder / "explain.png")
        sides = (simulate(record.trace, side.platform, side.partition, cycles) for side in (one, other))
        iterations_figure(tuple(sides), folder / "iterations.png")
        lines = [
            *(f"differs: {key} = {mine} → {theirs}" for key, mine, theirs in found.parameters),
            *(f"moved: {module}" for module in found.moved),
            "cause         A ms      B ms    B − A ms",
            *(
                f"{cause:10s} {one_ms / 1e9:9.3f} {other_ms / 1e9:9.3f} {(other_ms - one_ms) / 1e9:+10.3f}"
                for cause, (one_ms, other_ms) in found.by_cause.items()
            ),
            f"{'sum':10s} {found.a_picoseconds / 1e9:9.3f} {found.b_picoseconds / 1e9:9.3f}"
            f" {(found.b_picoseconds - found.a_picoseconds) / 1e9:+10.3f}",
            found.headline,
            found.energy_line,
            *found.computer_lines,
        ]
        options.print_report(lines, document, folder, as_json=as_json)


def _parts(text: str) -> tuple[Platform, dict[str, Any], str]:
    """A computer, what was set of it, and a partition's name, from their short form. Raises HwModelError."""
    from hw_model import HwModelError

    parts = text.split(":", 2)
    if len(parts) < 2:
        raise HwModelError(f"configuration {text!r}: must be {_FORM}")
    given = parts[2].split(",") if len(parts) > 2 else []
    settings = options.parsed_settings(given, option=f"configuration {text!r}: ")
    options.check_partition(parts[1])
    return options.computer(parts[0], settings), settings, parts[1]


def _configuration(text: str, trace: Trace, cycles: StageCycles) -> tuple[Configuration, dict[str, Any]]:
    from hw_model.report.best import chosen_partition
    from hw_model.report.explain import Configuration

    platform, settings, partition = _parts(text)
    return Configuration(text, platform, chosen_partition(partition, trace, platform, cycles)), settings
