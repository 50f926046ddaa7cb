"""`python -m orbsoc` is the command `orbsoc`."""

from orbsoc.commands.app import app

if __name__ == "__main__":
    app(prog_name="orbsoc")
