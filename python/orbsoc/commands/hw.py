"""`orbsoc hw`: experiments with the modelled computer. One file per command; this one lists them."""

from __future__ import annotations

import typer

from orbsoc.commands.hw_budget import budget
from orbsoc.commands.hw_calibrate import calibrate
from orbsoc.commands.hw_explain import explain
from orbsoc.commands.hw_partition import partition
from orbsoc.commands.hw_precision import precision
from orbsoc.commands.hw_run import run
from orbsoc.commands.hw_sweep import sweep
from orbsoc.commands.hw_trace import trace
from orbsoc.commands.hw_validate import validate

app = typer.Typer(
    help="Experiments with the modelled PS+PL computer.", no_args_is_help=True, rich_markup_mode=None
)
app.command()(run)
app.command()(validate)
app.command()(partition)
app.command()(sweep)
app.command()(explain)
app.command()(trace)
app.command()(budget)
app.command()(calibrate)
app.command()(precision)
