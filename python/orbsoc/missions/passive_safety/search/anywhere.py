"""Impulses at any times of an approach that keeps out of nothing: primer rounds over the whole window, with a bound."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from orbsoc.guidance.impulses import Generated, Impulses, generate
from orbsoc.guidance.scp import Iteration, Solve
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from ..model.problem import assemble

FIRST = 25
"""Times of the first round, equally spaced."""
GAP = 1e-7
"""Relative, between cost and bound."""
ACCEPTED = 1e-6


def generated_anywhere(
    approach: Approach, solve: Solve, callback: Callable[[Iteration], None]
) -> tuple[Generated, list[Impulses]]:
    """The cheapest programme with impulses at any times, and the unknowns of every round in order."""
    built: list[Impulses] = []

    def build(times: Array) -> Impulses:
        built.append(assemble(approach, times, start_s=0.0))
        return built[-1]

    end_s = approach.duration_s
    found = generate(
        build, np.linspace(0.0, end_s, FIRST), (0.0, end_s),
        solve=solve, gap=GAP, usable_residual=ACCEPTED, callback=callback,
    )  # fmt: skip
    return found, built
