"""Groups: problems of one pattern that are interleaved in one stream, and solved together (`pl.interleaved` of them).

The PL's own control runs them, and stops when the last has ended: each segment of each iteration runs as often as the problem
that needs it most asks for, and what closes an attempt runs once. All else is done once a problem. docs/pl-machine.md has
the streams; tests/rtl/test_interleaved.py counts the same segments on the RTL.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError

from .control_program import members

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform

    from .actions import Action, Work
    from .trace import Trace


NO_GROUPS_HERE = (
    "this report is of one problem after the other; `orbsoc hw trace` prints how many a second interleaved ones are,"
    " `orbsoc hw budget` what they take"
)
NO_GROUPS_BY_THE_PS = (
    "only the PL's own control runs several problems in one stream;"
    ' choose a partition with control = "pl", such as resident'
)


def require_one_problem(platform: Platform) -> None:
    """Raise HwModelError where the platform interleaves problems: the time of a run is that of one after the other."""
    copies = platform.pl.interleaved.value
    if copies > 1:
        raise HwModelError(f"`pl.interleaved` = {copies}: {NO_GROUPS_HERE}")


def require_groups(platform: Platform, partition: Partition) -> None:
    """Raise HwModelError where the platform interleaves problems that the partition cannot run together."""
    copies = platform.pl.interleaved.value
    if copies > 1 and partition.uses_pl and partition.control != "pl":
        raise HwModelError(
            f"`pl.interleaved` = {copies} under partition {partition.name!r}: {NO_GROUPS_BY_THE_PS}"
        )


def in_groups(trace: Trace, copies: int) -> Trace:
    """The trace's solves in an order in which groups follow one another, those of each pattern together, for `grouped`.

    The solves of a pattern are taken as independent problems, and form groups as they follow; the last may be smaller. If any
    pattern has fewer than a group takes, the trace stands for that many independent runs of it, and a group is the same
    solve of each run. Raises HwModelError for a solve that starts warm.
    """
    if copies == 1:
        return trace
    _require_cold(trace, copies)
    patterns, repeats = sorted({solve.pattern for solve in trace.solves}), runs_in_group(trace, copies)
    ordered = [solve for pattern in patterns for solve in trace.solves if solve.pattern == pattern]
    solves = tuple(solve for solve in ordered for _ in range(repeats))
    return trace.model_copy(update={"solves": solves, "outer_loop": None})  # independent problems are no plan


def runs_in_group(trace: Trace, copies: int) -> int:
    """Runs of the trace that a group takes its problems from: one, or where a pattern has too few solves as many as problems."""
    return copies if min(Counter(solve.pattern for solve in trace.solves).values()) < copies else 1


def _require_cold(trace: Trace, copies: int) -> None:
    method = trace.method
    if method is None:
        return
    steps = (method.startup, method.iteration, method.closing)
    cold = {stage for each in steps for step in each for stage in step}
    warm = {stage for step in method.warm_startup for stage in step} - cold
    for number, solve in enumerate(trace.solves):
        if any(stage in warm for stage, _ in solve.events):
            raise HwModelError(
                f"`pl.interleaved` = {copies}: solve {number} of the workload starts warm, and interleaved problems start cold"
            )


def grouped(actions: Iterable[Action], trace: Trace, copies: int) -> Iterator[Work]:
    """Of each group of a trace `in_groups` what precedes the PL's work, that work, and what follows."""
    groups: defaultdict[tuple[int, int], list[Action]] = defaultdict(list)
    numbers = _numbers(trace)
    for action in actions:
        pattern = trace.solves[action.solve].pattern
        groups[pattern, numbers[action.solve] // copies].append(action)
    for group in groups.values():
        yield from _together(group, _closing(trace))


def _numbers(trace: Trace) -> list[int]:
    """Of each solve its number among those of its pattern."""
    seen: Counter[int] = Counter()
    found: list[int] = []
    for solve in trace.solves:
        found.append(seen[solve.pattern])
        seen[solve.pattern] += 1
    return found


def _closing(trace: Trace) -> frozenset[str]:
    """Stages that close an attempt."""
    return (
        frozenset(stage for step in trace.method.closing for stage in step) if trace.method else frozenset()
    )


def _together(group: list[Action], closing: frozenset[str]) -> Iterator[Work]:
    before: list[Work] = []
    after: list[Work] = []
    runs: dict[int, Counter[tuple[int | None, Work]]] = {}
    for action in group:
        if action.work.kind in ("compute", "control") and action.work.side == "pl":
            iteration = None if closing.intersection(members(action.stage)) else action.iteration
            runs.setdefault(action.solve, Counter())[iteration, action.work] += 1
        else:
            (after if action.solve in runs else before).append(action.work)
    most: Counter[tuple[int | None, Work]] = Counter()
    for counts in runs.values():
        most |= counts
    yield from before
    yield from (work for _, work in most.elements())
    yield from after
