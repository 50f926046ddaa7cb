"""`orbsoc schema`: the JSON Schema of a mission's scenario files."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from orbsoc.missions.registry import MISSIONS, SCHEMAS

NAMES = ", ".join([*MISSIONS, *SCHEMAS])


def schema(
    name: Annotated[
        str, typer.Argument(help=f"mission, or another name of its files: {NAMES}", metavar="NAME")
    ],
) -> None:
    """Print the JSON Schema of a mission's scenario files."""
    mission = SCHEMAS.get(name, name)
    if mission not in MISSIONS:
        raise typer.BadParameter(f"{name!r}: no such mission; allowed: {', '.join([*MISSIONS, *SCHEMAS])}")
    typer.echo(json.dumps(MISSIONS[mission].Scenario.model_json_schema(), indent=2))
