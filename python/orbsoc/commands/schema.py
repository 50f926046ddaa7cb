"""`orbsoc schema`: the JSON Schema of a mission's scenario files."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from orbsoc.files.nearest import did_you_mean
from orbsoc.missions.registry import MISSIONS, SCHEMAS

NAMES = ", ".join([*MISSIONS, *SCHEMAS])


def schema(
    name: Annotated[
        str | None,
        typer.Argument(
            help=f"mission, or another name of its files: {NAMES}; without it they are listed",
            metavar="[NAME]",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Print the JSON Schema of a mission's scenario files; without NAME list the names."""
    if name is None:
        typer.echo("\n".join(_listed()))
        return
    mission = SCHEMAS.get(name, name)
    if mission not in MISSIONS:
        known = [*MISSIONS, *SCHEMAS]
        near = did_you_mean(mission, known)
        raise typer.BadParameter(f"{name!r}: no such mission; allowed: {', '.join(known)}.{near}")
    typer.echo(json.dumps(MISSIONS[mission].Scenario.model_json_schema(), indent=2))


def _listed() -> list[str]:
    """Every mission, with the other names of its files."""
    others = {
        mission: [other for other, meant in SCHEMAS.items() if meant == mission] for mission in MISSIONS
    }
    return [f"{mission:<22}{', '.join(names)}".rstrip() for mission, names in others.items()]
