"""Coast many states at once through the same times, by DOP853, with transition matrices where they are wanted."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ..array import Array
from ..propagate import PropagationError
from .forces import Force

RTOL = 1e-12
"""Of lengths and speeds in the units of the largest state; 7000 km are known to some 10 µm a step."""


def coast(
    states: ArrayLike,
    times_s: ArrayLike,
    forces: Sequence[Force],
    kicks: ArrayLike | None = None,
    *,
    rtol: float = RTOL,
) -> Array:
    """States [r_m, v_m_s] at the times (K,), shape (K, B, 6), from states (B, 6) at the first of them; ECI.

    `kicks` (K, B, 3), m/s, are added to the velocities at each time; a state is told before the kick of its time.
    Raises ValueError for times that do not increase, PropagationError when the integrator gives up.
    """
    return _integrated(np.asarray(states, np.float64), times_s, forces, kicks, rtol, variational=False)[0]


def coast_with_transitions(
    states: ArrayLike,
    times_s: ArrayLike,
    forces: Sequence[Force],
    kicks: ArrayLike | None = None,
    *,
    rtol: float = RTOL,
) -> tuple[Array, Array]:
    """States as `coast` gives them, and the transition matrices (K, B, 6, 6) from the first time to each.

    A kick that does not depend on the state leaves the matrices as they are.
    """
    start = np.asarray(states, np.float64)
    return _integrated(start, times_s, forces, kicks, rtol, variational=True)


def checked_arguments(
    states: ArrayLike, times_s: ArrayLike, kicks: ArrayLike | None
) -> tuple[Array, Array, Array | None]:
    """As arrays; raises ValueError for shapes that do not fit and times that do not increase."""
    start, times = np.array(states, np.float64), np.array(times_s, np.float64)
    if start.ndim != 2 or start.shape[1] != 6:
        raise ValueError(f"states has shape {start.shape}; it must be (B, 6)")
    if times.ndim != 1 or times.size == 0 or not (np.diff(times) > 0.0).all():
        raise ValueError(f"times_s = {times!r}: must be increasing times, one or more")
    impulses = None if kicks is None else np.array(kicks, np.float64)
    if impulses is not None and impulses.shape != (times.size, len(start), 3):
        raise ValueError(f"kicks has shape {impulses.shape}; it must be {(times.size, len(start), 3)}")
    return start, times, impulses


def _integrated(
    states: Array,
    times_s: ArrayLike,
    forces: Sequence[Force],
    kicks: ArrayLike | None,
    rtol: float,
    *,
    variational: bool,
) -> tuple[Array, Array]:
    states, times, impulses = checked_arguments(states, times_s, kicks)
    count = len(states)
    width = 42 if variational else 6
    scale = np.ones((1, width))  # lengths and speeds, and what transitions turn into what
    length, speed = (max(1.0, float(np.abs(part).max())) for part in (states[:, :3], states[:, 3:]))
    scale[:, :3], scale[:, 3:6] = length, speed
    if variational:
        units = np.repeat([length, speed], 3)
        scale[0, 6:] = np.outer(units, 1.0 / units).ravel()

    def rate(_: float, flat: Array) -> Array:
        now = flat.reshape(count, width) * scale
        found = np.empty_like(now)
        found[:, :3] = now[:, 3:6]
        found[:, 3:6] = sum(force.acceleration(now[:, :6]) for force in forces)
        if variational:
            matrices = now[:, 6:].reshape(count, 6, 6)
            jacobian = sum(force.jacobian(now[:, :6]) for force in forces)
            moved = np.concatenate([matrices[:, 3:], jacobian @ matrices], axis=1)
            found[:, 6:] = moved.reshape(count, 36)
        return np.asarray((found / scale).ravel())

    at = np.empty((times.size, count, width))
    at[0, :, :6] = states
    if variational:
        at[0, :, 6:] = np.eye(6).ravel()
    # Without kicks one run of the integrator reports every time; each kick begins another.
    stops = (
        [0, *range(1, times.size)] if impulses is not None else [0, *([times.size - 1] * (times.size > 1))]
    )
    for first, last in pairwise(stops):
        start = at[first].copy()
        if impulses is not None:
            start[:, 3:6] += impulses[first]
        at[first + 1 : last + 1] = _run(rate, times[first : last + 1], start / scale, rtol) * scale
    return at[:, :, :6], at[:, :, 6:].reshape(times.size, count, 6, 6) if variational else np.empty(0)


def _run(rate: Any, times: Array, start: Array, rtol: float) -> Array:
    """Scaled rows at the times after the first."""
    from scipy.integrate import solve_ivp  # pyright: ignore[reportUnknownVariableType]

    integrate: Any = cast(Any, solve_ivp)  # published without types
    with np.errstate(over="ignore", invalid="ignore"):
        found = integrate(
            rate,
            (times[0], times[-1]),
            start.ravel(),
            method="DOP853",
            t_eval=times[1:],
            rtol=rtol,
            atol=rtol,
        )
    if not found.success:
        reached = found.t[-1] if len(found.t) else times[0]
        raise PropagationError(f"propagation stopped after t = {reached:.6g} s: {found.message}")
    return np.asarray(found.y.T.reshape(-1, *start.shape))
