"""How results show themselves in a notebook: a small table, and nothing to fetch."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape


def html_table(caption: str, rows: Mapping[str, object]) -> str:
    """A table of two columns under a caption, as HTML; all text is escaped."""
    cells = "".join(
        f"<tr><th>{escape(name)}</th><td>{escape(str(value))}</td></tr>" for name, value in rows.items()
    )
    return f"<table><caption>{escape(caption)}</caption>{cells}</table>"
