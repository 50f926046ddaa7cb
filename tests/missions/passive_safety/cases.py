"""The eight rows of the paper's tables with both constant sets, and what is known of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from orbsoc.guidance.scenario_file import checked
from orbsoc.missions.passive_safety.model.approach import Approach
from orbsoc.missions.passive_safety.scenario import Scenario


@dataclass(frozen=True)
class Case:
    """A row: constants, start, time, condition; the optimum of the linear programme with 36 samples, of exact cones by the
    1-norm and 2-norm with four impulses, and of two impulses with the second one's time free, and that time."""

    fitted: bool
    start_m: float
    duration_s: float
    condition: str
    samples: float
    cones: float
    norms: float
    free: float
    second_s: float

    def scenario(self, **changes: Any) -> Scenario:
        document: dict[str, Any] = {
            "mission": "passive_safety",
            "name": "case",
            "target": {"mean_motion_rad_s": 1e-3} if self.fitted else {"altitude_km": 593.5},
            "start": {"x_m": self.start_m},
            "capture": {"x_m": 0.0, "z_m": 60.0 if self.fitted else 70.0},
            "keep_out_m": 40.0 if self.fitted else 50.0,
            "duration_s": self.duration_s,
            "condition": self.condition,
        }
        return checked(Scenario, document | changes, source="case")

    def approach(self, **changes: Any) -> Approach:
        return Approach.of(self.scenario(**changes))


CASES = [
    Case(True, -1000.0, 3600.0, "short", 0.546833, 0.5471, 0.5145, 0.3215, 2134),
    Case(True, -1000.0, 3600.0, "beyond", 0.536851, 0.5382, 0.4850, 0.3641, 1672),
    Case(True, -1000.0, 4200.0, "short", 0.309531, 0.3100, 0.2888, 0.2570, 1492),
    Case(True, -1000.0, 4200.0, "beyond", 0.439679, 0.4397, 0.3919, 0.3633, 2139),
    Case(True, -2000.0, 3600.0, "short", 1.410806, 1.4275, 1.2938, 0.8550, 2874),
    Case(True, -2000.0, 3600.0, "beyond", 1.265633, 1.2663, 1.1343, 0.6943, 2327),
    Case(True, -2000.0, 4200.0, "short", 0.720433, 0.7236, 0.6738, 0.5640, 1691),
    Case(True, -2000.0, 4200.0, "beyond", 0.812355, 0.8124, 0.7275, 0.6764, 2021),
    Case(False, -1000.0, 3600.0, "short", 0.434565, 0.4350, 0.3957, 0.3077, 1573),
    Case(False, -1000.0, 3600.0, "beyond", 0.484750, 0.4848, 0.4310, 0.4138, 1892),
    Case(False, -1000.0, 4200.0, "short", 0.249095, 0.2491, 0.2416, 0.2386, 1173),
    Case(False, -1000.0, 4200.0, "beyond", 0.490315, 0.4903, 0.4349, 0.4125, 1460),
    Case(False, -2000.0, 3600.0, "short", 1.021124, 1.0239, 0.9374, 0.6718, 1812),
    Case(False, -2000.0, 3600.0, "beyond", 1.030201, 1.0315, 0.9302, 0.7483, 1829),
    Case(False, -2000.0, 4200.0, "short", 0.570060, 0.5708, 0.5486, 0.5307, 1265),
    Case(False, -2000.0, 4200.0, "beyond", 0.890958, 0.8910, 0.7970, 0.7325, 1742),
]
