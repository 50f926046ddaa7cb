"""QOCOGEN: QOCO's method as C code generated for one sparsity pattern. Source: Chari & Açıkmeşe 2025.

It takes part where its code has been generated and compiled before (`prepare`, which wants a C compiler): minutes for
patterns of a thousand rows, so only small ones.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import io
import os
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Answer, Solve, Solver, Variant
from benchmarks.peers.installed import MissingSolver, module
from orbsoc.conic.problem import Problem

sparse: Any = _scipy_sparse  # published without types

LIBRARIES = Path(__file__).resolve().parents[2] / "out" / "qocogen"
SHIM = Path(__file__).with_name("qocogen_shim.c")
COMPILER, FLAGS = "cc", ("-O3", "-march=native")
MOST_ROWS = 900
"""n + p + m of the largest pattern that code is generated for."""
SOLVED = 1
PATIENCE_S = 300.0
"""For one compilation."""


def solver() -> Solver:
    _, release = module("qocogen")
    variants = (Variant("", _with(0.0)), Variant("kkt_static_reg = 1e-7", _with(1e-7)))
    return Solver("QOCOGEN", release, variants, lambda problem: _library(problem).exists())


def prepare(problem: Problem) -> str:
    """Generate and compile the solver of this pattern unless it is there; a line that says what was done.

    Raises MissingSolver without QOCOGEN or a C compiler.
    """
    qocogen, _ = module("qocogen")
    if shutil.which(COMPILER) is None:
        raise MissingSolver(f"QOCOGEN needs a C compiler called {COMPILER}: left out")
    path = _library(problem)
    if not _suits(problem):
        return "QOCOGEN: left out, too large or with products in its cost"
    if path.exists():
        return "QOCOGEN: compiled before"
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        with contextlib.redirect_stdout(io.StringIO()):
            qocogen.generate_solver(
                *(problem.n, problem.m, problem.p),
                sparse.csc_matrix(problem.P) if problem.P.nnz else None,
                problem.c,
                sparse.csc_matrix(problem.A),
                problem.b,
                sparse.csc_matrix(problem.G),
                problem.h,
                *(problem.cones.l, len(problem.cones.q), np.array(problem.cones.q, dtype=np.int32)),
                output_dir=folder,
                name="generated",
            )
        return _compile(Path(folder) / "generated", path)


def _compile(source: Path, path: Path) -> str:
    built = path.with_suffix(f".{os.getpid()}")
    files = [source / f"{name}.c" for name in ("qoco_custom", "cone", "utils", "ldl", "kkt")]
    command: Sequence[str | Path] = (COMPILER, *FLAGS, "-shared", "-fPIC", "-I", source, "-o", built)
    # In a session of its own: the compiler proper is a child of `cc`, and would outlive it.
    with subprocess.Popen(
        [*command, *files, SHIM, "-lm"], stderr=subprocess.PIPE, start_new_session=True
    ) as compiling:
        try:
            _, complaint = compiling.communicate(timeout=PATIENCE_S)
        except BaseException as error:
            os.killpg(compiling.pid, signal.SIGKILL)
            if not isinstance(error, subprocess.TimeoutExpired):
                raise
            return f"QOCOGEN: left out, not compiled within {PATIENCE_S:.0f} s"
    if compiling.returncode != 0:
        return f"QOCOGEN: left out, its code does not compile: {complaint.decode()[-200:]}"
    built.replace(path)
    return "QOCOGEN: compiled"


def _suits(problem: Problem) -> bool:
    coordinates = sparse.coo_array(problem.P)
    diagonal = bool(np.array_equal(*coordinates.coords))
    finite = bool(np.isfinite(problem.h).all())
    return problem.n + problem.p + problem.m <= MOST_ROWS and diagonal and finite


def _library(problem: Problem) -> Path:
    """Where the compiled code of the problem's pattern is, or would be."""
    digest = hashlib.sha256(f"{version('qocogen')} {FLAGS} {problem.cones}".encode())
    digest.update(SHIM.read_bytes())
    for matrix in (problem.P, problem.A, problem.G):
        digest.update(np.asarray(matrix.shape).tobytes())
        digest.update(np.asarray(matrix.indptr, dtype=np.int64).tobytes())
        digest.update(np.asarray(matrix.indices, dtype=np.int64).tobytes())
    return LIBRARIES / f"{digest.hexdigest()[:20]}.so"


@cache
def _loaded(path: Path) -> ctypes.CDLL:
    return ctypes.CDLL(str(path))


def _with(regularisation: float) -> Solve:
    def solve(problem: Problem, tol: float) -> Answer:
        library = _loaded(_library(problem))
        x, y, z = (np.zeros(size) for size in (problem.n, problem.p, problem.m))
        iterations, setup_s, solve_s = ctypes.c_int(), ctypes.c_double(), ctypes.c_double()
        status = library.orbsoc_solve(
            *map(
                _pointer,
                (problem.P.data, problem.c, problem.A.data, problem.b, problem.G.data, problem.h),
            ),
            *(problem.P.nnz, problem.A.nnz, problem.G.nnz),
            ctypes.c_double(tol),
            ctypes.c_double(regularisation),
            *map(_pointer, (x, y, z)),
            *(ctypes.byref(number) for number in (iterations, setup_s, solve_s)),
        )
        solved = status == SOLVED
        return Answer(
            x,
            y,
            z,
            "solved" if solved else f"status {status}",
            iterations.value,
            setup_s.value,
            solve_s.value,
            "SOLVED" if solved else "",
        )

    return solve


def _pointer(values: NDArray[np.float64]) -> Any:
    return np.ascontiguousarray(values).ctypes.data_as(ctypes.POINTER(ctypes.c_double))
