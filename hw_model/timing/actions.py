"""The sequence of actions of a trace under a partition, without any duration.

durations.py says how long each action takes, precedence.py what it waits for, and timeline.py when it happens. Actions
depend on no platform, so a sweep over platforms makes them once.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from hw_model.errors import TraceError
from hw_model.vocabulary import Module, Side

from .control_program import SEPARATOR, attempt_stages, members, split, streams_of
from .link import Residency
from .programs import follows_another

if TYPE_CHECKING:
    from hw_model.platform.partition import Partition

    from .trace import OuterLoop, Solve, Trace

RESULT = "(result)"
"""Stage name of what ends a solve: the status read, and copies of what the last stage wrote on the PL."""

PROBLEM = "(problem data)"
"""Stage name of the generation of a solve's data, and of the frame that announces them to the PL."""

OUTER = "(outer loop)"
"""Stage name of what the PS does after the last solve of a plan: the flight that judges it."""

START_UP = "equilibrate"
"""Stage that begins every solve attempt, cold or warm."""

REWRITTEN = ("parameters", "control", "verdict", "best", "farkas", "ray")
"""Buffers that the PS writes anew before it restarts a solve: parameters, limits, and what is kept from better to best."""

OUTCOME = ("control", "verdict")
"""Buffers in which the PL leaves why an attempt has ended, where it decides by itself."""

Kind = Literal[
    "build", "outer", "load", "compute", "copy", "launch", "interrupt", "flags", "publish", "rest", "control"
]  # fmt: skip
"""`build`: the PS generates the problem of a solve, as assumed; `outer`: it does what was counted around the solves; `load`: it writes the
program of another pattern than the last solve's; `launch`: the frame that starts a segment; `interrupt`: the PS learns,
by interrupt or polling, that the segment has ended; `flags`: status, data-valid flags and acknowledgement after it;
`publish`: the frame, status and flags by which the PS announces what it wrote itself; `rest`: the status read that ends
a solve; `control`: the PL's operation control between two segments that it runs by itself."""


REPEATED: frozenset[Kind] = frozenset({"publish", "launch"})
"""What the PS does with registers again and again in an attempt: the first time its code and data may be in no cache."""


class Work(NamedTuple):
    """What an action's duration depends on, apart from the platform."""

    kind: Kind
    side: Side
    """Where it computes; for a copy, where the buffer goes; else the PS."""
    pattern: int
    what: str
    """The stage or stream for "compute" and "control", the buffer for "copy", the number of the work for "outer", else empty."""
    first: bool = False
    """Whether it is of REPEATED, and an attempt's first of its kind."""


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

    Each solve starts with the generation of its data on the PS, then the program of its pattern where another's was before. It ends
    when the PS holds what the last stage wrote; after
    the last comes the rest of a counted outer loop. So does each attempt of a solve with restarts: the PS judges its outcome before the next one. A partition that leaves
    the PL idle has no protocol: the PS computes and nothing else happens.
    """
    streams = [members(name) for name in streams_of(trace, partition)]
    if partition.control == "pl" and not streams:
        raise TraceError(
            "trace: `method` is missing: resident control needs the step lists that the solves ran"
        )
    actions: list[Action] = []
    for s, (solve, changed) in enumerate(zip(trace.solves, follows_another(trace), strict=True)):
        pattern = trace.patterns[solve.pattern]
        residency = Residency(name for name, words in pattern.buffers.items() if words)
        outputs: tuple[str, ...] = ()
        left = set(REPEATED)
        iteration = solve.events[0][1] if solve.events else 0
        actions.append(Action(before(trace, s), "ps", PROBLEM, s, iteration, -1))
        if partition.uses_pl and changed:
            actions.append(Action(Work("load", "ps", solve.pattern, ""), "ps", PROBLEM, s, iteration, -1))
        if partition.uses_pl:
            publish = marked(Work("publish", "ps", solve.pattern, ""), left)
            actions.append(Action(publish, "ps", PROBLEM, s, iteration, -1))
        e = 0
        for stages in split([name for name, _ in solve.events], streams):
            name, iteration = SEPARATOR.join(stages), solve.events[e][1]
            begins = stages[0] == START_UP
            if e and begins:
                works = ending(partition, solve.pattern, residency, outputs)
                actions += [Action(marked(work, left), "ps", RESULT, s, iteration, e) for work in works]
                residency.written(REWRITTEN, "ps")
                left = set(REPEATED)
            stage = pattern.stage(name)
            side = partition.side(stage.module)
            works = []
            if partition.control == "ps":
                crossing = residency.missing(stage.reads, side)
                works += [Work("copy", side, solve.pattern, buffer) for buffer in crossing]
                works += running(side, solve.pattern, name, announced=partition.uses_pl)
            else:
                if begins:
                    works += _attempt(trace, solve, e, residency)
                works += [Work(kind, "pl", solve.pattern, name) for kind in ("control", "compute")]
            actions += [Action(marked(work, left), stage.module, name, s, iteration, e) for work in works]
            residency.written(stage.writes, side)
            outputs = stage.writes
            e += len(stages)
        works = ending(partition, solve.pattern, residency, outputs)
        actions += [
            Action(marked(work, left), "ps", RESULT, s, iteration, len(solve.events)) for work in works
        ]
    if trace.outer_loop is not None:
        last, solve = len(trace.solves), trace.solves[-1]
        iteration = solve.events[-1][1] if solve.events else 0
        work = Work("outer", "ps", solve.pattern, _number(trace.outer_loop, last))
        actions.append(Action(work, "ps", OUTER, last - 1, iteration, len(solve.events) + 1))
    return actions


def marked(work: Work, left: set[Kind]) -> Work:
    """The work, as the first of its kind if that is among those left in this attempt; it no longer is."""
    if work.kind not in left:
        return work
    left.remove(work.kind)
    return work._replace(first=True)


def before(trace: Trace, s: int) -> Work:
    """What the PS does before a solve."""
    pattern = trace.solves[s].pattern
    if trace.outer_loop is None:
        return Work("build", "ps", pattern, "")
    return Work("outer", "ps", pattern, _number(trace.outer_loop, s))


def _number(loop: OuterLoop, k: int) -> str:
    """The first work that is equal to number k."""
    return str(loop.works.index(loop.works[k]))


def _attempt(trace: Trace, solve: Solve, first: int, residency: Residency) -> list[Work]:
    """The start of an attempt under resident control: what it reads before it writes it, and the frame."""
    assert trace.method is not None  # actions_of has made sure
    stages = trace.patterns[solve.pattern].stages
    ran = [name for name, _ in solve.events[first:]]
    cold, warm = (attempt_stages(trace.method, warm=way) for way in (False, True))
    parting = next(k for k, (one, other) in enumerate(zip(cold, warm, strict=False)) if one != other)
    written: set[str] = set()
    given: dict[str, None] = {}
    for name in warm if ran[parting : parting + 1] == warm[parting : parting + 1] else cold:
        given |= dict.fromkeys(buffer for buffer in stages[name].reads if buffer not in written)
        written |= set(stages[name].writes)
    works = [Work("copy", "pl", solve.pattern, buffer) for buffer in residency.missing(given, "pl")]
    return [*works, Work("launch", "ps", solve.pattern, "")]


def ending(partition: Partition, pattern: int, residency: Residency, outputs: tuple[str, ...]) -> list[Work]:
    """The end of an attempt: the PL is idle, and what the last stage wrote goes to the PS."""
    works = [Work("rest", "ps", pattern, "")] if partition.uses_pl else []
    if partition.control == "pl":
        works = [Work(kind, "ps", pattern, "") for kind in ("interrupt", "flags", "rest")]
        outputs = (*outputs, *OUTCOME)
    return works + [Work("copy", "ps", pattern, buffer) for buffer in residency.missing(outputs, "ps")]


def running(side: Side, pattern: int, name: str, *, announced: bool) -> list[Work]:
    """One run of a stage: on the PL it is launched, interrupts, and has its flags read."""
    compute = Work("compute", side, pattern, name)
    if side == "ps":
        return [compute, Work("publish", "ps", pattern, "")] if announced else [compute]
    launch, interrupt, flags = (Work(kind, "ps", pattern, "") for kind in ("launch", "interrupt", "flags"))
    return [launch, compute, interrupt, flags]
