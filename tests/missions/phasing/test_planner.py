"""Plans of the paper's case: what they cost, that they are optimal, that they fly, and that other solvers agree."""

import sys

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import Agreement, Auditable, Dispersible
from orbsoc.guidance.scp import ExitReason
from orbsoc.guidance.verdict import Question, Word
from orbsoc.interfaces import clarabel
from orbsoc.missions import phasing
from orbsoc.missions.phasing import PlanStatus, ScenarioError, audit, disperse, plan
from orbsoc.missions.phasing.dispersion.replanning import Horizon
from orbsoc.missions.phasing.search.descent import PhasingImpulses, descend

from .cases import planned, scenario


def test_the_least_of_ten_revolutions_is_the_known_one() -> None:
    found = planned()
    assert found.status is PlanStatus.VERIFIED
    assert found.programme is not None
    assert found.programme.total_m_s == pytest.approx(385.3413, abs=0.003)
    known = [(0.6, 159.0, 37.6), (0.7, -112.0, 25.6), (0.3, -48.7, 11.4), (1.4, -57.0, 1.9)]
    assert np.abs(found.programme.dv_m_s - known).max() < 0.1
    assert found.scheme is not None
    assert found.scheme.cost_m_s > 440.0


def test_the_primer_and_the_dual_bound_prove_it_at_every_instant() -> None:
    descended = planned().descended
    assert descended is not None
    last, approach = descended.last, descended.approach
    assert isinstance(last.impulses, PhasingImpulses)
    assert len(approach.times_s) == 181
    sizes = last.impulses.primer_size(last.solution, approach.times_s)
    assert sizes.max() <= 1.0 + 1e-6
    active = np.flatnonzero(np.linalg.norm(descended.roll.dv_m_s, axis=1))
    assert np.abs(sizes[active] - 1.0).max() < 1e-8
    assert last.lower_bound == pytest.approx(descended.roll.cost_m_s, rel=1e-8)


def test_few_instants_are_generated_and_all_of_them_give_the_same() -> None:
    found = planned().descended
    assert found is not None
    assert max(len(row.problem.cones.q) for row in found.outcome.iterations) <= 32
    assert len(found.outcome.iterations) <= 12
    _, solution, dv = Horizon().solve(found.roll, 0)
    assert solution.objective == pytest.approx(found.roll.cost_m_s, rel=1e-6)
    assert np.abs(dv - found.roll.dv_m_s).max() < 1e-2


def test_it_flies_to_the_target_by_another_integrator() -> None:
    flight = planned().verification
    assert flight is not None
    assert flight.miss_m < 1.0
    assert flight.miss_m_s < 1e-3
    assert not flight.failures
    assert flight.distance_m[0] < 1.0


def test_the_papers_timing_and_scheme_cost_what_is_known() -> None:
    timing, design = planned("timing"), planned("design")
    assert timing.status is design.status is PlanStatus.VERIFIED
    assert timing.programme is not None
    assert design.programme is not None
    assert timing.programme.total_m_s == pytest.approx(575.84, abs=0.01)
    assert timing.programme.times_s[0] >= 112536.962 - 900.0 - 1e-3
    assert design.programme.total_m_s == pytest.approx(661.88, abs=0.005)
    radial, along, normal = design.programme.dv_m_s.T
    assert np.abs(radial[0]) < 1e-6
    assert np.allclose([radial[1], along[1], along[2]], [-113.97, 253.43, -312.78], atol=0.01)
    assert np.abs(normal[1]) < 1e-3


def test_the_front_over_revolutions_is_the_known_one() -> None:
    found = planned().analysis
    assert found is not None
    known = {4: 913.7, 6: 633.8, 8: 481.0, 12: 320.3, 14: 273.4}
    assert {each.revolutions: each.least_m_s for each in found.front} == pytest.approx(known, abs=0.05)
    assert all(
        each.scheme_m_s is not None and each.scheme_m_s > known[each.revolutions] for each in found.front
    )


def test_a_small_trust_region_gives_the_same() -> None:
    found = planned().descended
    assert found is not None
    from dataclasses import replace

    from orbsoc.missions.phasing.model.approach import approach_between
    from orbsoc.missions.phasing.search.descent import RULES, spread
    from orbsoc.missions.phasing.search.first_guess import plan_phasing, shoot

    guess = plan_phasing(scenario())
    coarse, roll = shoot(scenario(), guess)
    assert roll is not None
    fine = approach_between(scenario(), guess.start_s, guess.end_s, coarse.times_s)
    start = spread(fine, roll, coarse.times_s)
    assert start is not None
    small = descend(fine, start, solve=orbsoc.solve, rules=replace(RULES, radius=40.0))
    assert small.outcome.reason is ExitReason.CONVERGED
    assert small.roll.cost_m_s == pytest.approx(found.roll.cost_m_s, abs=1e-4)


def test_clarabel_agrees() -> None:
    theirs = plan(scenario(), solve=clarabel.solve)
    assert Agreement.of(planned(), theirs).agrees


def test_an_interrupt_is_a_status() -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    found = plan(scenario(), callback=interrupt)
    assert found.status is PlanStatus.INTERRUPTED
    assert found.verdict.word(Question.ANSWER) is Word.INTERRUPTED


def test_programmes_from_elsewhere_are_judged() -> None:
    assert isinstance(phasing, Auditable)
    programme = planned().programme
    assert programme is not None
    assert audit(scenario(), programme).status is PlanStatus.VERIFIED
    wrong = ImpulseProgramme(programme.times_s, programme.dv_m_s * 1.001)
    found = audit(scenario(), wrong)
    assert found.status is PlanStatus.NOT_VERIFIED
    assert "it breaks meeting, position" in found.verdict.lines[0].figure
    with pytest.raises(ScenarioError, match="must lie within"):
        audit(scenario(), ImpulseProgramme([1.0], [[1.0, 0.0, 0.0]]))


def test_dispersed_cases_are_scenarios() -> None:
    assert isinstance(phasing, Dispersible)
    case = disperse(scenario(), 3, 1)
    assert case == disperse(scenario(), 3, 1)
    assert case.target.true_anomaly_deg != scenario().target.true_anomaly_deg
    assert disperse(scenario(), 0).target == scenario().target


def test_a_descent_whose_bound_stays_open_is_not_called_the_least(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["orbsoc.missions.phasing.plan"], "PROVED", -1.0)
    found = plan(scenario())
    assert found.status is PlanStatus.VERIFIED
    assert found.verdict.word(Question.OPTIMUM) is Word.BEST_FOUND
