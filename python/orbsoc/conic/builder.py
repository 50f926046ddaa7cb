"""Build a conic problem from named variables and blocks of rows."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import csc
from .csc import Array, Csc
from .named_rows import HasDuals, HasStatus, Kind, NamedBlock, TwoSidedBlock, conflict, shares
from .outcome import Status
from .problem import Cones, Problem, ProblemError

Index = NDArray[np.intp]
Block = Any
"""A (rows, k) array, or a SciPy sparse matrix of that shape."""


class BuilderError(ProblemError):
    """A name or a shape given to the builder is wrong; the message names it."""


class HasPoint(Protocol):
    """Anything with a primal point `x`, a `Solution` for one."""

    @property
    def x(self) -> Array: ...


@dataclass(frozen=True, slots=True, eq=False)
class Variable:
    """A named array of unknowns; `index` (of the variable's shape) holds their columns in the problem."""

    name: str
    index: Index

    @property
    def shape(self) -> tuple[int, ...]:
        return self.index.shape


Columns = Variable | ArrayLike
"""A variable, or columns of the problem (usually a slice of some `Variable.index`)."""
Term = tuple[Columns, Block]
"""(columns (k,), block (rows, k)): the product block · x[columns]."""
Bound = Variable | ArrayLike
"""Of norms: a variable or an integer array of columns (a slice of some `Variable.index`), one a norm; or numbers."""


class _Rows:
    """Rows under construction: coordinate entries, right-hand sides, and how many rows there are."""

    def __init__(self) -> None:
        self.count = 0
        self._rows: list[Index] = []
        self._columns: list[Index] = []
        self._values: list[Array] = []
        self._sides: list[Array] = []

    def add(self, entries: list[tuple[Index, Index, Array]], side: Array) -> None:
        for rows, columns, values in entries:
            self._rows.append(rows + self.count)
            self._columns.append(columns)
            self._values.append(values)
        self._sides.append(side)
        self.count += side.size

    def side(self) -> Array:
        return np.concatenate(self._sides) if self._sides else np.zeros(0)

    def entries(self) -> tuple[Index, Index, Array]:
        if not self._rows:
            return np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0)
        return np.concatenate(self._rows), np.concatenate(self._columns), np.concatenate(self._values)


class ConicBuilder:
    """Collects variables, costs and rows; `build` puts them into standard form, R₊ rows before the cones.

    Exact zeros of dense blocks are left out; every stored entry of a sparse block is kept, zero or not, so a sparse
    block fixes the pattern of a problem that is built again with other values; so does `zeros` of the dense blocks of rows.

    >>> b = ConicBuilder()
    >>> x = b.variable("x", 2)
    >>> b.cost(x, [1.0, 1.0])
    >>> b.second_order([(x, [[0, 0], [-1, 0], [0, -1]])], [1.0, 0.0, 0.0])  # ‖x‖ ≤ 1
    >>> b.build()
    Problem(n=2, p=0, m=3, l=0, q=(3,), nnz: P 0, A 0, G 2)
    """

    def __init__(self) -> None:
        self._n = 0
        self._variables: dict[str, Variable] = {}
        self._costs: list[tuple[Index, Array]] = []
        self._quadratic = _Rows()
        self._equality = _Rows()
        self._nonnegative = _Rows()
        self._cone_rows = _Rows()
        self._cone_sizes: list[int] = []
        self._named: dict[str, NamedBlock | TwoSidedBlock] = {}

    def variable(self, name: str, shape: int | tuple[int, ...] = ()) -> Variable:
        """New unknowns of `shape` (row-major columns); raises BuilderError if the name is taken or the shape empty."""
        if name in self._variables:
            raise BuilderError(f"variable `{name}` exists already")
        dimensions = (shape,) if isinstance(shape, int) else tuple(shape)
        if any(d < 1 for d in dimensions):
            raise BuilderError(f"variable `{name}` has shape {dimensions}; every dimension must be 1 or more")
        size = int(np.prod(dimensions, dtype=np.intp))
        variable = Variable(name, np.arange(self._n, self._n + size, dtype=np.intp).reshape(dimensions))
        variable.index.setflags(write=False)
        self._variables[name] = variable
        self._n += size
        return variable

    def has(self, name: str) -> bool:
        """Whether there is a variable `name`."""
        return name in self._variables

    def columns(self, name: str) -> Index:
        """Columns of variable `name`, in its shape; raises BuilderError if there is none."""
        if name not in self._variables:
            raise BuilderError(f"no variable `{name}`; there are {', '.join(self._variables) or 'none'}")
        return self._variables[name].index

    def cost(self, columns: Columns, coefficients: ArrayLike) -> None:
        """Add Σ coefficients · x[columns] to the cost; coefficients have the columns' shape or are one number."""
        index = self._index("cost", columns)
        values = np.asarray(coefficients, dtype=np.float64)
        if values.ndim and values.shape != index.shape:
            raise BuilderError(
                f"cost: coefficients have shape {values.shape}, but columns have shape {index.shape}"
            )
        self._costs.append((index.ravel(), np.broadcast_to(values, index.shape).ravel()))

    def quadratic_cost(self, columns: Columns, block: Block) -> None:
        """Add ½ x[columns]ᵀ · block · x[columns] to the cost; block is (k, k), symmetric positive semidefinite."""
        index = self._index("quadratic_cost", columns).ravel()
        rows, positions, values = self._entries("quadratic_cost", 0, index, block, index.size)
        self._quadratic.add([(index[rows], positions, values)], np.zeros(0))

    def equality(self, terms: Iterable[Term], rhs: ArrayLike, *, name: str | None = None) -> None:
        """Add rows Σ block · x[columns] = rhs; rhs is (rows,) or one number for all rows.

        A `name`, here and below, is what `dual` and `why` know the rows by.
        """
        self._add("equality", self._equality, *self._prepare("equality", terms, rhs), name)

    def nonnegative(
        self, terms: Iterable[Term], rhs: ArrayLike, *, zeros: bool = False, name: str | None = None
    ) -> None:
        """Add rows rhs − Σ block · x[columns] ≥ 0; rhs is (rows,) or one number for all rows.

        With `zeros`, here and below, those of dense blocks are stored, so that other numbers make the same pattern.
        """
        self._add("nonnegative", self._nonnegative, *self._prepare("nonnegative", terms, rhs, zeros), name)

    def between(
        self, lower: ArrayLike, terms: Iterable[Term], upper: ArrayLike, *, name: str | None = None
    ) -> None:
        """Add rows lower ≤ Σ block · x[columns] ≤ upper; each bound is (rows,) or one number for all rows.

        Two equal bounds make one equality, an infinite bound makes no row. The dual of the rows is (rows,): positive
        where the upper bound holds a row, negative where the lower one does, so that c + Px + Mᵀ·dual + … = 0 with M
        the blocks. Raises BuilderError where a lower bound is above the upper one, NaN, or at the wrong infinity.

        >>> b = ConicBuilder()
        >>> x = b.variable("x", 3)
        >>> b.between([0.0, 1.0, -np.inf], [(x, np.eye(3))], [2.0, 1.0, 5.0])  # 0 ≤ x₀ ≤ 2, x₁ = 1, x₂ ≤ 5
        >>> b.build()
        Problem(n=3, p=1, m=3, l=3, q=(), nnz: P 0, A 1, G 3)
        """
        vector = lower if np.ndim(lower) else upper
        entries, side = self._prepare("between", terms, vector)
        low, high = (
            self._each("between", "lower", lower, side.size),
            self._each("between", "upper", upper, side.size),
        )
        wrong = np.flatnonzero(~(low <= high) | (low == np.inf) | (high == -np.inf))
        if wrong.size:
            k = wrong[0]
            raise BuilderError(f"between: row {k} is to lie between {low[k]} and {high[k]}")
        equal = low == high
        parts = [
            self._part("equality", self._equality, entries, low, equal, 1.0),
            self._part("nonnegative", self._nonnegative, entries, high, ~equal & (high < np.inf), 1.0),
            self._part("nonnegative", self._nonnegative, entries, low, ~equal & (low > -np.inf), -1.0),
        ]
        self._name(name, TwoSidedBlock(low.size, tuple(parts)))

    def bounds(
        self, columns: Columns, lower: ArrayLike, upper: ArrayLike, *, name: str | None = None
    ) -> None:
        """Add lower ≤ x[columns] ≤ upper; the rules, and the dual, are those of `between`."""
        index = self._index("bounds", columns).ravel()
        low, high = (
            self._each("bounds", "lower", lower, index.size),
            self._each("bounds", "upper", upper, index.size),
        )
        self.between(low, [(index, csc.identity(index.size))], high, name=name)

    def _part(
        self,
        kind: Kind,
        target: _Rows,
        entries: list[tuple[Index, Index, Array]],
        side: Array,
        keep: NDArray[np.bool_],
        sign: float,
    ) -> tuple[NamedBlock, Index, float]:
        """Add `sign` times the rows where `keep` is true; where they stand, which they are, and their sign."""
        rows = np.flatnonzero(keep)
        place = np.cumsum(keep) - 1
        kept = [(at, keep[at], columns, values) for at, columns, values in entries]
        block = NamedBlock(kind, target.count, rows.size)
        target.add([(place[at][k], c[k], sign * v[k]) for at, k, c, v in kept], sign * side[rows])
        return block, rows, sign

    def second_order(
        self,
        terms: Iterable[Term],
        rhs: ArrayLike,
        size: int | None = None,
        *,
        zeros: bool = False,
        name: str | None = None,
    ) -> None:
        """Add rows rhs − Σ block · x[columns] ∈ Q^size × Q^size × …; without `size`, one cone of all rows."""
        prepared, side = self._prepare("second_order", terms, rhs, zeros)
        each = side.size if size is None else size
        if each < 1 or side.size % each:
            raise BuilderError(f"second_order: {side.size} rows do not divide into cones of size {each}")
        self._add("cone", self._cone_rows, prepared, side, name, each)
        self._cone_sizes += [each] * (side.size // each)

    def norm(
        self,
        terms: Iterable[Term],
        offset: ArrayLike = 0.0,
        *,
        bound: Bound,
        margin: ArrayLike = 0.0,
        size: int | None = None,
        name: str | None = None,
    ) -> None:
        """Add ‖Σ block · x[columns] + offset‖ ≤ bound − margin; with `size`, one such norm for every `size` rows.

        `offset` is (rows,) or one number, `margin` one a norm or one number. `bound` is one number for all norms or one a norm, or the variable or
        columns (integers) that bound them, one a norm. The dual of the rows is (norms, size + 1), the bound's first.

        >>> b = ConicBuilder()
        >>> x, t = b.variable("x", 2), b.variable("t", 1)
        >>> b.norm([(x, [[1, 0], [0, 1]])], [3.0, 4.0], bound=t)  # ‖x + (3, 4)‖ ≤ t
        >>> b.build().G.toarray().tolist()
        [[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]
        """
        entries, side = self._prepare("norm", terms, offset)
        each = side.size if size is None else size
        if each < 1 or side.size % each:
            raise BuilderError(f"norm: {side.size} rows do not divide into norms of size {each}")
        norms = side.size // each
        rows = np.arange(side.size)
        rows += rows // each + 1
        heads = np.arange(norms) * (each + 1)
        prepared = [(rows[where], columns, -values) for where, columns, values in entries]
        h = np.empty(norms * (each + 1))
        h[rows], h[heads] = side, -self._each("norm", "margin", margin, norms)
        if isinstance(bound, Variable) or (np.asarray(bound).dtype.kind in "iu" and np.ndim(bound)):
            columns = self._index("norm", bound).ravel()
            if columns.size != norms:
                raise BuilderError(
                    f"norm: {columns.size} columns bound {norms} norms; there must be one a norm"
                )
            prepared.append((heads, columns, np.full(norms, -1.0)))
        else:
            h[heads] += self._each("norm", "bound", bound, norms)
        self._add("cone", self._cone_rows, prepared, h, name, each + 1)
        self._cone_sizes += [each + 1] * norms

    @staticmethod
    def _each(where: str, what: str, value: ArrayLike, count: int) -> Array:
        numbers = np.asarray(value, dtype=np.float64)
        if numbers.shape not in ((), (count,)):
            raise BuilderError(
                f"{where}: {what} has shape {numbers.shape}; it must be ({count},) or one number"
            )
        return np.broadcast_to(numbers, (count,))

    def sum_of_norms(
        self, name: str, terms: Iterable[Term], offset: ArrayLike = 0.0, *, size: int, weight: float = 1.0
    ) -> Variable:
        """Add weight · Σᵢ ‖rows i of (Σ block · x[columns] + offset)‖ to the cost, a norm for every `size` rows.

        Returns the bounds of the norms: the variable `name`, (norms,). Their rows have the same name.
        """
        terms = list(terms)
        count = self._prepare("sum_of_norms", terms, offset)[1].size
        if size < 1 or count % size:
            raise BuilderError(f"sum_of_norms: {count} rows do not divide into norms of size {size}")
        bounds = self.variable(name, count // size)
        self.norm(terms, offset, bound=bounds, size=size, name=name)
        self.cost(bounds, weight)
        return bounds

    def sum_of_absolutes(
        self, name: str, terms: Iterable[Term], offset: ArrayLike = 0.0, *, weight: float = 1.0
    ) -> Variable:
        """Add weight · Σᵢ |row i of (Σ block · x[columns] + offset)| to the cost.

        Returns the bounds of the rows: the variable `name`, (rows,). Their rows have the same name: v ≤ bound for all,
        then −v ≤ bound for all.
        """
        entries, side = self._prepare("sum_of_absolutes", terms, offset)
        bounds = self.variable(name, side.size)
        rows = np.arange(side.size)
        minus = [(at + side.size, columns, -values) for at, columns, values in entries]
        entries += [*minus, *((rows + k * side.size, bounds.index, np.full(side.size, -1.0)) for k in (0, 1))]
        self._add("nonnegative", self._nonnegative, entries, np.concatenate([-side, side]), name)
        self.cost(bounds, weight)
        return bounds

    def build(self) -> Problem:
        """The problem in standard form; raises BuilderError without variables, ProblemError on bad numbers."""
        if not self._n:
            raise BuilderError("no variables: call variable(name, shape) first")
        c = np.zeros(self._n)
        for index, values in self._costs:
            np.add.at(c, index, values)
        l = self._nonnegative.count
        upper, lower = self._nonnegative.entries(), self._cone_rows.entries()
        cone_entries = (
            np.concatenate([upper[0], lower[0] + l]),
            np.concatenate([upper[1], lower[1]]),
            np.concatenate([upper[2], lower[2]]),
        )
        h = np.concatenate([self._nonnegative.side(), self._cone_rows.side()])
        P = self._assemble(self._quadratic.entries(), self._n)
        return Problem(
            P=P if P.nnz else None,
            c=c,
            A=self._assemble(self._equality.entries(), self._equality.count),
            b=self._equality.side(),
            G=self._assemble(cone_entries, h.size),
            h=h,
            cones=Cones(l, self._cone_sizes),
        )

    def value(self, solution: HasPoint, name: str) -> Array:
        """The values of variable `name` at a solution of the built problem, in the variable's shape."""
        columns = self.columns(name)
        if solution.x.shape != (self._n,):
            raise BuilderError(
                f"the solution has {solution.x.shape} entries, but the variables are {self._n}"
            )
        return np.asarray(solution.x[columns])

    def dual(self, solution: HasDuals, name: str) -> Array:
        """The multipliers of the rows `name` at a solution of the built problem.

        Those of `equality`, `nonnegative`, `between` and `bounds` are (rows,), those of `second_order` and `norm` (cones, rows of a cone).
        With y for the equalities and z ∈ K for the rest, c + Px + Aᵀy + Gᵀz = 0.
        """
        if name not in self._named:
            raise BuilderError(f"no rows `{name}`; there are {', '.join(self._named) or 'none with a name'}")
        self._check_rows(solution)
        return np.array(self._named[name].of(solution.y, solution.z, self._nonnegative.count))

    def rows(self, name: str) -> Index:
        """Where the rows `name`, of `nonnegative`, `second_order` or `norm`, are in G and h of the built problem."""
        block = self._named.get(name)
        if not isinstance(block, NamedBlock) or block.kind == "equality":
            raise BuilderError(f"no rows `{name}` of one kind in a cone")
        first = block.start + (self._nonnegative.count if block.kind == "cone" else 0)
        return np.arange(first, first + block.count)

    def why(self, solution: HasStatus, h: Array | None = None) -> str:
        """In a sentence, which named rows take part in the proof that the built problem has no feasible point.

        Their shares are of Σ|bᵀy| + Σ|hᵀz| in the certificate; rows without a name are told together. `h`, if it is another
        than that which was built.
        """
        if solution.status is not Status.PRIMAL_INFEASIBLE:
            return f"there is no proof of infeasibility: the solve ended with {solution.status.name}"
        self._check_rows(solution)
        side = np.concatenate([self._nonnegative.side(), self._cone_rows.side()]) if h is None else h
        return conflict(shares(self._named, solution, self._equality.side(), side, self._nonnegative.count))

    def _check_rows(self, solution: HasDuals) -> None:
        expected = (self._equality.count, self._nonnegative.count + self._cone_rows.count)
        if (solution.y.size, solution.z.size) != expected:
            raise BuilderError(
                f"the solution has {solution.y.size} and {solution.z.size} multipliers,"
                f" but the rows are {expected[0]} and {expected[1]}"
            )

    def _assemble(self, entries: tuple[Index, Index, Array], rows: int) -> Csc:
        where_rows, where_columns, values = entries
        return csc.from_entries(values, where_rows, where_columns, (rows, self._n))

    def _index(self, where: str, columns: Columns) -> Index:
        if isinstance(columns, Variable):
            if self._variables.get(columns.name) is not columns:
                raise BuilderError(f"{where}: variable `{columns.name}` belongs to another builder")
            return columns.index
        index = np.asarray(columns)
        if index.dtype.kind not in "iu":
            raise BuilderError(f"{where}: columns have type {index.dtype}; they must be integers")
        if index.size and (index.min() < 0 or index.max() >= self._n):
            worst = index.min() if index.min() < 0 else index.max()
            raise BuilderError(f"{where}: column {worst} is not one of the {self._n} variables")
        return index.astype(np.intp, copy=False)

    def _add(
        self,
        kind: Kind,
        target: _Rows,
        entries: list[tuple[Index, Index, Array]],
        side: Array,
        name: str | None,
        size: int = 1,
    ) -> None:
        self._name(name, NamedBlock(kind, target.count, side.size, size))
        target.add(entries, side)

    def _name(self, name: str | None, block: NamedBlock | TwoSidedBlock) -> None:
        if name is not None:
            if name in self._named:
                raise BuilderError(f"rows `{name}` exist already")
            self._named[name] = block

    def _prepare(
        self, where: str, terms: Iterable[Term], rhs: ArrayLike, zeros: bool = False
    ) -> tuple[list[tuple[Index, Index, Array]], Array]:
        side = np.asarray(rhs, dtype=np.float64)
        if side.ndim > 1:
            raise BuilderError(f"{where}: rhs has shape {side.shape}; it must be (rows,) or one number")
        rows = side.size if side.ndim else None
        entries: list[tuple[Index, Index, Array]] = []
        for k, (columns, block) in enumerate(terms):
            if rows is None:
                rows = int(np.shape(block)[0]) if np.ndim(block) == 2 else 1
            entries.append(self._entries(where, k, self._index(where, columns).ravel(), block, rows, zeros))
        return entries, np.broadcast_to(side, (1 if rows is None else rows,)).copy()

    def _entries(
        self, where: str, term: int, index: Index, block: Block, rows: int, zeros: bool = False
    ) -> tuple[Index, Index, Array]:
        """Coordinates and values of block · x[index]."""
        matrix = block if csc.is_sparse(block) else np.asarray(block, dtype=np.float64)
        if matrix.shape != (rows, index.size):
            raise BuilderError(
                f"{where}: the block of term {term} has shape {matrix.shape}; "
                f"{rows} rows and {index.size} columns need {(rows, index.size)}"
            )
        if csc.is_sparse(matrix):
            values, where_rows, positions = csc.entries(matrix)
            return where_rows, index[positions], values
        where_rows, positions = np.nonzero(np.ones_like(matrix) if zeros else matrix)
        return where_rows, index[positions], matrix[where_rows, positions]
