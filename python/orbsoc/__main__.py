"""The command `orbsoc`, and `python -m orbsoc`."""

import sys

from orbsoc.files.extras import what_to_install


def main() -> None:
    """Run the command line; without its packages, say which extra brings them, and leave with 2."""
    try:
        from orbsoc.commands.app import app
    except ModuleNotFoundError as error:
        advice = what_to_install(error)
        if not advice:
            raise
        sys.stderr.write(f"orbsoc: error: {advice}\n")
        sys.exit(2)
    app(prog_name="orbsoc")


if __name__ == "__main__":
    main()
