"""Second-order cones on a system-on-chip, for orbits.

`orbsoc.solve(problem)` solves a conic problem; `orbsoc.PsScheduler` runs the same solve on the emulated PS+PL
computer; `orbsoc.plan(scenario)` plans a mission of `orbsoc.missions`, verifies and prices it, as the command `orbsoc plan` does.

What is not needed to solve a problem is imported when it is first named, SciPy when it is first used. `pip install orbsoc` brings what
solves; missions and the command line need the extra `orbsoc[missions]`, the hardware model `orbsoc[hw]`, `orbsoc.CVXPY` `orbsoc[cvxpy]`,
large results of `orbsoc.reach` `orbsoc[reach]`. Without it, they raise ModuleNotFoundError, which names the extra.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from orbsoc.conic.problem import Cones, Problem, ProblemError
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Certificate, Solution, Start, Status
from orbsoc.conic.verify import verify
from orbsoc.files.extras import told_what_to_install
from orbsoc.solving.solver import Solver, solve

if TYPE_CHECKING:
    from orbsoc.commands.plan import plan_file as plan_file
    from orbsoc.commands.plan_call import plan as plan
    from orbsoc.conic.builder import ConicBuilder as ConicBuilder
    from orbsoc.files.versions import __version__ as __version__
    from orbsoc.flight import export_c as export_c
    from orbsoc.hw.emulation import PsScheduler as PsScheduler
    from orbsoc.interfaces.cvxpy import CVXPY as CVXPY
    from orbsoc.solving.batch import BatchSolution as BatchSolution
    from orbsoc.solving.batch import BatchSolver as BatchSolver
    from orbsoc.solving.batch import solve_batch as solve_batch

    from . import missions as missions
    from . import reach as reach

__all__ = [
    "BatchSolution",
    "BatchSolver",
    "Certificate",
    "Cones",
    "ConicBuilder",
    "Problem",
    "ProblemError",
    "PsScheduler",
    "Settings",
    "Solution",
    "Solver",
    "Start",
    "Status",
    "solve",
    "solve_batch",
    "verify",
]


_LAZY = {
    **dict.fromkeys(("BatchSolution", "BatchSolver", "solve_batch"), "orbsoc.solving.batch"),
    "CVXPY": "orbsoc.interfaces.cvxpy",
    "ConicBuilder": "orbsoc.conic.builder",
    "PsScheduler": "orbsoc.hw.emulation",
    "__version__": "orbsoc.files.versions",
    "export_c": "orbsoc.flight",
    "plan": "orbsoc.commands.plan_call",
    "plan_file": "orbsoc.commands.plan",
}
_LAZY_MODULES = ("missions", "reach")


def __getattr__(name: str) -> Any:
    with told_what_to_install():
        if name in _LAZY:
            return getattr(import_module(_LAZY[name]), name)
        if name in _LAZY_MODULES:
            return import_module(f"orbsoc.{name}")
    raise AttributeError(f"module 'orbsoc' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(
        {*__all__, *_LAZY, *_LAZY_MODULES, "__all__", "__doc__", "__file__", "__name__", "__path__"}
    )
