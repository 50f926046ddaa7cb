"""Relative motion about a Kepler orbit by integrating its linear equations, which no optimiser of ours uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from scipy.integrate import solve_ivp  # pyright: ignore[reportUnknownVariableType]

from orbsoc.orbit import PropagationError
from orbsoc.orbit.array import Array

from .impulses import ImpulseProgramme

REST = np.zeros(3)


@dataclass(frozen=True, slots=True)
class LinearFlight:
    """R̈ = 2ν̇Ṫ + ν̈T + ν̇²R + 2μR/r³, T̈ = −2ν̇Ṙ − ν̈R + ν̇²T − μT/r³, N̈ = −μN/r³ about a Kepler orbit, by DOP853."""

    mean_motion_rad_s: float
    ecc: float
    start_rad: float

    def coasted(self, states: Array, anomalies: Array, times_s: Array) -> Array:
        """States (K, B, 6) at times after states (B, 6) at which the target's true anomalies are (B,)."""
        return self._run(states, anomalies, times_s)[:, :, :6]

    def flown(
        self, programme: ImpulseProgramme, start: Array, times_s: Array, *, held: bool = False
    ) -> tuple[Array, Array, Array]:
        """States (K, 6) before the impulse of their time, and after each impulse (N, 6) with the anomalies there (N,).

        `held`: each velocity change is one acceleration until the next one begins, or until the last time.
        """
        rows = np.empty((times_s.size, 7))
        rows[0] = *start, self.start_rad
        after = np.empty((len(programme), 7))
        ends = [*np.searchsorted(times_s, programme.times_s).tolist(), times_s.size - 1]
        state, at, push = rows[0], 0, np.zeros(3)
        for k, until in enumerate(ends):
            if until > at:
                arc = self._run(state[None, :6], state[6:], times_s[at : until + 1] - times_s[at], push)
                rows[at + 1 : until + 1] = arc[1:, 0]
                state, at = rows[until], until
            if k < len(programme):
                after[k] = state
                if held:
                    push = programme.dv_m_s[k] / (times_s[ends[k + 1]] - times_s[until])
                else:
                    after[k, 3:6] += programme.dv_m_s[k]
                state = after[k]
        return rows[:, :6], after[:, :6], after[:, 6]

    def _run(self, states: Array, anomalies: Array, times_s: Array, push: Array = REST) -> Array:
        n, e = self.mean_motion_rad_s, self.ecc
        k = n * (1.0 - e * e) ** -1.5  # ν̇ = k (1 + e cos ν)², μ/r³ = k² (1 + e cos ν)³
        scale = np.array([1.0, 1.0, 1.0, n, n, n, 1e-3])
        count = len(states)

        def rate(_: float, flat: Array) -> Array:
            x, y, z, vx, vy, vz, nu = (flat.reshape(count, 7) * scale).T
            rho = 1.0 + e * np.cos(nu)
            w, pull = k * rho**2, k**2 * rho**3
            wdot = -2.0 * k**2 * e * np.sin(nu) * rho**3
            ax = 2.0 * w * vy + wdot * y + w**2 * x + 2.0 * pull * x
            ay = -2.0 * w * vx - wdot * x + w**2 * y - pull * y
            rates = np.stack([vx, vy, vz, ax, ay, -pull * z, w], axis=1)
            rates[:, 3:6] += push
            return np.asarray((rates / scale).ravel())

        integrate: Any = cast(Any, solve_ivp)  # published without types
        first = (np.column_stack([states, anomalies]) / scale).ravel()
        found = integrate(
            rate, (0.0, times_s[-1]), first, method="DOP853", t_eval=times_s, rtol=1e-11, atol=1e-8
        )
        if not found.success:
            raise PropagationError(f"propagation stopped after t = {found.t[-1]:.6g} s: {found.message}")
        return np.asarray(found.y.T.reshape(-1, count, 7) * scale)
