"""What crosses when, and when it does not."""

from __future__ import annotations

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from hw_model.timing.actions import Action, actions_of
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.random_traces import traces
from tests.hw_model.synthetic import stage, synthetic_trace
from tests.hw_model.tiny import partition_of


def trace_of(stages: dict[str, Any], events: list[str], words: int = 100) -> dict[str, Any]:
    """A trace of one solve; every buffer has `words` words."""
    buffers = {name: words for entry in stages.values() for name in (*entry["reads"], *entry["writes"])}
    pattern = {
        "n": 1, "p": 0, "m": 1, "cones": {"l": 1, "q": []}, "nnz_kkt": 1, "nnz_l": 0,
        "buffers": buffers, "stages": stages,
    }  # fmt: skip
    solve = {"pattern": 0, "status": "SOLVED", "iterations": 0, "events": [[name, 0] for name in events]}
    return {"schema": "orbsoc.trace/2", "datapath": "f64", "patterns": [pattern], "solves": [solve]}


def copies(actions: list[Action]) -> list[tuple[str, str, str]]:
    """(stage that needs it, buffer, side it goes to) in order."""
    return [(a.stage, a.work.what, a.work.side) for a in actions if a.work.kind == "copy"]


STEPS = {
    "use": stage("cone_ops", "x", "y", 9, add=1),
    "use_again": stage("line_search", "x y", "z", 9, add=1),
    "look": stage("ps", "y", "", 9, add=1),
    "change": stage("ps", "", "x", 9, add=1),
}


def test_a_buffer_read_twice_crosses_once() -> None:
    actions = actions_of(parse_trace(trace_of(STEPS, ["use", "use_again", "use"])), partition_of(*PL_MODULES))
    assert copies(actions) == [("use", "x", "pl"), ("(result)", "y", "ps")]


def test_a_buffer_crosses_again_after_the_other_side_wrote_it() -> None:
    events = ["use", "look", "look", "change", "use", "look"]
    actions = actions_of(parse_trace(trace_of(STEPS, events)), partition_of(*PL_MODULES))
    assert copies(actions) == [
        ("use", "x", "pl"), ("look", "y", "ps"), ("use", "x", "pl"), ("look", "y", "ps"),
    ]  # fmt: skip


def test_what_stays_on_one_side_never_crosses() -> None:
    actions = actions_of(
        parse_trace(trace_of(STEPS, ["use", "use_again", "look"])), partition_of("line_search")
    )
    # y is made and looked at on the PS; only the line search needs it, and x, on the PL.
    assert copies(actions) == [("use_again", "x", "pl"), ("use_again", "y", "pl")]


def test_an_empty_buffer_never_crosses() -> None:
    actions = actions_of(parse_trace(trace_of(STEPS, ["use", "look"], words=0)), partition_of(*PL_MODULES))
    assert copies(actions) == []


def test_every_solve_starts_from_the_ps() -> None:
    trace = trace_of(STEPS, ["use"])
    trace["solves"] = trace["solves"] * 2
    actions = actions_of(parse_trace(trace), partition_of(*PL_MODULES))
    assert [(a.solve, a.work.what) for a in actions if a.work.kind == "copy"] == [
        (0, "x"), (0, "y"), (1, "x"), (1, "y"),
    ]  # fmt: skip


@settings(max_examples=100, deadline=None)
@given(trace=traces(), on_pl=st.sets(st.sampled_from(PL_MODULES)))
def test_every_read_finds_the_latest_version_and_no_copy_is_idle(trace, on_pl) -> None:  # type: ignore[no-untyped-def]
    """Replay with version numbers: each side has a version of each buffer, copies overwrite, writes advance."""
    checked, partition = parse_trace(trace), partition_of(*on_pl)
    version: dict[tuple[str, str], int] = {}
    clock, solve = 0, -1
    for action in actions_of(checked, partition):
        if action.solve != solve:
            solve, version = action.solve, {}
        pattern = checked.patterns[action.work.pattern]
        here = action.work.side
        other = "pl" if here == "ps" else "ps"
        if action.work.kind == "copy":
            buffer = action.work.what
            start = {"ps": 0, "pl": -1}
            mine, theirs = (version.get((side, buffer), start[side]) for side in (here, other))
            assert mine < theirs
            version[here, buffer] = theirs
        elif action.work.kind == "compute":
            done = pattern.stages[action.work.what]
            for buffer in done.reads:
                if pattern.buffers[buffer]:
                    latest = max(version.get(("ps", buffer), 0), version.get(("pl", buffer), -1))
                    assert version.get((here, buffer), 0 if here == "ps" else -1) == latest
            clock += 1
            version.update({(here, buffer): clock for buffer in done.writes})


def test_actions_do_not_depend_on_counts_or_sizes() -> None:
    trace = synthetic_trace(iterations=2)
    before = actions_of(parse_trace(trace), partition_of("factorization"))
    for entry in trace["patterns"][0]["stages"].values():
        entry["operations"] = {code: 3 * count + 1 for code, count in entry["operations"].items()}
    assert actions_of(parse_trace(trace), partition_of("factorization")) == before
