"""What two problems of one sparsity pattern share."""

from __future__ import annotations

import hashlib

import numpy as np

from .problem import Problem


def pattern_digest(problem: Problem) -> bytes:
    """Digest of the sparsity pattern: cones, positions of the nonzeros, and which rows constrain at all."""
    digest = hashlib.sha256(repr((problem.cones.l, tuple(problem.cones.q))).encode())
    for matrix in (problem.P, problem.A, problem.G):
        digest.update(repr(matrix.shape).encode())
        digest.update(matrix.indptr.tobytes())
        digest.update(matrix.indices.tobytes())
    digest.update(np.isfinite(problem.h).tobytes())  # rows with h = ∞ are absent
    return digest.digest()
