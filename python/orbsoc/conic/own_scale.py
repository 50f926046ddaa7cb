"""A problem's own scale: how large its rows, in whatever units, let each unknown be.

Curtis and Reid's scaling (1972) of Mx = h, with h as a column of fixed factor: those d and e that minimise
Σ (ln |eᵢMᵢⱼdⱼ|)² + Σ (ln |eᵢhᵢ|)² over the entries that are not zero. Where rows or unknowns have other units, the factors
change so that every product stays. Rows of a second-order cone share one factor, and so do its multipliers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import csc
from .cones import Cones
from .csc import Array
from .problem import Problem

MOST_ITERATIONS = 300
ENOUGH = 1e-4
"""Conjugate gradients end at this error in a logarithm."""

Groups = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class OwnScale:
    """The size of each unknown, and the largest scaled right-hand side |eᵢhᵢ| (1 where h is zero)."""

    sizes: Array
    largest_side: float


def primal_scale(problem: Problem) -> OwnScale:
    """Of x (n,), by the rows of A and G that constrain."""
    p, constrains = problem.p, np.isfinite(problem.h)
    values, rows, columns = csc.entries(problem.G)
    kept = constrains[rows]
    of_A = csc.entries(problem.A)
    groups = np.concatenate([np.arange(p), p + _cone_groups(problem.cones)])
    return _scale(
        groups,
        np.arange(problem.n),
        np.concatenate([of_A[0], values[kept]]),
        np.concatenate([of_A[1], p + rows[kept]]),
        np.concatenate([of_A[2], columns[kept]]),
        np.concatenate([problem.b, np.where(constrains, problem.h, 0.0)]),
    )


def dual_scale(problem: Problem) -> OwnScale:
    """Of (x, y, z) (n + p + m,), by the rows of Px + Aᵀy + Gᵀz = −c."""
    n, p = problem.n, problem.p
    of_P, of_A, of_G = (csc.entries(matrix) for matrix in (problem.P, problem.A, problem.G))
    kept = np.isfinite(problem.h)[of_G[1]]
    return _scale(
        np.arange(n),
        np.concatenate([np.arange(n + p), n + p + _cone_groups(problem.cones)]),
        np.concatenate([of_P[0], of_A[0], of_G[0][kept]]),
        np.concatenate([of_P[1], of_A[2], of_G[2][kept]]),
        np.concatenate([of_P[2], n + of_A[1], n + p + of_G[1][kept]]),
        problem.c,
    )


def _cone_groups(cones: Cones) -> Groups:
    """The group of each cone row: its own in R₊, one for each second-order cone."""
    of_cones = np.repeat(np.arange(len(cones.q)), np.asarray(cones.q, dtype=np.intp))
    return np.concatenate([np.arange(cones.l), cones.l + of_cones])


def _logarithms(values: Array) -> tuple[NDArray[np.bool_], Array]:
    """Which numbers count, and the logarithms of their magnitudes."""
    normal = np.abs(values) >= np.finfo(np.float64).tiny
    return normal, np.log(np.abs(values[normal]))


def _scale(
    row_groups: Groups,
    column_groups: Groups,
    values: Array,
    rows: NDArray[np.intp],
    columns: NDArray[np.intp],
    sides: Array,
) -> OwnScale:
    first = int(row_groups.max(initial=-1)) + 1
    size = first + int(column_groups.max(initial=-1)) + 1
    normal, entries = _logarithms(values)
    left, right = row_groups[rows[normal]], first + column_groups[columns[normal]]
    bounded, bounds = _logarithms(sides)
    ends = np.concatenate([left, right, row_groups[bounded]])
    diagonal = np.bincount(ends, minlength=size).astype(np.float64)
    wanted: Array = -np.bincount(ends, np.concatenate([entries, entries, bounds]), size).astype(np.float64)

    def product(v: Array) -> Array:
        across = np.bincount(left, v[right], size) + np.bincount(right, v[left], size)
        out: Array = diagonal * v + across
        return out

    logarithms = _conjugate_gradients(product, np.maximum(diagonal, 1.0), wanted)
    largest = float(np.max(np.abs(sides) * np.exp(logarithms[row_groups]), initial=0.0))
    return OwnScale(np.exp(logarithms[first + column_groups]), largest if largest > 0.0 else 1.0)


def _conjugate_gradients(product: Callable[[Array], Array], diagonal: Array, residual: Array) -> Array:
    """The solution of the normal equations, with their diagonal as preconditioner."""
    out, direction, energy = np.zeros_like(residual), np.zeros_like(residual), np.inf
    for _ in range(MOST_ITERATIONS):
        steps = residual / diagonal
        if np.all(np.abs(steps) <= ENOUGH):
            break
        now = float(residual @ steps)
        direction = steps + now / energy * direction
        energy, image = now, product(direction)
        length = now / float(image @ direction)
        if not np.isfinite(length):
            break
        out = out + length * direction
        residual = residual - length * image
    return out
