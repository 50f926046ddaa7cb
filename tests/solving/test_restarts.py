"""A solve attempt that stalls is followed by a restart from cold, with ten times the accuracy of the linear solves.

One that stalls then, far from a solution, is restarted with ten times the regularisation, too; one that stalls on an
infeasibility certificate, or after all that, with a hundredth of it. The best outcome counts.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

import orbsoc
from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.segments import Method
from tests.solving.restart_problems import (
    RECOVERED,
    STALLED,
    STALLING,
    STALLING_LIGHT,
    STALLING_REFINED,
    STALLING_REGULARIZED,
    WEAK,
    WEAK_REGULARIZED,
    badly_scaled,
    columns_apart,
    recovered_at_third_attempt,
    unstable_dynamics,
)


def attempts(problem: Problem, settings: Settings) -> list[orbsoc.Solution]:
    """The outcome after each solve attempt."""
    method, native = Method.from_core(_core), _core.Engine(problem, settings)
    pl = ProgrammableLogic(method, native.run)
    driver = Driver(method, native, pl, words=native.buffer_words(), record=PsRecord())
    found = []

    def restart() -> bool:
        found.append(orbsoc.solving.solver.solution_of(native.finish()))
        return native.begin_again()

    driver.run(restart=restart)
    return found


def bits(solution: orbsoc.Solution) -> list[bytes]:
    return [getattr(solution, name).tobytes() for name in "xyzs"]


def worst(solution: orbsoc.Solution) -> float:
    found = solution.certificate
    return max(found.primal_residual, found.dual_residual, found.gap)


@pytest.mark.parametrize("seed", RECOVERED)
def test_the_first_restart_is_an_attempt_with_a_tenth_of_the_refinement_share(seed: int) -> None:
    problem = badly_scaled(seed)
    first, last = attempts(problem, STALLING)
    solution = orbsoc.solve(problem, STALLING)
    careful = orbsoc.solve(problem, STALLING_REFINED)
    assert first.status in (orbsoc.Status.NUMERICAL_LIMIT, orbsoc.Status.SOLVED_INACCURATE)
    assert solution.status is careful.status is orbsoc.Status.SOLVED
    assert bits(solution) == bits(careful) == bits(last)
    assert solution.iterations == first.iterations + careful.iterations
    assert solution.refinements == first.refinements + careful.refinements


def test_the_second_restart_has_ten_times_the_regularisation() -> None:
    problem = recovered_at_third_attempt()
    _, second, last = attempts(problem, WEAK)
    solution, firm = orbsoc.solve(problem, WEAK), orbsoc.solve(problem, WEAK_REGULARIZED)
    assert second.status is orbsoc.Status.NUMERICAL_LIMIT
    assert solution.status is firm.status is orbsoc.Status.SOLVED
    assert bits(solution) == bits(firm) == bits(last)
    assert solution.iterations == second.iterations + firm.iterations
    assert solution.refinements == second.refinements + firm.refinements


def test_the_best_of_four_stalled_attempts_counts() -> None:
    problem = badly_scaled(STALLED)
    *_, last = attempts(problem, STALLING)
    solution = orbsoc.solve(problem, STALLING)
    levels = (STALLING, STALLING_REFINED, STALLING_REGULARIZED, STALLING_LIGHT)
    alone = [attempts(problem, settings)[0] for settings in levels]
    best = min(alone, key=worst)
    assert len({worst(found) for found in alone}) == 4
    assert bits(solution) == bits(best)
    assert worst(solution) == worst(last) == worst(best)
    assert solution.status is best.status is orbsoc.Status.SOLVED_INACCURATE
    assert solution.iterations == sum(found.iterations for found in alone)


@pytest.mark.parametrize("smaller", [1e-5, 1e-6])
def test_columns_of_very_different_sizes_beside_an_equality_row(smaller: float) -> None:
    """What the elimination of y rounds off hides the regularisation of x; the problem is solved nevertheless, also in a batch."""
    problems = [columns_apart(seed, smaller) for seed in range(10)]
    alone = [orbsoc.solve(problem) for problem in problems]
    stacked = {name: np.array([getattr(p, name) for p in problems]) for name in "cbh"}
    stacked |= {name: np.array([getattr(p, name).data for p in problems]) for name in "AG"}
    batch = orbsoc.solve_batch(problems[0], **stacked)
    assert [solution.status for solution in alone] == [orbsoc.Status.SOLVED] * len(problems)
    assert any(len(attempts(problem, Settings())) == 3 for problem in problems)
    for k, (problem, solution) in enumerate(zip(problems, alone, strict=True)):
        wanted = linprog(
            problem.c, problem.G.toarray(), problem.h, problem.A.toarray(), problem.b, bounds=(None, None)
        )
        assert solution.objective == pytest.approx(wanted.fun, rel=1e-6, abs=1e-6)
        assert batch.x[k].tobytes() == solution.x.tobytes()
        assert batch.iterations[k] == solution.iterations


@pytest.mark.parametrize("seed", [606, 3769, 4765, 5013, 5037])
def test_a_stall_on_a_certificate_is_restarted_with_a_hundredth_of_the_regularisation(seed: int) -> None:
    problem = unstable_dynamics(seed)
    *earlier, last = attempts(problem, Settings())
    solution = orbsoc.solve(problem)
    light = attempts(problem, Settings(static_regularization=1e-10, refinement_share=0.1 * 0.03))[0]
    assert earlier[-1].status is orbsoc.Status.PRIMAL_INFEASIBLE
    assert solution.status is light.status
    assert solution.status in (orbsoc.Status.SOLVED, orbsoc.Status.SOLVED_INACCURATE)
    assert np.abs(solution.x).max() >= earlier[-1].certificate.radius
    assert bits(solution) == bits(light) == bits(last)
    assert solution.iterations == earlier[-1].iterations + light.iterations
    assert orbsoc.verify(problem, solution).worst < 1e-5


def test_without_a_finite_iterate_the_message_says_so() -> None:
    none = Settings(static_regularization=1e-300, dynamic_regularization=1e-300, pivot_floor=1e-300)
    found = orbsoc.solve(columns_apart(1, 1e-6), none)
    assert found.status is orbsoc.Status.NUMERICAL_LIMIT
    assert np.isnan(found.x).all()
    assert found.message.startswith("no iterate (x is NaN)")


def test_every_way_to_solve_restarts() -> None:
    """A batch, row by row; the scheduler; a solver after another problem."""
    seeds = (*RECOVERED, 1, STALLED)
    problems = [badly_scaled(seed) for seed in seeds]
    stacked = {name: np.array([getattr(p, name) for p in problems]) for name in "cbh"}
    stacked |= {name: np.array([getattr(p, name).data for p in problems]) for name in "AG"}
    repeated = {name: np.tile(rows, (5, 1)) for name, rows in stacked.items()}
    many = orbsoc.solve_batch(problems[0], **repeated, settings=STALLING, threads=2)
    batch = orbsoc.solve_batch(problems[0], **stacked, settings=STALLING)
    assert many.x.tobytes() == np.tile(batch.x, (5, 1)).tobytes()
    assert many.message == batch.message * 5
    solver = orbsoc.Solver(problems[0], STALLING)
    for k, problem in enumerate(problems):
        solver.update(**{name: getattr(problem, name) for name in "cbhAG"})
        alone = orbsoc.solve(problem, STALLING)
        for found in (solver.solve(), orbsoc.PsScheduler(STALLING)(problem)):
            assert (found.status, found.message) == (alone.status, alone.message)
            assert (found.iterations, found.refinements) == (alone.iterations, alone.refinements)
            assert found.x.tobytes() == alone.x.tobytes()
        assert (batch.status[k], batch.message[k]) == (alone.status, alone.message)
        assert (batch.iterations[k], batch.refinements[k]) == (alone.iterations, alone.refinements)
        assert batch.x[k].tobytes() == alone.x.tobytes()
    assert batch.status[3] is orbsoc.Status.SOLVED
    assert batch.iterations[3] < batch.iterations[:3].min(), "one that does not stall has one attempt"


def test_a_solve_stopped_in_its_restart_returns_the_better_iterate() -> None:
    problem = badly_scaled(RECOVERED[2])
    first, _ = attempts(problem, STALLING)
    stopped = orbsoc.solve(problem, STALLING, callback=lambda at: at["iteration"] > first.iterations + 1)
    assert stopped.status is orbsoc.Status.INTERRUPTED
    assert stopped.x.tobytes() == first.x.tobytes()
    assert stopped.message.startswith("stopped in a restart; the attempt before: best iterate returned")
    assert stopped.iterations > first.iterations


def test_a_warm_start_that_fails_is_followed_by_a_cold_start_and_a_restart() -> None:
    problem = badly_scaled(RECOVERED[0])
    cold = orbsoc.solve(problem, STALLING)
    far = orbsoc.Start(x=cold.x + 1e3, y=cold.y, z=cold.z + 1e3, s=cold.s + 1e3)
    warm = orbsoc.solve(problem, STALLING, warm_start=far)
    rows = {"c": np.tile(problem.c, (11, 1))}
    batch = orbsoc.solve_batch(problem, **rows, settings=STALLING, warm_start=far)
    assert (warm.warm_start, warm.status) == ("fell_back", orbsoc.Status.SOLVED)
    assert warm.iterations >= cold.iterations
    assert warm.x.tobytes() == cold.x.tobytes()
    assert (batch.x == warm.x).all()
    assert batch.iterations.tolist() == [warm.iterations] * 11


def test_a_row_that_waits_for_its_restart_does_not_run_out_of_time() -> None:
    """It waits until the others, which do not stall, have been solved."""
    stalls, easy = badly_scaled(RECOVERED[0]), badly_scaled(1)
    count = 60_000
    rows = {name: np.tile(getattr(easy, name), (count, 1)) for name in "cbh"}
    rows |= {name: np.tile(getattr(easy, name).data, (count, 1)) for name in "AG"}
    for name in "cbh":
        rows[name][0] = getattr(stalls, name)
    for name in "AG":
        rows[name][0] = getattr(stalls, name).data
    unlimited = orbsoc.solve_batch(easy, **rows, settings=STALLING)
    limited = replace(STALLING, max_time_s=unlimited.solve_s / 5.0)
    batch = orbsoc.solve_batch(easy, **rows, settings=limited)
    assert batch.solve_s > 2 * limited.max_time_s
    assert batch.status[0] is orbsoc.Status.SOLVED, batch.message[0]
