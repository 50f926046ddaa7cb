"""What the core tests share: one fixed seed for generated data, and the solver under test."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, settings

from orbsoc.solution import Solution

# A busy machine makes examples slowly; no test may fail for that.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")


@pytest.fixture(scope="session")
def solve() -> Callable[..., Solution]:
    """`orbsoc.solver.solve`, imported when first asked for: the rest of these tests need no extension module."""
    from orbsoc.solver import solve

    return solve
