"""A walk that stalls is walked again from cold, with linear solves of ten times the accuracy; one that stalls then, and far
from a solution, with ten times the shifts of the pivots, too, and one that stalls on a proof with a hundredth of them. The best
outcome counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

import orbsoc
from orbsoc import _core
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.segments import Method

CARELESS = Settings(static_regularization=1e-2, refinement_share=30.0)
"""So much regularisation and so little refinement that some walks stall."""
CAREFUL = Settings(static_regularization=1e-2, refinement_share=3.0)
FIRM = Settings(static_regularization=1e-1, refinement_share=3.0)
MENDED, STALLED = (13, 19, 40), 2
"""Seeds whose second walk solves the problem, and whose walks all stall."""
LEVEL = 3e-9
TOO_LITTLE = Settings(static_regularization=LEVEL)
"""So little regularisation that rounding hides it in `mended_late`."""
ENOUGH = Settings(static_regularization=10.0 * LEVEL, refinement_share=0.1 * 0.03)


def badly_scaled(seed: int) -> Problem:
    """Rows over four orders of magnitude, some of them active without a multiplier."""
    rng = np.random.default_rng(seed)
    n, p, l, q = 6, 2, 8, 4
    A, x = rng.normal(size=(p, n)), rng.normal(size=n)
    G = rng.normal(size=(l + q, n)) * 10.0 ** rng.uniform(-2.0, 2.0, (l + q, 1))
    s, z = np.zeros(l + q), np.zeros(l + q)
    s[:l], s[l] = np.maximum(0.0, rng.normal(size=l)), 2.0
    z[:l] = np.where(s[:l] == 0.0, rng.uniform(size=l) * (rng.uniform(size=l) > 0.5), 0.0)
    c = -(G.T @ z + A.T @ rng.normal(size=p))
    return Problem(c=c, A=A, b=A @ x, G=G, h=G @ x + s, cones=Cones(l=l, q=[q]))


def columns_apart(seed: int, smaller: float, n: int = 40, m: int = 150, together: int = 40) -> Problem:
    """An LP with an equality of the first variables and inequalities half of whose columns are `smaller` times the others."""
    rng = np.random.default_rng(seed)
    G, A = rng.standard_normal((m, n)), rng.standard_normal((1, n))
    G[:, : n // 2] *= smaller
    A[:, together:] = 0.0
    x, s = rng.standard_normal(n), rng.random(m) * (rng.random(m) < 0.7)
    z = rng.random(m) * (s == 0.0)
    c = -(G.T @ z + A.T @ rng.standard_normal(1))
    return Problem(c=c, A=A, b=A @ x, G=G, h=G @ x + s, cones=Cones(l=m))


def mended_late() -> Problem:
    """Two walks stall with the settings TOO_LITTLE, the third solves it."""
    return columns_apart(24, 1e-6, n=8, m=16, together=4)


def unstable_dynamics(seed: int) -> Problem:
    """Quadratic control of x⁺ = Ax + Bu with small inputs and eigenvalues up to 2: feasible, with states of some 1e3."""
    rng = np.random.default_rng(seed)
    steps, states = int(rng.integers(5, 40)), int(rng.integers(1, 5))
    A = rng.normal(size=(states, states)) * rng.uniform(0.3, 1.2)
    stride, dynamics = states + 1, np.hstack([rng.normal(size=(states, 1)), -np.eye(states)])
    rows, b = np.zeros((steps * states, steps * stride)), np.zeros(steps * states)
    for t in range(steps):
        here = slice(t * states, (t + 1) * states)
        rows[here, t * stride : (t + 1) * stride] = dynamics
        if t:
            rows[here, (t - 1) * stride + 1 : t * stride] = A
    b[:states] = -A @ rng.normal(size=states)
    inputs = np.eye(steps * stride)[::stride]
    return Problem(
        P=np.diag(np.tile(np.append(0.01, np.ones(states)), steps)),
        c=np.zeros(steps * stride),
        A=rows,
        b=b,
        G=np.vstack([inputs, -inputs]),
        h=np.full(2 * steps, 0.01),
        cones=Cones(l=2 * steps),
    )


def walks(problem: Problem, settings: Settings) -> list[orbsoc.Solution]:
    """The outcome as it stands after each walk."""
    method, native = Method.from_core(_core), _core.Engine(problem, settings)
    pl = ProgrammableLogic(method, native.run)
    driver = Driver(method, native, pl, words=native.buffer_words(), record=PsRecord())
    found = []

    def again() -> bool:
        found.append(orbsoc.solving.solver.solution_of(native.finish()))
        return native.begin_again()

    driver.run(restart=again)
    return found


def bits(solution: orbsoc.Solution) -> list[bytes]:
    return [getattr(solution, name).tobytes() for name in "xyzs"]


def worst(solution: orbsoc.Solution) -> float:
    found = solution.certificate
    return max(found.primal_residual, found.dual_residual, found.gap)


@pytest.mark.parametrize("seed", MENDED)
def test_the_second_walk_is_that_of_a_tenth_of_the_share(seed: int) -> None:
    problem = badly_scaled(seed)
    first, last = walks(problem, CARELESS)
    solution = orbsoc.solve(problem, CARELESS)
    careful = orbsoc.solve(problem, CAREFUL)
    assert first.status in (orbsoc.Status.NUMERICAL_LIMIT, orbsoc.Status.SOLVED_INACCURATE)
    assert solution.status is careful.status is orbsoc.Status.SOLVED
    assert bits(solution) == bits(careful) == bits(last)
    assert solution.iterations == first.iterations + careful.iterations
    assert solution.refinements == first.refinements + careful.refinements


def test_the_third_walk_has_ten_times_the_shifts() -> None:
    problem = mended_late()
    _, second, last = walks(problem, TOO_LITTLE)
    solution, firm = orbsoc.solve(problem, TOO_LITTLE), orbsoc.solve(problem, ENOUGH)
    assert second.status is orbsoc.Status.NUMERICAL_LIMIT
    assert solution.status is firm.status is orbsoc.Status.SOLVED
    assert bits(solution) == bits(firm) == bits(last)
    assert solution.iterations == second.iterations + firm.iterations
    assert solution.refinements == second.refinements + firm.refinements


def test_the_best_of_three_stalled_walks_counts() -> None:
    problem = badly_scaled(STALLED)
    *_, last = walks(problem, CARELESS)
    solution = orbsoc.solve(problem, CARELESS)
    alone = [walks(problem, settings)[0] for settings in (CARELESS, CAREFUL, FIRM)]
    best = min(alone, key=worst)
    assert len({worst(found) for found in alone}) == 3
    assert bits(solution) == bits(best)
    assert worst(solution) == worst(last) == worst(best)
    assert solution.status is orbsoc.Status.NUMERICAL_LIMIT
    assert solution.iterations == sum(found.iterations for found in alone)


@pytest.mark.parametrize("smaller", [1e-5, 1e-6])
def test_columns_of_very_different_sizes_beside_an_equality_row(smaller: float) -> None:
    """What the elimination of y rounds off hides the shift of x; an answer is wanted all the same, also from a batch."""
    problems = [columns_apart(seed, smaller) for seed in range(10)]
    alone = [orbsoc.solve(problem) for problem in problems]
    stacked = {name: np.array([getattr(p, name) for p in problems]) for name in "cbh"}
    stacked |= {name: np.array([getattr(p, name).data for p in problems]) for name in "AG"}
    batch = orbsoc.solve_batch(problems[0], **stacked)
    assert [solution.status for solution in alone] == [orbsoc.Status.SOLVED] * len(problems)
    assert any(len(walks(problem, Settings())) == 3 for problem in problems)
    for k, (problem, solution) in enumerate(zip(problems, alone, strict=True)):
        wanted = linprog(
            problem.c, problem.G.toarray(), problem.h, problem.A.toarray(), problem.b, bounds=(None, None)
        )
        assert solution.objective == pytest.approx(wanted.fun, rel=1e-6, abs=1e-6)
        assert batch.x[k].tobytes() == solution.x.tobytes()
        assert batch.iterations[k] == solution.iterations


@pytest.mark.parametrize("seed", [606, 1985, 3769, 4765])
def test_a_stall_on_a_proof_is_walked_again_with_a_hundredth_of_the_shifts(seed: int) -> None:
    problem = unstable_dynamics(seed)
    *earlier, last = walks(problem, Settings())
    solution = orbsoc.solve(problem)
    light = walks(problem, Settings(static_regularization=1e-10, refinement_share=0.1 * 0.03))[0]
    assert earlier[-1].status is orbsoc.Status.PRIMAL_INFEASIBLE
    assert solution.status is light.status
    assert solution.status in (orbsoc.Status.SOLVED, orbsoc.Status.SOLVED_INACCURATE)
    assert np.abs(solution.x).max() >= earlier[-1].certificate.radius
    assert bits(solution) == bits(light) == bits(last)
    assert solution.iterations == earlier[-1].iterations + light.iterations
    assert orbsoc.verify(problem, solution).worst < 1e-5


def test_without_a_finite_iterate_the_message_says_so() -> None:
    shifts_too_small = Settings(static_regularization=1e-10)
    found = orbsoc.solve(columns_apart(0, 1e-6), shifts_too_small)
    assert found.status is orbsoc.Status.NUMERICAL_LIMIT
    assert np.isnan(found.x).all()
    assert found.message.startswith("no iterate (x is NaN)")


def test_every_way_to_solve_walks_again() -> None:
    """A batch, row by row; the scheduler; a solver after another problem."""
    seeds = (*MENDED, 1, STALLED)
    problems = [badly_scaled(seed) for seed in seeds]
    stacked = {name: np.array([getattr(p, name) for p in problems]) for name in "cbh"}
    stacked |= {name: np.array([getattr(p, name).data for p in problems]) for name in "AG"}
    again = {name: np.tile(rows, (5, 1)) for name, rows in stacked.items()}
    many = orbsoc.solve_batch(problems[0], **again, settings=CARELESS, threads=2)
    batch = orbsoc.solve_batch(problems[0], **stacked, settings=CARELESS)
    assert many.x.tobytes() == np.tile(batch.x, (5, 1)).tobytes()
    assert many.message == batch.message * 5
    solver = orbsoc.Solver(problems[0], CARELESS)
    for k, problem in enumerate(problems):
        solver.update(**{name: getattr(problem, name) for name in "cbhAG"})
        alone = orbsoc.solve(problem, CARELESS)
        for found in (solver.solve(), orbsoc.PsScheduler(CARELESS)(problem)):
            assert (found.status, found.message) == (alone.status, alone.message)
            assert (found.iterations, found.refinements) == (alone.iterations, alone.refinements)
            assert found.x.tobytes() == alone.x.tobytes()
        assert (batch.status[k], batch.message[k]) == (alone.status, alone.message)
        assert (batch.iterations[k], batch.refinements[k]) == (alone.iterations, alone.refinements)
        assert batch.x[k].tobytes() == alone.x.tobytes()
    assert batch.status[3] is orbsoc.Status.SOLVED
    assert batch.iterations[3] < batch.iterations[:3].min(), "one that does not stall walks once"


def test_who_stops_the_second_walk_gets_the_better_iterate() -> None:
    problem = badly_scaled(MENDED[0])
    first, _ = walks(problem, CARELESS)
    stopped = orbsoc.solve(problem, CARELESS, callback=lambda at: at["iteration"] > first.iterations + 1)
    assert stopped.status is orbsoc.Status.INTERRUPTED
    assert stopped.x.tobytes() == first.x.tobytes()
    assert stopped.message.startswith("stopped in another walk; after the one before: best iterate returned")
    assert stopped.iterations > first.iterations


def test_a_warm_start_that_fails_is_followed_by_a_cold_walk_and_a_careful_one() -> None:
    problem = badly_scaled(MENDED[0])
    cold = orbsoc.solve(problem, CARELESS)
    far = orbsoc.Start(x=cold.x + 1e3, y=cold.y, z=cold.z + 1e3, s=cold.s + 1e3)
    warm = orbsoc.solve(problem, CARELESS, warm_start=far)
    rows = {"c": np.tile(problem.c, (11, 1))}
    batch = orbsoc.solve_batch(problem, **rows, settings=CARELESS, warm_start=far)
    assert (warm.warm_start, warm.status) == ("fell_back", orbsoc.Status.SOLVED)
    assert warm.iterations >= cold.iterations
    assert warm.x.tobytes() == cold.x.tobytes()
    assert (batch.x == warm.x).all()
    assert batch.iterations.tolist() == [warm.iterations] * 11


def test_a_row_that_waits_for_its_second_walk_does_not_run_out_of_time() -> None:
    """It waits until the others, which do not stall, have been solved."""
    stalls, easy = badly_scaled(MENDED[0]), badly_scaled(1)
    count = 60_000
    rows = {name: np.tile(getattr(easy, name), (count, 1)) for name in "cbh"}
    rows |= {name: np.tile(getattr(easy, name).data, (count, 1)) for name in "AG"}
    for name in "cbh":
        rows[name][0] = getattr(stalls, name)
    for name in "AG":
        rows[name][0] = getattr(stalls, name).data
    unlimited = orbsoc.solve_batch(easy, **rows, settings=CARELESS)
    limited = replace(CARELESS, max_time_s=unlimited.solve_s / 5.0)
    batch = orbsoc.solve_batch(easy, **rows, settings=limited)
    assert batch.solve_s > 2 * limited.max_time_s
    assert batch.status[0] is orbsoc.Status.SOLVED, batch.message[0]
