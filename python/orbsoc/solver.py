"""Solving: the Rust core behind `orbsoc.solve` and `orbsoc.Solver`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

from orbsoc import _core, csc
from orbsoc.errors import ProblemError
from orbsoc.iteration_table import print_table
from orbsoc.problem import Problem
from orbsoc.settings import Settings
from orbsoc.solution import Certificate, Solution, Status

Callback = Callable[[Mapping[str, float]], object]
"""Sees each iteration's statistics (keys of `orbsoc.iteration_table.COLUMNS`); a true return value stops the solve."""

DEFAULTS = Settings()


def solve(
    problem: Problem,
    settings: Settings | None = None,
    *,
    callback: Callback | None = None,
    bundle: str | PathLike[str] | None = None,
    **overrides: Any,
) -> Solution:
    """Solve a conic problem in double precision.

    Keyword settings override `settings`: `solve(problem, tol=1e-10)`. Not converging is a status. Ctrl-C ends
    the solve within one iteration (or a millisecond) with `Status.INTERRUPTED` and the best iterate.
    `bundle` is where to write what repeats the solve (see orbsoc.bundle) if it does not end with SOLVED.
    Raises TypeError for an unknown setting, ProblemError or ValueError for data that cannot be solved, OSError
    if the bundle cannot be written.

    >>> import orbsoc
    >>> solve(orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=orbsoc.Cones(l=1))).status.name
    'SOLVED'
    """
    return Solver(problem, settings, **overrides).solve(callback=callback, bundle=bundle)


class Solver:
    """A problem's pattern, analysed once, for solving it again with other numbers."""

    def __init__(self, problem: Problem, settings: Settings | None = None, **overrides: Any) -> None:
        self.settings = resolve(settings, overrides)
        self.problem = problem
        self._engine = engine(problem, self.settings)

    def update(self, **data: Any) -> None:
        """Replace data by name (P=, c=, A=, b=, G=, h=), in the same sparsity pattern.

        The data are equilibrated anew: the next solve has the bits of a fresh `Solver`.
        Raises ProblemError if a shape or pattern differs, TypeError for an unknown name.
        """
        unknown = sorted(set(data) - set("PcAbGh"))
        if unknown:
            raise TypeError(f"update() has no data named {unknown[0]!r}; known are P, c, A, b, G, h")
        old = self.problem
        for name, value in data.items():
            _check_shape(name, value, getattr(old, name).shape)
        merged: dict[str, Any] = {name: getattr(old, name) for name in "PcAbGh"} | data
        problem = Problem(**merged, cones=old.cones)
        try:
            self._engine.update(problem)
        except _core.CoreError as error:
            raise ProblemError(str(error)) from None
        self.problem = problem

    def solve(
        self, *, callback: Callback | None = None, bundle: str | PathLike[str] | None = None
    ) -> Solution:
        """Solve the current data from a cold start; `callback` and `bundle` are those of `orbsoc.solve`."""
        watcher = print_table(callback) if self.settings.verbose else callback
        if bundle is not None:
            return self._solve_recorded(watcher, bundle)
        return solution_of(self._engine.solve(watcher))

    def _solve_recorded(self, callback: Callback | None, place: str | PathLike[str]) -> Solution:
        from orbsoc.bundle import Bundle, check_place, recording, versions, write_bundle

        check_place(place)
        history: list[Mapping[str, float]] = []
        solution = solution_of(self._engine.solve(recording(history, callback)))
        if solution.status is not Status.SOLVED:
            found = Bundle(self.problem, self.settings, solution, tuple(history), versions())
            write_bundle(found, place)
        return solution


def resolve(settings: Settings | None, overrides: Mapping[str, Any]) -> Settings:
    """The settings with overrides; TypeError names an unknown one."""
    base = DEFAULTS if settings is None else settings
    _check_type("settings", base, Settings)
    return replace(base, **overrides) if overrides else base


def engine(problem: Problem, settings: Settings) -> _core.Engine:
    """A native engine; what the core refuses becomes a ProblemError."""
    _check_type("problem", problem, Problem)
    try:
        return _core.Engine(problem, settings)
    except _core.CoreError as error:
        raise ProblemError(str(error)) from None


def _check_shape(name: str, value: Any, wanted: tuple[int, ...]) -> None:
    """ProblemError unless the new array has the old one's shape; what is no such array is left to `Problem`."""
    if value is None:
        return
    shape = value.shape if csc.is_sparse(value) else csc.as_array(name, value).shape
    if len(shape) != len(wanted) or shape == wanted:
        return
    if len(shape) == 1:
        raise ProblemError(f"`{name}` has {shape[0]} entries, but the solver was set up for {wanted[0]}")
    raise ProblemError(f"`{name}` has shape {shape}, but the solver was set up for {wanted}")


def _check_type(name: str, value: object, wanted: type) -> None:
    if not isinstance(value, wanted):
        raise TypeError(f"`{name}` is a {type(value).__name__}; it must be an orbsoc.{wanted.__name__}")


def solution_of(raw: _core.RawSolution) -> Solution:
    """The public record of a native solution."""
    return Solution(
        status=Status[raw.status],
        x=raw.x,
        y=raw.y,
        z=raw.z,
        s=raw.s,
        objective=raw.objective,
        dual_objective=raw.dual_objective,
        iterations=raw.iterations,
        refinements=raw.refinements,
        setup_s=raw.setup_s,
        solve_s=raw.solve_s,
        certificate=Certificate(raw.primal_residual, raw.dual_residual, raw.gap, raw.radius),
        message=raw.message,
        nnz_kkt=raw.nnz_kkt,
        nnz_l=raw.nnz_l,
    )
