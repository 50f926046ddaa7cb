"""The matrices of a problem: SciPy's `csc_array` with sorted, unique 32-bit indices, behind a typed face."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .errors import ProblemError

Array = NDArray[np.float64]
Indices = NDArray[np.int32]
Matrix = Any
"""A SciPy sparse matrix or array of any format, or anything `numpy.asarray` makes two-dimensional."""

INDEX_LIMIT = int(np.iinfo(np.int32).max)


class _Late:
    """`scipy.sparse`, published without types, imported when it is first used: it takes longer than all of `orbsoc`."""

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module("scipy.sparse"), name)


_sparse: Any = _Late()


class Csc(Protocol):
    """The part of `scipy.sparse.csc_array` that this package uses."""

    @property
    def data(self) -> Array: ...
    @property
    def indices(self) -> Indices: ...
    @property
    def indptr(self) -> Indices: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    @property
    def nnz(self) -> int: ...
    @property
    def T(self) -> Csc: ...
    def __matmul__(self, vector: Array, /) -> Array: ...
    def toarray(self) -> Array: ...
    def diagonal(self) -> Array: ...


def _csc(*arguments: Any, **options: Any) -> Csc:
    out: Csc = _sparse.csc_array(*arguments, **options)
    return out


def empty(rows: int, columns: int) -> Csc:
    """A matrix without entries."""
    return _csc((rows, columns))


def identity(size: int) -> Csc:
    """The identity."""
    return _csc(_sparse.eye_array(size))


def from_parts(data: Array, indices: NDArray[Any], indptr: NDArray[Any], shape: tuple[int, int]) -> Csc:
    """The matrix of compressed columns as they are, not checked."""
    return _csc((data, indices, indptr), shape=shape)


def from_entries(values: Array, rows: NDArray[Any], columns: NDArray[Any], shape: tuple[int, int]) -> Csc:
    """The matrix of coordinate entries; entries at the same place are added."""
    coordinates = (rows.astype(np.int32), columns.astype(np.int32))
    return _csc(_sparse.coo_array((values, coordinates), shape=shape))


def entries(matrix: Matrix) -> tuple[Array, NDArray[np.intp], NDArray[np.intp]]:
    """Values, rows and columns of the stored entries of a sparse matrix of any format."""
    coordinates = _sparse.coo_array(matrix)
    rows, columns = coordinates.coords
    return coordinates.data.astype(np.float64), rows.astype(np.intp), columns.astype(np.intp)


def is_sparse(value: Matrix) -> bool:
    """Whether `value` is a SciPy sparse matrix or array."""
    return "scipy.sparse" in sys.modules and bool(_sparse.issparse(value))


def upper(matrix: Csc) -> Csc:
    """The upper triangle, diagonal included."""
    return _csc(_sparse.triu(matrix))


def mirrored(matrix: Csc) -> Csc:
    """The full symmetric matrix of an upper triangle."""
    return _csc(matrix + _sparse.triu(matrix, 1).T)


def symmetric_part(matrix: Csc) -> Csc:
    """(M + Mᵀ)/2."""
    both: Any = matrix
    return _canonical(_sparse.csc_array((both + both.T) * 0.5))


def difference(left: Csc, right: Csc) -> Csc:
    """left − right."""
    minuend: Any = left
    return _csc(minuend - right)


def entry(matrix: Csc, row: int, column: int) -> float:
    """One entry of a matrix, stored or not."""
    here = slice(matrix.indptr[column], matrix.indptr[column + 1])
    return float(matrix.data[here][matrix.indices[here] == row].sum())


def stacked(top: Csc, bottom: Csc) -> Csc:
    """`top` above `bottom`."""
    return _csc(_sparse.vstack([top, bottom]))


def split_rows(matrix: Csc, count: int) -> tuple[Csc, Csc]:
    """The first `count` rows, and the others."""
    first = matrix.indices < count
    before = np.concatenate([[0], np.cumsum(first, dtype=np.int32)]).astype(np.int32)[matrix.indptr]
    rows, columns = matrix.shape
    indices = matrix.indices.astype(np.int32)
    top = from_parts(matrix.data[first], indices[first], before, (count, columns))
    others = (matrix.indptr - before).astype(np.int32)
    return top, from_parts(matrix.data[~first], indices[~first] - count, others, (rows - count, columns))


def selected_rows(matrix: Csc, keep: NDArray[np.bool_]) -> Csc:
    """The rows of `matrix` where `keep` is true."""
    return matrix if keep.all() else _sparse.csc_array(_sparse.csr_array(matrix)[keep])


def column_of_entry(matrix: Csc) -> NDArray[np.int64]:
    """The column of each stored entry."""
    return np.repeat(np.arange(matrix.shape[1]), np.diff(matrix.indptr))


def all_finite(values: Array) -> bool:
    """Whether no entry is NaN or infinite."""
    return bool(np.isfinite(values).all())


def refuse_masked(name: str, value: Any) -> None:
    """Raise ProblemError naming the argument `name` if an array, a row of a list or a sparse matrix hides entries."""
    if is_sparse(value):
        value = getattr(value, "data", None)
    rows = value if isinstance(value, list | tuple) else [value]
    if any(np.ma.is_masked(row) for row in rows):
        raise ProblemError(f"`{name}` has masked entries; fill them in first")


def as_array(name: str, value: Any) -> NDArray[Any]:
    """`value` as NumPy takes it; raises ProblemError naming the argument `name` for a list of unequal rows or masked entries."""
    refuse_masked(name, value)
    try:
        return np.asarray(value)
    except ValueError as error:
        raise ProblemError(f"`{name}` is not an array of numbers: {error}") from error


def real_numbers(name: str, value: Any) -> NDArray[Any]:
    """`value` as an array of real numbers of any type; raises ProblemError naming the argument `name` for others."""
    if is_sparse(value):
        raise ProblemError(f"`{name}` is a sparse matrix; it must be an array of numbers")
    array = as_array(name, value)
    if array.size and array.dtype.kind not in "fiub":
        raise ProblemError(f"`{name}` has entries of type {array.dtype}; they must be real numbers")
    return array


def vector(name: str, value: Any) -> Array:
    """`value` as a float64 vector, kept without a copy if it is one; raises ProblemError naming the argument `name`."""
    array = real_numbers(name, value)
    if array.ndim != 1:
        raise ProblemError(f"`{name}` has shape {array.shape}; it must be one-dimensional")
    if not array.size:
        return np.zeros(0)
    return (
        _narrowed(name, array) if array.dtype.itemsize > 8 else np.ascontiguousarray(array, dtype=np.float64)
    )


def _narrowed(name: str, array: NDArray[Any]) -> Array:
    """Numbers of more than double precision in it; ProblemError where one becomes infinite."""
    with np.errstate(over="ignore"):
        out = np.ascontiguousarray(array, dtype=np.float64)
    lost = np.flatnonzero(np.isinf(out) & np.isfinite(array))
    if lost.size:
        raise ProblemError(f"`{name}[{lost[0]}]` is {array[lost[0]]!s}, beyond double precision")
    return out


def sized_vector(name: str, value: Any, size: int) -> Array:
    """The same, of the size that a problem needs."""
    out = vector(name, value)
    if out.shape != (size,):
        raise ProblemError(f"`{name}` has shape {out.shape}, but the problem needs ({size},)")
    return out


def canonical(name: str, value: Matrix, n: int) -> Csc:
    """`value` as a finite float64 matrix of n columns; kept without a copy if it is canonical already.

    Raises ProblemError naming the argument `name` for a wrong shape or type, NaN or infinity, or indices that are out
    of range or beyond 32 bits.
    """
    matrix: Any = value if is_sparse(value) else as_array(name, value)
    if matrix.ndim != 2:
        raise ProblemError(f"`{name}` has shape {matrix.shape}; it must be two-dimensional")
    if is_sparse(matrix):
        refuse_masked(name, matrix)
        _check_indices(name, matrix)
    real = matrix.dtype.kind in "fiub"
    if not real and matrix.size:
        raise ProblemError(f"`{name}` has entries of type {matrix.dtype}; they must be real numbers")
    if matrix.shape[1] != n:
        raise ProblemError(f"`{name}` has {matrix.shape[1]} columns, but c has {n} entries")
    if max(matrix.shape) > INDEX_LIMIT or (is_sparse(matrix) and matrix.nnz > INDEX_LIMIT):
        raise ProblemError(
            f"`{name}` has shape {matrix.shape}; sizes and entries are limited to {INDEX_LIMIT}"
        )
    if not real:  # and empty: a type without meaning
        return empty(*matrix.shape)
    if type(matrix) is not _sparse.csc_array or matrix.dtype != np.float64:
        matrix = _sparse.csc_array(matrix, dtype=np.float64)
    out = _canonical(matrix)
    if not all_finite(out.data):
        k = int(np.flatnonzero(~np.isfinite(out.data))[0])
        place = f"{name}[{out.indices[k]}, {column_of_entry(out)[k]}]"
        raise ProblemError(f"`{place}` is {out.data[k]}; it must be finite")
    return out


def _check_indices(name: str, matrix: Any) -> None:
    """Whether the arrays of a sparse matrix fit one another and its shape. SciPy's conversions trust them: entries that do
    not fit would be lost, or written beside the new matrix."""
    if matrix.format == "bsr":
        try:
            matrix.check_format(full_check=True)
        except (ValueError, IndexError) as error:
            raise ProblemError(f"`{name}` is no BSR matrix: {error}") from error
    elif matrix.format == "coo":
        both = (matrix.row, matrix.col)
        for indices, limit, line in zip(both, matrix.shape, ("row", "column"), strict=True):
            _check_size(name, matrix, indices)
            _check_range(name, indices, limit, line)
    elif matrix.format == "lil":
        for k, (indices, values) in enumerate(zip(matrix.rows, matrix.data, strict=True)):
            if len(indices) != len(values):
                raise ProblemError(
                    f"`{name}` has {len(indices)} indices for {len(values)} entries in row {k}; they go together"
                )
            _check_range(name, np.asarray(indices), matrix.shape[1], "column")
    elif matrix.format in ("csc", "csr"):
        line, across = ("column", "row") if matrix.format == "csc" else ("row", "column")
        limit, lines = matrix.shape if matrix.format == "csc" else matrix.shape[::-1]
        pointers = matrix.indptr
        _check_size(name, matrix, matrix.indices)
        if pointers.size != lines + 1:
            raise ProblemError(
                f"`{name}` has {pointers.size} {line} pointers; a {matrix.format.upper()} matrix of shape "
                f"{matrix.shape} has {lines + 1}"
            )
        if pointers[0] != 0 or np.any(pointers[1:] < pointers[:-1]) or pointers[-1] > matrix.data.size:
            raise ProblemError(
                f"`{name}` is not a {matrix.format.upper()} matrix: its {line} pointers do not ascend from 0 to nnz"
            )
        _check_range(name, matrix.indices[: pointers[-1]], limit, across)


def _check_size(name: str, matrix: Any, indices: Any) -> None:
    if indices.size != matrix.data.size:
        raise ProblemError(
            f"`{name}` has {indices.size} indices for {matrix.data.size} entries; they go together"
        )


def _check_range(name: str, indices: Any, limit: int, line: str) -> None:
    if indices.size and (indices.min() < 0 or indices.max() >= limit):
        worst = indices.min() if indices.min() < 0 else indices.max()
        raise ProblemError(f"`{name}` has an entry in {line} {worst}, but only {limit} {line}s")


def _canonical(matrix: Any) -> Csc:
    """Sorted, unique, contiguous 32-bit indices; the argument itself if it has them already."""
    indptr, indices, data = matrix.indptr, matrix.indices, matrix.data
    nnz = int(indptr[-1])
    used = indices[:nnz]
    arrays = (data, indices, indptr)
    if (
        indices.dtype != np.int32
        or indptr.dtype != np.int32
        or indices.size != nnz
        or data.size != nnz
        or not all(array.flags.c_contiguous for array in arrays)
    ):
        matrix = from_parts(
            np.ascontiguousarray(data[:nnz]),
            np.ascontiguousarray(used, dtype=np.int32),
            np.ascontiguousarray(indptr, dtype=np.int32),
            matrix.shape,
        )
    if not matrix.has_canonical_format:
        matrix = matrix.copy()
        matrix.sum_duplicates()
    out: Csc = matrix
    return out
