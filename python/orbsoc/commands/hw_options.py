"""What the commands of `orbsoc hw` share: their arguments, the computer these describe, and the files they leave."""

from __future__ import annotations

import csv
import io
import json
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbsoc.files.atomic_write import write_atomically

if TYPE_CHECKING:
    from hw_model import Platform
    from hw_model.report.usage import ParameterUse
    from hw_model.timing.schedules import Engine
    from hw_model.timing.stage_cycles import StageCycles
    from orbsoc.hw.workload import Workload

WorkloadArgument = Annotated[
    Path,
    typer.Argument(
        help="SCENARIO.toml (planned once), PROBLEM.json (solved once) or a recorded TRACE.json",
        metavar="WORKLOAD",
        show_default=False,
    ),
]
DeviceOption = Annotated[str, typer.Option(help="platform: name or TOML file")]
PartitionOption = Annotated[
    str,
    typer.Option(
        help="what runs on the PL: name, TOML file, modules joined by +, or best: the fastest that fits"
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="set a parameter for this run, e.g. pl.lanes=8; repeatable", metavar="KEY=VALUE"
    ),
]
OrderingOption = Annotated[
    str | None,
    typer.Option(
        help="order of elimination of every solve: amd, nested_dissection, or automatic, the one with the shortest modelled run",
        show_default="automatic",
    ),
]
OutOption = Annotated[
    Path | None, typer.Option(help="output folder; out/hw-COMMAND by default", metavar="DIR")
]
ExactOption = Annotated[
    bool | None,
    typer.Option(
        "--exact/--estimate",
        help="cycles of segments from schedules, equal to the RTL, or estimated; schedules unless there is only a trace",
        show_default=False,
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="print the JSON document on standard output")]


def computer(
    device: str, settings: Mapping[str, Any] | None = None, *, interleaves: bool = False
) -> Platform:
    """The platform `device` with settings applied. Raises HwModelError naming key, value and what is allowed.

    `interleaves`: whether the command has a use for problems that are interleaved in one stream; else such a platform is refused.
    """
    from hw_model import load_platform
    from hw_model.area.engine import require_buildable
    from hw_model.timing.groups import require_one_problem

    platform = load_platform(device).with_values(settings or {})
    require_buildable(platform.pl)
    if not interleaves:
        require_one_problem(platform)
    return platform


def check_partition(name: str) -> None:
    """Raise PartitionError for a name that is neither a partition's nor "best", before there is a run."""
    from hw_model.platform.partition import BEST, load_partition

    if name != BEST:
        load_partition(name)


def parsed_settings(
    settings: Sequence[str] | None,
    elsewhere: Mapping[str, str] | None = None,
    option: str = "--set ",
    example: str = "pl.lanes=8",
) -> dict[str, Any]:
    """KEY=VALUE pairs; a value is a TOML value, or else text.

    `elsewhere`: keys that another option of the command sets, and that option's name. Raises PlatformError for what is
    no pair, IgnoredKeyError for a key that is set twice.
    """
    from hw_model import PlatformError
    from hw_model.errors import IgnoredKeyError

    found: dict[str, Any] = {}
    for item in settings or ():
        key, equals, text = (part.strip() for part in item.partition("="))
        if not equals or not key:
            raise PlatformError(f"{option}{item!r}: must be KEY=VALUE, e.g. {example}")
        if key in found:
            raise IgnoredKeyError(f"{option}{item!r}: `{key}` was set to {found[key]!r} before; set it once")
        if elsewhere and key in elsewhere:
            raise IgnoredKeyError(
                f"{option}{item!r} would do nothing here: {elsewhere[key]} sets `{key}`; use that one"
            )
        try:
            found[key] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            found[key] = text
    return found


def listed(text: str, option: str, what: Callable[[str], Any] = str) -> list[Any]:
    """Values joined by commas. Raises HwModelError for what is no value and for a value that is there twice."""
    from hw_model import HwModelError

    found: list[Any] = []
    for part in text.split(","):
        try:
            value = what(part.strip())
        except ValueError as error:
            raise HwModelError(f"{option} {text!r}: {part!r}: must be numbers joined by commas") from error
        if value in found:
            raise HwModelError(f"{option} {text!r}: names {value} twice; it would be counted twice")
        found.append(value)
    return found


def recorded(
    workload: Path, ordering: str | None, platform: Platform, partition: str, *, exact: bool | None = None
) -> Workload:
    """The record of a workload under an order of elimination.

    None and "automatic": the order whose run under `partition` is fastest on `platform`, of those that fit. With None a trace
    keeps its own, and so does a failure bundle whose settings name another than the host's. Raises what `load_workload`
    raises, and HwModelError for no such order.
    """
    from orbsoc.hw.elimination import AUTOMATIC, HOST, OrderedRun, fastest_order, ordered_run
    from orbsoc.hw.workload import load_workload

    host = _host_record(workload, ordering)
    if host.has_order or ordering not in (None, AUTOMATIC):
        return host
    records = {HOST: host}

    def run(work: Workload, name: str) -> OrderedRun:
        if not takes_schedules(work, exact=exact) and name != HOST:
            work = records[name] = load_workload(workload, name)  # an estimate counts the record's operations
        return ordered_run(work, name, platform, partition, stage_cycles(work, exact=exact))

    best = fastest_order(host, run)
    found = records.get(best) or load_workload(workload, best)
    return found if best == HOST else replace(found, origin=f"{found.origin}, eliminated in the order {best}")


def recorded_orders(workload: Path, ordering: str | None) -> dict[str, Workload]:
    """The record of a workload in each order that a grid is priced in, from which each point takes its fastest.

    One record where the order is given, or the workload has its own; the host's comes first else. Raises as `recorded` does.
    """
    from orbsoc.hw.elimination import AUTOMATIC, HOST, differing_orders
    from orbsoc.hw.workload import load_workload

    host = _host_record(workload, ordering)
    if host.has_order or ordering not in (None, AUTOMATIC):
        return {host.settings[0].ordering if host.settings else HOST: host}
    return {HOST: host} | {name: load_workload(workload, name) for name in differing_orders(host)}


def _host_record(workload: Path, ordering: str | None) -> Workload:
    """The record in the order that is given, or in the host's. Raises HwModelError for no such order."""
    from hw_model import HwModelError
    from orbsoc.conic.settings import ORDERINGS
    from orbsoc.hw.elimination import AUTOMATIC, HOST
    from orbsoc.hw.workload import load_workload

    if ordering is not None and ordering not in ORDERINGS:
        raise HwModelError(f"--ordering {ordering!r}: allowed are {', '.join(ORDERINGS)}")
    return load_workload(workload, HOST if ordering == AUTOMATIC else ordering)


def stage_cycles(
    workload: Workload, *, exact: bool | None = None, computers: Iterable[Platform] = ()
) -> StageCycles:
    """Where the cycles of this workload's segments come from: exact schedules of its problems, or the estimate.

    None: schedules, unless there is only a trace. Those of the `computers`, as far as it is known which will be priced,
    are made side by side. Raises WorkloadError when schedules are asked for and there is only a trace.
    """
    from hw_model import HwModelError
    from hw_model.timing.schedules import engine_of
    from hw_model.timing.stage_cycles import estimated
    from orbsoc.hw.exact_cycles import exact_cycles

    if not takes_schedules(workload, exact=exact):
        return estimated
    expected: list[Engine] = []
    for each in computers:
        with suppress(HwModelError):  # it is refused where it is priced
            expected.append(engine_of(each, workload.trace.datapath))
    return exact_cycles(workload.problems, expected, workload.settings)


def takes_schedules(workload: Workload, *, exact: bool | None) -> bool:
    """Whether this workload is priced by schedules. Raises WorkloadError as `stage_cycles` does."""
    from orbsoc.hw.workload import WorkloadError

    if exact and not workload.problems:
        raise WorkloadError(
            f"--exact: {workload.origin} holds no problem to schedule; give a scenario or a problem"
        )
    return bool(workload.problems) and exact is not False


def write_all(folder: Path, files: Mapping[str, str | bytes]) -> None:
    """Write `files` into `folder`, each whole or not at all; a file of that name is replaced, others are left alone."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        write_atomically(folder / name, content)


def as_json_text(document: Mapping[str, Any]) -> str:
    """A document as a file holds it."""
    return json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def as_csv_text(rows: Sequence[Mapping[str, Any]]) -> str:
    """Rows as CSV, the columns of all of them in order of appearance."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def echoed(platform: Platform, reading: ParameterUse) -> list[dict[str, Any]]:
    """Every parameter of a platform with its provenance, and whether the report reads it."""
    from dataclasses import asdict

    from hw_model.report.assumptions import assumptions

    return [asdict(row) for row in assumptions(platform, reading)]


def print_report(lines: Sequence[str], document: Mapping[str, Any], folder: Path, *, as_json: bool) -> None:
    """Print the lines, last the folder; with `as_json` the document on standard output, the lines on standard error."""
    if as_json:
        typer.echo(json.dumps(document, allow_nan=False))
    for line in (*lines, f"written to {folder}"):
        typer.echo(line, err=as_json)
