"""The solvers of a comparison: orbsoc, Clarabel, ECOS and QOCO, each with its own clock.

All run cold (a fresh object for every solve), on one thread, without presolve, at the tolerance asked for by their
own criterion. What a clock covers differs: orbsoc equilibrates and checks its certificate inside the solve; the
peers equilibrate in the set-up (QOCO, by default, not at all) and do not check.
Sources: Goulart & Chen 2024 (Clarabel); Domahidi, Chu & Boyd 2013 (ECOS); Chari & Açıkmeşe 2025 (QOCO).
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse as _scipy_sparse

import orbsoc
from benchmarks.answer import Answer, Array, Solve, Solver, Variant
from orbsoc.problem import Problem

sparse: Any = _scipy_sparse  # published without types


class MissingSolver(ImportError):
    """A peer that is not installed; `make bench` installs them all."""


def solvers(
    names: tuple[str, ...] = ("orbsoc", "clarabel", "ecos", "qoco"),
) -> tuple[list[Solver], list[str]]:
    """The solvers that are installed, and a line for each that is not."""
    found: list[Solver] = []
    missing: list[str] = []
    for name in names:
        try:
            found.append(_MAKERS[name]())
        except MissingSolver as error:
            missing.append(str(error))
        except KeyError:
            raise ValueError(f"no solver {name!r}; there are {', '.join(_MAKERS)}") from None
    return found, missing


def _module(name: str) -> tuple[Any, str]:
    """A peer's module, and the version of its distribution."""
    try:
        return importlib.import_module(name), version(name)
    except (ImportError, PackageNotFoundError):
        raise MissingSolver(f"{name} is not installed (`make bench` installs it): left out") from None


# ---- orbsoc ----


def _orbsoc() -> Solver:
    def solve(problem: Problem, tol: float) -> Answer:
        s = orbsoc.solve(problem, tol=tol)
        return Answer(s.x, s.y, s.z, s.status.name, s.iterations, s.setup_s, s.solve_s)

    return Solver("orbsoc", orbsoc.__version__, (Variant("", solve),))


# ---- Clarabel ----


def _clarabel() -> Solver:
    clarabel, release = _module("clarabel")

    def solve(problem: Problem, tol: float) -> Answer:
        """Clarabel's clock gives set-up and solve as one sum: the solve is timed from outside, around its one call
        (a few µs of binding count against it), and the set-up is what then remains of the sum."""
        kept = np.isfinite(problem.h)
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.presolve_enable, settings.max_threads = False, False, 1
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tol
        cones = problem.cones
        inequalities = int(kept[: cones.l].sum())
        blocks = [clarabel.ZeroConeT(problem.p)] if problem.p else []
        blocks += [clarabel.NonnegativeConeT(inequalities)] if inequalities else []
        blocks += [clarabel.SecondOrderConeT(q) if q > 1 else clarabel.NonnegativeConeT(1) for q in cones.q]
        P = sparse.triu(problem.P, format="csc")
        A = sparse.vstack([problem.A, _rows(problem.G, kept)], format="csc")
        engine = clarabel.DefaultSolver(P, problem.c, A, np.r_[problem.b, problem.h[kept]], blocks, settings)
        started = time.perf_counter()
        result = engine.solve()
        solve_s = time.perf_counter() - started
        multipliers = np.asarray(result.z)
        return Answer(
            np.asarray(result.x),
            multipliers[: problem.p],
            _scattered(multipliers[problem.p :], kept),
            str(result.status),
            int(result.iterations),
            max(float(result.solve_time) - solve_s, 0.0),
            solve_s,
        )

    return Solver("Clarabel", release, (Variant("", solve),))


# ---- ECOS ----


def _ecos() -> Solver:
    ecos, release = _module("ecos")

    def solve(problem: Problem, tol: float) -> Answer:
        """ECOS has no quadratic cost: ½‖Rx‖² ≤ t, RᵀR = P, goes in as one more cone on one more variable."""
        kept = np.isfinite(problem.h)
        rows, side, sizes = _rows(problem.G, kept), problem.h[kept], list(problem.cones.q)
        linear = problem.c, problem.A, rows, side, sizes
        c, A, G, h, q = _with_epigraph(problem, rows, side, sizes) if problem.P.nnz else linear
        inequalities = int(kept[: problem.cones.l].sum())
        result = ecos.solve(
            c,
            sparse.csc_matrix(G) if h.size else None,
            h if h.size else None,
            {"l": inequalities, "q": q, "e": 0},
            sparse.csc_matrix(A) if problem.p else None,
            problem.b if problem.p else None,
            verbose=False,
            abstol=tol,
            reltol=tol,
            feastol=tol,
        )
        info = result["info"]
        return Answer(
            np.asarray(result["x"])[: problem.n],
            np.asarray(result["y"]) if problem.p else np.zeros(0),
            _scattered(np.asarray(result["z"])[: int(kept.sum())], kept),
            str(info["infostring"]),
            int(info["iter"]),
            float(info["timing"]["tsetup"]),
            float(info["timing"]["tsolve"]),
        )

    return Solver("ECOS", release, (Variant("", solve),))


def _with_epigraph(problem: Problem, G: Any, h: Array, q: list[int]) -> tuple[Any, ...]:
    """c, A, G, h and cone sizes with t ≥ ½xᵀPx as the last variable: (t + 1, t − 1, √2 Rx) ∈ Q."""
    R = _root(problem.P)
    rows = R.shape[0]
    head = sparse.csc_array((2, problem.n))
    cone = sparse.hstack(
        [
            sparse.vstack([head, -np.sqrt(2.0) * R]),
            sparse.coo_array(([-1.0, -1.0], ([0, 1], [0, 0])), shape=(rows + 2, 1)),
        ]
    )
    return (
        np.append(problem.c, 1.0),
        sparse.hstack([problem.A, sparse.csc_array((problem.p, 1))], format="csc"),
        sparse.vstack([sparse.hstack([G, sparse.csc_array((G.shape[0], 1))]), cone], format="csc"),
        np.concatenate([h, [1.0, -1.0], np.zeros(rows)]),
        [*q, rows + 2],
    )


def _root(P: Any) -> Any:
    """R with RᵀR = P, by eigenvalues of the block of rows that P has; a diagonal P keeps its sparsity."""
    coordinates = sparse.coo_array(P)
    coordinates.eliminate_zeros()
    rows, columns = coordinates.coords
    if np.array_equal(rows, columns):
        return sparse.csc_array(
            (np.sqrt(coordinates.data), (np.arange(rows.size), columns)), shape=(rows.size, P.shape[1])
        )
    used: NDArray[np.intp] = np.unique(rows)
    block = sparse.csr_array(P)[used][:, used].toarray()
    values, vectors = np.linalg.eigh(block)
    positive = values > 1e-14 * values[-1]
    R = np.sqrt(values[positive])[:, None] * vectors[:, positive].T
    spread = np.zeros((R.shape[0], P.shape[1]))
    spread[:, used] = R
    return sparse.csc_array(spread)


# ---- QOCO ----

QOCO_REGULARISED = {"kkt_static_reg_P": 1e-6, "ir_tol": 1e-4}
"""For problems where QOCO 0.3's defaults end in QOCO_NUMERICAL_ERROR with NaN, as on all of mission 004's.

There, many variables are in no cost and no cone, so their pivot is the regularisation of P alone, 1e-13. It puts
a²/1e-13 on the equality rows, and what rounding leaves of that, about eps·a²/1e-13, swamps those rows' own
regularisation, 1e-8. By all signs what counts is reg_P · reg_A against eps: of the 52 subproblems, none verifies at
a product of 1e-18, 30 at 1e-16 (1e-8 each), 49 at 1e-15 and all at 1e-14 (1e-6 and 1e-8), where refinement makes up
for it. `kkt_dynamic_reg`, `kkt_static_reg_G` and more refinement do not help; `ir_tol` = 1e-4 instead of 1e-6 is 6 %
faster and verifies as well. `ruiz_iters` > 0 ends in NaN whenever a row of G is empty, as is that of the constant
head of ‖u‖ ≤ 1: two variables and one such cone, or one empty R₊ row, are enough to see it.
"""


def _qoco() -> Solver:
    qoco, release = _module("qoco")

    def variant(label: str, **settings: Any) -> Variant:
        return Variant(label, _qoco_with(qoco, settings))

    return Solver(
        "QOCO",
        release,
        (
            variant(""),
            variant("ruiz_iters = 3", ruiz_iters=3),
            variant("kkt_static_reg_P = 1e-6, ir_tol = 1e-4", **QOCO_REGULARISED),
            variant(
                "kkt_static_reg_P = 1e-6, ir_tol = 1e-4, ruiz_iters = 3", **QOCO_REGULARISED, ruiz_iters=3
            ),
        ),
    )


def _qoco_with(qoco: Any, chosen: dict[str, Any]) -> Solve:
    def solve(problem: Problem, tol: float) -> Answer:
        kept = np.isfinite(problem.h)
        engine = qoco.QOCO()
        m = int(kept.sum())
        engine.setup(
            problem.n,
            m,
            problem.p,
            sparse.csc_matrix(problem.P) if problem.P.nnz else None,
            problem.c,
            sparse.csc_matrix(problem.A) if problem.p else None,
            problem.b if problem.p else None,
            sparse.csc_matrix(_rows(problem.G, kept)) if m else None,
            problem.h[kept] if m else None,
            int(kept[: problem.cones.l].sum()),
            len(problem.cones.q),
            np.asarray(problem.cones.q, dtype=np.int32),
            abstol=tol,
            reltol=tol,
            **chosen,
        )
        result = engine.solve()
        return Answer(
            np.array(result.x, dtype=np.float64),
            np.array(result.y, dtype=np.float64)[: problem.p],
            _scattered(np.array(result.z, dtype=np.float64)[:m], kept),
            str(result.status),
            int(result.iters),
            float(result.setup_time_sec),
            float(result.solve_time_sec),
        )

    return solve


# ---- shared ----

_MAKERS: dict[str, Callable[[], Solver]] = {
    "orbsoc": _orbsoc,
    "clarabel": _clarabel,
    "ecos": _ecos,
    "qoco": _qoco,
}


def _rows(G: Any, kept: NDArray[np.bool_]) -> Any:
    """The rows of G that constrain."""
    return G if kept.all() else sparse.csr_array(G)[kept].tocsc()


def _scattered(z: Array, kept: NDArray[np.bool_]) -> Array:
    """Multipliers of all rows; 0 for rows that do not constrain."""
    out = np.zeros(kept.size)
    out[kept] = z
    return out
