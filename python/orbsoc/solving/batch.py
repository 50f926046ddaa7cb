"""Many problems of one sparsity pattern, side by side in SIMD lanes and on threads."""

from __future__ import annotations

import operator
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orbsoc import _core
from orbsoc.conic import csc
from orbsoc.conic.csc import Array
from orbsoc.conic.errors import ProblemError
from orbsoc.conic.problem import Problem, symmetric
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Certificate, Solution, Start, Status, WarmStart
from orbsoc.files.html_table import html_table

from .solver import check_type, resolve

MOST_THREADS = 1024
"""A second to start; twice as many take a minute on a few cores."""

BatchCallback = Callable[[Mapping[str, int]], object]
"""Called with `ended` and `count`: how many problems of the batch have ended."""


@dataclass(frozen=True, slots=True)
class BatchSolution:
    """What `solve_batch` returns, one row a problem; each row has the bits of that problem's own `solve`.

    Shapes: x (B, n), y (B, p), z (B, m), s (B, m); `status` (B,) holds `Status` members, `message` and
    `warm_start` (what became of the point to start from) are lists. In a batch that was stopped, rows that had not begun
    are NaN, INTERRUPTED after 0 iterations, and rows under way may be SOLVED a few iterations early.
    `setup_s` is the wall-clock time of the pattern's analysis, made once for a `BatchSolver`; `solve_s` that of the
    batch, loading and verification included, and in a solver's first batch making the lanes.
    """

    status: NDArray[np.object_]
    x: Array
    y: Array
    z: Array
    s: Array
    objective: Array
    dual_objective: Array
    iterations: NDArray[np.uint32]
    refinements: NDArray[np.uint32]
    primal_residual: Array
    dual_residual: Array
    gap: Array
    radius: Array
    message: list[str]
    warm_start: list[WarmStart]
    setup_s: float
    solve_s: float

    def __len__(self) -> int:
        return len(self.message)

    def __repr__(self) -> str:
        ends = ", ".join(f"{count} {name}" for name, count in self._ends().items())
        return f"BatchSolution({len(self)} problems: {ends})" if ends else "BatchSolution(no problems)"

    def _repr_html_(self) -> str:
        rows = {
            **self._ends(),
            "iterations": f"{self.iterations.min()} to {self.iterations.max()}" if len(self) else "–",
            "set-up, solve": f"{1e3 * self.setup_s:.3f} ms, {1e3 * self.solve_s:.3f} ms",
        }
        return html_table(f"BatchSolution: {len(self)} problems", rows)

    def _ends(self) -> dict[str, int]:
        """How many problems ended with which status."""
        return dict(Counter(status.name for status in self.status))

    def certificates(self) -> Iterator[Certificate]:
        """The certificate of each problem, in order."""
        columns = (self.primal_residual, self.dual_residual, self.gap, self.radius)
        for row in zip(*columns, strict=True):
            yield Certificate(*map(float, row))


class BatchSolver:
    """A pattern made ready for batches, one after another: analysed once, with the memory of its lanes and its threads
    kept.

    `problem` gives the pattern, the cones and whatever a batch does not say. Several may work side by side; one of them
    solves one batch at a time. Raises ProblemError for `threads` < 1 or what the solver refuses, TypeError for what is no
    problem or an unknown setting.

    >>> import numpy as np, orbsoc
    >>> base = orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[0.0], cones=orbsoc.Cones(l=1))
    >>> solver = BatchSolver(base)
    >>> [solver.solve(h=[[-1.0], [-shift]]).x[:, 0].round(6).tolist() for shift in (2.0, 3.0)]
    [[1.0, 2.0], [1.0, 3.0]]
    """

    def __init__(
        self, problem: Problem, settings: Settings | None = None, *, threads: int = 1, **overrides: Any
    ) -> None:
        check_type("problem", problem, Problem)
        try:
            threads = operator.index(threads)
        except TypeError:
            raise TypeError(f"`threads` is {threads!r}; it must be a whole number") from None
        if not 1 <= threads <= MOST_THREADS:
            raise ProblemError(f"`threads` is {threads}; it must be at least 1, and at most {MOST_THREADS}")
        self._problem, self._settings, self._threads = problem, resolve(settings, overrides), threads
        try:
            self._core = _core.BatchSolver(problem, self._settings, threads)
        except _core.CoreError as error:
            raise ProblemError(str(error)) from None

    def __reduce__(self) -> tuple[partial[BatchSolver], tuple[Problem, Settings]]:
        """A copy, in this process or another, analyses the pattern anew."""
        return partial(type(self), threads=self._threads), (self._problem, self._settings)

    @property
    def problem(self) -> Problem:
        """Pattern, cones, and the numbers that a batch does not give."""
        return self._problem

    @property
    def settings(self) -> Settings:
        """Those of every batch."""
        return self._settings

    def solve(
        self,
        *,
        c: ArrayLike | None = None,
        b: ArrayLike | None = None,
        h: ArrayLike | None = None,
        A: ArrayLike | None = None,
        G: ArrayLike | None = None,
        P: ArrayLike | None = None,
        warm_start: BatchSolution | Solution | Start | None = None,
        callback: BatchCallback | None = None,
    ) -> BatchSolution:
        """Solve one batch; the arguments are those of `orbsoc.solve_batch`, and so are the errors."""
        if callback is not None and not callable(callback):
            raise TypeError(f"`callback` is {callback!r}; it must be callable")
        given = {"c": c, "b": b, "h": h, "A": A, "G": G, "P": P}
        rows, count = _checked(self._problem, given)
        start = None if warm_start is None else _starts(self._problem, count, warm_start)
        try:
            raw = self._core.solve(count, **rows, start=start, callback=callback)
        except _core.CoreError as error:
            raise ProblemError(str(error)) from None
        status = np.empty(len(raw.status), dtype=object)
        status[:] = [Status[name] for name in raw.status]
        fields = BatchSolution.__dataclass_fields__
        return BatchSolution(
            status=status, **{name: getattr(raw, name) for name in fields if name != "status"}
        )


def solve_batch(
    problem: Problem,
    *,
    c: ArrayLike | None = None,
    b: ArrayLike | None = None,
    h: ArrayLike | None = None,
    A: ArrayLike | None = None,
    G: ArrayLike | None = None,
    P: ArrayLike | None = None,
    warm_start: BatchSolution | Solution | Start | None = None,
    callback: BatchCallback | None = None,
    settings: Settings | None = None,
    threads: int = 1,
    **overrides: Any,
) -> BatchSolution:
    """Solve B problems that share the sparsity pattern and cones of `problem`; `BatchSolver` is for batch after batch.

    Vectors come as (B, length), matrices as values (B, nnz) in the CSC order of `problem`; what is absent is
    shared. At least one must be given. +inf in `h` must stand on the same rows in every problem.
    `warm_start` holds the points to start from, one row a problem, or one point for all; see `Solver.solve`.
    All numbers are checked before the first problem is solved.
    `callback` sees how far the batch is: every millisecond while they are, at the beginning, after each iteration of
    the lanes (about every millisecond with several threads) and at the end. When it returns true, or on Ctrl-C, the
    batch ends: what has ended is kept, rows under way end with their best iterate, INTERRUPTED if that does not meet
    `tol`, the rest have none. An exception of its own comes out of here, and KeyboardInterrupt when all rows had ended
    by the time of Ctrl-C.
    `verbose` prints nothing here.
    Raises ProblemError for shapes that do not fit, numbers that are not finite, a `P` that is not symmetric positive
    semidefinite, or `threads` < 1.

    >>> import numpy as np, orbsoc
    >>> base = orbsoc.Problem(c=[1.0], G=[[-1.0]], h=[0.0], cones=orbsoc.Cones(l=1))
    >>> solve_batch(base, h=-np.arange(1.0, 4.0)[:, None]).x[:, 0].round(6)
    array([1., 2., 3.])
    """
    solver = BatchSolver(problem, settings, threads=threads, **overrides)
    return solver.solve(c=c, b=b, h=h, A=A, G=G, P=P, warm_start=warm_start, callback=callback)


def _checked(problem: Problem, given: dict[str, ArrayLike | None]) -> tuple[dict[str, Array], int]:
    """The batch's arrays by the core's names, and how many problems they are; ProblemError for what does not fit."""
    widths = {"c": problem.n, "b": problem.p, "h": problem.m}
    widths |= {"A": problem.A.nnz, "G": problem.G.nnz, "P": problem.P.nnz}
    rows = {name: _rows(name, value, widths[name]) for name, value in given.items() if value is not None}
    counts = {name: len(value) for name, value in rows.items()}
    if not counts:
        raise ProblemError("a batch needs at least one of c, b, h, A, G, P with one row a problem")
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"`{name}` has {count}" for name, count in counts.items())
        raise ProblemError(f"the batch's arrays have different numbers of rows: {listed}")
    if "P" in rows:
        rows["P"] = _upper_values(problem, rows["P"])
    return {name.lower(): value for name, value in rows.items()}, next(iter(counts.values()))


def _rows(name: str, value: ArrayLike, width: int) -> Array:
    array = np.ascontiguousarray(csc.real_numbers(name, value), dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != width:
        raise ProblemError(f"`{name}` has shape {array.shape}; it must be (B, {width}), one row a problem")
    return array


def _starts(problem: Problem, count: int, start: object) -> list[Array]:
    """x, y, z, s of the points to start from, one row a problem; TypeError for what is no such points."""
    if not isinstance(start, BatchSolution | Solution | Start):
        found = type(start).__name__
        raise TypeError(
            f"`warm_start` is of type {found}; it must be an orbsoc.BatchSolution, Solution or Start"
        )
    rows = []
    widths = {"x": problem.n, "y": problem.p, "z": problem.m, "s": problem.m}
    for name, width in widths.items():
        values = np.asarray(csc.real_numbers(f"warm_start.{name}", getattr(start, name)), dtype=np.float64)
        if values.shape not in ((width,), (count, width)):
            raise ProblemError(
                f"`warm_start.{name}` has shape {values.shape}; it must be ({count}, {width}), or ({width},) for all"
            )
        rows.append(np.ascontiguousarray(np.broadcast_to(values, (count, width))))
    return rows


def _upper_values(problem: Problem, values: Array) -> Array:
    """Entries on and above the diagonal; ProblemError where a row is no symmetric matrix that `Problem` would take."""
    P = problem.P
    rows, columns = P.indices, csc.column_of_entry(P)
    above = np.flatnonzero(rows <= columns)
    upper = values.take(above, axis=1)
    lower = values.take(np.lexsort((columns, rows))[above], axis=1)
    uneven = upper != lower
    for k in np.flatnonzero(uneven.any(axis=1)):
        if np.isfinite(values[k]).all():  # the core names numbers that are not
            try:
                symmetric(csc.from_parts(values[k], P.indices, P.indptr, P.shape))
            except ProblemError as error:
                raise ProblemError(f"problem {k} of the batch: {error}") from None
            with np.errstate(over="ignore"):
                upper[k] = np.where(uneven[k], (upper[k] + lower[k]) * 0.5, upper[k])
        else:
            upper[k] = np.where(uneven[k], np.nan, upper[k])
    return upper
