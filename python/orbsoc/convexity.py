"""Is a sparse symmetric matrix positive semidefinite? Answered with the reason when it is not."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import linalg

from orbsoc import csc
from orbsoc.csc import Array, Csc

_linalg: Any = linalg  # published without types

SHIFT = 1e-8
"""Negative curvature below this fraction of the diagonal passes: it is what rounding in P = MᵀM can produce."""

DENSE_LIMIT = 200
"""Up to this order a dense Cholesky is faster than the sparse elimination."""

WORDS_AT_ONCE = 2**22
"""Of dense matrices that are looked at together."""

EIGENVALUE_LIMIT = 500
"""Up to this order the reason names the smallest eigenvalue."""


def first_nonconvexity(P: Csc) -> str | None:
    """None if P (symmetric, canonical CSC, finite) is positive semidefinite, otherwise what shows that it is not.

    The coupled part of P is scaled to a unit diagonal, which keeps the signs of its eigenvalues, shifted by
    `SHIFT` and eliminated; a non-positive pivot is negative curvature (Sylvester's law of inertia).
    """
    diagonal = P.diagonal()
    negative = np.flatnonzero(diagonal < 0.0)
    if negative.size:
        k = int(negative[0])
        return f"P[{k}, {k}] is {diagonal[k]}"
    rows = P.indices
    columns = csc.column_of_entry(P)
    off = (rows != columns) & (P.data != 0.0)
    if not off.any():
        return None
    rows, columns, values = rows[off], columns[off], P.data[off]
    # |P_ij| ≤ √(P_ii P_jj) for every semidefinite matrix; this also catches P_ii = 0 with P_ij ≠ 0.
    bound = np.sqrt(diagonal[rows]) * np.sqrt(diagonal[columns])
    outside = np.flatnonzero(np.abs(values) > bound * (1.0 + SHIFT))
    if outside.size:
        k = int(outside[0])
        i, j = int(rows[k]), int(columns[k])
        return f"P[{i}, {j}] is {values[k]}, P[{i}, {i}] is {diagonal[i]} and P[{j}, {j}] is {diagonal[j]}"
    coupled = np.unique(rows)
    position = np.empty(P.shape[0], dtype=np.intp)
    position[coupled] = np.arange(coupled.size)
    # Sized [coupled]: the correlation matrix of P, its unit diagonal shifted.
    order = coupled.size
    unit = np.arange(order)
    shifted = csc.from_entries(
        np.concatenate([values / bound, np.full(order, 1.0 + SHIFT)]),
        np.concatenate([position[rows], unit]),
        np.concatenate([position[columns], unit]),
        (order, order),
    )
    if _has_positive_pivots(shifted):
        return None
    if order > EIGENVALUE_LIMIT:
        return "it has a direction of negative curvature"
    smallest = float(np.linalg.eigvalsh(shifted.toarray())[0]) - SHIFT
    return f"scaled to a unit diagonal, its smallest eigenvalue is {smallest:.3g}"


def all_plainly_convex(pattern: Csc, values: Array) -> bool:
    """Whether each row of `values` (B, nnz), in the pattern, is a symmetric matrix that `first_nonconvexity` takes.

    Looks at many at once; False where that is not plain, if only because they are too large or not finite.
    """
    n = pattern.shape[0]
    rows, columns = pattern.indices, csc.column_of_entry(pattern)
    if np.array_equal(rows, columns):
        return bool(((values >= 0.0) & (values < np.inf)).all())
    if n > DENSE_LIMIT:
        return False
    some = max(1, WORDS_AT_ONCE // (n * n))
    return all(_convex_if_dense(rows, columns, values[k : k + some], n) for k in range(0, len(values), some))


def _convex_if_dense(rows: NDArray[Any], columns: NDArray[Any], values: Array, n: int) -> bool:
    matrices = np.zeros((len(values), n, n))
    matrices[:, rows, columns] = values
    unit = np.arange(n)
    diagonal = matrices[:, unit, unit]
    matrices[:, unit, unit] = 0.0
    lone = (diagonal == 0.0) & ~matrices.any(axis=2)
    if not (np.array_equal(matrices, matrices.transpose(0, 2, 1)) and ((diagonal > 0.0) | lone).all()):
        return False
    roots = np.sqrt(np.where(lone, 1.0, diagonal))
    with np.errstate(all="ignore"):  # what is no number has no factors
        matrices /= roots[:, :, None] * roots[:, None, :]
    matrices[:, unit, unit] = 1.0 + SHIFT
    return _have_cholesky_factors(matrices)


def _has_positive_pivots(matrix: Csc) -> bool:
    """Whether a symmetric matrix eliminates with positive pivots only, which is positive definiteness."""
    if matrix.shape[0] <= DENSE_LIMIT:
        return _have_cholesky_factors(matrix.toarray())
    try:
        # Diagonal pivots in a symmetric order make this LDLᵀ: U carries the pivots on its diagonal.
        factors = _linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:  # an exactly singular pivot
        return False
    symmetric_order = np.array_equal(factors.perm_r, factors.perm_c)
    return symmetric_order and bool((factors.U.diagonal() > 0.0).all())


def _have_cholesky_factors(matrices: Array) -> bool:
    """Whether the last two axes' matrices all have."""
    try:
        np.linalg.cholesky(matrices)
    except np.linalg.LinAlgError:
        return False
    return True
