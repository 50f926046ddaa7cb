"""Flights of target and chaser about the Earth: the linear limit, the order of impulses, what J2 adds."""

import numpy as np
import pytest

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.relative_flight import TRUTHS, drifts, fly, oblate, two_body
from orbsoc.guidance.safety import states_after
from orbsoc.orbit import EARTH, Elements, state_from_elements
from orbsoc.orbit.relative import ClohessyWiltshire

RATE = 1e-3
ORBIT = Elements((EARTH.mu_m3_s2 / RATE**2) ** (1 / 3), 0.0, 0.8, 0.3, 0.0, 0.5)
TARGET = np.concatenate(state_from_elements(ORBIT))
START = np.array([0.0, -100.0, 20.0, 0.01, 0.0, 0.0])
PROGRAMME = ImpulseProgramme([0.0, 900.0, 2000.0], [[-0.02, 0.0, 0.0], [0.0, 0.01, 0.01], [0.01, 0.01, 0.0]])


@pytest.mark.parametrize("scale", [1.0, 0.1])
def test_a_flight_is_the_linear_one_up_to_the_square_of_the_distance(scale: float) -> None:
    motion = ClohessyWiltshire(RATE)
    programme = ImpulseProgramme(PROGRAMME.times_s, scale * PROGRAMME.dv_m_s)
    times = np.array([0.0, 450.0, 900.0, 1500.0, 3000.0])
    flown = fly(programme, scale * START, TARGET, times, two_body)
    after = states_after(programme, scale * START, motion)
    assert np.abs(flown.after - after)[:, :3].max() < 0.03 * scale**2 + 2e-4
    end = motion.transition(3000.0, 2000.0) @ after[-1]
    assert np.abs(flown.states[-1] - end)[:3].max() < 0.03 * scale**2 + 5e-4


def test_a_state_is_told_before_the_impulse_of_its_time() -> None:
    flown = fly(PROGRAMME, START, TARGET, [0.0, 900.0, 1000.0], two_body)
    assert flown.states[0] == pytest.approx(START, abs=1e-6)
    assert flown.after[0][3:] - START[3:] == pytest.approx(PROGRAMME.dv_m_s[0], abs=1e-9)
    assert flown.after[1] - flown.states[1] == pytest.approx([0, 0, 0, *PROGRAMME.dv_m_s[1]], abs=1e-8)
    assert len(flown.after) == 2  # the third comes later


def test_drifts_go_on_from_the_impulses() -> None:
    for forces in TRUTHS.values():
        flown = fly(PROGRAMME, START, TARGET, [0.0, 2000.0, 2600.0], forces)
        found = drifts(flown.pairs_after, [0.0, 600.0], forces)
        assert found[:, 0] == pytest.approx(flown.after[:, :3], abs=1e-5)
        assert found[2, 1] == pytest.approx(flown.states[-1, :3], abs=1e-3)


def test_oblateness_is_felt() -> None:
    one, two = (fly(PROGRAMME, START, TARGET, [0.0, 3000.0], forces) for forces in (two_body, oblate))
    apart = np.linalg.norm(one.states[-1, :3] - two.states[-1, :3])
    assert 0.01 < apart < 1.0
