"""What the outer loop in C executes is what the law states: counted again under QEMU, for sizes that it was not fitted to."""

from __future__ import annotations

from pathlib import Path

import pytest

import orbsoc
from orbsoc.flight.instructions import outer_loop_counts
from orbsoc.guidance.outer_loop import OuterLoop
from orbsoc.missions.reachable_insertion import Scenario, load_scenario, outer_loop, plan
from orbsoc.missions.reachable_insertion.on_board import on_board
from orbsoc.missions.registry import MISSIONS
from tests.flight.c_library import ROOT, need

WITHIN = 1e-3
"""Relative: copies end a few instructions sooner or later, and a sample on a node needs no division by its distance."""


def made(changes: dict[str, dict[str, float]]) -> Scenario:
    return load_scenario(ROOT / "scenarios" / "rec1.toml").with_changes(**changes)


def loop_of(scenario: Scenario) -> OuterLoop:
    found = outer_loop(scenario, plan(scenario))
    assert found is not None
    return found


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"method": {"nodes": 18}, "burn": {"duration_s": 210.0}},
        {"method": {"nodes": 9}, "vehicle": {"mass_flow_kg_s": 15.0}},
    ],
    ids=["as shipped", "a longer guess", "a longer judging flight"],
)
def test_counts_are_those_of_the_law(changes: dict[str, dict[str, float]], tmp_path: Path) -> None:
    need("aarch64-linux-gnu-gcc")
    need("qemu-aarch64")
    scenario = made(changes)
    counted = outer_loop_counts(tmp_path, on_board(scenario, orbsoc.solve))[0]
    stated = loop_of(scenario).works
    assert len(stated) == len(counted)
    for work, executed in zip(stated, counted, strict=True):
        assert tuple(work) == pytest.approx(executed, rel=WITHIN)


def test_more_nodes_and_steps_take_more() -> None:
    shipped, finer = loop_of(made({})), loop_of(made({"method": {"nodes": 16}}))
    for work, more in ((shipped.works[0], finer.works[0]), (shipped.works[-1], finer.works[-1])):
        assert more.instructions > work.instructions
        assert more.divisions > work.divisions


@pytest.mark.parametrize(
    "changes",
    [{"problem": "max_energy"}, {"burn": {"ignition": "free"}}, {"limits": {"attitude_rate_deg_s": 0.05}}],
    ids=str,
)
def test_a_plan_that_the_program_does_not_make_has_none(changes: dict[str, object]) -> None:
    scenario = made(changes)  # type: ignore[arg-type]
    assert outer_loop(scenario, plan(scenario)) is None


def test_a_plan_of_several_attempts_has_none() -> None:
    scenario = load_scenario(ROOT / "scenarios" / "deorbit.toml")
    found = plan(scenario)
    assert len(found.attempts) > 1
    assert outer_loop(scenario, found) is None


def test_other_missions_have_none() -> None:
    assert [name for name, mission in MISSIONS.items() if hasattr(mission, "outer_loop")] == [
        "reachable_insertion"
    ]
