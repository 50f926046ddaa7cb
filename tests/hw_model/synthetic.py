"""Traces built from stated formulae, for tests only: no solver ran.

The stages, their modules and their data flow are those of the interior-point method of the core. The sizes
are those of a 12-node orbit insertion: KKT order 245, nnz(L) 4372, 39 000 multiply-subtracts per LDLᵀ.
"""

from __future__ import annotations

from typing import Any

from hw_model.vocabulary import OPCODES

N, P, L, CONES, CONE = 120, 45, 20, 15, 4  # variables, equalities, R₊ rows, cones of size CONE
M = L + CONES * CONE
ORDER = N + P + M
NNZ_KKT = 1100
NNZ_L = 4372
FACTOR_MUL_SUB = 39_000
TREE_HEIGHT = 60
# Chains, at the latencies of the `orbsoc_rtl` and `vendor_ip` f64 presets: (add, mul, div, sqrt).
LATENCIES = {"orbsoc_rtl": (6, 7, 32, 32), "vendor_ip": (15, 16, 57, 57)}


def operations(**counts: int) -> dict[str, int]:
    """A count for every opcode, 0 where none is given; `and_` stands for "and"."""
    found = {name.rstrip("_"): count for name, count in counts.items()}
    assert found.keys() <= set(OPCODES), found
    return {code: found.get(code, 0) for code in OPCODES}


def stage(module: str, reads: str, writes: str, path: dict[str, int] | int, **counts: int) -> dict[str, Any]:
    """A stage; buffers are blank-separated names, `path` a chain for every preset or one for each."""
    chain = path if isinstance(path, dict) else dict.fromkeys(LATENCIES, path)
    return {
        "module": module,
        "reads": reads.split(),
        "writes": writes.split(),
        "operations": operations(**counts),
        "critical_path": chain,
    }


def _chain(adds: int = 0, muls: int = 0, divs: int = 0, sqrts: int = 0) -> dict[str, int]:
    return {
        name: adds * add + muls * mul + divs * div + sqrts * sqrt
        for name, (add, mul, div, sqrt) in LATENCIES.items()
    }


def _stages() -> dict[str, Any]:
    spread = CONES * CONE
    rows = ORDER
    return {
        "equilibrate": stage("matrix_scaling", "raw q", "a g q scale", _chain(30, 40, 20, 20),
                             mul=12 * NNZ_KKT, max=10 * NNZ_KKT, abs=10 * NNZ_KKT, div=10 * rows, sqrt=10 * rows),
        "load_kkt": stage("matrix_update", "a g", "kkt_values", 1, move=NNZ_KKT),
        "scaling_blocks": stage("matrix_update", "kkt_values w", "kkt_values", _chain(2, 4),
                                mul=CONES * CONE * (CONE + 1) + L, add=spread),
        "factorize": stage("factorization", "kkt_values", "l pivots", _chain(TREE_HEIGHT, 2 * TREE_HEIGHT, TREE_HEIGHT),
                           mul=NNZ_L, mul_sub=FACTOR_MUL_SUB, div=ORDER, compare=ORDER, select=ORDER),
        "rhs": stage("linear_solve", "q", "kkt_rhs", 6, neg=N, move=P + M),
        "solve_kkt": stage("linear_solve", "kkt_values l pivots kkt_rhs", "kkt_solution kkt_error",
                           _chain(2 * TREE_HEIGHT + 10, 2 * TREE_HEIGHT + 2),
                           mul_sub=2 * NNZ_L + 2 * NNZ_KKT, mul=ORDER),
        "refine_kkt": stage("linear_solve", "kkt_values l pivots kkt_rhs kkt_solution kkt_error",
                            "kkt_solution kkt_error", _chain(2 * TREE_HEIGHT + 11, 2 * TREE_HEIGHT + 2),
                            mul_sub=2 * NNZ_L + 2 * NNZ_KKT, mul=ORDER, add=ORDER),
        "check_solve": stage("ps", "kkt_error kkt_rhs", "refinement", _chain(9),
                             abs=2 * ORDER, max=2 * ORDER, compare=2),
        "statistics": stage("ps", "a g q scale point residual_scratch", "residual statistics", _chain(12, 3, 1),
                            mul_add=2 * NNZ_KKT, mul=3 * ORDER, abs=3 * ORDER, max=3 * ORDER, div=4),
        "nt_scaling": stage("cone_ops", "point", "w lambda", _chain(6, 6, 2, 3),
                            mul=14 * spread + 3 * L, add=6 * spread, div=2 * CONES + L, sqrt=3 * CONES + L),
        "direction": stage("cone_ops", "w lambda kkt_solution", "step", _chain(6, 6, 1),
                           mul=8 * spread + 2 * L, add=6 * spread, div=CONES),
        "step_length": stage("line_search", "lambda step", "alpha", _chain(9, 6, 1, 2),
                             mul=10 * spread, add=10 * spread, sqrt=2 * CONES, div=2 * CONES + 2, max=2 * (CONES + L)),
        "centering": stage("ps", "alpha statistics", "sigma", _chain(2, 3), sub=2, mul=3),
        "cone_product": stage("ps", "lambda step sigma", "complement", _chain(4, 2), mul=4 * spread, add=2 * spread),
        "corrector_rhs": stage("cone_ops", "residual sigma lambda w complement", "kkt_rhs", _chain(6, 6, 1),
                               mul=10 * spread + 3 * L, add=8 * spread, div=CONES),
        "advance": stage("ps", "alpha step point", "point", _chain(1, 1), mul_add=N + P + 2 * M),
        "unscale": stage("matrix_scaling", "scale point", "answer", _chain(0, 2), mul=ORDER + M),
    }  # fmt: skip


BUFFERS = {
    "raw": NNZ_KKT, "a": NNZ_KKT // 2, "g": NNZ_KKT // 2, "q": ORDER, "scale": 2 * ORDER, "kkt_values": NNZ_KKT,
    "l": NNZ_L, "pivots": ORDER, "kkt_rhs": ORDER, "kkt_solution": ORDER, "kkt_error": ORDER, "refinement": 4,
    "point": ORDER + M + 2, "residual": ORDER, "residual_scratch": 0, "statistics": 12, "w": 2 * M, "lambda": M,
    "step": ORDER + M, "alpha": 1, "sigma": 2, "complement": M, "answer": ORDER + M,
}  # fmt: skip

STARTUP = ("equilibrate", "load_kkt", "factorize", "rhs", "solve_kkt", "check_solve")
SOLVE = ("solve_kkt", "check_solve", "refine_kkt", "check_solve")
ITERATION = (
    "statistics", "nt_scaling", "scaling_blocks", "factorize", "rhs", *SOLVE, "direction", "step_length",
    "centering", "cone_product", "corrector_rhs", *SOLVE, "direction", "step_length", "advance",
)  # fmt: skip


def synthetic_trace(*, iterations: int = 12, solves: int = 1, datapath: str = "f64") -> dict[str, Any]:
    """A trace of `solves` solves of `iterations` iterations with one refinement step per KKT solve."""
    events = [[name, 0] for name in STARTUP]
    events += [[name, k] for k in range(iterations) for name in ITERATION]
    events += [["statistics", iterations], ["unscale", iterations]]
    pattern = {
        "n": N, "p": P, "m": M, "cones": {"l": L, "q": [CONE] * CONES}, "nnz_kkt": NNZ_KKT, "nnz_l": NNZ_L,
        "buffers": dict(BUFFERS), "stages": _stages(),
    }  # fmt: skip
    solve = {"pattern": 0, "status": "SOLVED", "iterations": iterations, "events": events}
    return {
        "schema": "orbsoc.trace/2",
        "datapath": datapath,
        "patterns": [pattern],
        "solves": [dict(solve) for _ in range(solves)],
    }
