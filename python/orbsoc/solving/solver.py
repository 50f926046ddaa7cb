"""Solving: the Rust core behind `orbsoc.solve` and `orbsoc.Solver`."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import replace
from functools import lru_cache
from os import PathLike
from typing import Any, cast

from orbsoc import _core
from orbsoc.conic import csc
from orbsoc.conic.csc import Array
from orbsoc.conic.errors import ProblemError
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings, refuse_unknown
from orbsoc.conic.solution import Certificate, Solution, Start, Status, WarmStart

from .iteration_table import print_table

Callback = Callable[[Mapping[str, float]], object]
"""Sees each iteration's statistics (keys of `orbsoc.solving.iteration_table.COLUMNS`); a true return value stops the solve."""

DEFAULTS = Settings()


def solve(
    problem: Problem,
    settings: Settings | None = None,
    *,
    warm_start: Solution | Start | None = None,
    callback: Callback | None = None,
    bundle: str | PathLike[str] | None = None,
    **overrides: Any,
) -> Solution:
    """Solve a conic problem in double precision.

    Keyword settings override `settings`: `solve(problem, tol=1e-10)`. Not converging is a status. Ctrl-C ends
    the solve within one iteration (or a millisecond) with `Status.INTERRUPTED` and the best iterate.
    `warm_start` is a point to start from, such as the solution of a problem nearby (see `Solver.solve`).
    `bundle` is where to write what repeats the solve (see orbsoc.solving.bundle) if it does not end with SOLVED.
    Raises TypeError for an unknown setting, ProblemError or ValueError for data that cannot be solved, OSError
    if the bundle cannot be written.

    >>> import orbsoc
    >>> solve(orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=orbsoc.Cones(l=1))).status.name
    'SOLVED'
    """
    solver = Solver(problem, settings, **overrides)
    return solver.solve(warm_start=warm_start, callback=callback, bundle=bundle)


class Solver:
    """A problem's pattern, analysed once, for solving it again with other numbers."""

    def __init__(self, problem: Problem, settings: Settings | None = None, **overrides: Any) -> None:
        self._settings = resolve(settings, overrides)
        self._problem = problem
        self._stale = False
        self._engine = engine(problem, self._settings)
        self._last: Solution | None = None

    def __reduce__(self) -> tuple[type[Solver], tuple[Problem, Settings], dict[str, Solution | None]]:
        """A copy, in this process or another, has these data and the last solution, and analyses the pattern anew."""
        return type(self), (self.problem, self.settings), {"_last": self._last}

    @property
    def settings(self) -> Settings:
        """Those of every solve."""
        return self._settings

    @property
    def problem(self) -> Problem:
        """The data that the next solve solves."""
        if self._stale:
            c, b, h, A, G = self._engine.numbers()
            old = self._problem
            rows = {
                name: csc.from_parts(entries, matrix.indices, matrix.indptr, matrix.shape)
                for name, entries, matrix in (("A", A, old.A), ("G", G, old.G))
            }
            self._problem = Problem(P=old.P, c=c, b=b, h=h, cones=old.cones, **rows)
            self._stale = False
        return self._problem

    def update(self, **data: Any) -> None:
        """Replace data by name (P=, c=, A=, b=, G=, h=), in the same sparsity pattern.

        The data are copied and equilibrated anew: the next solve has the bits of a fresh `Solver`. Quickest are
        float64 vectors, and matrices in SciPy's CSC format with the pattern that `problem` shows.
        Raises ProblemError if a shape or pattern differs, TypeError for an unknown name; then nothing is replaced.
        """
        if self._engine.update_numbers(data):
            self._stale = True
        else:
            self._update_checked(data)

    def _update_checked(self, data: Mapping[str, Any]) -> None:
        unknown = sorted(set(data) - set("PcAbGh"))
        if unknown:
            raise TypeError(f"update() has no data named {unknown[0]!r}; known are P, c, A, b, G, h")
        old = self.problem
        for name, value in data.items():
            csc.refuse_masked(name, value)
            _check_shape(name, value, getattr(old, name).shape)
        copies = {name: value.copy() if hasattr(value, "copy") else value for name, value in data.items()}
        merged: dict[str, Any] = {name: getattr(old, name) for name in "PcAbGh"} | copies
        problem = Problem(**merged, cones=old.cones)
        try:
            self._engine.update(problem)
        except _core.CoreError as error:
            dense = [name for name in "PAG" if data.get(name) is not None and not csc.is_sparse(data[name])]
            fewer = [name for name in dense if getattr(problem, name).nnz < getattr(old, name).nnz]
            lost = any(f"`{name}`" in str(error) for name in fewer)
            hint = "; a zero of a dense matrix is no entry: a sparse one can store it" if lost else ""
            raise ProblemError(f"{error}{hint}") from None
        self._problem = problem

    def solve(
        self,
        *,
        warm_start: bool | Solution | Start | None = None,
        callback: Callback | None = None,
        bundle: str | PathLike[str] | None = None,
    ) -> Solution:
        """Solve the current data; `callback` and `bundle` are those of `orbsoc.solve`.

        `warm_start` is a point to start from: a solution of a problem nearby, an `orbsoc.Start`, or True for
        this solver's last solution, as its holder left it (none before the first). `Solution.warm_start`
        tells what became of it: a rejected one is followed by a restart from cold, and the status is never
        worse than a cold start's.
        Raises ProblemError if the point's sizes are not the problem's, TypeError if it is no point.
        """
        if callback is not None and not callable(callback):
            raise TypeError(f"`callback` is {callback!r}; it must be callable")
        watcher = print_table(callback) if self.settings.verbose else callback
        start = self._last if warm_start is True else warm_start
        values = None if start is None or start is False else start_values(self._problem, start)
        if bundle is not None:
            self._last = self._solve_recorded(watcher, values, bundle)
        else:
            self._last = solution_of(self._engine.solve(watcher, values))
        return self._last

    def _solve_recorded(
        self, callback: Callback | None, start: StartValues | None, place: str | PathLike[str]
    ) -> Solution:
        from .bundle import Bundle, check_place, recording, versions, write_bundle

        check_place(place)
        history: list[Mapping[str, float]] = []
        solution = solution_of(self._engine.solve(recording(history, callback), start))
        if solution.status is not Status.SOLVED:
            point = None if start is None else Start(*start)
            found = Bundle(self.problem, self.settings, solution, tuple(history), versions(), point)
            write_bundle(found, place)
        return solution


def resolve(settings: Settings | None, overrides: Mapping[str, Any]) -> Settings:
    """The settings with overrides; TypeError names an unknown one."""
    if settings is None and all(isinstance(value, Hashable) for value in overrides.values()):
        return _defaults_with(**overrides)
    base = DEFAULTS if settings is None else settings
    check_type("settings", base, Settings)
    refuse_unknown(overrides)
    return replace(base, **overrides) if overrides else base


@lru_cache(maxsize=16, typed=True)
def _defaults_with(**overrides: Any) -> Settings:
    """Kept, as checking fifteen values takes a tenth of a small solve."""
    return Settings(**overrides)


def engine(problem: Problem, settings: Settings) -> _core.Engine:
    """A native engine; what the core refuses becomes a ProblemError."""
    check_type("problem", problem, Problem)
    try:
        return _core.Engine(problem, settings)
    except _core.CoreError as error:
        raise ProblemError(str(error)) from None


StartValues = tuple[Array, Array, Array, Array]


def start_values(problem: Problem, start: object) -> StartValues:
    """x, y, z, s of a point to start from; ProblemError or TypeError if it is none of this problem's sizes."""
    if not isinstance(start, Solution | Start):
        found = type(start).__name__
        raise TypeError(
            f"`warm_start` is of type {found}; it must be an orbsoc.Solution, an orbsoc.Start or a bool"
        )
    sizes = {"x": problem.n, "y": problem.p, "z": problem.m, "s": problem.m}
    x, y, z, s = (
        csc.sized_vector(f"warm_start.{name}", getattr(start, name), size) for name, size in sizes.items()
    )
    return x, y, z, s


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


def check_type(name: str, value: object, wanted: type) -> None:
    if not isinstance(value, wanted):
        raise TypeError(f"`{name}` is of type {type(value).__name__}; it must be an orbsoc.{wanted.__name__}")


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
        warm_start=cast(WarmStart, raw.warm_start),
    )
