"""The page of the commands: the help of each, as the terminal shows it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from generated import write_changed
from sphinx.application import Sphinx

HEAD = """# Commands

Each command's own help, in the order of `orbsoc --help`. Exit codes: 0 all is well, 1 a word of the verdict is bad, 2 bad input, 130 interrupted.
"""


def helps(command: Any, name: str) -> Iterator[str]:
    """A section for a command and for each below it."""
    context = command.make_context(name, [], resilient_parsing=True)
    with context:
        yield f"## {name}\n\n```text\n{command.get_help(context).rstrip()}\n```\n"
    for below, each in getattr(command, "commands", {}).items():
        yield from helps(each, f"{name} {below}")


def write_page(app: Sphinx) -> None:
    from typer.main import get_command

    from orbsoc.commands.app import app as commands

    page = "\n".join([HEAD, *helps(get_command(commands), "orbsoc")])
    write_changed(Path(app.srcdir) / "reference" / "commands.md", page)


def setup(app: Sphinx) -> dict[str, Any]:
    app.connect("builder-inited", write_page)
    return {"parallel_read_safe": True}
