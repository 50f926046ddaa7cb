"""What `pip install orbsoc` leaves out, and the extra that brings it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

EXTRA_OF = {
    **dict.fromkeys(("typer", "rich", "pydantic", "matplotlib", "jinja2", "sgp4", "erfa"), "missions"),
    **dict.fromkeys(("pyarrow", "xarray", "h5netcdf", "h5py", "plotly", "distributed"), "reach"),
    "cvxpy": "cvxpy",
}
"""Optional package, by the name of its import → the extra of orbsoc that brings it; `hw` is a part of `missions`."""


def what_to_install(error: ModuleNotFoundError) -> str:
    """The advice for a package that is not installed; empty for one that no extra brings."""
    package = (error.name or "").partition(".")[0]
    extra = EXTRA_OF.get(package)
    return f"{package} is not installed; pip install 'orbsoc[{extra}]'" if extra else ""


@contextmanager
def told_what_to_install() -> Iterator[None]:
    """Let the error of a package that an extra brings name the extra. Raises ModuleNotFoundError as the block does."""
    try:
        yield
    except ModuleNotFoundError as error:
        advice = what_to_install(error)
        if not advice:
            raise
        raise ModuleNotFoundError(advice, name=error.name) from error
