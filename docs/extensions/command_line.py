"""The command line as a Click command, for the reference."""

from typer.main import get_command

from orbsoc.commands.app import app

command = get_command(app)
