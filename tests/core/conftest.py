"""What the core tests share: the solver under test."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from orbsoc.conic.solution import Solution


@pytest.fixture(scope="session")
def solve() -> Callable[..., Solution]:
    """`orbsoc.solving.solver.solve`, imported when first asked for: the rest of these tests need no extension module."""
    from orbsoc.solving.solver import solve

    return solve
