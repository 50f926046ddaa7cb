"""Path: what the hardware model charges for is what the emulated PS did, with all six modules on the PL."""

from __future__ import annotations

from collections import Counter

import pytest

import hw_model
from orbsoc import _core
from orbsoc.ps import PsScheduler
from orbsoc.ps.events import Kind, PsRecord
from orbsoc.ps.segments import Method
from tests.zoo import ZooCase, cases

WORD_BYTES = 8


def solved(case: ZooCase) -> tuple[PsRecord, hw_model.Report]:
    ps = PsScheduler()
    ps(case.problem)
    return ps.record, hw_model.speedup(ps.trace, "zu9eg", "paper")


@pytest.mark.parametrize("case", cases()[::10], ids=lambda case: case.name)
def test_launches_interrupts_and_moves_are_those_of_the_model(case: ZooCase) -> None:
    record, modelled = solved(case)
    report = modelled.to_dict()
    counts = record.counts()
    assert (report["launches"], report["interrupts"]) == (counts[Kind.LAUNCH], counts[Kind.INTERRUPT])
    moves = [*record.of(Kind.TO_PL), *record.of(Kind.TO_PS)]
    side = {Kind.TO_PL: "pl", Kind.TO_PS: "ps"}
    moved = Counter((m.name, side[m.kind], WORD_BYTES * m.value) for m in moves if m.value)
    priced = {(copy["buffer"], copy["to"], copy["size_bytes"]): copy["count"] for copy in report["copies"]}
    assert priced == dict(moved)


def test_register_accesses_of_a_stage_are_those_of_the_model() -> None:
    record, _ = solved(cases()[0])
    link = hw_model.load_platform("zu9eg").link
    counts = record.counts()
    stages = counts[Kind.LAUNCH] + counts[Kind.RUN] + 1  # the problem data are published too
    frame, acknowledge = link.frame_register_writes.value, link.acknowledge_register_writes.value
    assert counts[Kind.WRITE] == frame * stages + acknowledge * counts[Kind.LAUNCH]
    flags = [event for event in record.of(Kind.READ) if event.name == "DATA_VALID"]
    statuses = [event for event in record.of(Kind.READ) if event.name == "STATUS"]
    assert len(statuses) == link.status_register_reads.value * stages + 1  # at rest at the end
    buffers = len(Method.from_core(_core).buffers)
    assert len(flags) == stages * -(-buffers // link.flags_per_register.value)
