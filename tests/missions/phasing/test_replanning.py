"""A drag that was not planned with, and planning again on one pattern."""

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.settings import Settings
from orbsoc.guidance.scp import ExitReason
from orbsoc.missions.phasing.dispersion.replanning import Horizon

from .cases import planned


def test_the_surprise_costs_what_is_known() -> None:
    analysis = planned().analysis
    assert analysis is not None
    found = analysis.surprised
    assert found is not None
    assert found.miss_m == pytest.approx(42.4e3, abs=50.0)
    assert [each.reason for each in found.replans] == [ExitReason.CONVERGED] * 4
    assert [each.extra_m_s for each in found.replans] == pytest.approx(
        [0.265, 0.265, 0.265, 0.628], abs=0.002
    )


def test_executed_impulses_stay_and_the_rest_meets() -> None:
    plan = planned()
    assert plan.analysis is not None
    assert plan.descended is not None
    surprised = plan.analysis.surprised
    assert surprised is not None
    for each in surprised.replans:
        assert each.roll is not None
        assert np.array_equal(each.roll.dv_m_s[: each.done], plan.descended.roll.dv_m_s[: each.done])
        assert each.roll.miss_m < 1e-3


def test_a_flight_has_one_pattern_and_an_update_is_a_fresh_solve() -> None:
    descended = planned().descended
    assert descended is not None
    horizon, patterns = Horizon(), []
    for done in (0, 60, 150):
        problem, solution, dv = horizon.solve(descended.roll, done)
        patterns.append((problem.A.indptr.tolist(), problem.A.indices.tolist()))
        fresh = orbsoc.solve(problem, Settings(tol=horizon.settings.tol))
        assert np.array_equal(solution.x, fresh.x)
        left = np.linalg.norm(descended.roll.dv_m_s[done:], axis=1).sum()
        assert solution.objective == pytest.approx(left, rel=1e-6)
        assert np.array_equal(dv[:done], descended.roll.dv_m_s[:done])
        assert np.abs(solution.x[: 3 * done]).max(initial=0.0) < 1e-6
    assert patterns[0] == patterns[1] == patterns[2]
    assert horizon.updates == 2
