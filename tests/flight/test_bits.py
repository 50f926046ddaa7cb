"""The library in C has the bits of the exact engine: every buffer after every stage, and every number of a solution."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from benchmarks.guidance import rendezvous
from benchmarks.recorded import first_insertions
from benchmarks.statistics import portfolio, small_lp
from orbsoc import _core
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight.export import default_settings
from tests.flight.c_library import CSolver, bits, compiled, expected
from tests.solving.restart_problems import RECOVERED, STALLED, STALLING, badly_scaled
from tests.zoo import cases
from tests.zoo.unsolvable import drawn, in_units


def with_rows_to_drop() -> Problem:
    """Absent rows and cones of one dimension beside larger ones: the tables of rows and entries are no identities."""
    random = np.random.default_rng(7)
    G, h = random.normal(size=(14, 4)), np.full(14, 3.0)
    h[[1, 4]] = np.inf
    h[[6, 8, 13]] = 5.0
    return Problem(c=random.normal(size=4), G=G, h=h, cones=Cones(l=5, q=[1, 3, 5]))


def zoo(name: str) -> Callable[[], Problem]:
    return lambda: next(case.problem for case in cases() if case.name == name)


PROBLEMS: dict[str, tuple[Callable[[], Problem], Settings | None]] = {
    "insertion": (lambda: first_insertions(12, 1)[0], None),
    "rendezvous": (lambda: rendezvous(10, 0), None),
    "quadratic": (lambda: portfolio(30, 0), None),
    "condensed": (lambda: small_lp(16, 0, rows=100), None),
    "absent rows": (with_rows_to_drop, None),
    "infeasible": (zoo("socp_disjoint_balls"), None),
    "unbounded, small units": (lambda: in_units(drawn(1)[0], "columns 1e8", 1), None),
    "unbounded, large units": (lambda: in_units(drawn(1)[0], "columns 1e-8", 1), None),
    "infeasible, mixed units": (lambda: in_units(drawn(2)[0], "all mixed", 2), None),
    "restarted": (lambda: badly_scaled(RECOVERED[0]), STALLING),
    "stalled": (lambda: badly_scaled(STALLED), STALLING),
}
UNBOUNDED = Problem(c=[-1.0, 0.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(l=2))

BUFFERS = 4
"""The first buffers are the raw data, which the library reads as given."""


def compare_stages(solver: CSolver, problem: Problem, settings: Settings, iterations: int) -> None:
    """Run both, stage by stage; the first word that differs."""
    engine = _core.ExactEngine(problem, settings, solver.fp)
    words = engine.buffer_words()
    solver.begin()

    def run(stage: str) -> int:
        outcome = engine.run(stage)
        assert solver.run(stage) == outcome, stage
        for number, (name, count) in enumerate(words.items()):
            # A diagonal entry of L is read by nothing once its pivot is known; the engine leaves a partial sum there.
            if number < BUFFERS or name == "factor_l":
                continue
            assert np.array_equal(engine.words(name), solver.words(number, count)), f"{name} after {stage}"
        return outcome

    for steps in [_core.startup()] + [_core.iteration()] * iterations:
        for step in steps:
            while (outcome := run(step[-1])) == _core.REPEAT:
                run(step[0])
            if outcome == _core.DONE:
                return


@pytest.mark.parametrize("fp", [64, 32])
@pytest.mark.parametrize("name", PROBLEMS)
def test_every_word_of_a_solve_is_the_engines(name: str, fp: int, tmp_path: Path) -> None:
    make, given = PROBLEMS[name]
    problem, settings = make(), given or default_settings(fp)
    solver = compiled(tmp_path, problem, settings, fp)
    compare_stages(solver, problem, settings, 3)
    engine = _core.ExactEngine(problem, settings, fp)
    cold = engine.solve()
    assert solver.solve() == expected(cold)
    random = np.random.default_rng(1)
    point = [v * (1.0 + 1e-3 * random.standard_normal(v.size)) for v in (cold.x, cold.y, cold.z, cold.s)]
    point[3] = np.where(np.isinf(point[3]), 1.0, point[3])
    assert solver.solve(point) == expected(engine.solve((point[0], point[1], point[2], point[3])))
    assert solver.solve() == expected(cold), "a solve leaves nothing behind"


@pytest.mark.parametrize(
    ("compiler", "option"), [("gcc", "-O0"), ("gcc", "-O3"), ("clang", "-O0"), ("clang", "-O3")]
)
def test_no_compiler_and_no_optimisation_changes_a_bit(compiler: str, option: str, tmp_path: Path) -> None:
    problem, settings = first_insertions(12, 1)[0], Settings()
    solver = compiled(tmp_path, problem, settings, 64, compiler, option)
    assert solver.solve() == expected(_core.ExactEngine(problem, settings, 64).solve())


def test_fused_instructions_are_not_used_where_the_machine_has_them(tmp_path: Path) -> None:
    problem, settings = rendezvous(10, 0), Settings()
    solver = compiled(tmp_path, problem, settings, 64, "gcc", "-O3", "-mavx2", "-mfma")
    assert solver.solve() == expected(_core.ExactEngine(problem, settings, 64).solve())


def test_an_unbounded_problem_has_the_engines_certificate(tmp_path: Path) -> None:
    found = compiled(tmp_path, UNBOUNDED, Settings(), 64).solve()
    assert found["status"] == "DUAL_INFEASIBLE"
    assert found == expected(_core.ExactEngine(UNBOUNDED, Settings(), 64).solve())


def test_other_numbers_in_the_pattern_are_solved_as_by_a_fresh_engine(tmp_path: Path) -> None:
    first, second = first_insertions(12, 2)
    solver = compiled(tmp_path, first, Settings(), 64)
    solver.solve()
    solver.set(second)
    assert solver.solve() == expected(_core.ExactEngine(second, Settings(), 64).solve())


def test_no_restart_is_made_where_none_is_allowed(tmp_path: Path) -> None:
    settings = Settings(static_regularization=1e-2, refinement_share=30.0, max_restarts=0)
    problem = badly_scaled(STALLED)
    found = compiled(tmp_path, problem, settings, 64).solve()
    assert found["attempts"] == 1
    assert found == expected(_core.ExactEngine(problem, settings, 64).solve())


def test_nan_counts_as_one_number_in_comparisons() -> None:
    assert bits(np.array([np.nan, -np.nan]))[0] == bits(np.array([np.nan, -np.nan]))[1]
