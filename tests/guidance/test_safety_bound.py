"""No drift of a cut impulse is nearer than the bound, which is within a millimetre of one; the unsafe share is between two."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.guidance.claims import Kind
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.safety import audit_cut_burns, drift_clearance, drift_least, nearest_claim
from orbsoc.guidance.safety_bound import WITHIN_M, DriftFamily, Least, least_bound, unsafe_shares
from orbsoc.orbit.relative import ClohessyWiltshire

N = 1e-3
FRACTIONS = 801


def dense(family: DriftFamily) -> np.ndarray:
    """Least distances at equal fractions."""
    share = np.linspace(0.0, 1.0, FRACTIONS)
    states = np.tile(family.before, (FRACTIONS, 1))
    states[:, 3:] += share[:, None] * family.dv_m_s
    return drift_clearance(states, N, family.horizon_s).distance_m


@pytest.mark.parametrize("horizon_s", [np.inf, 4.0 * np.pi / N, 2000.0])
@pytest.mark.parametrize("seed", range(20))
def test_no_drift_is_nearer_than_the_bound(seed: int, horizon_s: float) -> None:
    random = np.random.default_rng(seed)
    before = random.uniform(-1.0, 1.0, 6) * [200.0, 1000.0, 100.0, 0.2, 0.2, 0.1]
    dv = random.uniform(-1.0, 1.0, 3) * [0.2, 0.05, 0.05]
    if seed % 4 == 1:  # closed, whatever the fraction
        before[4], dv[1] = -2.0 * N * before[0], 0.0
    family = DriftFamily(before, dv, N, horizon_s)
    near = dense(family)
    found = least_bound(family, Least(float(near[::8].min()), None, 0.0, 0.0))
    assert found.at_least_m is not None
    assert found.at_least_m <= near.min() + 1e-6
    assert found.distance_m <= near.min() + 1e-3
    assert found.distance_m - found.at_least_m <= WITHIN_M + 1e-12
    keep_out = 1.01 * float(np.quantile(near, random.uniform(0.05, 0.95)))  # not where all fractions begin
    most, least = unsafe_shares(family, keep_out)
    assert least - 2.0 / FRACTIONS <= np.mean(near < keep_out) <= most + 2.0 / FRACTIONS
    assert most - least <= 0.03  # where the drift turns round, near and far fractions alternate ever faster


@pytest.mark.parametrize("seed", range(20))
def test_one_drift_has_a_bound_of_its_own(seed: int) -> None:
    random = np.random.default_rng(seed)
    state = random.uniform(-1.0, 1.0, 6) * [200.0, 1000.0, 100.0, 0.2, 0.2, 0.1]
    found = drift_least(state, N, 3e4)
    fine = drift_clearance(state, N, 3e4).distance_m[0]
    assert found.at_least_m is not None
    assert found.at_least_m <= fine <= found.at_least_m + 2.0 * WITHIN_M


def test_what_is_claimed_of_cut_burns_is_a_bound_where_it_is_proved_and_sampled_where_not() -> None:
    programme = ImpulseProgramme([0.0, 900.0], [[-0.1, 0.01, 0.0], [-0.05, 0.02, 0.03]])
    start = np.array([-100.0, -800.0, 20.0, 0.0, 0.1, 0.0])
    motion = ClohessyWiltshire(N)
    cuts = audit_cut_burns(programme, start, motion, 40.0, mean_motion_rad_s=N)
    claim = nearest_claim(cuts, "for all time")
    least = min(min(cut.at_least_m or 0.0, cut.completed_at_least_m or 0.0) for cut in cuts)
    assert (claim.kind, claim.claim) == (Kind.BOUND, f"none comes nearer than {least:.3f} m")
    sampled = audit_cut_burns(programme, start, motion, 40.0, mean_motion_rad_s=N, circular=False)
    assert nearest_claim(sampled, "for an orbit").kind is Kind.SAMPLED
