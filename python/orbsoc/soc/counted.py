"""What a run on the simulated computer counted, from its console (rtl/soc/program/counts.c)."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from orbsoc.flight.selftest import STATUSES

from .errors import SocError

_PLACE = re.compile(r"  place (\d); first try: (.*); second try: (.*)")


@dataclass(frozen=True, slots=True)
class StageCount:
    """A part of a solve. `where` is "core", "PL" or "link"; PL cycles are the engine's own, core cycles what the core spent or waited."""

    name: str
    where: str
    runs: int
    core_cycles: int
    instructions: int = 0
    pl_cycles: int = 0


@dataclass(frozen=True, slots=True)
class Place:
    """`where` is of PLACES; `events` name what ended the first and the second try on the PL, or "none"."""

    where: str
    events: tuple[str, str]


PLACES = ("core", "PL", "PL, second try", "core, after two tries on the PL")
"""By their numbers in the flight code."""


@dataclass(frozen=True, slots=True)
class Counted:
    """One solve. `verdicts`: the self-test's lines, which compare bits with the host's. `within`: what is a part of the launches
    on the PL as well. `places`: where each solve ran, and what ended its tries on the PL; none for the core alone."""

    core_cycles: int
    instructions: int
    stages: tuple[StageCount, ...]
    verdicts: tuple[str, ...] = field(default=())
    within: tuple[StageCount, ...] = field(default=())
    places: tuple[Place, ...] = field(default=())

    @property
    def same_bits(self) -> bool:
        """Whether status, iterations and every word of the solution are the host's."""
        return bool(self.verdicts) and all(line.endswith("the recorded bits") for line in self.verdicts)


def parsed(lines: Iterable[str], stage_names: tuple[str, ...]) -> Counted:
    """The solve's record. Raises SocError where its lines are missing."""
    stages: list[StageCount] = []
    verdicts: list[str] = []
    within: list[StageCount] = []
    places: list[Place] = []
    whole: tuple[int, int] | None = None
    for line in lines:
        kind, _, rest = line.partition(" ")
        if kind == "stage":
            number, runs, cycles, instructions = map(int, rest.split())
            stages.append(StageCount(stage_names[number], "core", runs, cycles, instructions))
        elif kind in {"put", "get", "load", "publish"}:
            stages.append(StageCount(kind, "link", *map(int, rest.split())))
        elif kind in {"launch", "interrupt"}:
            within.append(StageCount(kind, "link", *map(int, rest.split())))
        elif kind == "segment":
            number, runs, cycles, instructions, pl_cycles = map(int, rest.split())
            name = stage_names[number - 1] if number <= len(stage_names) else "attempt"
            stages.append(StageCount(name, "PL", runs, cycles, instructions, pl_cycles))
        elif kind == "solve":
            cycles, instructions = map(int, rest.split())
            whole = cycles, instructions
        elif kind in STATUSES and line.lower().endswith(" bits"):
            verdicts.append(line)
        elif found := _PLACE.fullmatch(line):
            places.append(Place(PLACES[int(found[1])], (found[2], found[3])))
    if whole is None:
        raise SocError("the program ended before its first solve did")
    return Counted(*whole, tuple(stages), tuple(verdicts), tuple(within), tuple(places))
