"""Thrust that is held on OpenSCvx's public data costs what `docs/approach.md` says: by pieces of 3, 20 and 1 s."""

from __future__ import annotations

import re

import numpy as np
import pytest

from benchmarks.station_proxops import planned
from tests.printed import near
from tests.site.stated import text_of

TEXT = text_of("approach.md")


@pytest.mark.parametrize(
    ("step_s", "said"),
    [
        (3.0, r"an acceleration held for 3 s each, with the fuel as cost \| (\d\.\d+) \|"),
        (20.0, r"with 9 pieces of 20 s it spends (\d\.\d+) m/s"),
        (1.0, r"with 177 of 1 s (\d\.\d+)\."),
    ],
)
def test_the_velocity_change(step_s: float, said: str) -> None:
    [shown] = re.findall(said, TEXT)
    _, dv = planned(step_s)
    assert near(shown, f"{np.linalg.norm(dv, axis=1).sum():.9g}", 1e-6)
