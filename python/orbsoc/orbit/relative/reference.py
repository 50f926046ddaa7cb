"""Relative motion along a reference orbit that is integrated, with any forces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ..array import Array
from ..perturbations import Force, coast_with_transitions
from .local_frame import to_inertial, to_relative


class AlongReference:
    """Motion relative to a target that coasts under `forces` from an inertial state (6,) at t = 0, which the chaser feels
    too; to first order in the distance. The orbit and its transition matrices are integrated once for each time asked for.
    """

    def __init__(self, target: ArrayLike, forces: Sequence[Force]) -> None:
        self.forces = tuple(forces)
        state = np.asarray(target, np.float64)
        self._known: dict[float, tuple[Array, Array]] = {0.0: (state, np.eye(6))}

    def prepare(self, times_s: ArrayLike) -> None:
        """Integrate once to all of these times ≥ 0, (K,), instead of to each when it is asked for."""
        times = np.unique(np.append(np.asarray(times_s, np.float64), 0.0))
        if times[0] < 0.0:
            raise ValueError(f"times_s begin at {times[0]:g}: must not be before the reference, 0")
        if times.size > 1:
            states, matrices = coast_with_transitions(self._known[0.0][0][None], times, self.forces)
            self._known |= {
                float(t): (states[k, 0], matrices[k, 0])
                for k, t in enumerate(times)
                if float(t) not in self._known
            }

    def target(self, t_s: float) -> Array:
        """The reference's inertial state (6,)."""
        return self._at(t_s)[0]

    def transition(self, t1_s: float, t0_s: float) -> Array:
        """The state transition matrix (6, 6) from t0_s to t1_s, frame (R, T, N)."""
        (one, to_one), (zero, to_zero) = self._at(t1_s), self._at(t0_s)
        inertial = np.linalg.solve(to_zero.T, to_one.T).T
        return np.asarray(to_relative(one, self._pull(one)) @ inertial @ to_inertial(zero, self._pull(zero)))

    def _at(self, t_s: float) -> tuple[Array, Array]:
        if t_s not in self._known:
            self.prepare([t_s])
        return self._known[t_s]

    def _pull(self, state: Array) -> Array:
        return np.asarray(sum(force.acceleration(state[None])[0] for force in self.forces))
