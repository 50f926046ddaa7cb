"""`orbsoc list`: what can be named: missions, scenarios, vehicles, launch sites, devices, partitions."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Annotated, Any

import typer

from orbsoc.missions.registry import MISSIONS

from . import hw_options as options
from .failures import BAD_INPUT, exit_handling, exit_with


def _missions() -> dict[str, str]:
    return {name: (MISSIONS[name].Scenario.__doc__ or "").split("\n")[0] for name in MISSIONS}


def _scenarios() -> dict[str, str]:
    from orbsoc.guidance.shipped import shipped_scenarios

    return {name: f"{each.mission}: {each.about}" for name, each in shipped_scenarios().items()}


def _vehicles() -> dict[str, str]:
    from orbsoc.guidance.presets import presets

    return {name: _preset_words(each) for name, each in presets("vehicle").items()}


def _sites() -> dict[str, str]:
    from orbsoc.guidance.presets import presets

    return {name: _preset_words(each) for name, each in presets("site").items()}


def _preset_words(preset: Mapping[str, Any]) -> str:
    numbers = ", ".join(f"{key} = {value}" for key, value in preset.items() if not isinstance(value, str))
    what = preset.get("what")
    return f"{f'{what}: ' if what else ''}{numbers} [{preset['source']}]"


def _devices() -> dict[str, str]:
    from hw_model import load_platform, platform_names

    return {name: load_platform(name).description for name in platform_names()}


def _partitions() -> dict[str, str]:
    from hw_model.platform.partition import load_partition, partition_names

    return {name: load_partition(name).description for name in partition_names()}


KINDS: dict[str, tuple[str, Callable[[], dict[str, str]]]] = {
    "missions": ("orbsoc new NAME", _missions),
    "scenarios": ("orbsoc new MISSION --like NAME", _scenarios),
    "vehicles": ('[vehicle] preset = "NAME"', _vehicles),
    "sites": ('[launch_site] preset = "NAME"', _sites),
    "devices": ("--device NAME", _devices),
    "partitions": ("--partition NAME", _partitions),
}
"""What can be listed: how a name is used, and the names with a line on each."""


def list_names(
    what: Annotated[
        str | None,
        typer.Argument(help=f"{', '.join(KINDS)}; all by default", metavar="WHAT", show_default=False),
    ] = None,
    as_json: options.JsonOption = False,
) -> None:
    """List the names that commands and scenarios take, each with a line on what it is."""
    with exit_handling(as_json):
        from orbsoc.files.nearest import did_you_mean

        if what is not None and what not in KINDS:
            allowed = f"allowed: {', '.join(KINDS)}.{did_you_mean(what, KINDS)}"
            exit_with(BAD_INPUT, f"{what!r}: nothing of that name to list; {allowed}", as_json)
        found = {kind: names() for kind, (_, names) in KINDS.items() if what in (None, kind)}
    if as_json:
        typer.echo(json.dumps(found, ensure_ascii=False))
        return
    for kind, names in found.items():
        typer.echo(f"{kind}, for {KINDS[kind][0]}:")
        width = max(map(len, names)) + 2
        for name, about in names.items():
            typer.echo(f"  {name.ljust(width)}{about}".rstrip())
