"""Report pages: self-contained HTML from a template; every image is inlined, nothing is fetched."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from jinja2 import ChoiceLoader, Environment, FileSystemLoader, PackageLoader, StrictUndefined

from orbsoc.guidance.mission import FigureFile


def render(
    template: str, figures: Iterable[FigureFile], place: Path, *, folder: Path | None = None, **values: Any
) -> str:
    """The page that `template` makes of `values` and of the figures in `place`, its `images`.

    Templates are those of this package and, before them, of `folder`.
    """
    loaders = [PackageLoader("orbsoc.report", "templates")]
    environment = Environment(
        loader=ChoiceLoader([FileSystemLoader(folder), *loaders] if folder else loaders),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": _number,
        "difference": _difference,
        "scientific": _scientific,
        "sentence": _sentence,
    }
    images = [image(figure, place) for figure in figures]
    return environment.get_template(template).render(images=images, **values)


def image(figure: FigureFile, place: Path) -> dict[str, Any]:
    """A figure in `place` as templates take it, with its data inline."""
    data = base64.b64encode((place / figure.name).read_bytes()).decode("ascii")
    return {"caption": figure.caption, "appendix": figure.appendix, "data": data}


def _number(value: float | None, form: str = "%.2f", *, per: float = 1.0) -> str:
    """`value` / `per` in a printf form; a dash for what is missing or not finite."""
    if value is None or not math.isfinite(value):
        return "–"
    return form % (value if per == 1.0 else value / per)


def _difference(value: float | None, other: float | None) -> float | None:
    """value − other; None when either is missing."""
    return None if value is None or other is None else value - other


def _scientific(value: float | None) -> str:
    return "–" if value is None else f"{value:.1e}"


def _sentence(text: str) -> str:
    """The text with its first letter in upper case, the rest as it is."""
    return text[:1].upper() + text[1:]
