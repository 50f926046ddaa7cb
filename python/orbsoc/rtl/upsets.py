"""Upsets: one bit of the RTL turned over in a solve, and what comes of it with a PS that checks and tries once more.

The PL runs a whole attempt by itself. At a drawn clock of it a drawn bit is turned over. What the PS then has is a fault of
the protocol, no end within twice the clocks of a clean attempt, or an answer, whose certificate Rust makes on the user's data.
Where that is not the status of the clean solve, the PS resets the PL, loads program and problem anew, and solves again. An engine
with parity reports storage and microcode that it reads; after words that the PS reads, it looks at STATUS.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np

from orbsoc import _core
from orbsoc.conic.problem import Problem
from orbsoc.conic.problem_file import encode_problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.hw.emulation import resident_program
from orbsoc.hw.schedules import Engine, pl_program
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.registers import ERROR_OF_FAULT, Control, Fault, LaunchTimeout, Parity, ProtocolError
from orbsoc.ps.registers import Register as Address
from orbsoc.ps.registers import Status as StatusWord
from orbsoc.ps.segments import Method
from orbsoc.solving.solver import solution_of

from .bits import same_solution
from .flip_flops import PLACES, Place, Register, registers_of
from .session import RtlPort, RtlSession
from .validation import Format, RtlError, built

Outcome = Literal["no effect", "other bits, right", "right after retry", "reported", "silent"]
OUTCOMES: tuple[Outcome, ...] = ("no effect", "other bits, right", "right after retry", "reported", "silent")
"""`reported`: the retry, too, ended otherwise than the clean solve, and says so; `silent`: accepted, and wrong."""
Cause = Literal["parity", "another fault", "time limit", "certificate"]
CAUSES: tuple[Cause, ...] = ("parity", "another fault", "time limit", "certificate")
"""What told the PS that a solve must be repeated."""
LIMIT = 2.0
"""Clocks that an attempt may take, over those of the clean one: the time limit of the PS."""
AGREES = 1e-6
"""Relative difference of objectives up to which an accepted answer with other bits is right."""


@dataclass(frozen=True, slots=True)
class Flip:
    """Bit `bit` of a register, turned over `clock` clocks after the attempt began."""

    number: int
    place: Place
    register: str
    bit: int
    clock: int


@dataclass(frozen=True, slots=True)
class Upset:
    """A flip and what came of it. `first`: how the solve with the flip ended: a status, or the fault that the PS saw."""

    flip: Flip
    first: str
    outcome: Outcome

    @property
    def found_by(self) -> Cause | None:
        """What refused the solve with the flip; None for an accepted one."""
        if self.outcome not in ("right after retry", "reported"):
            return None
        if self.first in (Parity.__name__, LaunchTimeout.__name__):
            return "parity" if self.first == Parity.__name__ else "time limit"
        return "certificate" if self.first in Status.__members__ else "another fault"

    def row(self) -> dict[str, str | int]:
        """As a table has it."""
        flip = self.flip
        return {
            "number": flip.number, "place": flip.place, "register": flip.register, "bit": flip.bit,
            "clock": flip.clock, "first": self.first, "outcome": self.outcome, "found_by": self.found_by or "",
        }  # fmt: skip


class _Port(RtlPort):
    """The registers of the RTL, with a bit that is turned over on the way and a limit of clocks."""

    def __init__(self, session: RtlSession, limit: int, clock: int | None, command: str) -> None:
        super().__init__(session)
        self._limit, self._clock, self._command = limit, clock, command
        self.began = self.ended = 0

    def write(self, address: int, value: int) -> None:
        super().write(address, value)
        if address == Address.CONTROL and value == Control.ATTEMPT:
            self.began = self.session.clocks()

    def tick(self) -> None:
        """To the flip, then to the interrupt. Raises LaunchTimeout at the limit."""
        if self._clock is not None:
            self.session.wait(self._clock)
            self._clock = None
            if self.session.ask(self._command) != "ok":
                raise RtlError(f"no bit to turn over: {self._command}")
            return
        up, _ = self.session.wait(self._limit)
        self.ended = self.session.clocks()
        if not up:
            raise LaunchTimeout(f"no interrupt within {self._limit} clocks")


class UpsetStudy:
    """One problem on one engine, clean and with flips."""

    def __init__(
        self,
        rtl: Path,
        problem: Problem,
        settings: Settings | None = None,
        engine: Engine | None = None,
        form: Format = "compressed",
        *,
        parity: bool = False,
    ) -> None:
        """Builds the harness, of an engine with `parity` or without, and solves once without a flip.

        Raises RtlError if the RTL does not build, or if the clean solve has other bits than Rust's.
        """
        self._problem, self._settings = problem, settings or Settings()
        self._control = resident_program()
        program = pl_program(problem, self._settings, engine, None, self._control.streams)
        self._method = Method.from_core(_core, resident=True)
        self._image = _core.program_image(program.core, form)
        self._words, self._fp = program.storage_words, program.engine.fp
        self._banks = program.engine.banks
        self._harness = built(
            rtl,
            program.engine,
            form,
            lines=len(self._image.microcode),
            resident=True,
            parity=parity,
            top="engine_upsets",
        )
        self._parity = parity
        self._limit = 1 << 30
        self._raw_clean = _core.ExactEngine(problem, self._settings, self._fp).solve(None)
        self.clean: Solution = solution_of(self._raw_clean)
        with RtlSession(self._harness) as session:
            found, port = self._solve(session)
            if not same_solution(found, self._raw_clean):
                raise RtlError("the clean solve on the RTL has not Rust's bits")
            self.clocks = port.ended - port.began
            self.registers = registers_of(session, self._harness)
        self._limit = int(LIMIT * self.clocks)

    @cached_property
    def _bits(self) -> dict[Place, list[tuple[Register, int]]]:
        """Of each place its registers, and how many bits of each the program uses: of memories the lines and rows that it has."""
        found: dict[Place, list[tuple[Register, int]]] = {place: [] for place in PLACES}
        for register in self.registers:
            elements = register.elements
            if register.place == "storage" and register.name == "words":
                elements = min(elements, -(-self._words // self._banks))
            if register.place == "microcode" and register.name == "code":
                elements = min(elements, len(self._image.microcode))
            found[register.place].append((register, elements * register.width))
        return found

    def key(self, seed: int) -> str:
        """What the flips of one study share: problem, settings, harness and seed."""
        parts = [encode_problem(self._problem), repr(self._settings), self._harness.name, seed]
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]

    def flip(self, seed: int, number: int) -> tuple[Flip, str]:
        """The flip of that number, and the session's command for it: places in turn, every bit of a place as likely."""
        rng = np.random.default_rng([seed, number])
        place = list(PLACES)[number % len(PLACES)]
        rows = self._bits[place]
        at = int(rng.integers(sum(bits for _, bits in rows)))
        for register, bits in rows:
            if at < bits:
                name = f"{register.scope.removeprefix('TOP.')}.{register.name}"
                flip = Flip(number, place, name, at, int(rng.integers(self.clocks)))
                return flip, f"flip {register.scope} {register.name} {register.in_memory(at)}"
            at -= bits
        raise AssertionError("a bit beyond the last")

    def run(self, seed: int, numbers: Sequence[int], workers: int = 1) -> Iterator[Upset]:
        """Each of these flips, in a solve of its own, in their order; `workers` simulations run side by side."""
        pool = ThreadPoolExecutor(workers)
        try:
            yield from pool.map(lambda number: self._one(*self.flip(seed, number)), numbers)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)

    def _one(self, flip: Flip, command: str) -> Upset:
        """A solve with a flip; the retry is in the same simulation, as on a chip."""
        with RtlSession(self._harness) as session:
            first, found = self._attempted(session, flip.clock, command)
            if found is not None and same_solution(found, self._raw_clean):
                return Upset(flip, first, "no effect")
            if found is not None and found.status == self._raw_clean.status:
                right = self._right(solution_of(found))
                return Upset(flip, first, "other bits, right" if right else "silent")
            _, again = self._attempted(session, None, "")
            right = again is not None and same_solution(again, self._raw_clean)
            return Upset(flip, first, "right after retry" if right else "reported")

    def _attempted(
        self, session: RtlSession, clock: int | None, command: str
    ) -> tuple[str, _core.RawSolution | None]:
        try:
            found, _ = self._solve(session, clock, command)
        except ProtocolError as error:
            return type(error).__name__, None
        return found.status, found

    def _solve(
        self, session: RtlSession, clock: int | None = None, command: str = ""
    ) -> tuple[_core.RawSolution, _Port]:
        """Reset, load and solve, with a flip or without."""
        session.reset()
        session.load(self._image, self._method, self._control)
        ps = _core.ExactEngine(self._problem, self._settings, self._fp)

        def carry(kind: Kind, buffer: str) -> None:
            if buffer not in self._image.homes:
                return
            indices, addresses = self._image.homes[buffer]
            if kind is Kind.TO_PL:
                session.set_words(addresses, ps.words(buffer, indices))
            else:
                ps.set_words(buffer, indices, session.get_words(addresses))
                self._require_no_fault(session)

        def again() -> bool:
            ps.take_over()
            return ps.begin_again()

        port = _Port(session, self._limit, clock, command)
        driver = Driver(
            self._method,
            ps,
            port,
            words=ps.buffer_words(),
            record=PsRecord(),
            carry=carry,
            program=self._control,
        )
        driver.run(restart=again)
        return ps.finish(), port

    def _require_no_fault(self, session: RtlSession) -> None:
        """Whether the words that were read had their parity."""
        if self._parity:
            fault = StatusWord.decode(session.read(Address.STATUS)).fault
            if fault is not Fault.NONE:
                raise ERROR_OF_FAULT[fault](f"the PL reports {fault.name} after words were read")

    def _right(self, found: Solution) -> bool:
        """Whether an accepted answer says what the clean one says."""
        if self.clean.status is not Status.SOLVED:
            return True  # a proof that Rust has checked on the user's data
        difference = abs(found.objective - self.clean.objective)
        return bool(difference <= AGREES * max(1.0, abs(self.clean.objective)))
