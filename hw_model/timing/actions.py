"""The sequence of actions of a trace under a partition, without any duration.

durations.py says how long each action takes, precedence.py what it waits for, and timeline.py when it happens. Actions
depend on no platform, so a sweep over platforms makes them once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from hw_model.vocabulary import Module, Side

from .link import Residency

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition

    from .trace import Trace

RESULT = "(result)"
"""Stage name of what ends a solve: the status read, and copies of what the last stage wrote on the PL."""

PROBLEM = "(problem data)"
"""Stage name of the generation of a solve's data, and of the frame that announces them to the PL."""

START_UP = "equilibrate"
"""Stage that begins every solve attempt, cold or warm."""

PARAMETERS = "parameters"
"""Buffer that the PS writes anew before it restarts a solve."""

Kind = Literal["build", "compute", "copy", "launch", "interrupt", "flags", "publish", "rest"]
"""`build`: the PS generates the problem of a solve; `launch`: the frame that starts a segment; `interrupt`: the PS learns,
by interrupt or polling, that the segment has ended; `flags`: status, data-valid flags and acknowledgement after it;
`publish`: the frame, status and flags by which the PS announces what it wrote itself; `rest`: the status read that ends
a solve."""


class Work(NamedTuple):
    """What an action's duration depends on, apart from the platform."""

    kind: Kind
    side: Side
    """Where it computes; for a copy, where the buffer goes; else the PS."""
    pattern: int
    what: str
    """The stage for "compute", the buffer for "copy", else empty."""


class Action(NamedTuple):
    """One step of the run: some work, done for one stage of one iteration of one solve."""

    work: Work
    module: Module
    stage: str
    solve: int
    iteration: int
    event: int
    """Position in the solve's events: -1 before the first, their number after the last."""


def actions_of(trace: Trace, partition: Partition) -> list[Action]:
    """Copies, launches, computations, interrupts and flag checks of every solve, in order.

    Each solve starts with the generation of its data on the PS, and ends when the PS holds what the last stage wrote. So
    does each attempt of a solve with restarts: the PS judges its outcome before the next one. A partition that leaves
    the PL idle has no protocol: the PS computes and nothing else happens.
    """
    actions: list[Action] = []
    for s, solve in enumerate(trace.solves):
        pattern = trace.patterns[solve.pattern]
        residency = Residency(name for name, words in pattern.buffers.items() if words)
        outputs: tuple[str, ...] = ()
        iteration = solve.events[0][1] if solve.events else 0
        actions.append(Action(Work("build", "ps", solve.pattern, ""), "ps", PROBLEM, s, iteration, -1))
        if partition.uses_pl:
            actions.append(Action(Work("publish", "ps", solve.pattern, ""), "ps", PROBLEM, s, iteration, -1))
        for e, (name, iteration) in enumerate(solve.events):
            if e and name == START_UP:
                works = _end(partition, solve.pattern, residency, outputs)
                actions += [Action(work, "ps", RESULT, s, iteration, e) for work in works]
                residency.written([PARAMETERS], "ps")
            stage = pattern.stages[name]
            side = partition.side(stage.module)
            crossing = residency.missing(stage.reads, side)
            works = [Work("copy", side, solve.pattern, buffer) for buffer in crossing]
            works += _run(side, solve.pattern, name, announced=partition.uses_pl)
            actions += [Action(work, stage.module, name, s, iteration, e) for work in works]
            residency.written(stage.writes, side)
            outputs = stage.writes
        works = _end(partition, solve.pattern, residency, outputs)
        actions += [Action(work, "ps", RESULT, s, iteration, len(solve.events)) for work in works]
    return actions


def _end(partition: Partition, pattern: int, residency: Residency, outputs: tuple[str, ...]) -> list[Work]:
    """The end of an attempt: the PL is idle, and what the last stage wrote goes to the PS."""
    works = [Work("rest", "ps", pattern, "")] if partition.uses_pl else []
    return works + [Work("copy", "ps", pattern, buffer) for buffer in residency.missing(outputs, "ps")]


def _run(side: Side, pattern: int, name: str, *, announced: bool) -> list[Work]:
    """One run of a stage: on the PL it is launched, interrupts, and has its flags read."""
    compute = Work("compute", side, pattern, name)
    if side == "ps":
        return [compute, Work("publish", "ps", pattern, "")] if announced else [compute]
    launch, interrupt, flags = (Work(kind, "ps", pattern, "") for kind in ("launch", "interrupt", "flags"))
    return [launch, compute, interrupt, flags]
