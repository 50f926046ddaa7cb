"""The reachable domain with orbsoc and with Clarabel in the same loop, one core against one core.

`python -m benchmarks.reach --shards 1 3 5 7 --out out/reach-bench` solves those shards of the paper's grid with each solver by
turns: guesses, sequences, flights, polish and the evidence for what is not reached are all inside the clock, which is
the processor time of this process. Clarabel keeps one solver per pattern and updates its data, on one thread; what it
calls solved is believed. Writes reach.json: seconds, verdicts and every point on which the two do not agree.
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

from benchmarks.circumstances import commit, machine_class
from orbsoc.batch import BatchSolution
from orbsoc.missions.reachable_domain import load_scenario
from orbsoc.missions.reachable_domain.condensed import CondensedBatch
from orbsoc.missions.reachable_domain.domain import Domain
from orbsoc.missions.reachable_domain.sequence import SolveMany, threaded
from orbsoc.missions.reachable_domain.tasks import grid_shards
from orbsoc.settings import Settings
from orbsoc.solution import Status

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

    def __call__(self, batch: CondensedBatch, settings: Settings) -> BatchSolution:
        base, count = batch.base, len(batch)
        solver, order = self._solver(batch, settings.tol)
        data = np.concatenate([batch.A, batch.G], axis=1)[:, order]
        sides = np.concatenate([batch.b, batch.h], axis=1)
        x, dual = np.empty((count, base.n)), np.empty((count, base.p + base.m))
        slack, status = np.empty((count, base.m)), np.empty(count, dtype=object)
        iterations, worst = np.zeros(count, np.uint32), np.zeros(count)
        for k in range(count):
            solver.update(q=batch.c[k], A=data[k], b=sides[k])
            found = solver.solve()
            x[k], dual[k], slack[k] = found.x, found.z, found.s[base.p :]
            status[k] = STATUS.get(str(found.status), Status.NUMERICAL_LIMIT)
            iterations[k] = found.iterations
            # Below the tolerance asked for it is believed; what stopped short is judged by its own residuals.
            worst[k] = max(found.r_prim, found.r_dual)
        nothing = np.zeros(count)
        return BatchSolution(
            status=status,
            x=x,
            y=dual[:, : base.p],
            z=dual[:, base.p :],
            s=slack,
            objective=nothing,
            dual_objective=nothing,
            iterations=iterations,
            refinements=np.zeros(count, np.uint32),
            primal_residual=worst,
            dual_residual=worst,
            gap=worst,
            radius=nothing,
            message=[""] * count,
            solve_s=0.0,
        )

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


def measure(shards: list[int], repeats: int) -> dict[str, Any]:
    """Solve the shards with both solvers by turns."""
    scenario = load_scenario(SCENARIO)
    solvers: dict[str, SolveMany] = {"orbsoc": threaded(1), "clarabel": ClarabelLoop()}
    domains = {name: Domain.of(scenario, solve=solve) for name, solve in solvers.items()}
    payloads = [payload for _rows, payload in grid_shards(domains["orbsoc"])]
    seconds: dict[str, list[float]] = {name: [] for name in solvers}
    tables: dict[str, list[Any]] = {name: [] for name in solvers}
    for repeat in range(repeats):
        for shard in shards:
            inc, raan = np.array(payloads[shard]["inc_deg"]), np.array(payloads[shard]["raan_deg"])
            for name, domain in domains.items():
                started = time.process_time()
                table = domain.solve_planes(inc, raan)
                seconds[name].append(time.process_time() - started)
                if repeat == 0:
                    tables[name].append(table)
                sys.stderr.write(f"shard {shard} {name} {seconds[name][-1]:.2f} s\n")
    names = ("status", "inc_deg", "raan_deg", "perigee_bound_km", "a_km", "evidence", "sequence_iterations")
    columns = {
        solver: {name: np.concatenate([table[name] for table in found]) for name in names}
        for solver, found in tables.items()
    }
    ours, theirs = columns["orbsoc"], columns["clarabel"]
    differ = np.flatnonzero(ours["status"] != theirs["status"])
    both = (ours["status"] == "reached") & (theirs["status"] == "reached")
    total = {name: float(np.sum(values)) for name, values in seconds.items()}
    return {
        "machine": machine_class(),
        "commit": commit(),
        "shards": shards,
        "repeats": repeats,
        "points": len(ours["status"]),
        "cpu_s": total,
        "ratio": total["clarabel"] / total["orbsoc"],
        "subproblems": {name: int(found["sequence_iterations"].sum()) for name, found in columns.items()},
        "largest_difference_of_a_rel": float(np.abs(ours["a_km"][both] / theirs["a_km"][both] - 1.0).max()),
        "differences": [
            {
                "inc_deg": float(ours["inc_deg"][k]),
                "raan_deg": float(ours["raan_deg"][k]),
                "perigee_bound_km": float(ours["perigee_bound_km"][k]),
                "orbsoc": f"{ours['status'][k]}: {ours['evidence'][k]}",
                "clarabel": f"{theirs['status'][k]}: {theirs['evidence'][k]}",
            }
            for k in differ
        ],
    }


def main() -> None:
    """Measure and write reach.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--shards", type=int, nargs="+", default=[1, 3, 5, 7], help="of the paper's grid, 0 to 7"
    )
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("out/reach-bench"))
    chosen = parser.parse_args()
    chosen.out.mkdir(parents=True, exist_ok=True)
    found = measure(chosen.shards, chosen.repeats)
    (chosen.out / "reach.json").write_text(json.dumps(found, indent=1) + "\n")
    sys.stdout.write(json.dumps({k: v for k, v in found.items() if k != "differences"}, indent=1) + "\n")


if __name__ == "__main__":
    main()
