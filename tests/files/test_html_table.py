"""Results in a notebook: small tables of escaped text, and short reprs."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

import orbsoc
from hw_model import speedup
from orbsoc.files.html_table import html_table
from tests.hw_model.tiny import tiny_trace

PROBLEM = orbsoc.Problem(c=[1.0, 2.0], G=-np.eye(2), h=[0.0, 0.0], cones=orbsoc.Cones(l=2))


def test_text_is_escaped() -> None:
    page = ElementTree.fromstring(html_table("a < b", {"<x>": "1 & 2"}))
    assert "".join(page.itertext()) == "a < b<x>1 & 2"


@pytest.mark.parametrize(
    "shown",
    [
        PROBLEM,
        orbsoc.solve(PROBLEM),
        orbsoc.solve_batch(PROBLEM, c=[[1.0, 2.0], [3.0, 4.0]]),
        speedup(tiny_trace(), "zu9eg", "paper"),
    ],
    ids=lambda shown: type(shown).__name__,
)
def test_a_result_is_told_in_a_line_and_shown_as_a_table(shown: object) -> None:
    line = repr(shown)
    assert line.startswith(type(shown).__name__)
    assert len(line) <= 120
    assert "array" not in line
    page = ElementTree.fromstring(shown._repr_html_())  # type: ignore[attr-defined]
    assert page.tag == "table"
    assert len(page) > 2
