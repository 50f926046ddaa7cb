"""`orbsoc new`: a scenario of one's own to begin with, every key documented."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from orbsoc.missions.registry import EXAMPLES, MISSIONS

from .failures import BAD_INPUT, exit_handling, exit_with

if TYPE_CHECKING:
    from orbsoc.guidance.shipped import ShippedScenario

OF_THE_PAPER = "compare_with"
"""A key of shipped scenarios that says which printed result they have; one's own have none."""


def new(
    mission: Annotated[str, typer.Argument(help=f"one of {', '.join(MISSIONS)}", metavar="MISSION")],
    like: Annotated[
        str | None,
        typer.Option(
            help="shipped scenario whose values to take, a name of `orbsoc list scenarios`", metavar="NAME"
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="file to write; MISSION.toml by default", metavar="FILE.toml")
    ] = None,
) -> None:
    """Write a scenario that can be planned as it is, with unit, meaning, allowed values and default of every key.

    A file that exists is never overwritten.
    """
    with exit_handling(as_json=False):
        base = _base(mission, like)
        path = out if out is not None else Path(f"{mission}.toml")
        text = scenario_text(mission, base, path)
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        except FileExistsError:
            exit_with(
                BAD_INPUT,
                f"{path} exists, and nothing is overwritten; give another with --out",
                as_json=False,
            )
    typer.echo(f"written to {path}, with the values of {base.name}; next: orbsoc plan {path}")


def scenario_text(mission: str, base: ShippedScenario, path: Path) -> str:
    """The scenario file, named after its path."""
    from orbsoc.guidance.scenario_template import template

    document: dict[str, Any] = base.document() | {"name": path.stem}
    document.pop(OF_THE_PAPER, None)
    model = MISSIONS[mission].Scenario
    about = (model.__doc__ or "").split("\n")[0]
    heading = (
        about,
        "",
        f"The values are those of the shipped scenario {base.name}. Plan it: orbsoc plan {path.name}",
        "A key behind # is not given; its default stands there, or ? where there is none. Behind each key: unit, meaning,",
        "what it may be, and whether it is needed.",
    )
    return template(model, document, heading=heading).replace("# \n", "#\n")


def _base(mission: str, like: str | None) -> ShippedScenario:
    """The shipped scenario whose values are taken. Leaves with 2 for a name that is not known."""
    from orbsoc.files.nearest import did_you_mean
    from orbsoc.guidance.shipped import shipped_scenarios

    if mission not in MISSIONS:
        allowed = f"allowed: {', '.join(MISSIONS)}.{did_you_mean(mission, MISSIONS)}"
        exit_with(BAD_INPUT, f"{mission!r}: no such mission; {allowed}", as_json=False)
    known = shipped_scenarios()
    name = EXAMPLES[mission] if like is None else like.removesuffix(".toml")
    own = [each.name for each in known.values() if each.mission == mission]
    if name not in own:
        what = f"is a scenario of {known[name].mission}" if name in known else "no such scenario"
        hint = did_you_mean(name, own)
        exit_with(
            BAD_INPUT,
            f"--like {name!r}: {what}; of {mission} there are {', '.join(own)}.{hint}",
            as_json=False,
        )
    return known[name]
