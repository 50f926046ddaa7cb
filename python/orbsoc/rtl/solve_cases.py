"""Which whole solves are run on the RTL: those in binary64 under the paper's control take ten iterations or more, most are a
mission's; under resident control every way to end is among them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution
from orbsoc.hw.schedules import Engine
from orbsoc.solving.solver import solve

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
REFINED = Settings(tol=1e-10, static_regularization=1e-5, refinement_share=1e-6)
"""Solutions that must be refined."""
INFEASIBLE = Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=Cones(l=2))
UNBOUNDED = Problem(c=[-1.0], G=[[-1.0]], h=[0.0], cones=Cones(l=1))


@dataclass(frozen=True, slots=True, eq=False)
class SolvePoint:
    """One solve on one engine."""

    name: str
    problem: Problem
    settings: Settings = field(default_factory=Settings)
    engine: Engine = FOUR_LANES
    format: Format = "flat"
    resident: bool = False
    start: Solution | None = None


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
    and on 2, and A with half as many again; and those under resident control."""
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
        *resident_solves(),
    ]


def resident_solves() -> list[SolvePoint]:
    """Attempts that the RTL runs by itself, flat and compressed: solved in both precisions, refined, from a start that is
    taken, and both ways to have no solution."""
    drawn = problems()
    small, middle = list(drawn)[1], list(drawn)[3]
    found = [
        SolvePoint(small, drawn[small], TIGHT),
        SolvePoint(middle, drawn[middle], TIGHT),
        SolvePoint(f"{small}, single", drawn[small], SINGLE, TWO_LANES_F32),
        SolvePoint(f"{small}, refined", drawn[small], REFINED),
        SolvePoint(f"{middle}, warm", shifted(drawn[middle], 10.0), start=solve(drawn[middle])),
        SolvePoint("infeasible", INFEASIBLE),
        SolvePoint("unbounded", UNBOUNDED),
    ]
    formats: tuple[Format, ...] = ("flat", "compressed")
    return [replace(at, format=form, resident=True) for form in formats for at in found]


def shifted(problem: Problem, by: float) -> Problem:
    """The problem with another cost."""
    A, b, G, h = problem.A, problem.b, problem.G, problem.h
    return Problem(P=problem.P, c=problem.c + by, A=A, b=b, G=G, h=h, cones=problem.cones)


def run_solves(rtl: Path, points: list[SolvePoint], *, exact_depth: bool = False) -> Iterator[SolveOutcome]:
    """Solve the points one by one, with `exact_depth` on banks of no more rows than each needs; raises what `solve_on_rtl` raises."""
    for at in points:
        yield solve_on_rtl(
            rtl, at.name, at.problem, at.settings,
            engine=at.engine, form=at.format, resident=at.resident, start=at.start, exact_depth=exact_depth,
        )  # fmt: skip


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
