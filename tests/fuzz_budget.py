"""How many generated cases a test runs: the same few every time, or many new ones by `make fuzz`."""

from __future__ import annotations

import os

from hypothesis import settings

TIMES = int(os.environ.get("ORBSOC_FUZZ", "0"))
"""Times as many examples as in the suite, from a new seed; 0 in the suite."""


def fuzz_budget(examples: int) -> settings:
    """The settings of a test of `examples` examples in the suite."""
    if TIMES:
        return settings(max_examples=examples * TIMES, derandomize=False, print_blob=True)
    return settings(max_examples=examples)
