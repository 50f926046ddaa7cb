"""Mutation tests of RTL and scheduler (V5): each is wrong in one place, and validation must notice.

A mutation of the RTL is a changed line in a copy of its sources; one of the model is a schedule for latencies or banks that
the engine does not have. Either is caught by a cycle more or less, by a word that differs, by an assertion of the RTL's own
checks, or by counter, status or interrupt saying what is not so; a mutation of the checks, by a control that breaks
every rule (rule_violations.py).
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.hw.precision import narrow_settings
from orbsoc.hw.schedules import Engine, scheduled

from .validation import (
    ADDRESS_BITS,
    MODULES,
    Format,
    Outcome,
    Point,
    Prepared,
    RtlError,
    case_of,
    compared,
    prepared,
    silent_checks,
)

ENGINE = Engine(fp=32, lanes=1, banks=4, address_bits=ADDRESS_BITS)
"""The smallest one: it is built anew for every mutation."""
FREEZING = Engine(fp=64, lanes=4, banks=16, address_bits=ADDRESS_BITS)
"""Its words are long enough for the decoder to freeze; the smallest engine's never are."""
CLUSTERED = Engine(fp=32, lanes=4, banks=8, clusters=4, address_bits=ADDRESS_BITS)
Kind = Literal["none", "RTL", "checks", "model"]
SETTINGS = narrow_settings(Settings(), 24)


@dataclass(frozen=True, slots=True)
class Mutation:
    """One replacement in one file of the RTL, seen on one engine."""

    file: str
    line: str
    becomes: str
    form: Format = "flat"
    engine: Engine = ENGINE

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
    "adder one cycle longer": Mutation("latency.svh", "F32_ADD_CYCLES = 7;", "F32_ADD_CYCLES = 8;"),
    "banks swapped at the write crossbar": Mutation(
        "engine/write_crossbar.sv", "address[u*A+:PICK] == PICK'(b)", "address[u*A+:PICK] == PICK'(b ^ 1)"
    ),
    "writes land in a second row": Mutation(
        "engine/bank.sv",
        "if (enable && write) words[INDEX'(write_row)] <= write_word;",
        "if (enable && write) begin words[INDEX'(write_row)] <= write_word;"
        " words[INDEX'(write_row ^ ROW'(1 << (ROW - 1)))] <= write_word; end",
    ),
    "counter two cycles ahead": Mutation("engine/engine.sv", ": 32'd1;", ": 32'd3;"),
    "counter stuck": Mutation("engine/engine.sv", "was_busy ? cycles + 32'd1", "was_busy ? cycles"),
    "done never in the status": Mutation("engine/registers.sv", "armed, state == DONE,", "armed, 1'b0,"),
    "interrupt never raised": Mutation(
        "engine/registers.sv", "irq = state == DONE || state == FAULT", "irq = 1'b0"
    ),
    "busy words ignored": Mutation(
        "engine/sequencer_in_order.sv", "word_busy[i] = uses[i]", "word_busy[i] = 1'b0", "in_order"
    ),
    "divider reserved a cycle short": Mutation(
        "engine/sequencer_in_order.sv", "INTERVAL+INTERVAL-1] = 1", "INTERVAL+INTERVAL-2] = 1", "in_order"
    ),
    "addresses stepped one too far": Mutation(
        "engine/compressed_payload.sv",
        "2'd1: at = at + step[(4*l+f)*A+:A];",
        "2'd1: at = at + step[(4*l+f)*A+:A] + A'(1);",
        "compressed",
    ),
    "runs of empty words one too long": Mutation(
        "engine/compressed_items.sv",
        "take ? run_4 :",
        "take ? run_4 + RUN'(1) :",
        "compressed",
    ),
    "divider counts on while the decoder freezes": Mutation(
        "fpu/fp_divsqrt.sv",
        "if (enable) begin\n        w <=",
        "begin\n        w <=",
        "compressed",
        FREEZING,
    ),
    "divider's digits taken from the next slot": Mutation(
        "fpu/fp_divsqrt.sv", "digits | ({N{collect[s]}}", "digits | ({N{collect[(s+1)%SLOTS]}}"
    ),
    "square of a root's digit three taken for two's": Mutation(
        "fpu/fp_divsqrt.sv", "low_3 <= root_2 ? 4'b1000", "low_3 <= root_2 ? 4'b0100"
    ),
    "divider's slots not taken by turns": Mutation(
        "fpu/fp_divsqrt.sv", "token[1] ? SLOTS'({load, load} >> (SLOTS - 1)) : load", "load"
    ),
    "rest of a quotient forgotten": Mutation(
        "fpu/fp_divsqrt.sv", "rest_c      <= (collect & inexact) != '0", "rest_c   <= 1'b0"
    ),
    "opening of a header believed before it is there": Mutation(
        "engine/compressed_items.sv",
        "complete = opened && (",
        "complete = (",
        "compressed",
        FREEZING,
    ),
    "places of payloads from the next header": Mutation(
        "engine/compressed_items.sv",
        "<= {used_3, divider_op_3, first_3}",
        "<= {used_3, divider_op_3, begins}",
        "compressed",
        FREEZING,
    ),
    "templates a stage early at the addresses": Mutation(
        "engine/compressed_payload.sv",
        "<= {used, used_2, used_3, used_4}",
        "<= {used, used_2, used_3, used_3}",
        "compressed",
    ),
    "one cluster's word given to all importers": Mutation(
        "engine/read_network.sv",
        "{WIDTH{remote_3[u*CLUSTERS+s]}}",
        "{WIDTH{remote_3[u*CLUSTERS]}}",
        engine=CLUSTERED,
    ),
    "imports a cycle early": Mutation(
        "engine/read_network.sv",
        "{WIDTH{remote_3[u*CLUSTERS+s]}}",
        "{WIDTH{remote_2[u*CLUSTERS+s]}}",
        engine=CLUSTERED,
    ),
    "results leave for the next cluster": Mutation(
        "engine/write_network.sv",
        "leaving_address[FROM*A+:PICK] == PICK'(s)",
        "leaving_address[FROM*A+:PICK] == PICK'(s + 1)",
        engine=CLUSTERED,
    ),
}

CHECK_MUTATIONS = {
    "checks left out": Mutation("engine/engine.sv", "CHECKS = 1", "CHECKS = 0"),
    "reads of words on their way not asserted": Mutation(
        "engine/checks.sv", "read_pending = 1'b1", "read_pending = 1'b0"
    ),
}
"""They change nothing that a right schedule shows."""


@dataclass(frozen=True, slots=True)
class Misbelief:
    """What a scheduler has wrong about the engine; all else in it is the product's."""

    misread: tuple[str, int] | None = None
    """A unit, and by how many cycles."""
    banks_by: int = 1
    """As many times the banks."""
    clusters: int | None = None
    """Another number of clusters."""
    engine: Engine = ENGINE

    def case(self, problem: Problem, point: Point) -> str:
        """A point scheduled by it, named a case for the engine as it is."""
        right = point.engine
        engine = replace(right, banks=self.banks_by * right.banks, clusters=self.clusters or right.clusters)
        case = case_of(point, scheduled(problem, SETTINGS, engine, misread=self.misread))
        for field in ("banks", "clusters"):
            case = case.replace(
                f" {field} {getattr(engine, field)} ", f" {field} {getattr(right, field)} ", 1
            )
        return case


MODEL_MUTATIONS = {
    "adder taken for one cycle longer": Misbelief(misread=("add", 1)),
    "adder taken for one cycle shorter": Misbelief(misread=("add", -1)),
    "multiplier taken for one cycle shorter": Misbelief(misread=("mul", -1)),
    "divider taken for one cycle shorter": Misbelief(misread=("div", -1)),
    "divider taken for free a cycle early": Misbelief(misread=("div_interval", -1)),
    "ports reserved as of twice the banks": Misbelief(banks_by=2),
    "network between clusters forgotten": Misbelief(clusters=1, engine=CLUSTERED),
}


@dataclass(frozen=True, slots=True)
class Catch:
    """What the segments of a problem made of an engine; `mutation` none: engine and schedules as they are."""

    mutation: str | None
    kind: Kind
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
    silent: int
    """Rules that the control broke without an assertion."""

    @property
    def caught(self) -> bool:
        """By any of the five."""
        segments = self.wrong_cycles or self.wrong_words or self.asserted or self.signalled
        return bool(segments or self.silent)

    @property
    def good(self) -> bool:
        """A mutation that is caught, or engine and schedules as they are, with nothing to catch."""
        return self.caught is (self.mutation is not None)


def catches(rtl: Path, name: str, problem: Problem) -> Iterator[Catch]:
    """Every module of a problem on the engine as it is, then on every mutated one, then scheduled by every mutated
    scheduler. Raises RtlError as `prepared` and `compared` do."""

    def cases(form: Format, wrong: Misbelief, engine: Engine = ENGINE) -> list[tuple[Point, str]]:
        points = [Point(name, module, engine, form) for module in MODULES]
        return [(point, wrong.case(problem, point)) for point in points]

    right = Misbelief()
    for form, engine in dict.fromkeys((mutation.form, mutation.engine) for mutation in MUTATIONS.values()):
        yield _catch(None, "none", rtl, cases(form, right, engine))
    kinds: list[tuple[Kind, dict[str, Mutation]]] = [("RTL", MUTATIONS), ("checks", CHECK_MUTATIONS)]
    for kind, mutations in kinds:
        for title, mutation in mutations.items():
            with tempfile.TemporaryDirectory() as scratch:
                wrong = mutation.apply(rtl, Path(scratch))
                yield _catch(title, kind, wrong, cases(mutation.form, right, mutation.engine))
    for title, misbelief in MODEL_MUTATIONS.items():
        yield _catch(title, "model", rtl, cases("flat", misbelief, misbelief.engine))


def _catch(mutation: str | None, kind: Kind, rtl: Path, cases: list[tuple[Point, str]]) -> Catch:
    ready: list[Prepared] = [prepared(rtl, point, case) for point, case in cases]
    outcomes: list[Outcome] = [outcome for one in ready for outcome in compared(one)]
    return Catch(
        mutation,
        kind,
        ready[0].point.format,
        segments=len(outcomes),
        wrong_cycles=sum(outcome.rtl_cycles != outcome.model_cycles for outcome in outcomes),
        wrong_words=sum(bool(outcome.different_words) for outcome in outcomes),
        asserted=sum(bool(outcome.assertions) for outcome in outcomes),
        signalled=sum(bool(outcome.signals) for outcome in outcomes),
        silent=len(silent_checks(rtl, ready[0])),
    )
