"""`orbsoc reproduce`: what the missions' papers print, beside what this computes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orbsoc.accuracy import table as accuracy
from orbsoc.files.interrupts import Interrupts
from orbsoc.files.nearest import did_you_mean
from orbsoc.files.versions import __version__
from orbsoc.missions.registry import MISSIONS

from . import hw_options as options
from .failures import FAILED, exit_handling

if TYPE_CHECKING:
    from orbsoc.guidance.mission import PaperRow

    Part = tuple[str, str, Callable[[], Sequence[PaperRow]]]

COLUMNS = ("quantity", "source", "paper", "ours", "tolerance", "verdict", "reason")
JOURNAL = "reproduce.journal"
"""The parts that are done, of a run that was interrupted."""


def reproduce(
    what: Annotated[
        str,
        typer.Argument(
            help=f"mission ({', '.join(MISSIONS)}), number of a paper (000 to 004), all of them, or accuracy: numbers of other"
            " programs and books",
            metavar="NAME",
        ),
    ] = "all",
    full: Annotated[bool, typer.Option("--full", help="also the Monte Carlo, which takes minutes")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="go on where an interrupted run of the same parts ended")
    ] = False,
    scenarios: Annotated[Path, typer.Option(help="folder of the papers' scenarios", metavar="DIR")] = Path(
        "scenarios"
    ),
    out: Annotated[Path, typer.Option(help="output folder", metavar="DIR")] = Path("out/reproduce"),
    as_json: options.JsonOption = False,
) -> None:
    """Compute what a paper prints: its value, ours, tolerance, verdict, and why they differ.

    Exit codes: 0 every stated verdict holds, 1 one does not, 2 bad input, 130 interrupted (finished parts stay for --resume).
    """
    from orbsoc.guidance.mission import BROKEN

    papers = {name: MISSIONS[name].PAPER for name in MISSIONS if what not in MISSIONS}
    known = (*MISSIONS, accuracy.NAME)
    names = [what] if what in known else [name for name in papers if what in ("all", papers[name])]
    if not names:
        allowed = ", ".join(["all", *sorted({*papers.values()} - {""}), *known])
        hint = did_you_mean(what, known)
        raise typer.BadParameter(f"{what!r}: no such mission; allowed: {allowed}.{hint}")
    if not scenarios.is_dir():
        raise typer.BadParameter(f"--scenarios {scenarios}: no such folder; give that of the source tree")
    interrupted = f"interrupted; finished parts are in {out / JOURNAL}, --resume goes on"
    with Interrupts() as interrupts, exit_handling(as_json, interrupted=interrupted, interrupts=interrupts):
        rows: dict[str, list[PaperRow]] = {name: [] for name in names}
        parts = list(_parts(names, scenarios, full=full))
        if not resume:
            (out / JOURNAL).unlink(missing_ok=True)
        for name, found in _computed(parts, out / JOURNAL, _key(parts, scenarios), interrupts):
            rows[name] += found
        document = {
            "schema": "orbsoc.reproduce/1",
            "missions": {name: [asdict(row) for row in found] for name, found in rows.items()},
        }
        text = _markdown(rows)
        options.write_all(
            out, {"reproduce.json": options.as_json_text(document), "reproduce.md": text + "\n"}
        )
        (out / JOURNAL).unlink(missing_ok=True)
        options.print_report(text.splitlines(), document, out, as_json=as_json)
        broken = [row.quantity for found in rows.values() for row in found if row.verdict == BROKEN]
        if broken:
            typer.echo(f"orbsoc: does not hold as stated: {', '.join(broken)}", err=True)
            raise typer.Exit(FAILED)


def _parts(names: Sequence[str], scenarios: Path, *, full: bool) -> Iterator[Part]:
    """Mission, what of it, and its rows, in the order of the report."""
    from orbsoc.guidance.mission import Sampled

    for name in names:
        if name == accuracy.NAME:
            yield from ((name, part, run) for part, run in accuracy.parts(scenarios))
            continue
        mission = MISSIONS[name]
        yield name, "tables", partial(mission.reproduce, scenarios)
        if full and isinstance(mission, Sampled):
            yield from ((name, part, run) for part, run in mission.samples(scenarios).items())


def _key(parts: Sequence[Part], scenarios: Path) -> str:
    """What a journal must be of: this version, these parts, these scenarios."""
    texts = b"".join(path.name.encode() + path.read_bytes() for path in sorted(scenarios.glob("*.toml")))
    return " ".join([__version__, sha256(texts).hexdigest(), *(f"{name}/{part}" for name, part, _ in parts)])


def _computed(
    parts: Sequence[Part], path: Path, key: str, interrupts: Interrupts
) -> Iterator[tuple[str, Sequence[PaperRow]]]:
    """The rows of each part, told on standard error as it begins; after Ctrl-C none is kept that may be cut short."""
    from orbsoc.sweep.journal import Journal

    def whole(number: int) -> Sequence[PaperRow]:
        name, part, run = parts[number]
        typer.echo(f"{number + 1} of {len(parts)}: {name}, {part}", err=True)
        found = tuple(run())
        interrupts.check()
        return found

    with closing(Journal(path, key, "orbsoc")) as journal:
        for number, (name, _, _) in enumerate(parts):
            yield name, journal.part(partial(whole, number))


def _markdown(rows: Mapping[str, Sequence[PaperRow]]) -> str:
    """A table a mission; or the one of published numbers."""
    if accuracy.NAME in rows:
        return "\n".join(
            ["# Accuracy: published numbers beside ours", *_table(rows[accuracy.NAME], paper="theirs")]
        )
    papers = sorted({MISSIONS[name].PAPER for name in rows} - {""})
    of_papers = f"Paper{'s' * (len(papers) > 1)} {' and '.join(papers)}: printed and computed"
    lines = [f"# {of_papers if papers else 'Printed and computed'}"]
    for name, found in rows.items():
        lines += ["", f"## {name}", *_table(found)]
    return "\n".join(lines)


def _table(rows: Sequence[PaperRow], paper: str = "paper") -> Iterator[str]:
    """A blank line and the rows; `paper` heads the column of what is printed."""
    titles = (paper if column == "paper" else column for column in COLUMNS)
    yield from ("", f"| {' | '.join(titles)} |", "|" + "---|" * len(COLUMNS))
    yield from (f"| {' | '.join(getattr(row, column) for column in COLUMNS)} |" for row in rows)
