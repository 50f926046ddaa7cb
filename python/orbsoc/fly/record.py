"""A flight as data: its document, a table of its re-plans, and its trajectory."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from typing import Any

from orbsoc.files.versions import versions
from orbsoc.guidance.closed_loop import ClosedLoop
from orbsoc.guidance.scenario_file import BaseScenario
from orbsoc.guidance.verdict import Verdict

from .computer import Computer
from .loop import CycleRecord, Flight, Timing
from .slower import Enough
from .verdict import verdict_of

SCHEMA = "orbsoc.flight/1"
SCOPE = (
    "each conic solve with what guidance does around it where that was counted, else with the generation of its problem, as assumed;"
    " navigation is not in it"
)


@dataclass(frozen=True, slots=True, eq=False)
class FlightRun:
    """A flight beside the same one without re-planning, the computer that it had, and the slowest that would do."""

    scenario: BaseScenario
    loop: ClosedLoop
    flight: Flight
    open_loop: Flight
    computer: Computer
    timing: Timing
    enough: Enough

    @property
    def verdict(self) -> Verdict:
        """All lines."""
        return verdict_of(self.loop, self.flight, self.computer, self.timing, self.enough)

    def to_dict(self) -> dict[str, Any]:
        """The content of `flight.json`."""
        window_s = self.timing.window_s
        return {
            "mission": self.scenario.mission,
            "name": self.scenario.name,
            "seed": self.flight.seed,
            "number": self.flight.number,
            "verdict": self.verdict.to_list(),
            "outcome": dict(self.flight.outcome),
            "outcome_without_replanning": dict(self.open_loop.outcome),
            "units": dict(self.loop.columns),
            "computer": {
                "provenance": "modelled",
                "scope": SCOPE,
                "device": self.computer.device,
                "partition": self.computer.partition,
                "times_as_slow": self.computer.slower,
                "slowest_that_would_do": number_or_none(self.enough.factor),
                "slowest_that_would_do_words": self.enough.words,
            },
            "allowance_ms": 1e3 * self.timing.allowance_s,
            "window_ms": None if window_s is None else 1e3 * window_s,
            "cycles": [cycle_row(each) for each in self.flight.cycles],
            "decisions": decisions_of(self.flight.cycles),
            "scenario": self.scenario.model_dump(mode="json"),
            "versions": versions(),
        }


def cycle_row(cycle: CycleRecord) -> dict[str, Any]:
    """A row of cycles.csv."""
    answer = cycle.answer
    figures = {} if answer is None else {k: number_or_none(v) for k, v in answer.figures.items()}
    return {
        "number": cycle.trigger.number,
        "at_s": cycle.trigger.at_s,
        "cause": cycle.trigger.cause,
        "fate": cycle.fate.value,
        "computed_ms": cycle.price.time_ms,
        "pl_cycles": cycle.price.pl_cycles,
        "solves": cycle.solves,
        "iterations": cycle.iterations,
        "outer_loop_counted": cycle.counted,
        "ready_s": cycle.ready_s if cycle.solves else None,
        "flown_s": number_or_none(cycle.flown_s),
        "answer": "" if answer is None else answer.words,
        **figures,
    }


def decisions_of(cycles: Iterable[CycleRecord]) -> list[dict[str, Any]]:
    """Every branch that was tried, with the trigger that it belongs to."""
    return [
        {"number": cycle.trigger.number, "sought": each.sought, "word": each.word, "found": each.found, "solves": each.solves}
        for cycle in cycles
        if cycle.answer is not None
        for each in cycle.answer.decisions
    ]  # fmt: skip


def number_or_none(value: float) -> float | None:
    """JSON has no infinity."""
    return value if isfinite(value) else None
