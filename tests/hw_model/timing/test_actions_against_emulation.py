"""The actions are those of the emulated PS, move for move and access for access."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from hw_model.platform.partition import load_partition
from hw_model.platform.platform import load_platform
from hw_model.report.run import simulate
from hw_model.timing.actions import START_UP, actions_of
from hw_model.timing.trace import parse_trace
from orbsoc import Cones, Problem, PsScheduler
from orbsoc.conic.settings import Settings
from orbsoc.ps.events import Kind
from tests.hw_model.synthetic import stage
from tests.hw_model.timing.test_actions import copies, trace_of
from tests.ps.fake_engine import STAGES, WORDS, FakeEngine, prepare
from tests.solving.restart_problems import RECOVERED, STALLING, WEAK, badly_scaled, recovered_at_third_attempt

PAPER = load_partition("paper")


def _trace_of_fake(engine: FakeEngine) -> dict[str, Any]:
    stages = {
        name: stage(info.module, " ".join(info.reads), " ".join(info.writes), 1)
        for name, info in STAGES.items()
    }
    trace = trace_of(stages, engine.ran)
    trace["patterns"][0]["buffers"] = dict(WORDS)
    return trace


@pytest.mark.parametrize("iterations", [1, 4])
@pytest.mark.parametrize("refinements", [0, 2])
def test_the_actions_are_those_of_the_emulated_ps(iterations: int, refinements: int) -> None:
    """Same moves in the same order, and the register accesses and interrupts of the driver's own record."""
    run = prepare(FakeEngine(iterations, refinements))
    run.driver.run()
    actions = actions_of(parse_trace(_trace_of_fake(run.engine)), PAPER)
    moved = [
        (event.name, "pl" if event.kind is Kind.TO_PL else "ps")
        for event in run.record
        if event.kind in (Kind.TO_PL, Kind.TO_PS)
    ]
    needed = [(buffer, side) for _, buffer, side in copies(actions)]
    # Within one stage the driver moves in the order of the buffers, the actions in that of the reads.
    assert sorted(moved) == sorted(needed)
    kinds = Counter(action.work.kind for action in actions)
    counts = run.record.counts()
    assert counts[Kind.INTERRUPT] == kinds["interrupt"]
    assert counts[Kind.WRITE] == 4 * (kinds["launch"] + kinds["publish"]) + kinds["flags"]
    assert counts[Kind.READ] == 2 * (kinds["flags"] + kinds["publish"]) + kinds["rest"]


SMALL = Problem(
    c=[1.0, 0.0], A=[[1.0, 1.0]], b=[2.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0], cones=Cones(q=[2])
)


@pytest.mark.parametrize(
    ("problem", "settings", "attempts"),
    [
        (SMALL, Settings(), 1),
        (badly_scaled(RECOVERED[0]), STALLING, 2),
        (recovered_at_third_attempt(), WEAK, 3),
    ],
)
def test_the_actions_are_those_of_the_emulated_ps_with_the_real_solver(
    problem: Problem, settings: Settings, attempts: int
) -> None:
    """Also with restarts, for which the parameters, and nothing else, go to the PL again."""
    ps = PsScheduler(settings)
    assert ps(problem).status.name == "SOLVED"
    assert [stage for stage, _ in ps.trace["solves"][0]["events"]].count(START_UP) == attempts
    trace = parse_trace(ps.trace)
    actions = actions_of(trace, PAPER)
    needed = Counter((buffer, side) for _, buffer, side in copies(actions))
    assert needed["parameters", "pl"] == attempts
    assert needed["raw_g", "pl"] == 1
    moved = Counter(
        (event.name, "pl" if event.kind is Kind.TO_PL else "ps")
        for event in ps.record
        if event.kind in (Kind.TO_PL, Kind.TO_PS) and event.value
    )
    assert moved == needed
    kinds, counts = Counter(action.work.kind for action in actions), ps.record.counts()
    flag_words = -(-len(trace.patterns[0].buffers) // 32)
    assert counts[Kind.INTERRUPT] == kinds["interrupt"]
    assert counts[Kind.WRITE] == 4 * (kinds["launch"] + kinds["publish"]) + kinds["flags"]
    assert counts[Kind.READ] == (1 + flag_words) * (kinds["flags"] + kinds["publish"]) + kinds["rest"]


@pytest.mark.parametrize(("name", "published"), [("paper", 3), ("resident", 1), ("all_ps", 0)])
def test_an_attempts_first_publish_and_launch_take_more(name: str, published: int) -> None:
    """Of three attempts; under resident control nothing is published again."""
    ps = PsScheduler(WEAK)
    ps(recovered_at_third_attempt())
    trace, partition = parse_trace(ps.trace), load_partition(name)
    works = [action.work for action in actions_of(trace, partition)]
    first = Counter(work.kind for work in works if work.first)
    assert first == +Counter(publish=published, launch=3 * partition.uses_pl)
    platform = load_platform("zu9eg")
    less, more = (
        simulate(trace, platform.with_values(values), partition).makespan_picoseconds
        for values in ({}, {"link.first_ns": 150.0, "link.publish_ns": 20.0})
    )
    publishes = sum(work.kind == "publish" for work in works)
    assert more - less == 150_000 * first.total() + 20_000 * publishes


def test_the_longest_iteration_holds_no_start_up() -> None:
    """Not a restart's either, which has the number of the iteration that ended the attempt before."""
    ps = PsScheduler(STALLING)
    ps(badly_scaled(RECOVERED[0]))
    [_, again] = [number for stage, number in ps.trace["solves"][0]["events"] if stage == START_UP]
    timeline = simulate(ps.trace, "zu9eg", PAPER)
    solve, longest = timeline.longest_iteration()
    assert solve == 0
    assert longest not in (0, again)
