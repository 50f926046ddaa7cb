"""What the hardware model prices: the record of a mission's plan, of one solve, or of a trace file.

A scenario is planned and a problem solved once, on the emulated PS+PL computer; every platform, partition and clock
is then priced from that record without solving again.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from orbsoc.files.json_fields import is_object, read_json, shown

if TYPE_CHECKING:
    from hw_model import Trace
    from hw_model.timing.trace import Pattern
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.settings import Settings
    from orbsoc.conic.solution import Solution
    from orbsoc.hw.emulation import PsScheduler


class WorkloadError(ValueError):
    """A file that is neither a scenario, a problem nor a trace, or that gave nothing to price."""


@dataclass(frozen=True, slots=True, eq=False)
class Workload:
    """A recorded run. `problems` holds one problem of each pattern of the trace, `settings` what it was solved with; none
    when there is only a trace."""

    name: str
    origin: str
    """How it was made, for a report: "plan of rec1.toml (4 solves, 41 iterations)"."""
    trace: Trace
    problems: tuple[Problem, ...]
    settings: tuple[Settings, ...] = ()
    is_trace: bool = False
    """Whether it was read from a trace, which has its order of elimination."""

    @property
    def has_order(self) -> bool:
        """Whether its order of elimination was chosen where it comes from."""
        from orbsoc.conic.settings import Settings

        return self.is_trace or any(each.ordering != Settings().ordering for each in self.settings)

    def of_pattern(self, name: str) -> Workload:
        """The solves of one pattern: its number, or "most", that of most solves. Raises WorkloadError for another name."""
        counts = Counter(solve.pattern for solve in self.trace.solves)
        numbers = {str(number): number for number in sorted(counts)} | {"most": counts.most_common(1)[0][0]}
        if name not in numbers:
            raise WorkloadError(f"--pattern {name!r}: allowed are {', '.join(numbers)}")
        chosen = numbers[name]
        of_it = [solve for solve in self.trace.solves if solve.pattern == chosen]
        trace = self.trace.model_copy(
            update={
                "outer_loop": None,  # that of a whole plan
                "patterns": (self.trace.patterns[chosen],),
                "solves": tuple(solve.model_copy(update={"pattern": 0}) for solve in of_it),
            }
        )
        return replace(
            self,
            origin=f"{self.origin}, of it the {len(of_it)} of pattern {chosen}",
            trace=trace,
            problems=self.problems[chosen : chosen + 1],
            settings=self.settings[chosen : chosen + 1],
        )


def load_workload(path: str | Path, ordering: str | None = None) -> Workload:
    """The record of SCENARIO.toml (planned now), PROBLEM.json or a failure bundle (solved now), or TRACE.json with the
    problems of its patterns, where they lie beside it.

    `ordering`: the order of elimination of every solve; a trace has its own.
    Raises WorkloadError, or what reading a scenario, problem or trace raises; KeyboardInterrupt when a solve was
    interrupted, for a truncated record would be priced too low.
    """
    path = Path(path)
    return _planned(path, ordering) if path.suffix == ".toml" else _from_json(path, ordering)


class Posed(NamedTuple):
    """A problem, and what it is solved with."""

    problem: Problem
    settings: Settings


def solves_of(path: Path) -> list[Posed]:
    """Every solve of planning SCENARIO.toml, in order, or the one of PROBLEM.json, by the usual settings. Raises what reading and
    planning raise."""
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.settings import Settings
    from orbsoc.missions.registry import load_scenario

    if path.suffix == ".toml":
        return subproblems(*load_scenario(path))
    return [Posed(Problem.load(path), Settings())]


def subproblems(mission: Any, scenario: Any) -> list[Posed]:
    """Every solve of planning a scenario, in order."""
    import orbsoc
    from orbsoc.conic.settings import Settings

    found: list[Posed] = []

    def recorded(problem: Problem, settings: Settings | None = None, /) -> Solution:
        found.append(Posed(problem, settings or Settings()))
        return orbsoc.solve(problem, settings)

    mission.plan(scenario, solve=recorded)
    return found


def pattern_file(number: int) -> str:
    """Name of the file, beside a recorded trace, with a problem of its pattern."""
    return f"pattern_{number}.json"


def record_trace(
    trace: dict[str, Any],
    name: str,
    what: str,
    problems: tuple[Problem, ...] = (),
    settings: tuple[Settings, ...] = (),
) -> Workload:
    """A workload from a raw trace; `what` says what ran, e.g. "plan of rec1.toml"."""
    from hw_model import parse_trace

    parsed = parse_trace(trace)
    solves, iterations = len(parsed.solves), sum(solve.iterations for solve in parsed.solves)
    count = f"{solves} solve{'s' if solves != 1 else ''}, {iterations} iterations"
    return Workload(name, f"{what} ({count})", parsed, problems, settings)


def _planned(path: Path, ordering: str | None) -> Workload:
    from orbsoc.hw.emulation import PsScheduler
    from orbsoc.missions.registry import load_scenario

    from .outer_loop import outer_loop_of, with_outer_loop

    scheduler = PsScheduler(every_ordering=ordering)
    mission, scenario = load_scenario(path)
    plan = mission.plan(scenario, solve=scheduler)
    if plan.status.name == "INTERRUPTED":
        raise KeyboardInterrupt
    if not scheduler.trace["solves"]:
        raise WorkloadError(f"{path}: the plan ended before its first conic solve: {plan.message}")
    trace = with_outer_loop(scheduler.trace, outer_loop_of(mission, scenario, plan))
    return _record_of(scheduler, path, "plan", trace)


def _record_of(
    scheduler: PsScheduler, path: Path, what: str, trace: dict[str, Any] | None = None
) -> Workload:
    return record_trace(
        trace or scheduler.trace,
        path.stem,
        f"{what} of {path.name}",
        scheduler.patterns,
        scheduler.pattern_settings,
    )


def _from_json(path: Path, ordering: str | None) -> Workload:
    from hw_model.timing.trace import SCHEMA as TRACE
    from orbsoc.conic import problem_file
    from orbsoc.conic.errors import FileError, ProblemError
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.settings import Settings
    from orbsoc.files.json_fields import FieldError
    from orbsoc.solving import bundle

    try:
        document = read_json(path)
        schema = document.get("schema") if is_object(document) else None
        if schema == TRACE:
            if ordering is not None:
                raise WorkloadError(f"{path}: a trace has its own ordering; give a scenario or a problem")
            found = record_trace(document, path.stem, f"trace {path.name}")
            return _with_problems(replace(found, is_trace=True), path)
        if schema == problem_file.SCHEMA:
            return solved(Problem(**problem_file.decode_problem(document)), Settings(), path, ordering)
        if schema == bundle.SCHEMA:
            bundled = bundle.decode_bundle(document)
            return solved(bundled.problem, bundled.settings, path, ordering)
    except (FieldError, ProblemError) as error:
        raise FileError(f"{path}: {error}") from error
    known = f"{TRACE!r}, {problem_file.SCHEMA!r} or {bundle.SCHEMA!r}"
    raise WorkloadError(
        f"{path}: `schema` is {shown(schema)}; a workload has {known}, or is a scenario (.toml)"
    )


def _with_problems(record: Workload, path: Path) -> Workload:
    """The same with the problems that lie beside the trace, if all do. Raises WorkloadError for one that is another's."""
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.problem_file import decode_problem

    places = [path.with_name(pattern_file(k)) for k in range(len(record.trace.patterns))]
    if not all(place.is_file() for place in places):
        return record
    problems = tuple(Problem(**decode_problem(read_json(place))) for place in places)
    settings: list[Settings] = []
    for place, problem, pattern in zip(places, problems, record.trace.patterns, strict=True):
        found = _settings_of(problem, pattern)
        if found is None:
            raise WorkloadError(
                f"{place}: is no problem of that pattern of {path.name}: the operations of its stages differ;"
                " take the file away, or the one that was written with the trace"
            )
        settings.append(found)
    return replace(record, problems=problems, settings=tuple(settings))


def _settings_of(problem: Problem, pattern: Pattern) -> Settings | None:
    """Settings under which the stages of a problem have the pattern's operations; None where there are none."""
    from orbsoc import _core
    from orbsoc.conic.settings import ORDERINGS, Settings

    for ordering in ORDERINGS:
        settings = Settings(ordering=ordering)
        counted = _core.operation_counts(problem, settings, {})
        if all(counted[name]["operations"] == stage.operations for name, stage in pattern.stages.items()):
            return settings
    return None


def solved(problem: Problem, settings: Settings, path: Path, ordering: str | None = None) -> Workload:
    """The record of one solve of `problem` on the emulated computer."""
    from orbsoc.conic.solution import Status
    from orbsoc.hw.emulation import PsScheduler

    scheduler = PsScheduler(settings, every_ordering=ordering)
    if scheduler(problem).status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return _record_of(scheduler, path, "solve")
