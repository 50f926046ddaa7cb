"""Narrow datapaths: they reach what they can, say when they do not, and never claim more."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import orbsoc
from hw_model import speedup
from hw_model.platform.partition import on_pl
from orbsoc import Problem, Settings
from orbsoc.hw.precision import BITS, narrow_settings, solve_narrow
from orbsoc.missions.reachable_insertion import load_scenario, plan
from tests.hw.rendezvous_lp import rendezvous_lp

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
REC1 = SCENARIOS / "rec1.toml"
RENDEZVOUS = SCENARIOS / "rendezvous_lp.json"
ALL = ("matrix_update", "matrix_scaling", "factorization", "linear_solve", "cone_ops", "line_search")
ASKED = Settings(tol=1e-6)


@cache
def mission_004() -> Problem:
    return plan(load_scenario(REC1)).subproblems[0].problem


PROBLEMS = {"mission 004": mission_004, "rendezvous": rendezvous_lp}


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_single_precision_factor_refined_in_double_reaches_1e_6(name: str) -> None:
    problem = PROBLEMS[name]()
    wide, narrow = (solve_narrow(problem, bits, ("factorization",), ASKED) for bits in (53, 24))
    assert narrow.solution.status is orbsoc.Status.SOLVED
    assert narrow.worst <= 1e-6
    assert narrow.solution.refinements > wide.solution.refinements  # the price
    assert abs(narrow.solution.iterations - wide.solution.iterations) <= 3
    # A residual of 1e-6 is worth its multiplier in the objective, and slack weighs 100 in mission 004.
    assert narrow.solution.objective == pytest.approx(wide.solution.objective, abs=1e-4)


def test_the_rendezvous_that_comes_as_a_file_is_the_one_tested() -> None:
    made, filed = rendezvous_lp(), Problem.load(RENDEZVOUS)
    assert made.cones == filed.cones
    for ours, theirs in ((made.c, filed.c), (made.b, filed.b), (made.A.data, filed.A.data)):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-15)


def test_fifty_three_bits_are_the_solver_itself() -> None:
    problem = mission_004()
    assert (
        solve_narrow(problem, 53, ALL, ASKED).solution.x.tobytes() == orbsoc.solve(problem, ASKED).x.tobytes()
    )


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("bits", BITS)
@pytest.mark.parametrize("modules", [ALL, ("factorization", "linear_solve"), ("cone_ops",)], ids="+".join)
def test_what_a_narrow_datapath_claims_the_referee_confirms(
    name: str, bits: int, modules: tuple[str, ...]
) -> None:
    run = solve_narrow(PROBLEMS[name](), bits, modules, ASKED)
    limit = {"SOLVED": 1e-6, "SOLVED_INACCURATE": ASKED.tol_inaccurate}.get(run.solution.status.name)
    if limit is None:
        assert run.solution.message  # says what is wrong
    else:
        assert run.worst <= limit * (1 + 1e-9)


def test_everything_in_single_precision_does_not_reach_1e_6_on_mission_004_and_says_so() -> None:
    run = solve_narrow(mission_004(), 24, ALL, ASKED)
    assert run.solution.status is not orbsoc.Status.SOLVED
    # By the strict formula, that is, with the slack that the narrow words hold; h − Gx may be nearer to the cone.
    found = run.solution.certificate
    assert max(found.primal_residual, found.dual_residual, found.gap) > 1e-6
    assert "residual" in run.solution.message


def test_the_record_is_priced_with_single_precision_units_on_the_pl_and_double_on_the_ps() -> None:
    wide, narrow = (solve_narrow(mission_004(), bits, ("factorization",), ASKED) for bits in (53, 24))
    assert (narrow.trace["datapath"], narrow.trace["ps_datapath"]) == ("f32", "f64")
    split = on_pl("factorization")
    reports = [speedup(run.trace, "zu9eg", split) for run in (wide, narrow)]
    each = [{row.stage: row.cycles_each for row in report.stages} for report in reports]
    assert each[1]["factorize"] < each[0]["factorize"]  # the divider is faster
    assert each[1]["statistics"] == each[0]["statistics"]  # the PS computes in binary64 all the same
    sizes = [{row.buffer: row.size_bytes for row in report.copies} for report in reports]
    assert sizes[1]["kkt_values"] * 2 == sizes[0]["kkt_values"]


def test_regularisation_follows_the_bits_and_leaves_binary64_alone() -> None:
    shifts = [narrow_settings(ASKED, bits).static_regularization for bits in BITS]
    assert shifts == sorted(shifts)
    assert narrow_settings(ASKED, 53) is ASKED
    assert all(narrow_settings(ASKED, bits).tol == ASKED.tol for bits in BITS)


def test_what_does_not_exist_is_refused() -> None:
    with pytest.raises(
        ValueError, match="bits = 17: there is no such arithmetic; allowed: 53, 24, 20, 16, 12"
    ):
        solve_narrow(rendezvous_lp(), 17, ALL)
    with pytest.raises(ValueError, match='no module named "warp"; modules are cone_ops, factorization'):
        solve_narrow(rendezvous_lp(), 24, ("warp",))
