"""Small problems as a user meets them: building, set-up and solve of one problem from SciPy matrices, beside the peers.

`python -m benchmarks.small` prints a table: medians of processor time in µs over interleaved rounds; the peers get their own
formats, made beforehand. Answers count when `orbsoc.verify` finds 1e-7 at most. Patterns come again: what the solver
keeps of them counts for it; the column "first" is with a pattern that it has not met.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy import sparse as _scipy_sparse

import orbsoc
from benchmarks.peers.installed import MissingSolver, module
from benchmarks.statistics import portfolio, small_lp
from orbsoc.conic.problem import Cones, Problem

sparse: Any = _scipy_sparse  # published without types

ROUNDS = 60
TOLERANCE = 1e-8
VERIFIED = 1e-7

Call = Callable[[], Any]


def grasp(seed: int) -> Problem:
    """Least normal forces of five fingers that hold a weight: friction cones of 3 and six equations of balance."""
    rng = np.random.default_rng(seed)
    fingers = 5
    A = np.hstack([np.vstack([np.eye(3), rng.normal(size=(3, 3))]) for _ in range(fingers)])
    held = np.concatenate([[2.0, *(0.3 * rng.normal(size=2))] for _ in range(fingers)])
    cone = -np.kron(np.eye(fingers), np.diag([0.6, 1.0, 1.0]))
    most = np.kron(np.eye(fingers), [1.0, 0.0, 0.0])
    return Problem(
        c=np.tile([1.0, 0.0, 0.0], fingers),
        A=sparse.csc_array(A),
        b=A @ held,
        G=sparse.csc_array(np.vstack([most, cone])),
        h=np.concatenate([np.full(fingers, 10.0), np.zeros(3 * fingers)]),
        cones=Cones(l=fingers, q=[3] * fingers),
    )


def robust_least_squares(seed: int) -> Problem:
    """min ‖Ax − b‖ + 0.1‖x‖ in 10 unknowns and 20 rows."""
    rng = np.random.default_rng(seed)
    n, rows = 10, 20
    A, b = rng.normal(size=(rows, n)), rng.normal(size=rows)
    G = np.zeros((rows + n + 2, n + 2))
    G[0, n], G[1 : rows + 1, :n] = -1.0, -A
    G[rows + 1, n + 1], G[rows + 2 :, :n] = -1.0, -np.eye(n)
    h = np.concatenate([[0.0], -b, np.zeros(n + 1)])
    c = np.concatenate([np.zeros(n), [1.0, 0.1]])
    return Problem(c=c, G=sparse.csc_array(G), h=h, cones=Cones(q=[rows + 1, n + 1]))


def mpc(seed: int) -> Problem:
    """Ten steps of a double integrator in two axes with bounded thrust; 60 variables."""
    rng = np.random.default_rng(seed)
    steps, dt = 10, 0.3
    dynamics = np.kron([[1.0, dt], [0.0, 1.0]], np.eye(2))
    control = np.kron([[0.5 * dt * dt], [dt]], np.eye(2))
    states = np.eye(4 * steps) - np.kron(np.eye(steps, k=-1), dynamics)
    A = np.hstack([states, -np.kron(np.eye(steps), control)])
    b = np.concatenate([dynamics @ rng.normal(size=4), np.zeros(4 * (steps - 1))])
    bounds = np.hstack([np.zeros((2 * steps, 4 * steps)), np.eye(2 * steps)])
    return Problem(
        P=sparse.csc_array(np.diag(np.r_[np.ones(4 * steps), np.full(2 * steps, 0.1)])),
        c=np.zeros(6 * steps),
        A=sparse.csc_array(A),
        b=b,
        G=sparse.csc_array(np.vstack([bounds, -bounds])),
        h=np.ones(4 * steps),
        cones=Cones(l=4 * steps),
    )


@dataclass(frozen=True, slots=True)
class Row:
    """Medians in µs of one problem; `peers` holds those whose answers verify."""

    name: str
    ours: float
    first: float
    build: float
    peers: dict[str, float]

    @property
    def ratio(self) -> float:
        """The best peer's time over ours."""
        return min(self.peers.values(), default=float("nan")) / self.ours

    @property
    def first_ratio(self) -> float:
        """The same with a pattern that was not met before."""
        return min(self.peers.values(), default=float("nan")) / self.first


def _clarabel(problem: Problem) -> Call:
    clarabel, _ = module("clarabel")
    settings = clarabel.DefaultSettings()
    settings.verbose, settings.presolve_enable, settings.max_threads = False, False, 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    P, A = sparse.triu(problem.P, format="csc"), sparse.vstack([problem.A, problem.G], format="csc")
    side = np.r_[problem.b, problem.h]
    cones = [clarabel.ZeroConeT(problem.p)] if problem.p else []
    cones += [clarabel.NonnegativeConeT(problem.cones.l)] if problem.cones.l else []
    cones += [clarabel.SecondOrderConeT(q) for q in problem.cones.q]

    def call() -> Any:
        found = clarabel.DefaultSolver(P, problem.c, A, side, cones, settings).solve()
        z = np.asarray(found.z)
        return SimpleNamespace(x=np.asarray(found.x), y=z[: problem.p], z=z[problem.p :])

    return call


def _ecos(problem: Problem) -> Call:
    ecos, _ = module("ecos")
    if problem.P.nnz:
        raise MissingSolver("ECOS has no quadratic cost")
    A, G = (sparse.csc_matrix(matrix) for matrix in (problem.A, problem.G))
    dims = {"l": problem.cones.l, "q": list(problem.cones.q), "e": 0}
    rows = (A, problem.b) if problem.p else (None, None)

    def call() -> Any:
        tolerances = {"abstol": TOLERANCE, "reltol": TOLERANCE, "feastol": TOLERANCE}
        found = ecos.solve(problem.c, G, problem.h, dims, *rows, verbose=False, **tolerances)
        return SimpleNamespace(x=found["x"], y=found["y"] if problem.p else np.zeros(0), z=found["z"])

    return call


def _qoco(problem: Problem) -> Call:
    qoco, _ = module("qoco")
    P = sparse.csc_matrix(problem.P) if problem.P.nnz else None
    A, G = (sparse.csc_matrix(matrix) for matrix in (problem.A, problem.G))
    rows = (A, problem.b) if problem.p else (None, None)
    l, q = problem.cones.l, np.array(problem.cones.q, dtype=np.int32)

    def call() -> Any:
        engine = qoco.QOCO()
        sizes = (problem.n, problem.m, problem.p)
        engine.setup(*sizes, P, problem.c, *rows, G, problem.h, l, q.size, q, abstol=TOLERANCE, reltol=TOLERANCE)  # fmt: skip
        found = engine.solve()
        return SimpleNamespace(x=found.x, y=found.y if problem.p else np.zeros(0), z=found.z)

    return call


def _piqp(problem: Problem, *, dense: bool) -> Call:
    piqp, _ = module("piqp")
    if problem.cones.q:
        raise MissingSolver("PIQP has no cones")
    make = piqp.DenseSolver if dense else piqp.SparseSolver
    convert = (lambda matrix: np.asfortranarray(matrix.toarray())) if dense else sparse.csc_matrix
    P, A, G = (convert(matrix) for matrix in (problem.P, problem.A, problem.G))

    def call() -> Any:
        engine = make()
        settings = engine.settings
        settings.verbose = False
        settings.eps_abs = settings.eps_rel = TOLERANCE
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = TOLERANCE
        some = problem.p > 0
        engine.setup(
            P=P, c=problem.c, A=A if some else None, b=problem.b if some else None, G=G, h_u=problem.h
        )
        engine.solve()
        found = engine.result
        return SimpleNamespace(
            x=np.array(found.x), y=np.array(found.y)[: problem.p], z=np.array(found.z_u)[: problem.m]
        )

    return call


def _ours(problem: Problem) -> tuple[Call, Call]:
    """Build and solve; build alone."""
    parts = (problem.P, problem.A, problem.G)
    P, A, G = (matrix if matrix.shape[0] and matrix.nnz else None for matrix in parts)
    b, h = problem.b if A is not None else None, problem.h

    def build() -> Problem:
        return Problem(P=P, c=problem.c, A=A, b=b, G=G, h=h, cones=problem.cones)

    return lambda: orbsoc.solve(build(), tol=TOLERANCE), build


MAKERS: dict[str, Callable[[Problem], Call]] = {
    "clarabel": _clarabel,
    "ecos": _ecos,
    "qoco": _qoco,
    "piqp sparse": lambda problem: _piqp(problem, dense=False),
    "piqp dense": lambda problem: _piqp(problem, dense=True),
}
FAMILIES: dict[str, Callable[[int], Problem]] = {
    "grasp": grasp,
    "robust least squares": robust_least_squares,
    "portfolio, 20 assets": lambda seed: portfolio(20, seed),
    "MPC, 10 steps": mpc,
    "LP 16 × 128": lambda seed: small_lp(16, seed, rows=128),
}


KINDS = {
    "SOCP": ("grasp", "robust least squares"),
    "QP": ("portfolio", "MPC"),
    "LP": ("LP",),
}


def _means(rows: list[Row]) -> list[str]:
    """Geometric means of the ratios by kind of problem: with a known pattern, and the first time."""
    out = []
    for kind, names in KINDS.items():
        of = [row for row in rows if row.name.startswith(names)]
        known, first = (
            np.exp(np.mean(np.log([getattr(row, ratio) for row in of]))) for ratio in ("ratio", "first_ratio")
        )
        out.append(f"{kind}: {known:.2f}, the first time {first:.2f}")
    return out


def _forget() -> None:
    """As many other patterns as the solver keeps, so that it has none of the problem's."""
    for size in range(2, 19):
        rows = Problem(c=np.ones(size), G=-np.eye(size), h=np.zeros(size), cones=Cones(l=size))
        orbsoc.Solver(rows)


def measure(name: str, problem: Problem, rounds: int = ROUNDS) -> Row:
    solve, build = _ours(problem)
    calls: dict[str, Call] = {"ours": solve, "build": build}
    for peer, make in MAKERS.items():
        try:
            call = make(problem)
            if orbsoc.verify(problem, call()).worst <= VERIFIED:
                calls[peer] = call
        except MissingSolver:
            continue
    if not orbsoc.verify(problem, solve()).worst <= VERIFIED:
        raise RuntimeError(f"{name}: the answer does not verify")
    times: dict[str, list[float]] = {key: [] for key in [*calls, "first"]}
    for k in range(rounds):
        for key, call in calls.items():
            times[key].append(_timed(call))
        if k % 6 == 0:
            _forget()
            times["first"].append(_timed(solve))
    medians = {key: 1e6 * float(np.median(values)) for key, values in times.items()}
    ours, first, built = (medians.pop(key) for key in ("ours", "first", "build"))
    return Row(name, ours, first, built, medians)


def _timed(call: Call) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


def main() -> int:
    rows = [measure(f"{name} ({seed})", make(seed)) for name, make in FAMILIES.items() for seed in range(2)]
    lines = [
        "| problem | build | build, set-up, solve | first | best peer | ratio |",
        "|---|--:|--:|--:|---|--:|",
    ]
    for row in rows:
        best = min(row.peers, key=row.peers.__getitem__, default="none")
        peer = f"{best} {row.peers.get(best, float('nan')):.0f}"
        lines.append(
            f"| {row.name} | {row.build:.1f} | {row.ours:.0f} | {row.first:.0f} | {peer} | {row.ratio:.2f} |"
        )
    sys.stdout.write("\n".join([*lines, "", *_means(rows)]) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
