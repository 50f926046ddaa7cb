"""The sequential-convex loop on a problem small enough to follow by hand, with a solver made of arithmetic."""

from __future__ import annotations

import signal
from typing import Any

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Certificate, Solution, Status
from orbsoc.guidance.scp import ExitReason, Iteration, Rules, Solve, Step, Subproblem, sequential_convex
from orbsoc.interfaces.clarabel import solve as clarabel
from orbsoc.ps.driver import Driver

PROBLEM = Problem(c=[1.0], A=[[1.0]], b=[0.0])


def answer(
    x: float = 0.0, status: Status = Status.SOLVED, residual: float = 1e-12, message: str = ""
) -> Solution:
    return Solution(
        status=status,
        x=np.array([x]),
        y=np.zeros(1),
        z=np.zeros(0),
        s=np.zeros(0),
        objective=0.0,
        dual_objective=0.0,
        iterations=3,
        refinements=0,
        setup_s=0.0,
        solve_s=0.0,
        certificate=Certificate(residual, residual, residual, float("nan")),
        message=message,
        nnz_kkt=1,
        nnz_l=1,
    )


class Scripted:
    """A solver that answers from a list, and remembers the tolerances it was asked for."""

    def __init__(self, *answers: Solution | BaseException) -> None:
        self.answers = list(answers)
        self.tolerances: list[float] = []

    def __call__(self, _problem: Problem, settings: Settings | None = None) -> Solution:
        assert settings is not None
        self.tolerances.append(settings.tol)
        found = self.answers.pop(0)
        if isinstance(found, BaseException):
            raise found
        return found


def follow(slack: float = 0.0):
    """Linearisation whose next reference is the solver's x."""

    def linearise(reference: float) -> Subproblem[float]:
        def read(solution: Solution) -> Step[float]:
            x = float(solution.x[0])
            return Step(x, abs(x - reference), slack, {"x": x})

        return Subproblem(PROBLEM, read)

    return linearise


def newton_on_square_root(target: float, *, bounded: bool = False):
    """Linearise x² = target about the reference: 2x̂x = x̂² + target. Converges quadratically to √target.

    `bounded` adds 0 ≤ x ≤ 10, without which one linear solve is the whole interior-point method.
    """

    def linearise(reference: float) -> Subproblem[float]:
        builder = ConicBuilder()
        x = builder.variable("x", 1)
        if bounded:
            builder.nonnegative([(x, [[-1.0], [1.0]])], [0.0, 10.0])
        builder.equality([(x, [[2.0 * reference]])], [reference**2 + target])

        def read(solution: Solution) -> Step[float]:
            found = float(builder.value(solution, "x")[0])
            return Step(found, abs(found - reference), 0.0, {"x": found})

        return Subproblem(builder.build(), read)

    return linearise


def test_newtons_method_is_a_sequence_of_convex_problems() -> None:
    outcome = sequential_convex(3.0, newton_on_square_root(2.0), solve=clarabel)
    assert outcome.reason is ExitReason.CONVERGED
    assert outcome.iterate == pytest.approx(2.0**0.5, abs=1e-10)
    # 3 → 11/6 → 1.462 → 1.4150 → 1.4142137 → 1.41421356: a change below 1e-7 in the sixth step
    assert [row.number for row in outcome.iterations] == [1, 2, 3, 4, 5, 6]
    assert outcome.iterations[0].change == pytest.approx(7.0 / 6.0, abs=1e-7)


def test_tolerance_tightens_once_the_change_is_small_and_only_tight_solves_converge() -> None:
    solve = Scripted(answer(1.0), answer(1.0 + 1e-9), answer(1.0 + 1e-9))
    outcome = sequential_convex(0.0, follow(), solve=solve)
    assert solve.tolerances == [1e-8, 1e-8, 1e-10]
    assert outcome.reason is ExitReason.CONVERGED
    assert len(outcome.iterations) == 3


def test_slack_left_at_convergence_is_infeasible_and_between_the_limits_goes_on() -> None:
    rules = Rules(max_iterations=4)
    still = [answer(1.0) for _ in range(4)]
    assert sequential_convex(1.0, follow(2e-6), solve=Scripted(*still), rules=rules).reason is (
        ExitReason.INFEASIBLE
    )
    outcome = sequential_convex(1.0, follow(5e-7), solve=Scripted(*still), rules=rules)
    assert outcome.reason is ExitReason.MAX_ITERATIONS
    assert "slack 5.0e-07 (needs < 1e-07)" in outcome.message


@pytest.mark.parametrize(
    ("last", "reason"),
    [
        (answer(status=Status.PRIMAL_INFEASIBLE, message="radius 1e9"), ExitReason.SUBPROBLEM_INFEASIBLE),
        (answer(status=Status.DUAL_INFEASIBLE), ExitReason.SUBPROBLEM_FAILED),
        (answer(status=Status.MAX_TIME), ExitReason.SUBPROBLEM_FAILED),
        (answer(status=Status.NUMERICAL_LIMIT, residual=1e-3), ExitReason.SUBPROBLEM_FAILED),
        (answer(status=Status.NUMERICAL_LIMIT, residual=float("nan")), ExitReason.SUBPROBLEM_FAILED),
        (answer(status=Status.INTERRUPTED), ExitReason.INTERRUPTED),
    ],
)
def test_a_subproblem_without_a_usable_point_ends_the_loop_and_keeps_the_last_reference(
    last: Solution, reason: ExitReason
) -> None:
    outcome = sequential_convex(0.0, follow(), solve=Scripted(answer(7.0), last))
    assert outcome.reason is reason
    assert outcome.iterate == 7.0
    assert len(outcome.iterations) == 2
    assert np.isnan(outcome.iterations[-1].change)
    assert last.message in outcome.message


def test_a_point_short_of_its_tolerance_is_used_while_its_residuals_are_small() -> None:
    rough = answer(2.0, Status.SOLVED_INACCURATE, residual=9e-6)
    nearly = answer(2.0, Status.NUMERICAL_LIMIT, residual=5e-9)
    outcome = sequential_convex(2.0, follow(), solve=Scripted(rough, nearly))
    assert outcome.reason is ExitReason.CONVERGED
    assert len(outcome.iterations) == 2


def test_a_rough_point_shows_the_way_but_is_not_converged() -> None:
    rough = answer(2.0, Status.SOLVED_INACCURATE, residual=9e-6)
    outcome = sequential_convex(2.0, follow(), solve=Scripted(*[rough] * 5), rules=Rules(max_iterations=5))
    assert outcome.reason is ExitReason.MAX_ITERATIONS


def test_ctrl_c_in_the_solver_is_an_outcome_with_what_was_reached() -> None:
    outcome = sequential_convex(0.0, follow(), solve=Scripted(answer(5.0), KeyboardInterrupt()))
    assert outcome.reason is ExitReason.INTERRUPTED
    assert outcome.iterate == 5.0
    assert "iteration 2" in outcome.message


def native(problem: Problem, settings: Settings | None = None, /) -> Solution:
    """The Rust core, which Ctrl-C reaches in its first iteration."""
    return orbsoc.solve(problem, settings, callback=lambda _: signal.raise_signal(signal.SIGINT))


class InterruptedScheduler(orbsoc.PsScheduler):
    """The emulated computer, which Ctrl-C reaches between its first two launches."""

    def __call__(self, problem: Problem, settings: Settings | None = None, /, **overrides: Any) -> Solution:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Driver, "run", self._signal_then_run)
            return super().__call__(problem, settings, **overrides)

    @staticmethod
    def _signal_then_run(driver: Driver, **arguments: Any) -> None:
        signal.raise_signal(signal.SIGINT)
        run_driver(driver, **arguments)


run_driver = Driver.run


@pytest.mark.parametrize("solve", [native, InterruptedScheduler()], ids=["orbsoc.solve", "PsScheduler"])
def test_ctrl_c_inside_our_solvers_is_an_outcome(solve: Solve) -> None:
    outcome = sequential_convex(3.0, newton_on_square_root(2.0, bounded=True), solve=solve)
    assert outcome.reason is ExitReason.INTERRUPTED
    assert outcome.iterate == 3.0
    assert outcome.iterations[0].solution.status is Status.INTERRUPTED


def test_ctrl_c_in_the_callback_is_an_outcome_with_what_was_reached() -> None:
    def interrupted(row: Iteration) -> None:
        if row.number == 2:
            raise KeyboardInterrupt

    outcome = sequential_convex(3.0, newton_on_square_root(2.0), solve=clarabel, callback=interrupted)
    assert outcome.reason is ExitReason.INTERRUPTED
    assert len(outcome.iterations) == 2
    assert "iteration 2" in outcome.message


def test_callback_sees_every_iteration_in_order() -> None:
    seen: list[Iteration] = []
    outcome = sequential_convex(3.0, newton_on_square_root(2.0), solve=clarabel, callback=seen.append)
    assert tuple(seen) == outcome.iterations


@pytest.mark.parametrize("name", ["step_tol", "max_iterations", "tight_tol"])
def test_rules_must_be_positive(name: str) -> None:
    with pytest.raises(ValueError, match=f"{name} = 0"):
        Rules(**{name: 0})
