"""The reachable domain with orbsoc and with Clarabel in the same loop, one core against one core.

`python -m benchmarks.reach --out out/reach-bench` solves the paper's grid with each solver by turns: guesses, sequences,
flights, polish and the evidence for what is not reached are all inside the clock, which is the processor time of this
process. `--every K` takes every Kth plane. Three solvers of the same subproblems, and nothing else that differs:

- `orbsoc`: Newton on the dual from the multipliers before, its interior-point method where there are none or that fails;
- `orbsoc_interior_point`: its interior-point method, `solve_batch`, for every subproblem;
- `clarabel`: one solver per pattern with updated data, on one thread; what it calls solved is accepted.

Writes reach.json: seconds, the seconds in the solvers' calls alone, verdicts, and every point on which they do not agree.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import clarabel
import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from benchmarks.environment import commit, machine_class
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.guidance.scp import Rules
from orbsoc.missions.reachable_domain import load_scenario
from orbsoc.missions.reachable_domain.model.direct.condensed import CondensedBatch
from orbsoc.missions.reachable_domain.model.direct.subproblems import Answers, SolvedBatch, Subproblems
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain

Array = NDArray[np.float64]
SCENARIO = Path(__file__).resolve().parents[1] / "scenarios" / "paper004_reach.toml"

STATUS = {
    "Solved": Status.SOLVED,
    "AlmostSolved": Status.SOLVED_INACCURATE,
    "PrimalInfeasible": Status.PRIMAL_INFEASIBLE,
    "AlmostPrimalInfeasible": Status.PRIMAL_INFEASIBLE,
    "DualInfeasible": Status.DUAL_INFEASIBLE,
    "AlmostDualInfeasible": Status.DUAL_INFEASIBLE,
    "MaxIterations": Status.MAX_ITERATIONS,
}


class ClarabelLoop:
    """Clarabel behind the call shape of a batch: one problem after the other, solvers kept and updated."""

    def __init__(self) -> None:
        self._kept: dict[tuple[int, float], tuple[Any, NDArray[np.intp]]] = {}

    def __call__(self, batch: CondensedBatch, settings: Settings) -> SolvedBatch:
        base, count = batch.base, len(batch)
        solver, order = self._solver(batch, settings.tol)
        data = np.concatenate([batch.A, batch.G], axis=1)[:, order]
        sides = np.concatenate([batch.b, batch.h], axis=1)
        x, dual = np.empty((count, base.n)), np.empty((count, base.p + base.m))
        status = np.empty(count, dtype=object)
        iterations, worst = np.zeros(count, np.uint32), np.zeros(count)
        for k in range(count):
            solver.update(q=batch.c[k], A=data[k], b=sides[k])
            found = solver.solve()
            x[k], dual[k] = found.x, found.z
            status[k] = STATUS.get(str(found.status), Status.NUMERICAL_LIMIT)
            iterations[k] = found.iterations
            # Below the requested tolerance it is accepted; what stopped short is checked by its own residuals.
            worst[k] = max(found.r_prim, found.r_dual)
        return SolvedBatch(status, x, dual[:, : base.p], dual[:, base.p :], iterations, worst)

    def _solver(self, batch: CondensedBatch, tolerance: float) -> tuple[Any, NDArray[np.intp]]:
        """The kept solver of the pattern at a tolerance, and where its values stand in [A, G]."""
        base = batch.base
        key = (id(base), tolerance)
        if key not in self._kept:
            order = np.arange(base.A.nnz + base.G.nnz, dtype=float)
            a = sparse.csc_array(
                (order[: base.A.nnz] + 1.0, base.A.indices, base.A.indptr), shape=base.A.shape
            )
            g = sparse.csc_array(
                (order[base.A.nnz :] + 1.0, base.G.indices, base.G.indptr), shape=base.G.shape
            )
            stacked = sparse.csc_matrix(sparse.vstack([a, g]))
            stacked.sort_indices()
            places = stacked.data.astype(np.intp) - 1
            stacked.data = np.concatenate([batch.A[0], batch.G[0]])[places]
            cones = [clarabel.ZeroConeT(base.p)]
            cones += [clarabel.NonnegativeConeT(base.cones.l)] if base.cones.l else []
            cones += [clarabel.SecondOrderConeT(q) for q in base.cones.q]
            chosen = clarabel.DefaultSettings()
            chosen.verbose, chosen.presolve_enable, chosen.max_threads = False, False, 1
            chosen.tol_gap_abs = chosen.tol_gap_rel = chosen.tol_feas = tolerance
            side = np.concatenate([batch.b[0], batch.h[0]])
            nothing = sparse.csc_matrix((base.n, base.n))
            made = clarabel.DefaultSolver(nothing, batch.c[0], stacked, side, cones, chosen)
            self._kept[key] = (made, places)
        return self._kept[key]


class Timed:
    """Solves subproblems and adds up the processor time that takes."""

    def __init__(self, solve: Subproblems) -> None:
        self.solve, self.cpu_s, self.count = solve, 0.0, 0

    def __call__(self, batch: CondensedBatch, near: Array, tight: NDArray[np.bool_], rules: Rules) -> Answers:
        started = time.process_time()
        answers = self.solve(batch, near, tight, rules)
        self.cpu_s += time.process_time() - started
        self.count += len(batch)
        return answers


def solvers() -> dict[str, Timed]:
    """What solves the subproblems, by name."""
    return {
        "orbsoc": Timed(Subproblems.in_process()),
        "orbsoc_interior_point": Timed(Subproblems.in_process(dual=False)),
        "clarabel": Timed(Subproblems(ClarabelLoop(), dual=False)),
    }


def measure(every: int, repeats: int) -> dict[str, Any]:
    """Solve the shards of the paper's grid, or of every k-th plane of it, with all solvers by turns."""
    scenario = load_scenario(SCENARIO)
    timed = solvers()
    domains = {name: Domain.of(scenario, solve=solve) for name, solve in timed.items()}
    inc, raan = (values[::every] for values in domains["orbsoc"].planes())
    shards = -(-len(inc) // scenario.method.planes_per_shard)
    seconds = {name: [0.0] * repeats for name in timed}
    tables: dict[str, list[Any]] = {name: [] for name in timed}
    for repeat in range(repeats):
        for shard in range(shards):
            for name, domain in domains.items():
                started = time.process_time()
                table = domain.solve_planes(inc[shard::shards], raan[shard::shards])
                seconds[name][repeat] += time.process_time() - started
                if repeat == 0:
                    tables[name].append(table)
                sys.stderr.write(f"{shard + 1}/{shards} {name} {seconds[name][repeat]:.2f} s\n")
    names = ("status", "inc_deg", "raan_deg", "perigee_bound_km", "a_km", "evidence", "sequence_iterations")
    columns = {
        solver: {name: np.concatenate([table[name] for table in found]) for name in names}
        for solver, found in tables.items()
    }
    own, theirs = columns["orbsoc"], columns["clarabel"]
    differ = np.flatnonzero(own["status"] != theirs["status"])
    both = (own["status"] == "reached") & (theirs["status"] == "reached")
    ratios = {
        name: [theirs / own for theirs, own in zip(seconds["clarabel"], seconds[name], strict=True)]
        for name in ("orbsoc", "orbsoc_interior_point")
    }
    return {
        "machine": machine_class(),
        "commit": commit(),
        "every": every,
        "points": len(own["status"]),
        "reached": int((own["status"] == "reached").sum()),
        "cpu_s": seconds,
        "clarabel_over": ratios,
        "in_the_solver_cpu_s": {name: solve.cpu_s / repeats for name, solve in timed.items()},
        "subproblems": {name: solve.count // repeats for name, solve in timed.items()},
        "largest_difference_of_a_rel": float(np.abs(own["a_km"][both] / theirs["a_km"][both] - 1.0).max()),
        "differences": [
            {
                "inc_deg": float(own["inc_deg"][k]),
                "raan_deg": float(own["raan_deg"][k]),
                "perigee_bound_km": float(own["perigee_bound_km"][k]),
                "orbsoc": f"{own['status'][k]}: {own['evidence'][k]}",
                "clarabel": f"{theirs['status'][k]}: {theirs['evidence'][k]}",
            }
            for k in differ
        ],
    }


def main() -> None:
    """Measure and write reach.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--every", type=int, default=1, help="take every k-th plane")
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/reach-bench"))
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    found = measure(chosen.every, chosen.repeats)
    (chosen.out / "reach.json").write_text(json.dumps(found, indent=1) + "\n")
    sys.stdout.write(json.dumps({k: v for k, v in found.items() if k != "differences"}, indent=1) + "\n")


if __name__ == "__main__":
    main()
