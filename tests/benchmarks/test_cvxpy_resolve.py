"""The re-solves through CVXPY that are timed: all solvers find the same values."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.cvxpy_resolve import FAMILIES, measure


@pytest.mark.parametrize("family", FAMILIES)
def test_all_solvers_find_the_same_values(family: str) -> None:
    medians, values = measure(family, rounds=2)
    assert {"orbsoc", "orbsoc, cold", "CLARABEL"} <= set(medians)
    for name, found in values.items():
        if name != "OSQP":  # to 1e-5 by default
            np.testing.assert_allclose(found, values["CLARABEL"], rtol=1e-6, err_msg=name)
