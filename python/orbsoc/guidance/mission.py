"""What a mission is to everything outside its folder: the protocols `Mission`, `Plan`, `Dispersible`, `Auditable`,
`Sampled`, `OnBoard` and `Flyable`, and their data.

A module satisfies `Mission`, so that `orbsoc.missions.reachable_insertion.plan(scenario)` is a function call. A mission
builds conic problems and hands them to the `solve` that it is given; it knows no registers, cycles or partitions.

A new mission is one folder in `missions/`, one line in `missions/registry.py`, scenarios, a page in the docs and tests.
A file `report.html.j2` in its folder extends the report page of every plan, `report/templates/plan.html.j2`.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, runtime_checkable

from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution

from .closed_loop import ClosedLoop
from .monte_carlo import Dispersion
from .scenario_file import BaseScenario
from .scp import Iteration, Solve
from .verdict import Question, Verdict, VerdictLine, Word

if TYPE_CHECKING:
    from .impulses import ImpulseProgramme
    from .outer_loop import OuterLoop


class PlanStatus(enum.Enum):
    """What a plan is worth."""

    VERIFIED = "verified"
    NOT_VERIFIED = "not_verified"
    INFEASIBLE = "infeasible"
    """Proved: no plan exists."""
    NOT_FOUND = "not_found"
    """Every start was tried; a plan may exist."""
    FAILED = "failed"
    INTERRUPTED = "interrupted"


BROKEN = "failed"
"""Verdict of a row that is stated and does not hold: `orbsoc reproduce` then exits with 1."""


@dataclass(frozen=True, slots=True)
class PaperRow:
    """One printed result of a paper: where it stands, its value, the one computed here, the verdict, and why.

    Verdicts: reproduced, misprint, not reproduced, inferred, met by construction, other data; and `BROKEN` where one of
    them is what is known of the shipped data and is not found.
    """

    quantity: str
    source: str
    paper: str
    ours: str
    verdict: str
    reason: str
    tolerance: str = ""
    """Within which the verdict takes two numbers for the same."""

    def to_dict(self) -> dict[str, str]:
        """A row of `paper` in plan.json."""
        found = asdict(self)
        del found["tolerance"]
        return found


@dataclass(frozen=True, slots=True)
class Check:
    """A row of `constraints` in plan.json: by how much a condition is kept (negative: broken), in its unit, and when."""

    name: str
    margin: float
    unit: str
    at_s: float


@dataclass(frozen=True, slots=True)
class FigureFile:
    """A figure that was written: its file name, and a caption that says what it shows."""

    name: str
    caption: str
    appendix: bool = False
    """Whether it shows how well the plan was computed, and not the plan: it then stands in a fold at the report's end."""


@dataclass(frozen=True, slots=True)
class Difference:
    """How far two plans of one scenario are apart in one quantity, and the limit up to which they agree."""

    name: str
    """Key in `plan.json`."""
    quantity: str
    value: float
    limit: float
    unit: str = ""

    @property
    def of_limit(self) -> float:
        """The value in limits. A count has none to spend: 0 where it is met, else infinity."""
        if self.limit > 0.0:
            return self.value / self.limit
        return inf if self.value > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class Agreement:
    """Two plans of one scenario, made by two solvers: their statuses, and how far they are apart."""

    ours: str
    theirs: str
    differences: tuple[Difference, ...]

    @classmethod
    def of(cls, ours: Plan, theirs: Plan) -> Agreement:
        return cls(ours.status.value, theirs.status.value, tuple(ours.differences(theirs)))

    @property
    def agrees(self) -> bool:
        """The same status, and every difference within its limit."""
        return self.ours == self.theirs and all(each.value <= each.limit for each in self.differences)

    @property
    def message(self) -> str:
        """One sentence with every difference beside its limit."""
        if self.ours != self.theirs:
            return f"the plan is {self.ours}, but the other solver's is {self.theirs}"
        if not self.differences:
            return f"both plans are {self.ours}"
        return ", ".join(
            f"{each.quantity} {'' if k else 'differs '}by {each.value:.1e}{each.unit and f' {each.unit}'}"
            f" (limit {each.limit:.0e})"
            for k, each in enumerate(self.differences)
        )

    def line(self, solver: str) -> VerdictLine:
        """The line *Check* of the verdict."""
        word = Word.AGREES if self.agrees else Word.DISAGREES
        if self.ours != self.theirs or not self.differences:
            return VerdictLine(Question.CHECK, word, f"{solver}: {self.theirs}")
        worst = max(self.differences, key=lambda each: each.of_limit)
        figure = f"{solver}: {worst.quantity} differs by {worst.value:.1e} {worst.unit}".rstrip()
        return VerdictLine(Question.CHECK, word, figure, f"{worst.limit:.0e}")

    def to_dict(self) -> dict[str, Any]:
        """The `check` entry of `plan.json`, without the solver's name."""
        values = {each.name: each.value if isfinite(each.value) else None for each in self.differences}
        return {
            "ours": self.ours,
            "theirs": self.theirs,
            **values,
            "agrees": self.agrees,
            "words": self.message,
        }


class Column(NamedTuple):
    """A column of the iteration table: its title, the format of its numbers, and their unit."""

    title: str
    form: str
    unit: str = ""


class SolvedProblem(Protocol):
    """A conic problem as it was solved; an `Iteration` of a sequence is one."""

    @property
    def problem(self) -> Problem: ...
    @property
    def solution(self) -> Solution: ...
    @property
    def settings(self) -> Settings: ...
    def to_dict(self) -> dict[str, Any]: ...


class Plan(Protocol):
    """What commands and reports may ask of a plan."""

    @property
    def status(self) -> PlanStatus: ...
    @property
    def message(self) -> str:
        """How the sequence or the solve ended, in a sentence."""
        ...

    @property
    def verification(self) -> Any:
        """What a check that is independent of the solver found; None where there was nothing to check."""
        ...

    @property
    def subproblems(self) -> Sequence[SolvedProblem]:
        """Every conic problem that was solved, in order; each is priced."""
        ...

    @property
    def verdict(self) -> Verdict:
        """The answer as lines, *Answer* first; the run of the plan adds the computer's."""
        ...

    def to_dict(self) -> dict[str, Any]:
        """The content of `plan.json` that is the mission's; at least `DOCUMENT_KEYS`."""
        ...

    def tables(self) -> Mapping[str, str]:
        """Text of the tables for other programs, by file name: attitude.csv, impulses.csv."""
        ...

    def figures(self, folder: Path) -> tuple[FigureFile, ...]:
        """Write the figures into `folder`; empty where there is nothing to show."""
        ...

    def differences(self, other: Any, /) -> Sequence[Difference]:
        """How far another plan of the same scenario is from this one; empty where nothing can be compared."""
        ...


DOCUMENT_KEYS = ("mission", "name", "status", "message", "details", "subproblems", "scenario")
"""Keys of every plan's document. `details` tells in sentences, without a last full stop, what the lines of the verdict have
no room for."""


@runtime_checkable
class Mission(Protocol):
    """What `missions.MISSIONS` holds."""

    @property
    def __file__(self) -> str | None:
        """Of the module; its report template may stand beside it."""
        ...

    @property
    def Scenario(self) -> type[BaseScenario]:
        """The scenario file; `orbsoc schema NAME` prints its JSON Schema."""
        ...

    @property
    def PAPER(self) -> str:
        """Number of the paper that it is after, "004", for `orbsoc reproduce 004`; empty for none."""
        ...

    @property
    def COLUMNS(self) -> Mapping[str, Column]:
        """Columns of the iteration table that are the mission's own, by the name of the figure."""
        ...

    def plan(
        self,
        scenario: Any,
        /,
        *,
        solve: Solve | None = None,
        callback: Callable[[Iteration], None] | None = None,
    ) -> Plan:
        """Plan the scenario with `solve`, `orbsoc.solve` by default; `callback` sees every solved subproblem.

        What cannot be reached or does not converge is a status with its reason, Ctrl-C is INTERRUPTED.
        """
        ...

    def reproduce(self, scenarios: Path, /) -> Sequence[PaperRow]:
        """What the mission's paper prints, beside what the scenarios of that folder give."""
        ...


@runtime_checkable
class Dispersible(Mission, Protocol):
    """A mission with dispersed cases, for `orbsoc plan … --cases`."""

    @property
    def DISPERSION(self) -> Dispersion: ...

    def disperse(self, scenario: Any, number: int, seed: int = 0, /) -> Any:
        """Case `number` of the scenario, itself a scenario; case 0 is not dispersed. The draws depend on (seed, number)
        alone. Raises ScenarioError for a negative number or seed, and where a draw contradicts physics."""
        ...


@runtime_checkable
class Auditable(Mission, Protocol):
    """A mission that judges a programme of impulses made elsewhere, for `orbsoc plan … --impulses`."""

    def audit(self, scenario: Any, programme: ImpulseProgramme, /) -> Plan:
        """The programme, judged and flown as the scenario's own plan would be; nothing is solved. Raises ScenarioError
        where it has impulses outside the scenario's time."""
        ...


@runtime_checkable
class Sampled(Mission, Protocol):
    """A mission that flies its paper's data with errors, many times, for `orbsoc reproduce --full`."""

    def samples(self, scenarios: Path, /) -> Mapping[str, Callable[[], Sequence[PaperRow]]]:
        """What is drawn, by name; its rows are computed when it is called, and depend on its seed alone."""
        ...


class NotOnBoard(ValueError):
    """Why a scenario has no program in C that plans it: the key with its value, and what the program does."""


@runtime_checkable
class OnBoard(Mission, Protocol):
    """A mission whose outer loop has a program in C, for `orbsoc export c`."""

    def on_board(self, scenario: Any, solve: Solve, /) -> Any:
        """What `orbsoc.flight.export_c` takes as `mission`, with plans that `solve` makes of it. Raises NotOnBoard where the
        scenario asks for what the program has not."""
        ...

    def outer_loop(self, scenario: Any, plan: Any, /) -> OuterLoop | None:
        """What the program does around the solves of a plan of that scenario; None where it does not make that very plan."""
        ...


@runtime_checkable
class Flyable(Mission, Protocol):
    """A mission that is flown in a closed loop, for `orbsoc fly`."""

    def closed_loop(self, scenario: Any, solve: Solve, /) -> ClosedLoop:
        """The scenario planned on the ground by `solve`, ready to be flown any number of times. Raises ScenarioError where the
        scenario has no loop, or no plan to set out with."""
        ...
