"""Draws beside other draws: near is told as such, and far is not."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.mission import BROKEN
from orbsoc.guidance.samples import share_row, statistics_row

DRAWS = np.random.default_rng(0).normal(10.0, 2.0, 4000)
"""Mean 10, 95th percentile 13.29."""


@pytest.mark.parametrize(
    ("mean", "p95", "verdict"),
    [(10.0, 13.29, "inferred"), (None, 13.29, "inferred"), (11.5, 13.29, BROKEN), (10.0, 16.0, BROKEN)],
)
def test_mean_and_percentile_are_held_against_what_is_known(
    mean: float | None, p95: float, verdict: str
) -> None:
    row = statistics_row("miss", DRAWS, "m", "assumed", mean=mean, p95=p95)
    assert row.verdict == verdict
    assert ("mean" in row.ours) is (mean is not None)


@pytest.mark.parametrize(
    ("count", "known", "verdict"),
    [(50, 0.25, "inferred"), (75, 0.25, "inferred"), (77, 0.25, BROKEN), (0, 0.0, "inferred"), (1, 0.0, BROKEN)],
)  # fmt: skip
def test_a_share_is_within_three_deviations_and_a_known_0_is_met(
    count: int, known: float, verdict: str
) -> None:
    """Of 200: 3 √(2 · 0.25 · 0.75 / 200) = 13.0 %."""
    assert share_row("unsafe", count, 200, known, "assumed").verdict == verdict
