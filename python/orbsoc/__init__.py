"""Second-order cones on a system-on-chip, for orbits.

`orbsoc.solve(problem)` solves a conic problem; `orbsoc.PsScheduler` runs the same solve on the emulated PS+PL
computer; `orbsoc.missions` plans; the command `orbsoc` does all of it.
"""

from orbsoc.builder import ConicBuilder
from orbsoc.problem import Cones, Problem, ProblemError
from orbsoc.ps import PsScheduler
from orbsoc.settings import Settings
from orbsoc.solution import Certificate, Solution, Status
from orbsoc.solver import Solver, solve
from orbsoc.verify import verify

__version__ = "0.1.0"

__all__ = [
    "Certificate",
    "Cones",
    "ConicBuilder",
    "Problem",
    "ProblemError",
    "PsScheduler",
    "Settings",
    "Solution",
    "Solver",
    "Status",
    "solve",
    "verify",
]
