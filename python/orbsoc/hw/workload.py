"""What the hardware model prices: the record of a mission's plan, of one solve, or of a trace file.

A scenario is planned and a problem solved once, on the emulated PS+PL computer; every platform, partition and clock
is then priced from that record without solving again.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbsoc.files.json_fields import is_object, read_json, shown

if TYPE_CHECKING:
    from hw_model import Trace
    from orbsoc.conic.problem import Problem


class WorkloadError(ValueError):
    """A file that is neither a scenario, a problem nor a trace, or that gave nothing to price."""


@dataclass(frozen=True, slots=True, eq=False)
class Workload:
    """A recorded run. `problems` holds one problem of each pattern of the trace; none when it came from a file."""

    name: str
    origin: str
    """How it was made, for a report: "plan of rec1.toml (4 solves, 41 iterations)"."""
    trace: Trace
    problems: tuple[Problem, ...]


def load_workload(path: str | Path) -> Workload:
    """The record of SCENARIO.toml (planned now), PROBLEM.json or a failure bundle (solved now), or TRACE.json.

    Raises WorkloadError, or what reading a scenario, problem or trace raises; KeyboardInterrupt when a solve was
    interrupted, for a truncated record would be priced too low.
    """
    path = Path(path)
    return _planned(path) if path.suffix == ".toml" else _from_json(path)


def record_trace(trace: dict[str, Any], name: str, what: str, problems: tuple[Problem, ...] = ()) -> Workload:
    """A workload from a raw trace; `what` says what ran, e.g. "plan of rec1.toml"."""
    from hw_model import parse_trace

    parsed = parse_trace(trace)
    solves, iterations = len(parsed.solves), sum(solve.iterations for solve in parsed.solves)
    count = f"{solves} solve{'s' if solves != 1 else ''}, {iterations} iterations"
    return Workload(name, f"{what} ({count})", parsed, problems)


def _planned(path: Path) -> Workload:
    from orbsoc.hw.emulation import PsScheduler
    from orbsoc.missions.registry import load_scenario

    scheduler = PsScheduler()
    mission, scenario = load_scenario(path)
    plan = mission.plan(scenario, solve=scheduler)
    if plan.status.name == "INTERRUPTED":
        raise KeyboardInterrupt
    if not scheduler.trace["solves"]:
        raise WorkloadError(f"{path}: the plan ended before its first conic solve: {plan.message}")
    return record_trace(scheduler.trace, path.stem, f"plan of {path.name}", scheduler.patterns)


def _from_json(path: Path) -> Workload:
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
            return record_trace(document, path.stem, f"trace {path.name}")
        if schema == problem_file.SCHEMA:
            return solved(Problem(**problem_file.decode_problem(document)), Settings(), path)
        if schema == bundle.SCHEMA:
            found = bundle.decode_bundle(document)
            return solved(found.problem, found.settings, path)
    except (FieldError, ProblemError) as error:
        raise FileError(f"{path}: {error}") from error
    known = f"{TRACE!r}, {problem_file.SCHEMA!r} or {bundle.SCHEMA!r}"
    raise WorkloadError(
        f"{path}: `schema` is {shown(schema)}; a workload has {known}, or is a scenario (.toml)"
    )


def solved(problem: Problem, settings: Any, path: Path) -> Workload:
    """The record of one solve of `problem` on the emulated computer."""
    from orbsoc.conic.solution import Status
    from orbsoc.hw.emulation import PsScheduler

    scheduler = PsScheduler(settings)
    if scheduler(problem).status is Status.INTERRUPTED:
        raise KeyboardInterrupt
    return record_trace(scheduler.trace, path.stem, f"solve of {path.name}", scheduler.patterns)
