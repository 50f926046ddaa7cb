"""The iteration table of a verbose solve."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping

COLUMNS = {
    "iteration": "{:>4.0f}",
    "objective": "{:>15.7e}",
    "dual_objective": "{:>15.7e}",
    "primal_residual": "{:>9.1e}",
    "dual_residual": "{:>9.1e}",
    "gap": "{:>9.1e}",
    "mu": "{:>9.1e}",
    "step": "{:>6.3f}",
    "refinements": "{:>4.0f}",
}
"""Statistics of an iteration, in the user's units, and how each is printed."""

HEADER = "iter       objective            dual    primal      dual       gap        mu   step  ref"


def print_table(
    callback: Callable[[Mapping[str, float]], object] | None = None,
) -> Callable[[Mapping[str, float]], object]:
    """A callback that writes one line per iteration to standard error, where there is one, then asks `callback`."""
    lines = 0

    def write(line: str) -> None:
        if sys.stderr is not None:  # a windowed or detached interpreter has none
            sys.stderr.write(line + "\n")

    def watch(progress: Mapping[str, float]) -> object:
        nonlocal lines
        if lines == 0:
            write(HEADER)
        lines += 1
        write(" ".join(form.format(progress[name]) for name, form in COLUMNS.items()))
        return callback(progress) if callback else False

    return watch
