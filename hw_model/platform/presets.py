"""The shared numbers of presets.toml and of the RTL: processor cores, PL engine, links, latencies."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path

from hw_model.errors import PlatformError

from .data_file import Table, is_table
from .rtl_latency import rtl_latencies


@cache
def _presets() -> Table:
    presets: Table = tomllib.loads((Path(__file__).parent / "presets.toml").read_text(encoding="utf-8"))
    presets["latency"] = {"orbsoc_rtl": rtl_latencies()} | presets["latency"]
    return presets


def preset(section: str, name: object) -> Table:
    """A fresh copy of `[section.name]`; PlatformError lists the known names."""
    known: Table = _presets()[section]
    if not isinstance(name, str) or name not in known:
        raise PlatformError(f"`{section}` preset {name!r} is not known; allowed: {', '.join(known)}")
    return _copy(known[name])


def with_preset(section: str, given: Table) -> Table:
    """A platform's section with its `preset` filled in; the section's own keys win.

    `borrowed = true` says that the preset describes another part than this one: what is sourced or
    measured there is only assumed here.
    """
    own = dict(given)
    if "preset" not in own:
        if "borrowed" in own:
            raise PlatformError(f"`{section}.borrowed` = {own['borrowed']!r} needs `{section}.preset`")
        return own
    name, borrowed = own.pop("preset"), own.pop("borrowed", False)
    if not isinstance(borrowed, bool):
        raise PlatformError(f"`{section}.borrowed` = {borrowed!r}: allowed are true and false")
    base = preset(section, name)
    if borrowed:
        for entry in base.values():
            if is_table(entry) and entry["tag"] != "assumed":
                entry.update(tag="assumed", source=f"borrowed from {name}: {entry['source']}")
    return base | own


def _copy(table: Table) -> Table:
    return {key: _copy(item) if is_table(item) else item for key, item in table.items()}
