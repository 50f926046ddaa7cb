"""The control program against the lists that it is made from: the same stages, whatever the flags say."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hw_model.errors import TraceError
from hw_model.platform.partition import load_partition, on_pl
from hw_model.timing.control_program import (
    ControlProgram,
    control_cycles,
    control_program,
    partition_streams,
    split,
)
from hw_model.timing.trace import Method

METHOD = Method(
    startup=(("scale",), ("load",), ("solve",), ("refine", "check")),
    warm_startup=(("scale",), ("place",), ("judge",), ("center",)),
    iteration=(
        ("judge",), ("factor",), ("solve",), ("refine", "check"), ("aim",), ("solve",), ("refine", "check"), ("advance",),
    ),
    closing=(("unscale",),),
    flags={"judge": "stop", "center": "stop", "check": "repeat"},
)  # fmt: skip
MODULES = {
    "scale": "matrix_scaling", "load": "matrix_update", "solve": "linear_solve", "refine": "linear_solve",
    "check": "statistics", "place": "matrix_scaling", "judge": "statistics", "center": "cone_ops",
    "factor": "factorization", "aim": "cone_ops", "advance": "statistics", "unscale": "matrix_scaling",
}  # fmt: skip


def _by_lists(raised: Callable[[str], bool], *, warm: bool) -> list[str]:
    """An attempt as the solver's loop runs it."""
    ran: list[str] = []

    def perform(steps: tuple[tuple[str, ...], ...]) -> bool:
        for stage, *until in steps:
            ran.append(until[0] if until else stage)
            while until and raised(ran[-1]):
                ran.extend([stage, until[0]])
            if not until and METHOD.flags.get(stage) == "stop" and raised(stage):
                return True
        return False

    ended = perform(METHOD.warm_startup if warm else METHOD.startup)
    while not ended:
        ended = perform(METHOD.iteration)
    perform(METHOD.closing)
    return ran


def _by_program(
    program: ControlProgram, raised: Callable[[str], bool], *, warm: bool
) -> list[tuple[str, ...]]:
    at, ran, flag = program.warm if warm else program.cold, list[tuple[str, ...]](), False
    while (instruction := program.instructions[at]).op != "end":
        at += 1
        if instruction.op == "run":
            ran.append(instruction.stream)
            last = instruction.stream[-1]
            assert not set(instruction.stream[:-1]) & METHOD.flags.keys(), "a decision ends its stream"
            flag = last in METHOD.flags and raised(last)
        else:
            assert ran[-1][-1] == instruction.flag, "a branch follows its decision"
            at = instruction.target if flag == (instruction.op == "if") else at
    return ran


def _flags(answers: list[bool]) -> Callable[[str], bool]:
    """Flags as drawn, and then such that the attempt ends."""
    given: Iterator[bool] = iter(answers)
    return lambda stage: next(given, METHOD.flags[stage] == "stop")


@given(answers=st.lists(st.booleans(), max_size=40), warm=st.booleans(), joined=st.booleans())
def test_the_program_runs_the_stages_of_the_lists(answers: list[bool], warm: bool, joined: bool) -> None:
    program = control_program(METHOD, joined=joined)
    ran = _by_program(program, _flags(answers), warm=warm)
    stages = [stage for stream in ran for stage in stream]
    assert stages == _by_lists(_flags(answers), warm=warm)
    # What a trace says of the stages is enough to know the segments.
    assert list(split(stages, program.streams)) == ran


def test_an_iteration_has_as_many_streams_as_decisions() -> None:
    program = control_program(METHOD, joined=True)
    several = [stream for stream in program.streams if len(stream) > 1]
    assert set(several) == {
        ("factor", "solve", "check"), ("refine", "check"), ("aim", "solve", "check"), ("advance", "judge"),
    }  # fmt: skip
    assert all(len(stream) == 1 for stream in control_program(METHOD, joined=False).streams)


def test_a_segment_costs_its_start_and_its_branch() -> None:
    assert control_cycles(("factor",), METHOD) == 3
    assert control_cycles(("aim", "solve", "check"), METHOD) == 3 + 7


def test_under_the_papers_control_a_stream_ends_where_the_ps_computes() -> None:
    streams = partition_streams(METHOD, MODULES, load_partition("paper_streams"))
    assert [stream for stream in streams if len(stream) > 1] == [("factor", "solve"), ("aim", "solve")]
    assert {stream[0] for stream in streams} == {
        stage for stage, module in MODULES.items() if module != "statistics"
    }
    assert partition_streams(METHOD, MODULES, load_partition("paper")) == ()


def test_stage_by_stage_all_partitions_with_statistics_share_one_program() -> None:
    found = {
        partition_streams(METHOD, MODULES, on_pl(*names))
        for names in (("statistics",), ("statistics", "factorization"))
    }
    assert found == {tuple((stage,) for stage in MODULES)}


def test_an_iteration_that_does_not_begin_with_a_decision_is_refused() -> None:
    turned = METHOD.model_copy(update={"iteration": METHOD.iteration[1:]})
    with pytest.raises(TraceError, match="iteration must begin with"):
        control_program(turned, joined=True)
