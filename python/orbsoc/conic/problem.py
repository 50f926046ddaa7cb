"""The conic problem in standard form: its data, checked once, when it is built."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from orbsoc import _core
from orbsoc.files.html_table import html_table
from orbsoc.files.json_fields import FieldError, read_json, write_json

from . import csc
from .cones import Cones
from .csc import Array, Csc, Matrix
from .errors import ProblemError
from .problem_file import decode_problem, encode_problem

__all__ = ["Cones", "Problem", "ProblemError"]

SYMMETRY_TOLERANCE = 1e-12
"""Largest |Pᵢⱼ − Pⱼᵢ| over √(Pᵢᵢ Pⱼⱼ), which bounds |Pᵢⱼ|, taken for rounding (and averaged away)."""
ABSENT_FROM = 1e20
"""From here on a bound in h of an R₊ row is +inf: as a number it would make every primal tolerance worthless."""


@dataclass(frozen=True, slots=True, init=False, eq=False)
class Problem:
    """min ½xᵀPx + cᵀx subject to Ax = b, Gx + s = h, s ∈ K.

    Shapes: P (n, n) symmetric positive semidefinite, c (n,), A (p, n), b (p,), G (m, n), h (m,),
    K = `cones` of m rows, its R₊ rows first. Absent matrices become empty ones. `h = +inf` on an R₊ row means
    that the row does not constrain; 1e20 and more become +inf there. Matrices come in any SciPy format or as dense arrays and are held as CSC
    with sorted, unique 32-bit indices; what already is so is kept without a copy, and must not be changed.

    Raises ProblemError for wrong shapes, NaN or infinite data, cones that do not add up, P not symmetric or
    not positive semidefinite, and sizes beyond 32-bit indices.

    >>> Problem(c=[1.0, 2.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(l=2))
    Problem(n=2, p=0, m=2, l=2, q=(), nnz: P 0, A 0, G 2)
    """

    c: Array
    b: Array
    h: Array
    cones: Cones
    _data: _core.ProblemData
    _matrices: dict[str, Csc]

    def __init__(
        self,
        *,
        P: Matrix | None = None,
        c: ArrayLike,
        A: Matrix | None = None,
        b: ArrayLike | None = None,
        G: Matrix | None = None,
        h: ArrayLike | None = None,
        cones: Cones | None = None,
    ) -> None:
        # One pass over plain data. Others, and data with a fault, take the checks one by one, which name it.
        whole = Cones() if cones is None else cones
        plain = type(whole) is Cones and _core.ProblemData.plain(P, c, A, b, G, h, whole.l, whole.q)
        if not plain:
            self._check(P, c, A, b, G, h, cones)
            return
        data, matrices = plain
        self._hold(
            c=c if type(c) is np.ndarray else data.vector("c"),
            b=b if type(b) is np.ndarray else data.vector("b"),
            h=h if type(h) is np.ndarray else data.vector("h"),
            cones=whole,
            _data=data,
            _matrices=matrices,
        )

    def _check(
        self,
        P: Matrix | None,
        c: ArrayLike,
        A: Matrix | None,
        b: ArrayLike | None,
        G: Matrix | None,
        h: ArrayLike | None,
        cones: Cones | None,
    ) -> None:
        """Take data that are not plain, or say what is wrong with them."""
        cost = csc.vector("c", c)
        n = cost.size
        if n == 0:
            raise ProblemError("`c` is empty; a problem needs at least one variable")
        _finite_vector("c", cost)
        quadratic = csc.empty(n, n) if P is None else _convex(symmetric(_square(P, n)))
        equalities, b_ = _rows("A", A, "b", b, n)
        _finite_vector("b", b_)
        inequalities, h_ = _rows("G", G, "h", h, n)
        m = h_.size
        if cones is None:
            if m:
                raise ProblemError(
                    f"`cones` is missing, but G has {m} rows; Cones(l={m}) makes each an inequality"
                )
            cones = Cones()
        if not isinstance(cones, Cones):
            raise TypeError(f"`cones` is of type {type(cones).__name__}; it must be an orbsoc.Cones")
        if cones.m != m:
            raise ProblemError(
                f"`cones` add up to {cones.m} rows (l = {cones.l}, q = {_short(cones.q)}), but G has {m} rows"
            )
        held = _Checked(quadratic, cost, equalities, b_, inequalities, _checked_bounds(h_, cones.l), cones)
        try:
            data = _core.ProblemData(held)
        except _core.CoreError as error:
            raise ProblemError(str(error)) from None
        self._hold(
            c=held.c,
            b=held.b,
            h=held.h,
            cones=cones,
            _data=data,
            _matrices={"P": quadratic, "A": equalities, "G": inequalities},
        )

    def _hold(self, **fields: object) -> None:
        for name, value in fields.items():
            object.__setattr__(self, name, value)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self.P, self.c, self.A, self.b, self.G, self.h, self.cones)

    @property
    def P(self) -> Csc:
        """Matrix of the quadratic cost, (n, n)."""
        return self._matrix("P")

    @property
    def A(self) -> Csc:
        """Matrix of the equalities, (p, n)."""
        return self._matrix("A")

    @property
    def G(self) -> Csc:
        """Matrix of the cone rows, (m, n)."""
        return self._matrix("G")

    def _matrix(self, name: str) -> Csc:
        """A matrix; SciPy makes one that was not given as it is held when it is first asked for."""
        kept = self._matrices.get(name)
        return (
            self._matrices.setdefault(name, csc.from_parts(*self._data.matrix(name)))
            if kept is None
            else kept
        )

    @classmethod
    def from_upper(cls, P: Matrix, **arguments: Any) -> Problem:
        """The problem whose quadratic cost is given by the upper triangle (with diagonal) of P.

        Raises ProblemError if an entry lies below the diagonal; other arguments are those of `Problem`.
        """
        upper = _square(P, np.shape(P)[1] if np.ndim(P) == 2 else 0)
        columns = csc.column_of_entry(upper)
        below = np.flatnonzero(upper.indices > columns)
        if below.size:
            k = below[0]
            raise ProblemError(
                f"`P[{upper.indices[k]}, {columns[k]}]` lies below the diagonal;"
                " from_upper takes the upper triangle only"
            )
        return cls(P=csc.mirrored(upper), **arguments)

    @property
    def n(self) -> int:
        """Number of variables."""
        return self.c.size

    @property
    def p(self) -> int:
        """Number of equality rows."""
        return self.b.size

    @property
    def m(self) -> int:
        """Number of cone rows."""
        return self.h.size

    def save(self, path: str | PathLike[str]) -> None:
        """Write the problem to a JSON file of schema `orbsoc.problem/1` (see orbsoc.conic.problem_file)."""
        write_json(encode_problem(self), path)

    @staticmethod
    def load(path: str | PathLike[str]) -> Problem:
        """Read a JSON file of schema `orbsoc.problem/1`; every number comes back exactly.

        Raises ProblemError naming the field that is missing or damaged, OSError if there is no such file.
        """
        try:
            return Problem(**decode_problem(read_json(path)))
        except (FieldError, ProblemError) as error:
            raise ProblemError(f"{fspath(path)}: {error}") from error

    def __repr__(self) -> str:
        return (
            f"Problem(n={self.n}, p={self.p}, m={self.m}, l={self.cones.l}, q={_short(self.cones.q)}, "
            f"nnz: P {self.P.nnz}, A {self.A.nnz}, G {self.G.nnz})"
        )

    def _repr_html_(self) -> str:
        rows = {
            "variables n": self.n,
            "equality rows p": self.p,
            "cone rows m": self.m,
            "cones": f"R₊ of {self.cones.l} rows; second-order {_short(self.cones.q)}",
            "entries of P, A, G": f"{self.P.nnz}, {self.A.nnz}, {self.G.nnz}",
        }
        return html_table("Problem: min ½xᵀPx + cᵀx, Ax = b, Gx + s = h, s ∈ K", rows)


@dataclass(frozen=True, slots=True)
class _Checked:
    """Canonical data, for the core to take."""

    P: Csc
    c: Array
    A: Csc
    b: Array
    G: Csc
    h: Array
    cones: Cones


def _rebuilt(P: Csc, c: Array, A: Csc, b: Array, G: Csc, h: Array, cones: Cones) -> Problem:
    return Problem(P=P, c=c, A=A, b=b, G=G, h=h, cones=cones)


def _short(sizes: Sequence[int]) -> str:
    if len(sizes) <= 8:
        return str(tuple(sizes))
    return f"({', '.join(map(str, sizes[:6]))}, … {len(sizes)} cones)"


def _finite_vector(name: str, values: Array) -> None:
    if not csc.all_finite(values):
        k = int(np.flatnonzero(~np.isfinite(values))[0])
        raise ProblemError(f"`{name}[{k}]` is {values[k]}; it must be finite")


def _checked_bounds(h: Array, l: int) -> Array:
    """h with +inf for the R₊ rows, the first `l`, that have no bound."""
    if l and h[:l].max() >= ABSENT_FROM:
        h = np.concatenate([np.where(h[:l] >= ABSENT_FROM, np.inf, h[:l]), h[l:]])
    if csc.all_finite(h):
        return h
    allowed = np.isfinite(h)
    allowed[:l] |= h[:l] == np.inf
    if not allowed.all():
        k = int(np.flatnonzero(~allowed)[0])
        rule = (
            "finite, or +inf for no constraint"
            if k < l
            else "finite, because the row is in a second-order cone"
        )
        raise ProblemError(f"`h[{k}]` is {h[k]}; it must be {rule}")
    return h


def _rows(
    matrix_name: str, matrix: Matrix | None, name: str, vector: ArrayLike | None, n: int
) -> tuple[Csc, Array]:
    """A block of rows and its right-hand side, both given or both absent."""
    if matrix is None:
        side = np.zeros(0) if vector is None else csc.vector(name, vector)
        if side.size:
            raise ProblemError(f"`{name}` has {side.size} entries, but {matrix_name} is missing")
        return csc.empty(0, n), side
    block = csc.canonical(matrix_name, matrix, n)
    rows = block.shape[0]
    if vector is None:
        if rows:
            raise ProblemError(f"`{name}` is missing, but {matrix_name} has {rows} rows")
        return block, np.zeros(0)
    side = csc.vector(name, vector)
    if side.size != rows:
        raise ProblemError(f"`{name}` has {side.size} entries, but {matrix_name} has {rows} rows")
    return block, side


def _square(P: Matrix, n: int) -> Csc:
    matrix = csc.canonical("P", P, n)
    if matrix.shape[0] != n:
        raise ProblemError(f"`P` has {matrix.shape[0]} rows, but c has {n} entries")
    return matrix


def symmetric(P: Csc) -> Csc:
    """P if symmetric, up to rounding, which is averaged away; otherwise ProblemError with the reason why not."""
    rows, columns = P.indices, csc.column_of_entry(P)
    if np.array_equal(rows, columns):
        return P
    upper, lower = rows < columns, rows > columns
    used = P.data != 0.0
    if (upper & used).any() != (lower & used).any():
        raise ProblemError(
            "`P` has entries on one side of its diagonal only; P takes the full symmetric matrix,"
            " Problem.from_upper the upper triangle"
        )
    order = np.argsort(rows * np.int64(P.shape[0]) + columns, kind="stable")
    mirrored = np.array_equal(rows[order], columns) and np.array_equal(columns[order], rows)
    return P if mirrored and np.array_equal(P.data[order], P.data) else _averaged(P)


def _convex(P: Csc) -> Csc:
    try:
        _core.check_cost(P)
    except _core.CoreError as error:
        raise ProblemError(str(error)) from None
    return P


def _averaged(P: Csc) -> Csc:
    """(P + Pᵀ)/2 where the two differ by rounding; raises ProblemError naming the worst pair where by more."""
    values, rows, columns = csc.entries(csc.difference(P, P.T))
    roots = np.sqrt(np.abs(P.diagonal()))
    excess = np.abs(values) - SYMMETRY_TOLERANCE * roots[rows] * roots[columns]
    if excess.size and excess.max() > 0.0:
        worst = int(np.argmax(excess))
        i, j = int(rows[worst]), int(columns[worst])
        pair = csc.entry(P, i, j), csc.entry(P, j, i)
        raise ProblemError(f"`P` is not symmetric: P[{i}, {j}] is {pair[0]}, but P[{j}, {i}] is {pair[1]}")
    return csc.symmetric_part(P)
