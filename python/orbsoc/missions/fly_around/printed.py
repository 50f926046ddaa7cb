"""The paper's own rule for the next pulse, its eq. (15), as printed: what it gives is not what the paper reports."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from orbsoc.orbit.relative import LVLH

from .model.flight import Flight

Array = NDArray[np.float64]

STEPS = 400
"""In which the first length beyond the tolerance is sought: the printed error does not grow everywhere."""


def printed_times(flight: Flight, end_s: float, tolerance_m: float, *, along: float = 5.0) -> Array:
    """Ends of the intervals by |−Δt² B/4 (E + Δt B)(D − A r)| = tolerance, the last cut, (N + 1,).

    D is the chord of the interval, by DΔt = r_m+1 − r_m. A is ω at its upper right corner times `along`: 5 as printed, 0
    by expansion of Φ_rr; B is as printed, −ω there and ω opposite. The axes are the paper's.
    """
    n, path = flight.ellipse.mean_motion_rad_s, flight.ellipse
    first, second = np.zeros((3, 3)), np.zeros((3, 3))
    first[0, 2], second[0, 2], second[2, 0] = along * n, -n, n
    times = [0.0]
    while times[-1] < end_s:
        t = times[-1]
        position = path.position(t)

        def excess(dt: float, t: float = t, position: Array = position) -> float:
            chord = (path.position(t + dt) - position) / dt
            rest = LVLH @ chord - first @ (LVLH @ position)
            drift = -0.25 * dt**2 * second @ (np.eye(3) + dt * second) @ rest
            return float(np.linalg.norm(drift)) - tolerance_m

        longest = min(end_s - t, 0.999 * flight.longest_transfer_s)
        lengths = np.linspace(0.0, longest, STEPS + 1)[1:].tolist()
        beyond = next((k for k, dt in enumerate(lengths) if excess(dt) > 0.0), None)
        if beyond is None:
            times.append(t + longest)
        else:
            times.append(t + float(brentq(excess, lengths[beyond - 1] if beyond else 1e-6, lengths[beyond])))
    return np.array(times)
