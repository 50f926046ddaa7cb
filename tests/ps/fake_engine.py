"""A small engine and its dataflow table, for tests of the PS that need no Rust.

The method: scale, load half of the matrix, start; then iterations that finish the matrix, factorize, solve (refined
while the residual asks for it), step and check; then unscale.
Its numbers are integers that depend on the order of all stages run, so a wrong schedule gives a wrong result.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from orbsoc.ps.driver import Driver
from orbsoc.ps.events import PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.registers import RegisterFile
from orbsoc.ps.segments import Method

NEXT, REPEAT, DONE = 0, 1, 2


@dataclass(frozen=True)
class Stage:
    module: str
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    stales: tuple[str, ...] = ()
    flag: tuple[str, str] | None = None


STAGES = {
    "scale": Stage("matrix_scaling", reads=("data",), writes=("scaled",)),
    "load": Stage("matrix_update", reads=("scaled",), writes=("kkt",), stales=("kkt", "factor")),
    "start": Stage("ps", reads=("scaled", "settings"), writes=("point",)),
    "update": Stage("matrix_update", reads=("kkt", "point"), writes=("kkt",), stales=("factor",)),
    "factorize": Stage("factorization", reads=("kkt",), writes=("factor",), stales=("direction",)),
    "solve": Stage("linear_solve", reads=("factor", "point"), writes=("direction",)),
    "residual": Stage("ps", reads=("kkt", "direction"), writes=("error",)),
    "refine": Stage("linear_solve", reads=("factor", "error", "direction"), writes=("direction",)),
    "search": Stage("line_search", reads=("point", "direction"), writes=("step",)),
    "advance": Stage("cone_ops", reads=("step", "direction", "point"), writes=("point",), stales=("kkt",)),
    "check": Stage("ps", reads=("point", "settings"), writes=("statistics",)),
    "unscale": Stage("matrix_scaling", reads=("point", "scaled"), writes=("answer",)),
}
STARTUP = (("scale",), ("load",), ("start",))
ITERATION = (
    ("update",), ("factorize",), ("solve",), ("refine", "residual"), ("search",), ("advance",), ("check",),
)  # fmt: skip
CLOSING = (("unscale",),)
METHOD = Method.from_tables(
    startup=STARTUP, iteration=ITERATION, closing=CLOSING, stages=STAGES, repeat=REPEAT, done=DONE
)
WORDS = {name: 10 + position for position, name in enumerate(METHOD.buffers)}


@dataclass
class FakeEngine:
    """Counts iterations and mixes the stages run into `state`; every iteration refines `refinements` times."""

    iterations: int = 2
    refinements: int = 1
    ran: list[str] = field(default_factory=list)
    state: int = 0

    def run(self, stage: str) -> int:
        self.ran.append(stage)
        self.state = (self.state * 31 + list(STAGES).index(stage) + 1) % 1_000_003
        if stage == "residual":
            since = self.ran[::-1].index("solve")
            return REPEAT if self.ran[len(self.ran) - since :].count("refine") < self.refinements else NEXT
        if stage == "check":
            return DONE if self.ran.count("check") == self.iterations else NEXT
        return NEXT

    def solve(self) -> None:
        """The whole solve: the loop as Rust has it."""
        _run_steps(self, STARTUP)
        while _run_steps(self, ITERATION) != DONE:
            pass
        _run_steps(self, CLOSING)


def _run_steps(engine: FakeEngine, steps: tuple[tuple[str, ...], ...]) -> int:
    outcome = NEXT
    for stage, *until in steps:
        if until:
            while (outcome := engine.run(until[0])) == REPEAT:
                engine.run(stage)
        else:
            outcome = engine.run(stage)
        if outcome == DONE:
            break
    return outcome


@dataclass
class Run:
    """One scheduled run with everything that can be looked at afterwards."""

    engine: FakeEngine
    pl: ProgrammableLogic
    record: PsRecord
    driver: Driver


def prepare(
    engine: FakeEngine | None = None,
    *,
    between: Callable[[ProgrammableLogic], RegisterFile] = lambda pl: pl,
    method: Method = METHOD,
    busy_ticks: int = 1,
    poll_budget: int = 5,
) -> Run:
    """A run ready to start; `between` may put something between the PS and the PL."""
    engine = engine or FakeEngine()
    pl = ProgrammableLogic(method, engine.run, busy_ticks=busy_ticks)
    record = PsRecord()
    driver = Driver(method, engine, between(pl), words=WORDS, record=record, poll_budget=poll_budget)
    return Run(engine, pl, record, driver)
