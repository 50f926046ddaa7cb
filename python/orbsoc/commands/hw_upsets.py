"""`orbsoc hw upsets`: bits of the RTL turned over in a solve, by place and by what came of each."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from . import hw_options as options
from .failures import FAILED, INTERRUPTED, exit_handling, exit_with
from .hw_progress import Progress

if TYPE_CHECKING:
    from orbsoc.rtl.upsets import UpsetStudy

SCHEMA = "orbsoc.upsets/2"
ROWS = "upsets.jsonl"


def upsets(
    workload: Annotated[
        Path,
        typer.Argument(
            help="PROBLEM.json, or SCENARIO.toml: its first problem", metavar="WORKLOAD", show_default=False
        ),
    ],
    flips: Annotated[int, typer.Option(help="bits to turn over, each in a solve of its own")] = 100,
    seed: Annotated[int, typer.Option(help="seed of what is drawn: place, bit, clock")] = 1,
    lanes: Annotated[int, typer.Option(help="lanes of the engine")] = 4,
    parity: Annotated[
        bool,
        typer.Option(
            "--parity", help="an engine with a parity bit a word of storage and a line of microcode"
        ),
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="go on with what the folder holds")] = False,
    rtl: Annotated[
        Path | None, typer.Option(help="folder of the RTL; that of the source tree by default", metavar="DIR")
    ] = None,
    out: options.OutOption = None,
    as_json: options.JsonOption = False,
) -> None:
    """Turn over a drawn bit of storage, microcode or any flip-flop in a solve on the RTL; the PS checks, and tries once more.

    Exit codes: 0 nothing silent, 1 an accepted answer was wrong, 2 bad input, 130 interrupted (finished flips stay for --resume).
    """
    with exit_handling(as_json):
        from hw_model import HwModelError
        from orbsoc.hw.schedules import Engine
        from orbsoc.hw.workload import solves_of
        from orbsoc.rtl.upsets import UpsetStudy
        from orbsoc.rtl.validation import rtl_folder

        for name, value, least in (("--flips", flips, 1), ("--seed", seed, 0)):
            if value < least:
                raise HwModelError(f"{name} = {value}: allowed is a whole number from {least}")
        folder, tell = rtl_folder(rtl), Progress()
        where = out or Path("out") / f"hw-upsets-{workload.stem}"
        engine = Engine(lanes=lanes, banks=max(16, 4 * lanes))
        problem, settings = solves_of(workload)[0]
        tell(
            f"builds the engine whose bits can be turned over, {lanes} lanes, and solves once without a flip"
        )
        study = UpsetStudy(folder, problem, settings, engine=engine, parity=parity)
        rows = _recorded(where, study.key(seed), resume=resume)
        tell(f"a clean solve takes {study.clocks} clocks and ends {study.clean.status.name}")
        try:
            with (where / ROWS).open("a", encoding="utf-8") as file:
                for found in study.run(seed, range(len(rows), flips), len(os.sched_getaffinity(0))):
                    rows.append(found.row())
                    file.write(json.dumps(rows[-1]) + "\n")
                    file.flush()
                    tell.now_and_then(f"{len(rows)} of {flips} flips")
        except KeyboardInterrupt:
            exit_with(
                INTERRUPTED, f"interrupted; {len(rows)} flips are in {where}, --resume goes on", as_json
            )
        silent = sum(row["outcome"] == "silent" for row in rows)
        document = _document(study, rows, workload, seed, lanes, parity=parity)
        options.write_all(
            where,
            {"upsets.json": options.as_json_text(document), "upsets.csv": options.as_csv_text(rows)},
        )
        options.print_report([*_table(rows), document["headline"]], document, where, as_json=as_json)
        raise typer.Exit(FAILED if silent else 0)


def _recorded(where: Path, key: str, *, resume: bool) -> list[dict[str, Any]]:
    """The flips that the folder holds. Raises HwModelError for those of another study, and where --resume is missing."""
    from hw_model import HwModelError

    place = where / ROWS
    if not place.exists():
        options.write_all(where, {ROWS: json.dumps({"schema": SCHEMA, "study": key}) + "\n"})
        return []
    if not resume:
        raise HwModelError(
            f"--out = {where}: holds flips already; --resume goes on with them, or give another folder"
        )
    lines = place.read_text(encoding="utf-8").splitlines(keepends=True)
    whole = [line for line in lines if line.endswith("\n")]  # a kill may have cut the last one short
    if whole != lines:
        options.write_all(where, {ROWS: "".join(whole)})
    if not whole or json.loads(whole[0]) != {"schema": SCHEMA, "study": key}:
        raise HwModelError(f"--out = {where}: holds flips of another problem, engine, seed or version")
    return [json.loads(line) for line in whole[1:]]


def _document(
    study: UpsetStudy, rows: Sequence[dict[str, Any]], workload: Path, seed: int, lanes: int, *, parity: bool
) -> dict[str, Any]:
    changed = [row for row in rows if row["outcome"] != "no effect"]
    counts = Counter(row["outcome"] for row in changed)
    right = counts["other bits, right"] + counts["right after retry"]
    headline = (
        f"measured: {len(rows)} bits turned over, {len(changed)} with an effect: {counts['silent']} silent,"
        f" {counts['reported']} reported, {right} answered right, {counts['right after retry']} of them by the retry"
        + f"; {sum(row['found_by'] == 'parity' for row in rows)} found by parity"
        * parity
    )
    return {
        "schema": SCHEMA,
        "provenance": "measured: RTL under Verilator, certificates by Rust",
        "headline": headline,
        "workload": str(workload),
        "seed": seed,
        "lanes": lanes,
        "parity": parity,
        "clean": {"status": study.clean.status.name, "clocks": study.clocks},
        "by_place": _counted(rows, "outcome"),
        "found_by": _counted([row for row in rows if row["found_by"]], "found_by"),
        "flips": list(rows),
    }


def _counted(rows: Sequence[dict[str, Any]], what: str) -> dict[str, dict[str, int]]:
    """By place how often each word stands there."""
    found: dict[str, dict[str, int]] = {}
    for row in rows:
        of = found.setdefault(row["place"], {})
        of[row[what]] = of.get(row[what], 0) + 1
    return found


def _table(rows: Sequence[dict[str, Any]]) -> list[str]:
    """By place how many flips came to what, and what found those that were not accepted."""
    from orbsoc.rtl.upsets import CAUSES, OUTCOMES

    heads = ["place", "flips", *OUTCOMES, *(f"found by {cause}" for cause in CAUSES)]
    lines = ["  ".join(heads)]
    found = _counted(rows, "found_by")
    for place, counts in _counted(rows, "outcome").items():
        cells = [place, sum(counts.values()), *(counts.get(outcome, 0) for outcome in OUTCOMES)]
        cells += [found[place].get(cause, 0) for cause in CAUSES]
        lines.append("  ".join(f"{cell!s:>{len(head)}}" for head, cell in zip(heads, cells, strict=True)))
    return lines
