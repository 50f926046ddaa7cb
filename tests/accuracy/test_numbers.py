"""A published number that is not met is said to be broken, and there are enough of them."""

from __future__ import annotations

from math import nan

import pytest

from orbsoc.accuracy.cone_problems import numbers as of_cones
from orbsoc.accuracy.motion import numbers as of_motion
from orbsoc.accuracy.number import AGREES, Number
from orbsoc.guidance.mission import BROKEN


@pytest.mark.parametrize(("ours", "verdict"), [(1.2344, AGREES), (1.2351, BROKEN), (nan, BROKEN)])
def test_a_number_agrees_within_what_is_allowed(ours: float, verdict: str) -> None:
    row = Number("a length", "a book", "1.234", ours, 5e-4, "m").row
    assert row.verdict == verdict
    assert row.paper == "1.234 m"


def test_every_number_says_where_it_is_from() -> None:
    found = [*of_cones(), *of_motion()]
    assert len(found) >= 25
    assert all(each.source and each.row.verdict == AGREES for each in found)
