"""`orbsoc hw validate`: the schedules' cycles and words against the RTL, regenerated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import FAILED, exit_handling
from .hw_validate_groups import validate_groups
from .hw_validate_mutations import validate_mutations
from .hw_validate_solve import validate_solves
from .hw_validate_tables import print_tables

if TYPE_CHECKING:
    from hw_model.platform.sections import Pl
    from orbsoc.rtl.validation import Outcome


def validate(
    quick: Annotated[
        bool, typer.Option("--quick", help="the subset of continuous integration: a few minutes")
    ] = False,
    engines: Annotated[
        bool,
        typer.Option("--engines", help="engines with clusters, several dividers, few banks: 84 points"),
    ] = False,
    solve: Annotated[
        bool, typer.Option("--solve", help="whole solves, Python as the PS, instead of segment by segment")
    ] = False,
    mutations: Annotated[
        bool,
        typer.Option(
            "--mutations", help="engines and schedulers that are wrong in one place: what catches each"
        ),
    ] = False,
    tables: Annotated[
        bool,
        typer.Option(
            "--tables",
            help="the modelled tables of docs/pl-schedules.md, mission 004's problems C and A; needs no Verilator",
        ),
    ] = False,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            help="pl.interleaved=K: problems of one pattern in every segment, or with --solve in every attempt;"
            " pl.storage_depth=exact: banks with no more rows than the schedules need",
            metavar="KEY=VALUE",
        ),
    ] = None,
    rtl: Annotated[
        Path | None, typer.Option(help="folder of the RTL; that of the source tree by default", metavar="DIR")
    ] = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Run the same microcode on the RTL under Verilator, and compare cycles and every word of storage.

    Exit codes: 0 all equal (and every mutation caught), 1 any difference, 2 no RTL or no Verilator.
    """
    with exit_handling(as_json):
        from orbsoc.rtl.validation import (
            all_points,
            engine_points,
            kkt_points,
            mission_004,
            problems,
            quick_points,
            rtl_folder,
            rtl_sources,
        )
        from orbsoc.rtl.validation import validate as compare

        _require_one_run(
            {"--tables": tables, "--engines": engines, "--mutations": mutations, "--solve": solve},
            quick=quick,
        )
        pl = _computer(settings, {"--tables": tables, "--mutations": mutations})
        copies, exact = pl.interleaved.value, pl.storage_depth.value == "exact"
        where = out or Path("out") / "hw-validate"
        if tables:
            print_tables(rtl_sources(rtl).parent / "scenarios" / "rec1.toml", where, as_json=as_json)
        folder = rtl_folder(rtl)
        if mutations:
            validate_mutations(folder, where, as_json=as_json)
        if solve and copies > 1 and exact:
            raise _would_do_nothing(
                "pl.storage_depth", "exact", "groups have engines of a power of two of rows"
            )
        if solve and copies > 1:
            validate_groups(folder, where, copies, quick=quick, as_json=as_json)
        if solve:
            validate_solves(folder, where, quick=quick, exact_depth=exact, as_json=as_json)
        scenario = folder.parent / "scenarios" / "rec1.toml"
        named = problems(mission_004(scenario, free_perigee=False))
        chosen = quick_points if quick else engine_points if engines else all_points
        points = chosen(tuple(named))
        if chosen is all_points:
            named["mission 004 C, N = 12"] = mission_004(scenario, free_perigee=True)
            points += kkt_points("mission 004 C, N = 12")
        points = [point.with_interleaved(copies) for point in points]
        outcomes: list[Outcome] = []
        watched: set[Path] = set()
        done = 0
        options.write_all(where, {})  # what cannot be written ends the run here
        try:
            for done, found in enumerate(compare(folder, points, named, watched, exact_depth=exact), start=1):
                outcomes += found
                verdict = "equal" if all(outcome.good for outcome in found) else "DIFFERENT"
                point = found[0].point if found else points[done - 1]
                typer.echo(f"{done}/{len(points)} {_title(point)}: {verdict}", err=True)
        finally:  # what has run is kept, whatever ended the rest
            document = _document(outcomes, watched, done, len(points))
            table = _table(document["summary"])
            text = "\n".join([*table, "", f"{done} of {len(points)} points."]) + "\n"
            files = {"validation.json": options.as_json_text(document), "validation.md": text}
            options.write_all(where, files)
        equal = document["equal"]
        verdict = (
            f"measured: model and RTL are {'EQUAL' if equal else 'DIFFERENT'} in {len(outcomes)} segments,"
            f" on {len(watched)} harnesses that assert every rule when a control breaks it"
        )
        options.print_report([*table, verdict], document, where, as_json=as_json)
        raise typer.Exit(0 if equal else FAILED)


def _document(outcomes: Sequence[Outcome], watched: set[Path], done: int, points: int) -> dict[str, Any]:
    """As JSON; equal when all points ran, and all of them were."""
    from orbsoc.rtl.validation import summary

    return {
        "schema": "orbsoc.rtl-validation/1",
        "provenance": "measured: RTL under Verilator against its schedule",
        "points": {"done": done, "of": points},
        "equal": done == points and all(outcome.good for outcome in outcomes),
        "harnesses_that_assert_every_rule": len(watched),
        "summary": summary(outcomes),
        "outcomes": [asdict(outcome) for outcome in outcomes],
    }


def _computer(settings: list[str] | None, without: dict[str, bool]) -> Pl:
    """The PL with the parameters that can be set. Raises IgnoredKeyError for others, and where a run has no use for them."""
    chosen = options.parsed_settings(settings, example="pl.interleaved=2")
    uses = {"pl.interleaved": "no points to interleave", "pl.storage_depth": "no points with other banks"}
    unused = [name for name, wanted in without.items() if wanted]
    for key, value in chosen.items():
        if key not in uses:
            why = f"the points have engines of their own; only {' and '.join(uses)} can be set"
            raise _would_do_nothing(key, value, why)
        if unused:
            raise _would_do_nothing(key, value, f"{unused[0]} has {uses[key]}")
    return options.computer("zu9eg", chosen, interleaves=True).pl


def _would_do_nothing(key: str, value: object, why: str) -> Exception:
    from hw_model.errors import IgnoredKeyError

    return IgnoredKeyError(f"`{key}` = {value!r} would do nothing here: {why}")


def _require_one_run(given: dict[str, bool], *, quick: bool) -> None:
    """Raises RtlError for options of which one would be ignored."""
    from orbsoc.rtl.validation import RtlError

    chosen = [name for name, wanted in given.items() if wanted]
    if len(chosen) > 1:
        raise RtlError(f"{' and '.join(chosen)} are runs of their own; give one of them")
    if quick and chosen and chosen != ["--solve"]:
        raise RtlError(
            f"--quick chooses points for the RTL, and {chosen[0]} has none to choose from; leave it out"
        )


def _title(point: Any) -> str:
    engine = point.engine
    gaps = f" level {point.level}" if point.format == "in_order" else ""
    what = point.stream.name if point.stream else point.module
    rows = f" of {engine.rows} rows" if engine.rows else ""
    return (
        f"{what} of {point.problem!r}, f{engine.fp}, {engine.lanes} lanes, {engine.banks} banks{rows},"
        f" {point.format}{gaps}{f', {point.interleaved} interleaved' if point.interleaved > 1 else ''}"
    )


def _table(summary: dict[str, dict[str, Any]]) -> Sequence[str]:
    """Markdown, one row a format."""
    rows = [
        f"| {form} | {found['points']} | {found['segments']} | {found['rtl_cycles']} |"
        f" {100 * found['largest_cycle_error']:.3f} % | {found['different_words']} | {found['assertions']} |"
        f" {found['signals']} |"
        for form, found in summary.items()
    ]
    return [
        "| sequencer | points | segments | RTL cycles | largest cycle error | words different | assertions |"
        " wrong signals |",
        "|---|---|---|---|---|---|---|---|",
        *rows,
    ]
