"""Is a sparse symmetric matrix positive semidefinite? Answered with the reason when it is not."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

SHIFT = 1e-8
"""Negative curvature below this fraction of the diagonal passes: it is what rounding in P = MᵀM can produce."""

DENSE_LIMIT = 200
"""Up to this order a dense Cholesky is faster than the sparse elimination."""


def first_nonconvexity(P: sparse.csc_array) -> str | None:
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
    columns = np.repeat(np.arange(P.shape[1]), np.diff(P.indptr))
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
    correlation = sparse.csc_array(
        (values / bound, (position[rows], position[columns])), shape=(coupled.size, coupled.size)
    )
    return None if _positive_definite(correlation) else "it has a direction of negative curvature"


def _positive_definite(correlation: sparse.csc_array) -> bool:
    """Whether I(1 + SHIFT) + `correlation` has only positive pivots."""
    order = correlation.shape[0]
    if order <= DENSE_LIMIT:
        dense = correlation.toarray()
        dense[np.diag_indices(order)] = 1.0 + SHIFT
        try:
            np.linalg.cholesky(dense)
        except np.linalg.LinAlgError:
            return False
        return True
    shifted = sparse.csc_array(correlation + (1.0 + SHIFT) * sparse.eye_array(order, format="csc"))
    try:
        # Diagonal pivots in a symmetric order make this LDLᵀ: U carries the pivots on its diagonal.
        factors = sparse_linalg.splu(
            shifted, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:  # an exactly singular pivot
        return False
    symmetric_order = np.array_equal(factors.perm_r, factors.perm_c)
    return symmetric_order and bool((factors.U.diagonal() > 0.0).all())
