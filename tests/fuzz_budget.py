"""How much generated data a test looks at: the same few cases every time, or many new ones by `make fuzz`."""

from __future__ import annotations

import os

from hypothesis import settings

TIMES = int(os.environ.get("ORBSOC_FUZZ", "0"))
"""Times as many examples as in the suite, from a new seed; 0 in the suite."""


def effort(examples: int) -> settings:
    """For a test of `examples` examples in the suite."""
    if TIMES:
        return settings(max_examples=examples * TIMES, derandomize=False, print_blob=True)
    return settings(max_examples=examples)
