"""Approaches without interior or infeasible by a margin: passive-safety grids, robust rendezvous.

`python -m benchmarks.approaches` prints what orbsoc and its peers answer, and orbsoc's iterations over Clarabel's.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import isfinite, nan
from typing import Any

import numpy as np

from benchmarks.answer import Answer, Solver
from benchmarks.grading import Graded, graded
from benchmarks.peers import solvers
from orbsoc.conic.problem import Problem
from orbsoc.missions.passive_safety.model.approach import Approach
from orbsoc.missions.passive_safety.model.margins import Margins
from orbsoc.missions.passive_safety.model.problem import assemble
from orbsoc.missions.passive_safety.scenario import Scenario
from orbsoc.missions.passive_safety.search.timing import equal_times

TOL = 1e-8
INACCURATE = 1e-5
"""A peer that claims nothing has an inaccurate answer where `orbsoc.verify` finds residuals no larger."""
PEERS = ("clarabel", "ecos", "qoco")
STEP_S = 100.0
"""Between times of the second impulse, and between the impulses after it."""
GRIDS = ((1000.0, 6000.0, 40.0, 60.0), (2000.0, 6000.0, 50.0, 70.0))
"""Distance behind the target, duration, keep-out and capture of a grid: the constants of the paper's tables, and as printed."""
ROBUST = 100


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """One problem of a family."""

    name: str
    problem: Problem


def grid(behind_m: float, duration_s: float, keep_out_m: float, below_m: float) -> Iterator[Asked]:
    """Safe for an orbit wherever a burn stops: for each time of the second impulse, one impulse every `STEP_S` after it."""
    approach = Approach.of(
        _scenario(
            {"keep_out_m": keep_out_m, "interruption_orbits": 1, "impulses": {"timing": "generated"}},
            behind_m,
            duration_s,
            below_m,
        )
    )
    for second_s in np.arange(STEP_S, duration_s, STEP_S):
        times = np.concatenate([[0.0], np.arange(second_s, duration_s, STEP_S)])
        yield Asked(f"t2 = {second_s:.0f} s", assemble(approach, times).builder.build())


def robust(seed: int) -> Asked:
    """Four equally spaced impulses with margins for errors, from a random place, in a random time, errors over two decades."""
    random = np.random.default_rng([seed, 94])
    behind_m = float(random.choice([-1.0, 1.0]) * random.uniform(200.0, 5000.0))
    duration_s = float(random.uniform(1500.0, 9000.0))
    size = float(10.0 ** random.uniform(-1.0, 1.0))
    errors = {
        "position_m": 0.5 * size,
        "velocity_m_s": 1e-3 * size,
        "execution_share": 0.01 * min(size, 5.0),
        "execution_fixed_m_s": 2e-4 * size,
    }
    changes = {"keep_out_m": 40.0, "impulses": {"count": 4, "timing": "equal"}, "uncertainty": errors}
    approach = Approach.of(_scenario(changes, behind_m, duration_s, below_m=60.0))
    times = equal_times(approach)
    problem = assemble(approach, times, margins=Margins.of(approach, times.size)).builder.build()
    return Asked(f"{behind_m:.0f} m, {duration_s:.0f} s, errors x {size:.2f}", problem)


def _scenario(changes: dict[str, Any], behind_m: float, duration_s: float, below_m: float) -> Scenario:
    return Scenario.model_validate({
        "mission": "passive_safety", "name": "approach", "condition": "short", "duration_s": duration_s,
        "target": {"mean_motion_rad_s": 1e-3}, "start": {"x_m": -behind_m}, "capture": {"x_m": 0.0, "z_m": below_m},
        **changes,
    })  # fmt: skip


FAMILIES: dict[str, Callable[[], list[Asked]]] = {
    **{
        f"grid, {behind_m:.0f} m in {duration_s:.0f} s, keep-out {keep_out_m:.0f} m": lambda row=row: list(
            grid(*row)
        )  # type: ignore[misc]
        for row in GRIDS
        for behind_m, duration_s, keep_out_m, _ in [row]
    },
    "robust rendezvous": lambda: [robust(seed) for seed in range(ROBUST)],
}


def answered(row: Graded) -> bool:
    """Whether a solver has an answer, accurate or not: residuals within `INACCURATE`, or a certificate."""
    return row.residual <= INACCURATE or (bool(row.claim) and row.certified)


def grade(solver: Solver, asked: Asked, tol: float) -> Graded:
    answer: Answer = solver.variants[0].solve(asked.problem, tol)
    who = (solver.name, solver.version, "default")
    return graded(asked.problem, answer, where=("approaches", asked.name, ""), who=who, tol=tol)


@dataclass(frozen=True, slots=True)
class Tally:
    """One solver on one family; iterations of the problems where both it and the reference have an answer."""

    solver: str
    claimed: int
    answered: int
    iterations: float
    over_reference: float
    worst: float


def tally(rows: Sequence[Graded], reference: Sequence[Graded]) -> Tally:
    """`over_reference`: mean iterations over the reference's; `worst`: the largest such ratio of one problem."""
    both = [
        (row.iterations, other.iterations)
        for row, other in zip(rows, reference, strict=True)
        if answered(row) and answered(other)
    ]
    mine, theirs = np.array(both, dtype=float).reshape(-1, 2).T
    return Tally(
        solver=rows[0].solver,
        claimed=sum(bool(row.claim) for row in rows),
        answered=sum(answered(row) for row in rows),
        iterations=float(mine.mean()) if both else nan,
        over_reference=float(mine.sum() / theirs.sum()) if both else nan,
        worst=float((mine / theirs).max()) if both else nan,
    )


def lost(rows: Sequence[Graded], peers: Sequence[Sequence[Graded]]) -> list[str]:
    """Problems on which orbsoc ends with a numerical limit, or without an answer, and a peer has one."""
    return [
        f"{row.problem}: {row.status}, residual {row.residual:.1e}; {', '.join(found)}"
        for k, row in enumerate(rows)
        if row.status == "NUMERICAL_LIMIT" or not answered(row)
        for found in [[peer[k].solver for peer in peers if answered(peer[k])]]
        if found
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """A table for each family, and the problems that were lost; 1 where there are any."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--tol", type=float, default=TOL)
    parser.add_argument("--each", action="store_true", help="a line for every problem, too")
    chosen = parser.parse_args(arguments)
    found, missing = solvers(("orbsoc", *PEERS))
    sys.stderr.writelines(f"{line}\n" for line in missing)
    lost_in_all = 0
    sys.stdout.write("| family | solver | claims | answers | iterations | over Clarabel's | most |\n")
    sys.stdout.write("|---|---|--:|--:|--:|--:|--:|\n")
    for family, generate in FAMILIES.items():
        problems = generate()
        rows = [[grade(solver, asked, chosen.tol) for asked in problems] for solver in found]
        reference = next((each for each in rows if each[0].solver == "Clarabel"), rows[0])
        for each in rows:
            t = tally(each, reference)
            cells = (family, t.solver, f"{t.claimed} of {len(each)}", f"{t.answered}", f"{t.iterations:.1f}")
            ratios = (f"{ratio:.2f}" if isfinite(ratio) else "–" for ratio in (t.over_reference, t.worst))
            sys.stdout.write(f"| {' | '.join([*cells, *ratios])} |\n")
        named = lost(rows[0], rows[1:])
        lost_in_all += len(named)
        if chosen.each:
            for k, asked in enumerate(problems):
                answers = [
                    f"{each[k].solver} {each[k].status} {each[k].iterations} {each[k].residual:.0e}"
                    for each in rows
                ]
                sys.stderr.write(f"{asked.name}: {'; '.join(answers)}\n")
        for line in named:
            sys.stderr.write(f"lost: {family}, {line}\n")
        sys.stdout.flush()
    return 1 if lost_in_all else 0


if __name__ == "__main__":
    raise SystemExit(main())
