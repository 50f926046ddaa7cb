"""All published numbers, as parts of `orbsoc reproduce accuracy`; what computes them is imported when it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from orbsoc.guidance.mission import PaperRow

    from .number import Number

NAME = "accuracy"


def parts(scenarios: Path) -> Iterator[tuple[str, Callable[[], Sequence[PaperRow]]]]:
    """Each part with what computes its rows."""
    from . import cone_problems, motion, plans

    yield "cone problems", partial(_rows, cone_problems.numbers)
    yield "motion", partial(_rows, motion.numbers)
    yield "plans", partial(_rows, partial(plans.numbers, scenarios))


def _rows(numbers: Callable[[], Iterator[Number]]) -> tuple[PaperRow, ...]:
    return tuple(number.row for number in numbers())
