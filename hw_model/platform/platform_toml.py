"""A platform as the text of a platform file: every number with its tag and source, no preset left to look up."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from .sections import Section

if TYPE_CHECKING:
    from .parameter import Parameter
    from .platform import Platform


def to_toml(platform: Platform) -> str:
    """Text that `load_platform` reads back as the same platform."""
    lines = [f"name = {json.dumps(platform.name)}", f"description = {json.dumps(platform.description)}"]
    for name in type(platform).model_fields:
        section = getattr(platform, name)
        if not isinstance(section, Section):
            continue
        lines += ["", f"[{name}]"]
        plain = {key: getattr(section, key) for key in type(section).model_fields}
        lines += [f"{key} = {json.dumps(value)}" for key, value in plain.items() if isinstance(value, str)]
        lines += [f"{key} = {_entry(item)}" for key, item in section.own_parameters()]
    return "\n".join(lines) + "\n"


def _entry(item: Parameter[float] | Parameter[int] | Parameter[str]) -> str:
    band = "" if item.low is None else f", low = {json.dumps(item.low)}, high = {json.dumps(item.high)}"
    source = json.dumps(item.source, ensure_ascii=False)
    return f'{{ value = {json.dumps(item.value)}{band}, tag = "{item.tag}", source = {source} }}'
