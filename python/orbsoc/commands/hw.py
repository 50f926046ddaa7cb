"""`orbsoc hw`: experiments with the modelled computer. One file per command; this one lists them."""

from __future__ import annotations

import typer

from .hw_budget import budget
from .hw_calibrate import calibrate
from .hw_design import design
from .hw_explain import explain
from .hw_partition import partition
from .hw_precision import precision
from .hw_run import run
from .hw_soc import soc
from .hw_sweep import sweep
from .hw_throughput import throughput
from .hw_trace import trace
from .hw_upsets import upsets
from .hw_validate import validate

app = typer.Typer(
    help="Experiments with the modelled PS+PL computer.", no_args_is_help=True, rich_markup_mode=None
)
app.command()(run)
app.command()(validate)
app.command()(partition)
app.command()(sweep)
app.command()(explain)
app.command()(trace)
app.command()(throughput)
app.command()(budget)
app.command()(calibrate)
app.command()(precision)
app.command()(design)
app.command()(soc)
app.command()(upsets)
