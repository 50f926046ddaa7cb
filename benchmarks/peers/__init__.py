"""The solvers of a comparison, each with its own clock, one module each.

All run cold (a fresh object for every solve), on one thread, without presolve, at the tolerance asked for by their
own criterion. What a clock covers differs: orbsoc equilibrates and checks its certificate inside the solve; the
peers equilibrate in the set-up (QOCO, by default, not at all) and do not check.
"""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.answer import Solver
from benchmarks.peers import clarabel, ecos, highs, orbsoc, piqp, qoco, qocogen, scs
from benchmarks.peers.installed import MissingSolver

MAKERS: dict[str, Callable[[], Solver]] = {
    "orbsoc": orbsoc.solver,
    "clarabel": clarabel.solver,
    "ecos": ecos.solver,
    "qoco": qoco.solver,
    "qocogen": qocogen.solver,
    "piqp_sparse": piqp.sparse_solver,
    "piqp_dense": piqp.dense_solver,
    "scs": scs.solver,
    "highs": highs.solver,
}
DEFAULT = ("orbsoc", "clarabel", "ecos", "qoco", "piqp_sparse", "piqp_dense", "scs", "highs")
"""All that need no compiler."""


def solvers(names: tuple[str, ...] = DEFAULT) -> tuple[list[Solver], list[str]]:
    """The solvers that are installed, and a line for each that is not; ValueError for a name that is none."""
    found: list[Solver] = []
    missing: list[str] = []
    for name in names:
        if name not in MAKERS:
            raise ValueError(f"no solver {name!r}; there are {', '.join(MAKERS)}")
        try:
            found.append(MAKERS[name]())
        except MissingSolver as error:
            missing.append(str(error))
    return found, missing
