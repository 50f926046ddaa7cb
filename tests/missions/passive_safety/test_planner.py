"""Plans: verified by other integrators, told from every side, written for other programs, audited from a file."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import orbsoc
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.mission import DOCUMENT_KEYS, Auditable, Dispersible, Mission, PlanStatus
from orbsoc.guidance.safety import FRACTIONS
from orbsoc.guidance.scenario_file import ScenarioError
from orbsoc.guidance.verdict import Question, Word
from orbsoc.missions import passive_safety
from orbsoc.missions.passive_safety.model.problem import assemble
from orbsoc.missions.passive_safety.plan import Plan, audit, plan
from orbsoc.missions.passive_safety.planner import plan_unflown
from orbsoc.missions.passive_safety.search.timing import usable
from orbsoc.missions.registry import MISSIONS
from tests.missions.passive_safety.cases import CASES, Case

SCENARIOS = Path(__file__).resolve().parents[3] / "scenarios"


@pytest.fixture(scope="module")
def rows() -> list[Plan]:
    """Of all sixteen rows: four impulses, exact cones, 2-norms."""
    return [plan(case.scenario()) for case in CASES]


def lines(found: Plan) -> list[str]:
    """Of the verdict, each on one line with single blanks."""
    return [" ".join(str(line).split()) for line in found.verdict.lines]


def test_the_module_is_a_mission_with_every_optional_part() -> None:
    for protocol in (Mission, Dispersible, Auditable):
        assert isinstance(MISSIONS["passive_safety"], protocol)


def test_every_row_is_verified_by_integrators_that_the_optimiser_does_not_use(rows: list[Plan]) -> None:
    for found in rows:
        assert found.status is PlanStatus.VERIFIED, found.to_dict()["details"]
        assert found.safe
        assert found.verification is not None
        assert found.verification.terminal_position_m < 1e-3


def test_completed_burns_are_safe_but_burn_2_is_not_where_it_stops_inside(rows: list[Plan]) -> None:
    """Burns 3 and 4 are safe at every fraction; burn 2 comes within 0.1 to 12 m in 16 of 16 rows, at some hundredths."""
    for case, found in zip(CASES, rows, strict=True):
        assert found.verification is not None
        one, two, *later = found.verification.cuts
        on_grid = two.by_fraction_m.min()
        assert 0.0 < on_grid < 12.1
        assert 0.07 < two.unsafe_share < 1.0
        assert two.distance_m <= on_grid
        for cut in later:
            assert cut.unsafe_share == 0.0
            assert cut.distance_m > found.scenario.keep_out_m - 1e-3
        if case.condition == "short":
            assert one.unsafe_share == 0.0
        else:
            worst = one.by_fraction_m.argmin() / (FRACTIONS - 1)
            assert 0.80 <= worst <= 0.99
            assert one.by_fraction_m.min() < 9.1
    assert max(found.verification.cuts[1].unsafe_share for found in rows if found.verification) > 0.975
    assert not any(found.safe_when_cut for found in rows)


def test_flights_about_the_earth_differ_by_what_is_known(rows: list[Plan]) -> None:
    """Fitted −1000/3600/1: 41.01 m and 1.4 m by two bodies, 37.8 m and 3.0 m with J2; later drifts 38.5 to 38.7 m."""
    found = rows[0].verification
    assert found is not None
    two_body, j2, drag = found.truths
    assert (two_body.first_range_m, two_body.capture_miss_m) == pytest.approx((41.01, 1.39), abs=0.02)
    assert (j2.first_range_m, j2.capture_miss_m) == pytest.approx((37.78, 2.97), abs=0.03)
    assert j2.least_depth_m == pytest.approx(38.5, abs=0.1)
    assert drag.capture_miss_m == pytest.approx(j2.capture_miss_m, abs=0.1)


@pytest.mark.parametrize(
    ("case", "duration_s", "orbits", "cost"),
    [
        (2, 4200.0, 0, 0.2570),
        (2, 4200.0, 1, 0.4258),
        (2, 4200.0, 2, 0.6037),
        (2, 6000.0, 1, 0.1104),
        (2, 6000.0, 2, 0.1331),
        (4, 6000.0, 1, 0.1963),
        (4, 6000.0, 2, 0.2207),
    ],
)
def test_safety_under_interrupted_burns_costs_what_is_known_on_the_same_grid(
    case: int, duration_s: float, orbits: int, cost: float
) -> None:
    base = CASES[case]
    row = Case(base.fitted, base.start_m, duration_s, "short", 0, 0, 0, 0, 0)
    approach = row.approach(impulses={"timing": "generated"}, interruption_orbits=orbits)
    costs = []
    for second in np.arange(400.0, 1700.0, 100.0):
        times = np.concatenate([[0.0], np.arange(second, duration_s, 100.0)])
        solution = orbsoc.solve(assemble(approach, times).builder.build())
        costs.append(solution.objective if usable(solution) else np.inf)
    assert min(costs) == pytest.approx(cost, abs=2e-4)


def test_an_interruption_safe_plan_is_safe_wherever_a_burn_stops_and_cheaper_than_a_grid() -> None:
    found = plan_unflown(CASES[2].scenario(impulses={"timing": "generated"}, interruption_orbits=1))
    assert found.programme is not None
    assert found.cost < 0.4258
    judged = audit(found.scenario, found.programme)
    assert judged.status is PlanStatus.VERIFIED
    assert judged.verification is not None
    assert min(cut.distance_m for cut in judged.verification.cuts_within_orbits) > 39.99
    assert re.search(
        r"Safety PARTLY 40\.\d\d m for 1 orbit after any cut \(allowed ≥ 40 m\); later 0", lines(judged)[-1]
    )
    assert len(found.programme) <= 8
    impossible = plan_unflown(CASES[10].scenario(impulses={"timing": "generated"}, interruption_orbits=2))
    assert impossible.status is PlanStatus.NOT_FOUND  # 48 times of impulse 2 are no proof
    assert "drift 2 stays short" in impossible.message


@pytest.mark.parametrize(
    ("ecc", "depth", "miss"), [(1e-3, 38.8, 1.4), (1e-2, 29.5, 24.9), (2e-2, 19.2, 50.7)]
)
def test_the_circular_model_is_refused_where_it_breaks_the_keep_out(
    ecc: float, depth: float, miss: float
) -> None:
    target = {"mean_motion_rad_s": 1e-3, "eccentricity": ecc, "true_anomaly_deg": 180.0, "motion": "circular"}
    scenario = CASES[2].scenario(target=target)
    if ecc < 5e-3:
        found = plan(scenario)
        assert found.verification is not None
        truth = found.verification.truths[0]
        assert (truth.least_depth_m, truth.capture_miss_m) == pytest.approx((depth, miss), abs=0.05)
        return
    with pytest.raises(ScenarioError) as caught:
        plan(scenario)
    assert f"passes at {depth:.1f} m (keep_out_m = 40)" in str(caught.value)
    assert f"misses the capture point by {miss:.1f} m; must be 'elliptic'" in str(caught.value)


def test_the_elliptic_plan_holds_by_true_motion() -> None:
    """e = 0.01 from the apogee: 39.7 m, 1.8 m, 0.2702 m/s."""
    scenario = passive_safety.load_scenario(SCENARIOS / "paper000_elliptic.toml")
    found = plan(scenario)
    assert found.status is PlanStatus.VERIFIED
    assert found.cost == pytest.approx(0.2702, abs=2e-4)
    assert found.verification is not None
    truth = found.verification.truths[0]
    assert (truth.least_depth_m, truth.capture_miss_m) == pytest.approx((39.7, 1.8), abs=0.3)
    assert lines(found)[-1] == (
        "Safety PARTLY 40.40 m after burn 1 in an orbit (allowed ≥ 40 m); burn 2 cut short 0.1 m, with J2 38.6 m"
    )


def test_a_plan_is_a_document_tables_and_figures(rows: list[Plan], tmp_path: Path) -> None:
    found = rows[2]
    document = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert {*DOCUMENT_KEYS} <= {*document}
    assert {"delta_v_m_s", "cost", "impulses", "terminal_error", "constraints", "audits", "certificates"} <= {
        *document
    }
    answer, optimum, safety = lines(found)
    assert answer.startswith("Answer VERIFIED 0.2888 m/s in 3 of 4 impulses, the rest zero; flown ")
    assert optimum == "Optimum PROVED impulses at these times cost at least 0.288773 m/s"
    assert re.fullmatch(
        r"Safety PARTLY 45\.35 m after burn [34] \(allowed ≥ 40 m\); burn 2 cut short 0\.0 m, with J2 38\.7 m",
        safety,
    )
    assert document["certificates"]["optimum"]["gap"] == pytest.approx(0.0, abs=1e-7)
    assert document["audits"]["cut_burns"]["number"] == 2
    assert all(row["margin"] > -0.01 for row in document["constraints"])
    again = ImpulseProgramme.from_csv(found.tables()["impulses.csv"])
    assert found.programme is not None
    assert np.array_equal(again.dv_m_s, found.programme.dv_m_s)
    names = [figure.name for figure in found.figures(tmp_path)]
    assert names == ["approach.png", "margins.png", "cut_burns.png", "primer.png"]
    assert all((tmp_path / name).stat().st_size > 10_000 for name in names)


def test_messages_are_read_back_by_an_independent_reader(rows: list[Plan], tmp_path: Path) -> None:
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io", reason="the independent reader is not installed").NdmIo
    for name, text in rows[2].tables().items():
        (tmp_path / name).write_text(text)
    ephemeris = ndm_io().from_path(tmp_path / "chaser.oem")
    segment = ephemeris.body.segment[0]
    assert segment.metadata.ref_frame == "SCENARIO_ECI"
    assert len(segment.data.state_vector) == 121
    state = segment.data.state_vector[0]
    first = [float(getattr(state, name).value) for name in ("x", "y", "z", "x_dot", "y_dot", "z_dot")]
    assert np.linalg.norm(first[:3]) == pytest.approx(7359.4590, abs=1e-2)
    message = ndm_io().from_path(tmp_path / "chaser.opm").body.segment.data
    burns = message.maneuver_parameters
    programme = rows[2].programme
    assert programme is not None
    sizes = [
        1e3 * np.linalg.norm([float(getattr(each, f"man_dv_{k}").value) for k in (1, 2, 3)]) for each in burns
    ]
    assert sizes == pytest.approx(programme.sizes_m_s, abs=1e-9)


def test_a_programme_of_another_planner_is_judged_alike(rows: list[Plan]) -> None:
    found = rows[0]
    assert found.programme is not None
    same = audit(found.scenario, found.programme)
    assert same.status is PlanStatus.VERIFIED
    assert same.subproblems == ()
    assert same.to_dict()["audits"] == found.to_dict()["audits"]
    wrong = ImpulseProgramme(found.programme.times_s, 0.9 * found.programme.dv_m_s)
    broken = audit(found.scenario, wrong)
    assert broken.status is PlanStatus.NOT_VERIFIED
    assert "NOT VERIFIED capture is broken by" in str(broken.verdict)
    assert not broken.verdict.succeeded
    late = ImpulseProgramme([0.0, 4000.0], [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
    with pytest.raises(ScenarioError, match=r"time_s = 4000: must lie within 0 and duration_s = 3600"):
        audit(found.scenario, late)


def test_a_drift_that_enters_the_keep_out_is_not_safe_and_not_verified(rows: list[Plan]) -> None:
    """Of a programme whose last impulses are turned about: one word a question, and the worst rules the exit code."""
    found = rows[0]
    assert found.programme is not None
    turned = found.programme.dv_m_s.copy()
    turned[2:] *= -1.0
    judged = audit(found.scenario, ImpulseProgramme(found.programme.times_s, turned))
    assert judged.verdict.word(Question.SAFETY) is Word.NOT_SAFE
    assert judged.verdict.word(Question.ANSWER) is Word.NOT_VERIFIED
    assert not judged.verdict.succeeded


def test_safe_between_samples_is_partly_where_samples_were_asked_for() -> None:
    """39.98 m of 40 m between the 36 samples: as asked, and not for all time."""
    sampled = plan(passive_safety.load_scenario(SCENARIOS / "paper000_1.toml"))
    assert sampled.status is PlanStatus.VERIFIED
    assert lines(sampled)[2] == (
        "Safety PARTLY 39.98 m after burn 3 (allowed ≥ 40 m at samples); burn 2 cut short 0.0 m, with J2 37.8 m"
    )
    for_all_time = audit(sampled.scenario.with_changes(safety="cone", samples=None), _programme(sampled))
    assert for_all_time.verdict.word(Question.SAFETY) is Word.NOT_SAFE
    assert for_all_time.status is PlanStatus.NOT_VERIFIED


def _programme(found: Plan) -> ImpulseProgramme:
    assert found.programme is not None
    return found.programme


def test_infeasible_and_interrupted_are_statuses() -> None:
    none = plan(CASES[0].scenario(impulses={"count": 2}))
    assert none.status is PlanStatus.INFEASIBLE
    assert str(none.verdict).startswith("Answer   INFEASIBLE   ")
    assert none.tables() == {}

    def stopped(*_: object) -> orbsoc.Solution:
        raise KeyboardInterrupt

    assert plan(CASES[0].scenario(), solve=stopped).status is PlanStatus.INTERRUPTED


def test_clarabel_plans_the_same(rows: list[Plan]) -> None:
    from orbsoc.interfaces.clarabel import solve

    for case, found in zip(CASES[::4], rows[::4], strict=True):
        other = plan_unflown(case.scenario(), solve=solve)
        for difference in found.differences(other):
            assert difference.value <= difference.limit, difference


def test_a_programme_that_leaves_the_plane_or_passes_the_target_is_found_out(rows: list[Plan]) -> None:
    found = rows[2]
    assert found.programme is not None
    dv = found.programme.dv_m_s.copy()
    dv[2, 2] = 0.01
    aside = audit(found.scenario, ImpulseProgramme(found.programme.times_s, dv))
    assert aside.verification is not None
    assert aside.verification.terminal_position_m > 3.0
    assert aside.status is PlanStatus.NOT_VERIFIED
    drifting = CASES[2].scenario(condition="none", start={"x_m": -100.0, "vz_m_s": 0.025})
    late = audit(drifting, ImpulseProgramme([3500.0, 3800.0], [[0.0, 0.01, 0.0], [0.0, 0.01, 0.0]]))
    assert any(words.startswith("approach is broken by") for words in late.verification.failures)  # type: ignore[union-attr]


def test_a_drift_that_leads_there_needs_no_first_impulse() -> None:
    """From the state that a planned first impulse leaves, what is left is planned."""
    short = CASES[2]
    planned = plan_unflown(short.scenario(impulses={"timing": "free"}))
    assert planned.programme is not None
    dv = planned.programme.dv_m_s[0]
    start = {"x_m": -1000.0, "vx_m_s": float(dv[1]), "vz_m_s": float(-dv[0])}
    found = plan(short.scenario(condition="none", start=start, impulses={"timing": "generated"}))
    assert found.status is PlanStatus.VERIFIED
    assert found.programme is not None
    assert found.cost <= planned.programme.sizes_m_s[1:].sum() + 1e-4


@pytest.mark.parametrize("timing", ["equal", "free", "generated"])
def test_a_velocity_at_the_end_is_matched(timing: str) -> None:
    scenario = CASES[3].scenario(
        capture={"x_m": 0.0, "z_m": 60.0, "vx_m_s": 0.09}, impulses={"timing": timing}, condition="none"
    )
    found = plan(scenario)
    assert found.status is PlanStatus.VERIFIED
    assert found.programme is not None
    assert found.programme.times_s[-1] == scenario.duration_s
    assert found.to_dict()["terminal_error"]["velocity_m_s"] < 1e-6
