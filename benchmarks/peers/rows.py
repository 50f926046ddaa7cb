"""Rows of G that do not constrain (h = +inf): most peers take finite data only."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse as _scipy_sparse

from benchmarks.answer import Array

sparse: Any = _scipy_sparse  # published without types


def rows(G: Any, kept: NDArray[np.bool_]) -> Any:
    """The rows of G that constrain."""
    return G if kept.all() else sparse.csr_array(G)[kept].tocsc()


def scattered(z: Array, kept: NDArray[np.bool_]) -> Array:
    """Multipliers of all rows; 0 for rows that do not constrain."""
    out = np.zeros(kept.size)
    out[kept] = z
    return out
