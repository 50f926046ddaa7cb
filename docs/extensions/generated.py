"""Generated pages keep their dates where nothing has changed, so that Sphinx reads only what is new."""

from __future__ import annotations

from pathlib import Path


def write_changed(place: Path, text: str) -> None:
    """Write a page, unless it stands there already."""
    if not place.exists() or place.read_text(encoding="utf-8") != text:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(text, encoding="utf-8")
