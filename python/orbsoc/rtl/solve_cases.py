"""Which whole solves are run on the RTL: those in binary64 take ten iterations or more, most are a mission's."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine

from .solve import SolveOutcome, solve_on_rtl
from .validation import ADDRESS_BITS, Format, mission_004, problems, require_scenario

FOUR_LANES = Engine(lanes=4, banks=16, address_bits=ADDRESS_BITS)
TWO_LANES_F32 = Engine(fp=32, lanes=2, banks=8, address_bits=ADDRESS_BITS)
"""The engines that the schedules' validation builds, too: a build serves both."""
TIGHT = Settings(tol=1e-10)
"""At the default tolerance all converge in eight to ten iterations; a tenth of this, and some end SOLVED_INACCURATE."""
SINGLE = Settings(
    tol=1e-4, tol_inaccurate=1e-3, static_regularization=1e-6, pivot_floor=1e-7, dynamic_regularization=1e-4
)
"""Binary32 in all stages: a regularisation of 1e-8 is lost beside entries of 1, and the first factorization breaks down."""


@dataclass(frozen=True, slots=True, eq=False)
class SolvePoint:
    """One solve on one engine."""

    name: str
    problem: Problem
    settings: Settings = field(default_factory=Settings)
    engine: Engine = FOUR_LANES
    format: Format = "flat"


def quick_solves(scenarios: Path) -> list[SolvePoint]:
    """Two drawn problems and a mission's subproblem in binary64; one of them compressed, and one in binary32."""
    drawn = problems()
    middle, large = list(drawn)[3:5]
    return [
        SolvePoint(middle, drawn[middle], TIGHT),
        SolvePoint(large, drawn[large], TIGHT),
        _mission_004(scenarios, 4),
        SolvePoint(middle, drawn[middle], TIGHT, format="compressed"),
        SolvePoint(middle, drawn[middle], SINGLE, TWO_LANES_F32),
    ]


def all_solves(scenarios: Path) -> list[SolvePoint]:
    """Those, and the mission's subproblems A and C with as many nodes as the paper's, flat and compressed on 4 lanes
    and on 2, and A with half as many again."""
    sixteen = Engine(lanes=4, banks=16, address_bits=16)
    free = mission_004(scenarios / "rec1.toml", free_perigee=True)
    twelve = [_mission_004(scenarios, 12), SolvePoint("mission 004 C, N = 12", free, TIGHT)]
    formats: tuple[Format, ...] = ("flat", "compressed")
    return [
        *quick_solves(scenarios),
        *(
            replace(at, engine=replace(FOUR_LANES, lanes=lanes), format=form)
            for at in twelve
            for lanes in (4, 2)
            for form in formats
        ),
        _mission_004(scenarios, 18, sixteen),
    ]


def run_solves(rtl: Path, points: list[SolvePoint]) -> Iterator[SolveOutcome]:
    """Solve the points one by one; raises what `solve_on_rtl` raises."""
    for at in points:
        yield solve_on_rtl(rtl, at.name, at.problem, at.settings, engine=at.engine, form=at.format)


def _mission_004(scenarios: Path, nodes: int, engine: Engine = FOUR_LANES) -> SolvePoint:
    """The first subproblem of rec1 with this many nodes. Raises RtlError where the scenario is not at hand."""
    scenario = scenarios / "rec1.toml"
    require_scenario(scenario)
    from orbsoc.hw.emulation import PsScheduler
    from orbsoc.missions.registry import load_scenario

    recorder = PsScheduler()
    mission, chosen = load_scenario(scenario, {"method.nodes": nodes})
    mission.plan(chosen, solve=recorder)
    return SolvePoint(f"mission 004, N = {nodes}", recorder.patterns[0], TIGHT, engine)
