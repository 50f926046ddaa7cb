"""What the program in C executes around the solves of a plan, by counts that only the sizes of the mission move.

The program has no loop whose length a number of the state decides, so what it executes is a sum over its loops. The factors
are those of an aarch64 build by gcc 12 at -O2, counted under QEMU over 8 to 32 nodes, 1 to 5 steps a node of the guess and
1 to 5 steps a sample of the judging flight; a sum is within 0.02 % of every count. A sample that falls on a node takes less.
tests/flight/test_outer_loop.py counts again.

A re-plan in flight runs the same loops over other counts: it flies the estimate on, then the flying attitude for a reference, in the
steps of the judging flight.
"""

from __future__ import annotations

from orbsoc.guidance.outer_loop import OuterLoop, Work
from orbsoc.guidance.scp import ExitReason

from .on_board import sizes_of_flights, what_it_has_not
from .scenario import Scenario
from .search.run import COLD, SearchResult
from .verification import SAMPLES

SOURCE = "the program in C, instructions counted on aarch64 under QEMU, gcc 12 -O2"

Factors = tuple[float, float, float]
SUBPROBLEM: tuple[Factors, ...] = ((2912.7, 26.0, 4.0), (928.7, 24.0, 1.0), (16.997, 0.0, 0.0))
"""Of a solution read, a reference moved, data made and set: once, per node, per entry of A; as (instructions, divisions, roots)."""
GUESS: tuple[Factors, ...] = ((211.6, 2.0, 5.0), (32.1, 4.0, 1.0), (527.9, 29.0, 8.0))
"""Of the first guess: once, per piece between nodes, per step."""
JUDGED: tuple[Factors, ...] = (
    (0.0, 9.0, 5.0),
    (122.25, 5.0, 2.0),
    (38.17, 1.0, 0.0),
    (655.9, 45.0, 8.0),
    (152.0, 4.0, 0.0),
)
"""Of the judging flight: once, per sample, per sample and node, per step, per step and node."""


def outer_loop(scenario: Scenario, plan: object) -> OuterLoop | None:
    """What the program does around the solves of `plan`; None where the program does not make that very plan."""
    if not isinstance(plan, SearchResult) or any(wrong for wrong, _, _ in what_it_has_not(scenario)):
        return None
    nodes = scenario.method.nodes
    one = plan.attempts[0] if len(plan.attempts) == 1 else None
    if (
        one is None
        or one.start is not COLD
        or one.nodes != nodes
        or one.outcome.reason is not ExitReason.CONVERGED
    ):
        return None
    guess_steps, check_steps = sizes_of_flights(plan.setup)
    entries = one.outcome.iterations[0].problem.A.nnz
    pieces, steps = nodes + 1, check_steps * (SAMPLES - 1)
    each = _sum(SUBPROBLEM, (1, nodes, entries))
    first = _plus(each, _sum(GUESS, (1, pieces, pieces * guess_steps)))
    last = _sum(JUDGED, (1, SAMPLES, SAMPLES * nodes, steps, steps * nodes))
    between = len(one.outcome.iterations) - 1
    return OuterLoop((first, *[each] * between, last), SOURCE)


def replan_loop(nodes: int, entries: int, solves: int, ahead: int, judged: int) -> OuterLoop:
    """Of a re-plan from the flying burn: `ahead` and `judged` steps of the flights over the allowance and of the answer."""
    each = _sum(SUBPROBLEM, (1, nodes, entries))
    pieces = nodes + 1
    flights = _sum(JUDGED, (1, nodes, nodes * nodes, ahead + pieces, (ahead + pieces) * nodes))
    if not solves:
        return OuterLoop((flights,), SOURCE)
    samples = 2 * judged + 1
    last = _sum(JUDGED, (1, samples, samples * nodes, judged, judged * nodes))
    return OuterLoop((_plus(each, flights), *[each] * (solves - 1), last), SOURCE)


def _sum(factors: tuple[Factors, ...], times: tuple[int, ...]) -> Work:
    kinds = zip(*factors, strict=True)
    return Work(*(round(sum(f * n for f, n in zip(kind, times, strict=True))) for kind in kinds))


def _plus(one: Work, other: Work) -> Work:
    return Work(*(a + b for a, b in zip(one, other, strict=True)))
