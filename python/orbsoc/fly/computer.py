"""The computer on board: how long the conic solves of an answer take on a device under a partition.

The PL's cycles are those of schedules, equal to the RTL, as in `orbsoc plan`; every time is modelled at nominal parameters. What is
timed is each solve and what guidance does around it, where that was counted; else the problem's generation, as assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from hw_model import Partition, Platform, Trace, load_partition, load_platform, parse_trace
from hw_model.timing import ps
from hw_model.timing.durations import Durations
from hw_model.timing.solve_cost import Cost, SolveCosts
from hw_model.timing.trace import Work as CountedWork
from hw_model.vocabulary import picoseconds_of_cycles
from orbsoc import _core
from orbsoc.guidance.outer_loop import OuterLoop, Work
from orbsoc.hw.emulation import operation_latencies
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.ps.trace import SCHEMA, method_of, pattern_of

from .solver import OnboardSolver, Pattern, PatternKey, Ran

PICOSECONDS_PER_S = 1e12


@dataclass(frozen=True, slots=True)
class Price:
    """Of a list of solves: modelled time, and the cycles that the PL computes in it."""

    time_s: float
    pl_cycles: int

    @property
    def time_ms(self) -> float:
        return 1e3 * self.time_s


def scope(counted: int, replans: int) -> str:
    """What the times of re-plans are of, of which `counted` have their outer loop in them."""
    if not counted:
        return "conic solves alone"
    if counted == replans:
        return "the outer loop counted"
    return f"the outer loop counted in {counted} of {replans}, else conic solves alone"


NOTHING = Price(0.0, 0)
_NO_WORK = {"instructions": 0, "divisions": 0, "roots": 0}


@dataclass(slots=True, eq=False)
class Computer:
    """A device under a partition, `slower` times as slow as it is modelled. Prices are kept: solves that ran alike cost alike.

    Raises `hw_model.HwModelError` for unknown names, and where it prices what its PL has no schedules for.
    """

    device: str
    partition: str
    slower: float = 1.0
    _costs: dict[tuple[PatternKey, bool], _Costs] = field(default_factory=dict)
    _known: dict[tuple[Ran, bool], Cost] = field(default_factory=dict)
    _platform: Platform = field(init=False)
    _split: Partition = field(init=False)

    def __post_init__(self) -> None:
        self._platform, self._split = load_platform(self.device), load_partition(self.partition)

    @property
    def name(self) -> str:
        """In words."""
        slow = f", {self.slower:g} times as slow" if self.slower != 1.0 else ""
        return f"{self.device}, partition {self.partition}{slow}"

    def at(self, slower: float) -> Computer:
        """The same with another speed; what was priced is shared."""
        other = Computer(self.device, self.partition, slower)
        other._costs, other._known = self._costs, self._known
        return other

    def price(self, ran: Sequence[Ran], solver: OnboardSolver, around: OuterLoop | None = None) -> Price:
        """Of solves, one after the other, and what was counted around the first of them."""
        counted = 0 if around is None else around.solves
        keys = [(each, k < counted) for k, each in enumerate(ran)]
        found = [self._known.get(key) or self._price(*key, solver) for key in keys]
        picoseconds, cycles = (sum(each[k] for each in found) for k in (0, 1))
        picoseconds += sum(map(self._outer, around.works if around is not None else ()))
        return Price(self.slower * picoseconds / PICOSECONDS_PER_S, cycles)

    def _price(self, ran: Ran, alone: bool, solver: OnboardSolver) -> Cost:
        """`alone`: without the generation of its problem."""
        costs = self._costs.get((ran.pattern, alone))
        if costs is None:
            costs = _Costs(solver.patterns[ran.pattern], ran, alone, self._platform, self._split)
            self._costs[ran.pattern, alone] = costs
        self._known[ran, alone] = found = costs.costs.of(ran.events)
        return found

    def _outer(self, work: Work) -> int:
        """Picoseconds of a core."""
        cycles = ps.outer_cycles(CountedWork(**work._asdict()), self._platform.ps)
        [found] = picoseconds_of_cycles([cycles], self._platform.ps.clock_mhz.value)
        return found


@dataclass(eq=False)
class _Costs:
    """Durations of the stages of one pattern, from its first solve on."""

    pattern: Pattern
    first: Ran
    alone: bool
    platform: Platform
    split: Partition

    @cached_property
    def trace(self) -> Trace:
        """Of the first solve."""
        solve = {"pattern": 0, **self.first._asdict(), "events": [list(each) for each in self.first.events]}
        outer = (
            {"outer_loop": {"works": [_NO_WORK, _NO_WORK], "source": "priced beside it"}}
            if self.alone
            else {}
        )
        return parse_trace(outer | {
            "schema": SCHEMA,
            "datapath": "f64",
            "method": method_of(_core),
            "patterns": [pattern_entry(self.pattern)],
            "solves": [solve | {"pattern": 0}],
        })  # fmt: skip

    @cached_property
    def costs(self) -> SolveCosts:
        """By exact schedules of the pattern's segments."""
        cycles = exact_cycles([self.pattern.problem], settings=[self.pattern.settings])
        return SolveCosts(Durations(self.trace, self.platform, self.split, cycles))


def pattern_entry(pattern: Pattern) -> dict[str, Any]:
    """A pattern as a trace has it."""
    problem, settings = pattern.problem, pattern.settings
    sizes = (pattern.nnz_kkt, pattern.nnz_l)
    return pattern_of(_core, operation_latencies(), problem, settings, pattern.words, sizes)
