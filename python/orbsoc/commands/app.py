"""The command `orbsoc`: one module of this package a command, registered here.

Exit codes: 0 done, 1 the plan or a check failed (its reason is printed), 2 bad input, 130 interrupted. A missed
deadline is a finding about the computer, printed and written, and leaves the exit code as it is.
"""

from __future__ import annotations

from typing import Annotated

import typer

from orbsoc.files.versions import __version__

from .console_entry import ConsoleApp, OneLineGroup
from .export import app as export
from .fly import fly
from .hw import app as hw
from .list_names import list_names
from .new import new
from .plan import plan
from .reach import reach
from .reproduce import reproduce
from .schema import schema
from .solve import solve

app = ConsoleApp(
    cls=OneLineGroup,
    help="Can this spacecraft re-plan its orbit on this chip, before this deadline?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"orbsoc {__version__}")
        raise typer.Exit


@app.callback()
def main(
    _: Annotated[
        bool, typer.Option("--version", help="print the version and leave", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Can this spacecraft re-plan its orbit on this chip, before this deadline?"""


app.command()(solve)
app.add_typer(hw, name="hw")
app.add_typer(export, name="export")
app.command()(new)
app.command("list")(list_names)
app.command()(reach)
app.command()(plan)
app.command()(fly)
app.command()(reproduce)
app.command()(schema)
