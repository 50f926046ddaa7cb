"""Engines that are wrong in one place (V5): each must be caught by schedules that the right engine runs as promised.

A mutation is a changed line in a copy of the RTL's sources. It is caught by a cycle more or less, by a word that
differs, by an assertion of the RTL's own checks, or by counter, status or interrupt saying what is not so.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from orbsoc.pl_program import Engine, scheduled
from orbsoc.precision import narrow_settings
from orbsoc.problem import Problem
from orbsoc.rtl_validation import ADDRESS_BITS, MODULES, Format, Outcome, Point, RtlError, run
from orbsoc.settings import Settings

ENGINE = Engine(fp=32, lanes=1, banks=4, address_bits=ADDRESS_BITS)
"""The smallest one: it is built anew for every mutation."""


@dataclass(frozen=True, slots=True)
class Mutation:
    """One replacement in one file of the RTL, seen with one sequencer."""

    file: str
    line: str
    becomes: str
    form: Format = "flat"

    def apply(self, rtl: Path, folder: Path) -> Path:
        """A copy of the RTL with the mutation, in `folder`.

        Raises RtlError if the line is not there exactly once.
        """
        copy = folder / "rtl"
        shutil.copytree(rtl, copy)
        path = copy / self.file
        text = path.read_text(encoding="utf-8")
        count = text.count(self.line)
        if count != 1:
            raise RtlError(f"{path.name}: {self.line!r} is there {count} times, a mutation needs it once")
        path.write_text(text.replace(self.line, self.becomes), encoding="utf-8")
        return copy


MUTATIONS = {
    "adder one cycle longer": Mutation("latency.svh", "F32_ADD_CYCLES = 6", "F32_ADD_CYCLES = 7"),
    "banks swapped at the write crossbar": Mutation(
        "engine/write_crossbar.sv", "address[u*A+:PICK] == PICK'(b)", "address[u*A+:PICK] == PICK'(b ^ 1)"
    ),
    "writes land in a second row": Mutation(
        "engine/bank.sv",
        "if (enable && write) words[write_row] <= write_word;",
        "if (enable && write) begin words[write_row] <= write_word;"
        " words[write_row ^ ROW'(1 << (ROW - 1))] <= write_word; end",
    ),
    "counter two cycles ahead": Mutation("engine/engine.sv", "cycles <= '0;", "cycles <= 32'd2;"),
    "counter stuck": Mutation("engine/engine.sv", "cycles <= cycles + 32'd1;", "cycles <= cycles;"),
    "done never in the status": Mutation("engine/registers.sv", "armed, state == DONE,", "armed, 1'b0,"),
    "interrupt never raised": Mutation(
        "engine/registers.sv", "irq = state == DONE || state == FAULT", "irq = 1'b0"
    ),
    "busy words ignored": Mutation(
        "engine/sequencer_in_order.sv", "word_busy[i] = uses[i]", "word_busy[i] = 1'b0", "in_order"
    ),
    "divider reserved a cycle short": Mutation(
        "engine/sequencer_in_order.sv", "divider_next[d*DIV+DIV-1]", "divider_next[d*DIV+DIV-2]", "in_order"
    ),
}


@dataclass(frozen=True, slots=True)
class Catch:
    """What the segments of a problem made of an engine; `mutation` none: the engine as it is."""

    mutation: str | None
    form: Format
    segments: int
    wrong_cycles: int
    """Segments whose cycles are not their schedule's."""
    wrong_words: int
    """Segments that left a word otherwise."""
    asserted: int
    """Segments in which the RTL's checks found a rule broken."""
    signalled: int
    """Segments whose status, interrupt or counter said what was not so."""

    @property
    def caught(self) -> bool:
        """By any of the four."""
        return bool(self.wrong_cycles or self.wrong_words or self.asserted or self.signalled)

    @property
    def good(self) -> bool:
        """A mutation that is caught, or the engine as it is, with nothing to catch."""
        return self.caught is (self.mutation is not None)


def catches(rtl: Path, name: str, problem: Problem) -> Iterator[Catch]:
    """Every module of a problem on the engine as it is, then on every mutated one. Raises RtlError as `run` does."""
    forms: list[Format] = sorted({mutation.form for mutation in MUTATIONS.values()})
    for form in forms:
        yield _catch(None, form, _outcomes(rtl, name, problem, form))
    for title, mutation in MUTATIONS.items():
        with tempfile.TemporaryDirectory() as scratch:
            wrong = mutation.apply(rtl, Path(scratch))
            yield _catch(title, mutation.form, _outcomes(wrong, name, problem, mutation.form))


def _outcomes(rtl: Path, name: str, problem: Problem, form: Format) -> list[Outcome]:
    program = scheduled(problem, narrow_settings(Settings(), 24), ENGINE)
    found = (run(rtl, Point(name, module, ENGINE, form), program) for module in MODULES)
    return [outcome for outcomes in found for outcome in outcomes]


def _catch(mutation: str | None, form: Format, outcomes: list[Outcome]) -> Catch:
    return Catch(
        mutation,
        form,
        segments=len(outcomes),
        wrong_cycles=sum(outcome.rtl_cycles != outcome.model_cycles for outcome in outcomes),
        wrong_words=sum(bool(outcome.different_words) for outcome in outcomes),
        asserted=sum(bool(outcome.assertions) for outcome in outcomes),
        signalled=sum(bool(outcome.signals) for outcome in outcomes),
    )
