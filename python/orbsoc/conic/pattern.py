"""The identity of a sparsity pattern."""

from __future__ import annotations

import hashlib

import numpy as np

from .problem import Problem


def pattern_digest(problem: Problem) -> bytes:
    """What two problems of one sparsity pattern share: equal digests have equal schedules."""
    digest = hashlib.sha256(repr((problem.cones.l, tuple(problem.cones.q))).encode())
    for matrix in (problem.P, problem.A, problem.G):
        digest.update(repr(matrix.shape).encode())
        digest.update(matrix.indptr.tobytes())
        digest.update(matrix.indices.tobytes())
    digest.update(np.isfinite(problem.h).tobytes())  # rows with h = ∞ are absent
    return digest.digest()
