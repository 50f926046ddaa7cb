"""A plan's conic problems beside Clarabel: every one is taken, both solve it, and the line says what was found."""

from __future__ import annotations

import re

from benchmarks.mission_solves import line, pairs
from orbsoc.conic.solution import Status


def test_problems_of_a_plan_are_solved_by_both() -> None:
    found = pairs("paper002_norms", 1)
    assert len(found) == 9
    assert {pair.ours.status for pair in found} == {Status.SOLVED}
    assert all(pair.ours_s > 0.0 and pair.theirs_s > 0.0 for pair in found)
    said = line("paper002_norms", found)
    assert said.startswith("paper002_norms: 9 problems, solved 9 / ")
    [apart] = re.findall(r"objectives within (\S+)$", said)
    assert float(apart) < 1e-6
