"""Attitude programmes: vectors at Legendre–Gauss nodes whose interpolant, normalised, is the thrust direction.

The programme of a convex sequence is its unit controls. That of a polished plan is primer vectors at their own lengths:
the primer is smooth where its direction swings, so a few nodes hold it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.collocation import interpolation_matrix, legendre_gauss
from orbsoc.orbit.array import Array

from ..indirect.primer import Extremals

LENGTHS_AT = np.linspace(-1.0, 1.0, 201)
"""Times, on [−1, 1], at which a programme's length is sampled."""


@dataclass(frozen=True, slots=True, eq=False)
class Programmes:
    """Programmes of B points on one grid: `vectors` (B, N, 3)."""

    vectors: Array

    @property
    def nodes(self) -> int:
        return int(self.vectors.shape[1])


def primer_programmes(flown: Extremals, nodes: int) -> Programmes:
    """The primers of extremals at Legendre–Gauss nodes, each programme scaled to a largest length of 1 on the way."""
    scheme = flown.scheme
    at = 0.5 * scheme.duration * (legendre_gauss(nodes).nodes + 1.0)
    step = np.minimum((at / scheme.length).astype(np.intp), scheme.steps - 1)
    primers = flown.nodes[:, 3:].reshape(scheme.steps, scheme.stages, 3, -1)
    vectors = np.empty((primers.shape[3], nodes, 3))
    for k in range(nodes):
        start = step[k] * scheme.length
        row = interpolation_matrix(scheme.offsets, [at[k] - start])[0]
        vectors[:, k] = np.einsum("s,sdb->bd", row, primers[step[k]])
    between = interpolation_matrix(legendre_gauss(nodes).nodes, LENGTHS_AT) @ vectors
    largest = np.sqrt(np.einsum("bkd,bkd->bk", between, between).max(axis=1))
    return Programmes(vectors / largest[:, None, None])
