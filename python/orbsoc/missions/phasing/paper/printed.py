"""Table 1 of the paper: osculating elements after the burns, as designed and as flown. Epochs are the ends of burns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.orbit import Elements, state_from_elements
from orbsoc.orbit.array import Array


@dataclass(frozen=True, slots=True)
class TableRow:
    """A row as printed."""

    epoch_s: float
    sma_km: float
    ecc: float
    inc_deg: float
    argp_deg: float
    raan_deg: float
    true_anomaly_deg: float

    @property
    def elements(self) -> Elements:
        angles = (self.inc_deg, self.raan_deg, self.argp_deg, self.true_anomaly_deg)
        inc, raan, argp, anomaly = map(float, np.deg2rad(angles))
        return Elements(1e3 * self.sma_km, self.ecc, inc, raan, argp, anomaly)

    @property
    def state(self) -> Array:
        """[r_m, v_m_s], (6,), ECI."""
        return np.concatenate(state_from_elements(self.elements))


TABLE = {
    "target design": TableRow(89267.6305, 6670.4, 0.013584, 40.796, 177.039, 309.835, 128.038),
    "parking": TableRow(83147.8704, 6771.8, 0.00006115, 40.7669, 338.2943, 310.3621, 256.4066),
    "burn 6 design": TableRow(89267.6305, 6769.1, 0.00037181, 40.7604, 78.1720, 309.0892, 195.0076),
    "burn 7 design": TableRow(112704.6022, 7267.8, 0.06833348, 40.8008, 350.5850, 307.4282, 6.5313),
    "burn 8 design": TableRow(149684.4129, 6675.4, 0.01256429, 40.8241, 180.7671, 305.3550, 181.2260),
    "target actual": TableRow(89267.6305, 6671.1, 0.012401, 40.806, 177.958, 309.824, 127.606),
    "burn 6 flight": TableRow(89402.3031, 6769.7, 0.00036763, 40.8602, 70.9899, 309.0664, 210.2634),
    "burn 7 flight": TableRow(112773.4899, 7266.2, 0.06892788, 40.8932, 355.6202, 307.4233, 5.0833),
    "burn 8 flight": TableRow(149786.6842, 6675.3, 0.01347015, 40.8969, 184.8944, 305.3599, 183.4781),
}
"""In the order of the paper; the parking orbit is the designed one, not the flown one."""
