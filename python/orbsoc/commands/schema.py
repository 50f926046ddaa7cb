"""`orbsoc schema`: the JSON Schema of a mission's scenario files."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from orbsoc.missions.registry import MISSIONS

ALIASES = {"scenario": "reachable_insertion", "reach-scenario": "reachable_domain"}


def schema(
    name: Annotated[str, typer.Argument(help=f"mission: {', '.join([*MISSIONS, *ALIASES])}", metavar="NAME")],
) -> None:
    """Print the JSON Schema of a mission's scenario files."""
    mission = ALIASES.get(name, name)
    if mission not in MISSIONS:
        raise typer.BadParameter(f"{name!r} is no mission; allowed: {', '.join([*MISSIONS, *ALIASES])}")
    typer.echo(json.dumps(MISSIONS[mission].Scenario.model_json_schema(), indent=2))
