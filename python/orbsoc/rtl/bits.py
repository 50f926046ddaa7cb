"""Bits of the RTL's words beside those of Rust: any NaN equals any other, for the RTL's is the canonical one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from orbsoc import _core


def unequal(found: NDArray[np.uint64], wanted: NDArray[np.uint64], fp: int) -> NDArray[np.bool_]:
    """Which words of `fp` bits differ."""
    differs: NDArray[np.bool_] = (found != wanted) & ~(_is_nan(found, fp) & _is_nan(wanted, fp))
    return differs


def _is_nan(words: NDArray[np.uint64], fp: int) -> NDArray[np.bool_]:
    numbers = words.view(np.float64) if fp == 64 else words.astype(np.uint32).view(np.float32)
    return np.isnan(numbers)


def same_solution(found: _core.RawSolution, whole: _core.RawSolution) -> bool:
    """The same end, bit for bit."""
    pairs = [(getattr(found, v), getattr(whole, v)) for v in ("x", "y", "z", "s")]
    same_bits = all(not unequal(one.view(np.uint64), other.view(np.uint64), 64).any() for one, other in pairs)
    ends = ((end.status, end.iterations, end.warm_start) for end in (found, whole))
    return same_bits and next(ends) == next(ends)
