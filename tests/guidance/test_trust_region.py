"""The trust region: descent on a curved feasible set, its ends, and what it keeps when a proposal is worth nothing."""

import numpy as np
import pytest

import orbsoc
from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.guidance.scp import ExitReason, Iteration, Outcome, Proposal, TrustRules, trust_region

Array = np.ndarray
SLOPE = np.array([1.0, 2.0])


def propose(point: Array, radius: float) -> Proposal[Array]:
    """The lowest point on the tangent of the unit circle, within a radius."""
    builder = ConicBuilder()
    step = builder.variable("step", 2)
    builder.cost(step, SLOPE)
    builder.equality([(step, point[None])], 0.0)
    builder.norm([(step, np.eye(2))], bound=radius)
    problem = builder.build()
    solution = orbsoc.solve(problem, Settings(tol=1e-10))
    assert solution.status is Status.SOLVED
    moved = point + builder.value(solution, "step")
    return Proposal(
        moved,
        float(SLOPE @ moved),
        float(np.linalg.norm(moved - point)),
        (Iteration(1, 1e-10, problem, solution),),
    )


def lower(rules: TrustRules, restore: object = None) -> Outcome[Array]:
    back = restore or (lambda point: point / np.linalg.norm(point))
    return trust_region(np.array([1.0, 0.0]), propose, back, lambda p: float(SLOPE @ p), rules=rules)  # type: ignore[arg-type]


def test_it_finds_the_lowest_point_of_a_circle_from_a_radius_too_large() -> None:
    found = lower(TrustRules(radius=50.0, least_gain=1e-10))
    assert found.reason is ExitReason.CONVERGED, found.message
    assert found.iterate == pytest.approx(-SLOPE / np.linalg.norm(SLOPE), abs=1e-4)
    assert [row.number for row in found.iterations] == list(range(1, len(found.iterations) + 1))


def test_a_step_that_cannot_be_restored_is_not_taken() -> None:
    found = lower(TrustRules(radius=1.0, least_radius=1e-3), restore=lambda _: None)
    assert found.reason is ExitReason.MAX_ITERATIONS
    assert found.iterate.tolist() == [1.0, 0.0]
    assert "no step of more than 0.001" in found.message


def test_it_stops_where_the_limit_is() -> None:
    found = lower(TrustRules(radius=1e-3, max_iterations=2, good=2.0))
    assert found.reason is ExitReason.MAX_ITERATIONS
    assert len(found.iterations) == 2


def test_a_proposal_without_an_iterate_tells_why() -> None:
    builder = ConicBuilder()
    x = builder.variable("x", 1)
    builder.nonnegative([(x, [[1.0], [-1.0]])], [-1.0, -1.0])
    problem = builder.build()
    row = Iteration(1, 1e-8, problem, orbsoc.solve(problem))
    found = trust_region(
        0.0,
        lambda *_: Proposal(None, float("nan"), float("nan"), (row,)),
        lambda p: p,
        abs,
        rules=TrustRules(radius=1.0),
    )
    assert found.reason is ExitReason.SUBPROBLEM_INFEASIBLE
