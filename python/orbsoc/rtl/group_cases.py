"""Which groups of interleaved problems are solved on the RTL: on one crossbar and in clusters, in both formats of microcode and both
precisions, and one whose problems end for different reasons."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle, islice
from pathlib import Path

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine

from .group import GroupOutcome, group_on_rtl
from .same_pattern import same_pattern
from .solve_cases import FOUR_LANES, SINGLE, TWO_LANES_F32
from .validation import ADDRESS_BITS, CLUSTERED, Format, problems

EIGHT_LANES = Engine(lanes=8, dividers=2, banks=32, clusters=4, address_bits=ADDRESS_BITS)


@dataclass(frozen=True, slots=True, eq=False)
class GroupPoint:
    """One group on one engine."""

    name: str
    problems: Sequence[Problem]
    settings: Settings = field(default_factory=Settings)
    engine: Engine = FOUR_LANES
    format: Format = "flat"


def quick_groups(copies: int) -> list[GroupPoint]:
    """A small problem and others of its pattern on four lanes, also in two clusters, and problems that end differently."""
    drawn = problems()
    small = list(drawn)[1]
    several = same_pattern(drawn[small], copies)
    return [
        GroupPoint(small, several),
        GroupPoint(small, several, format="compressed"),
        GroupPoint("three ways to end", list(islice(cycle(ENDS), copies))),
        GroupPoint(small, several, engine=CLUSTERED),
    ]


def all_groups(copies: int) -> list[GroupPoint]:
    """Those, a larger problem on the same engines and on eight lanes in four clusters, and the small one in binary32."""
    drawn = problems()
    small, middle = list(drawn)[1], list(drawn)[3]
    quick, larger = quick_groups(copies), same_pattern(drawn[middle], copies)
    return [
        *quick,
        *(replace(at, name=middle, problems=larger) for at in quick if at.name == small),
        GroupPoint(middle, larger, engine=EIGHT_LANES),
        GroupPoint(f"{small}, single", same_pattern(drawn[small], copies), SINGLE, TWO_LANES_F32),
    ]


def run_groups(rtl: Path, points: Sequence[GroupPoint]) -> Iterator[GroupOutcome]:
    """Solve the groups one by one; raises what `group_on_rtl` raises."""
    for at in points:
        yield group_on_rtl(rtl, at.name, at.problems, at.settings, engine=at.engine, form=at.format)


def _ending(cost: float, most: float) -> Problem:
    """x₀ between 2 and `most`, x₁ ≥ 0 at a cost."""
    rows = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0]]
    return Problem(c=[1.0, cost], G=rows, h=[-2.0, most, 0.0], cones=Cones(l=3))


ENDS = (_ending(1.0, 5.0), _ending(1.0, 1.0), _ending(-1.0, 5.0), _ending(0.5, 2.5))
"""Solved, infeasible, unbounded, solved."""
