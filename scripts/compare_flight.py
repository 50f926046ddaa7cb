"""Compare the library in C with the exact engine, word for word, on many problems: the wide campaign behind tests/flight.

    python scripts/compare_flight.py [--compiler gcc] [--option=-O3 ...]

Subproblems of missions, the zoo and its rescaled twins, problems whose attempts stall; cold and from a point near the
solution; binary64 and binary32. Prints each difference, then counts by outcome; exits 1 where anything differed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import orbsoc
from orbsoc import _core
from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.flight.export import default_settings
from orbsoc.missions.registry import load_scenario
from tests.flight.c_library import compiled, expected
from tests.solving import restart_problems as stalling
from tests.zoo import cases, rescaled_twins

SCENARIOS = Path(__file__).resolve().parents[1] / "scenarios"
PLANNED = (
    "rec1", "rec2", "paper004_insertion", "paper004_insertion_zf196", "deorbit", "escape", "paper000_1", "paper001_equal",
    "paper002", "paper003_socp",
)  # fmt: skip
MOST_UNKNOWNS = 3000
"""Larger problems are left out: their tables take minutes to compile."""
Work = tuple[str, Problem, Settings | None]


def subproblems() -> Iterator[Work]:
    """Of every pattern that a mission's plan makes, the first and the last problem."""
    for name in PLANNED:
        mission, scenario = load_scenario(SCENARIOS / f"{name}.toml")
        found: dict[bytes, list[Problem]] = {}

        def recorded(problem: Problem, *rest: Any, _found: Any = found, **options: Any) -> Any:
            _found.setdefault(pattern_digest(problem), []).append(problem)
            return orbsoc.solve(problem, *rest, **options)

        mission.plan(scenario, solve=recorded)
        for k, same in enumerate(found.values()):
            yield f"{name}-{k}-first", same[0], None
            yield f"{name}-{k}-last", same[-1], None


def others() -> Iterator[Work]:
    """The zoo, its twins, and problems whose attempts stall."""
    for case in cases() + rescaled_twins():
        yield case.name, case.problem, None
    for settings in (
        stalling.STALLING,
        stalling.STALLING_REFINED,
        stalling.STALLING_REGULARIZED,
        stalling.STALLING_LIGHT,
    ):
        for seed in (*range(0, 100, 7), *stalling.RECOVERED, stalling.STALLED):
            yield f"badly_scaled-{seed}", stalling.badly_scaled(seed), settings
    yield "third_attempt", stalling.recovered_at_third_attempt(), stalling.WEAK
    for seed in range(20):
        yield f"unstable_dynamics-{seed}", stalling.unstable_dynamics(seed), None


def compare(work: Work, fp: int, compiler: str, options: list[str], outcomes: Counter[str]) -> int:
    """Solves that differ, of one from cold and one from a point near the solution."""
    name, problem, given = work
    settings = given or default_settings(fp)
    with tempfile.TemporaryDirectory() as folder:
        solver = compiled(Path(folder), problem, settings, fp, compiler, *options)
        engine = _core.ExactEngine(problem, settings, fp)
        cold = engine.solve()
        random = np.random.default_rng(0)
        x, y, z, s = (
            v * (1.0 + 1e-3 * random.standard_normal(v.size)) for v in (cold.x, cold.y, cold.z, cold.s)
        )
        s = np.where(np.isinf(s), 1.0, s)
        pairs = [
            (solver.solve(), expected(cold)),
            (solver.solve((x, y, z, s)), expected(engine.solve((x, y, z, s)))),
        ]
    for found, wanted in pairs:
        outcomes[f"{found['status']}, start {found['warm_start']}, attempts {found['attempts']}"] += 1
        if found != wanted:
            differing = {key: (found[key], wanted[key]) for key in found if key != "numbers"}
            sys.stdout.write(f"DIFFERS {name} binary{fp}: {differing}\n")
    return sum(found != wanted for found, wanted in pairs)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--compiler", default="gcc")
    parser.add_argument("--option", action="append", default=[])
    given = parser.parse_args()
    outcomes: Counter[str] = Counter()
    wrong = left_out = 0
    for work in (*subproblems(), *others()):
        if work[1].c.size + work[1].b.size + work[1].h.size > MOST_UNKNOWNS:
            left_out += 1
            continue
        wrong += sum(compare(work, fp, given.compiler, given.option, outcomes) for fp in (64, 32))
    for outcome, count in sorted(outcomes.items()):
        sys.stdout.write(f"{count:6} {outcome}\n")
    sys.stdout.write(
        f"{outcomes.total()} solves, {wrong} differ; {left_out} problems left out as too large\n"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
