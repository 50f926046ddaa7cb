"""What a solve returns, by any solver."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike, fspath

from orbsoc.files.html_table import html_table
from orbsoc.files.json_fields import FieldError, read_json, write_json

from .csc import Array
from .errors import FileError
from .outcome import Certificate, Start, Status, WarmStart
from .solution_file import decode_solution, encode_solution

__all__ = ["Certificate", "Solution", "Start", "Status", "WarmStart"]


@dataclass(frozen=True, slots=True)
class Solution:
    """A primal-dual point of min ½xᵀPx + cᵀx, Ax = b, Gx + s = h, s ∈ K, with its residuals.

    Shapes: x (n,), y (p,), z (m,), s (m,). Times are wall-clock seconds.
    For an infeasibility status (y, z) or x is the certificate, not a solution. `iterations` and `refinements`
    are those of all solve attempts, restarts included.
    """

    status: Status
    x: Array
    y: Array
    z: Array
    s: Array
    objective: float
    dual_objective: float
    iterations: int
    refinements: int
    setup_s: float
    solve_s: float
    certificate: Certificate
    message: str
    nnz_kkt: int
    nnz_l: int
    warm_start: WarmStart = "none"

    def __repr__(self) -> str:
        return (
            f"Solution({self.status.name} in {self.iterations} iterations, objective {self.objective:.10g}, "
            f"n={self.x.size}, p={self.y.size}, m={self.z.size})"
        )

    def _repr_html_(self) -> str:
        found = self.certificate
        rows = {
            "status": self.status.name,
            "objective, dual": f"{self.objective:.10g}, {self.dual_objective:.10g}",
            "iterations, refinements": f"{self.iterations}, {self.refinements}",
            "primal, dual residual": f"{found.primal_residual:.1e}, {found.dual_residual:.1e}",
            "gap": f"{found.gap:.1e}",
            "n, p, m": f"{self.x.size}, {self.y.size}, {self.z.size}",
            "set-up, solve": f"{1e3 * self.setup_s:.3f} ms, {1e3 * self.solve_s:.3f} ms",
            "message": self.message,
        }
        return html_table("Solution", rows)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the solution to a JSON file of schema `orbsoc.solution/1` (see orbsoc.conic.solution_file)."""
        write_json(encode_solution(self), path)

    @staticmethod
    def load(path: str | PathLike[str]) -> Solution:
        """Read a JSON file of schema `orbsoc.solution/1`; every number comes back exactly.

        Raises FileError naming the field that is missing or damaged, OSError if there is no such file.
        """
        try:
            return Solution(**decode_solution(read_json(path)))
        except FieldError as error:
            raise FileError(f"{fspath(path)}: {error}") from error
