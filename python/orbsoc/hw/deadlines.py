"""Does the computer make the deadline in every dispersed case? Cases are planned once, and priced as often as asked.

A case is recorded in a file of its own (`cases/case-0007.json.gz`: status, iterations, trace) as soon as it is
planned, so that an interrupted study goes on where it stopped, and another device needs no planning at all. One problem
of each sparsity pattern is kept beside them (`cases/pattern-….json`), from which the PL's segments are scheduled: once
for all cases, which share their patterns.
"""

from __future__ import annotations

import gzip
import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from orbsoc.files.atomic_write import write_atomically

if TYPE_CHECKING:
    from hw_model import Partition, Platform
    from hw_model.platform.parameter import End
    from hw_model.timing.stage_cycles import StageCycles
    from hw_model.vocabulary import Cause
    from orbsoc.conic.problem import Problem

RECORD = "orbsoc.case/3"
SCHEMA = "orbsoc.deadline/1"
Verdict = Literal["PASS", "FAIL", "MARGINAL"]


class CaseError(ValueError):
    """A recorded case that is damaged or belongs to another study."""


@dataclass(frozen=True, slots=True)
class Case:
    """One planned case and the trace of its solves."""

    number: int
    status: str
    scp_iterations: int
    ipm_iterations: tuple[int, ...]
    """Of each subproblem."""
    trace: dict[str, Any]
    patterns: tuple[str, ...]
    """Digests of the trace's patterns, in its order: the names of their problems' files."""

    @property
    def verified(self) -> bool:
        """Whether there is a plan to fly."""
        return self.status == "verified"


@dataclass(frozen=True, slots=True)
class PricedCase:
    """A case on a computer: modelled times of all its conic solves, in ms."""

    case: int
    status: str
    scp_iterations: int
    ipm_iterations: int
    time_ms: float
    fast_ms: float
    """Fast end of every band, at the cheapest price of the PS's work."""
    worst_ms: float
    """Slow end of every band, every jitter at its bound, at the dearest price."""


@dataclass(frozen=True, slots=True)
class DeadlineReport:
    """The verdict over all cases. PASS: every one is met in its worst case; FAIL: one is missed at its fastest or has no
    plan, or the device does not hold the engine; MARGINAL: in between."""

    device: str
    partition: str
    cycles: Literal["exact", "estimated"]
    """Where the PL's cycles come from: schedules, equal to the RTL, or the L1 estimate."""
    deadline_ms: float
    verdict: Verdict
    margin_ms: float | None
    """Deadline minus the longest worst case of a verified plan; None where there is none."""
    nominal_margin_ms: float | None
    binding_cause: str | None
    """What most of the longest verified plan's time is spent on, its critical path being what counts."""
    binding_share: float | None
    binding_words: str | None
    fits: bool
    """Whether the engine fits into the device; its largest case's, which most often is every case's."""
    area_words: str
    scope: str
    """What the times are of: in how many cases the outer loop is counted."""
    cases: tuple[PricedCase, ...]

    @property
    def headline(self) -> str:
        """One sentence: verdict, margin, binding resource."""
        planned = [case for case in self.cases if case.status == "verified"]
        lost = len(self.cases) - len(planned)
        return (
            f"modelled deadline verdict over {len(self.cases)} dispersed cases, {self.partition} on {self.device},"
            f" {self.cycles} PL cycles, {self.scope}: {self.verdict}:"
            f" {self._times(planned)}; {lost} without a verified plan; {self.area_words}"
        )

    def _times(self, planned: Sequence[PricedCase]) -> str:
        if self.margin_ms is None or self.binding_share is None:
            return f"no verified plan to hold against {self.deadline_ms:g} ms, no margin"
        times = sorted(case.time_ms for case in planned)
        return (
            f"{times[0]:.3f}–{times[-1]:.3f} ms nominally, worst case {max(case.worst_ms for case in planned):.3f} ms"
            f" against {self.deadline_ms:g} ms, margin {self.margin_ms:+.3f} ms; binding is {self.binding_words}"
            f" ({100 * self.binding_share:.0f} % of the longest plan's time)"
        )

    def to_dict(self) -> dict[str, Any]:
        """JSON-able data with the distributions."""
        planned = [case for case in self.cases if case.status == "verified"]
        return {
            "schema": SCHEMA,
            "provenance": "modelled",
            "headline": self.headline,
            "time_ms": _quantiles([case.time_ms for case in planned]),
            "worst_ms": _quantiles([case.worst_ms for case in planned]),
            "scp_iterations": _counted(case.scp_iterations for case in self.cases),
            "ipm_iterations": _counted(case.ipm_iterations for case in self.cases),
            **asdict(self),
        }


def study_key(scenario: Any, seed: int) -> str:
    """What the records of one study share: scenario, dispersion, seed and versions."""
    from orbsoc.missions.registry import dispersible
    from orbsoc.solving.bundle import versions

    dispersion = dispersible(scenario).DISPERSION.to_dict()
    parts = [scenario.model_dump(mode="json"), dispersion, seed, versions()]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def record_cases(
    scenario: Any,
    count: int,
    seed: int,
    folder: Path,
    *,
    resume: bool,
    progress: Callable[[Case], None] | None = None,
) -> list[Case]:
    """Plan cases 0 to `count` − 1 on the emulated computer, each recorded in `folder` when it is done.

    With `resume`, what is recorded there is not planned again; `progress` sees every case. Raises CaseError for
    records of another study, KeyboardInterrupt when a solve was interrupted: what was recorded stays.
    """
    key = study_key(scenario, seed)
    folder.mkdir(parents=True, exist_ok=True)
    cases: list[Case] = []
    for number in range(count):
        place = folder / f"case-{number:04d}.json.gz"
        case = _read(place, key) if resume and place.exists() else None
        if case is None:
            case, problems = _plan(scenario, number, seed)
            _keep(problems, folder)
            _write(case, key, place)
        cases.append(case)
        if progress is not None:
            progress(case)
    return cases


def check_deadline(deadline_ms: float | None) -> None:
    """Raise hw_model.HwModelError unless it is absent or a positive number."""
    from hw_model import HwModelError

    if deadline_ms is not None and not 0.0 < deadline_ms < float("inf"):
        raise HwModelError(f"--deadline-ms = {deadline_ms}: must be a positive number of milliseconds")


def estimated_cycles(_: Case) -> StageCycles:
    """The L1 estimate, for every case."""
    from hw_model.timing.stage_cycles import estimated

    return estimated


def exact_cycles_of(cases: Sequence[Case], folder: Path) -> Callable[[Case], StageCycles]:
    """The schedules of each case's patterns, whose problems lie in `folder`. Raises CaseError when one is missing."""
    from orbsoc.conic.errors import FileError
    from orbsoc.conic.problem import Problem

    from .exact_cycles import exact_cycles

    problems: dict[str, Problem] = {}
    for digest in dict.fromkeys(digest for case in cases for digest in case.patterns):
        try:
            problems[digest] = Problem.load(_pattern_file(folder, digest))
        except (FileError, OSError) as error:
            raise CaseError(f"{error}; start again without --resume, or ask for --estimate") from error
    return lambda case: exact_cycles([problems[digest] for digest in case.patterns])


def judge(
    cases: Sequence[Case],
    platform: Platform,
    partition: Partition,
    deadline_ms: float,
    cycles_of: Callable[[Case], StageCycles] = estimated_cycles,
) -> DeadlineReport:
    """Price every case and judge them together. Raises hw_model.HwModelError for an impossible deadline."""
    from hw_model.report.bottleneck import bottleneck_of
    from hw_model.report.run import simulate

    check_deadline(deadline_ms)
    priced = tuple(_price(case, platform, partition, cycles_of(case)) for case in cases)
    planned = [case for case in priced if case.status == "verified"]
    fits, area_words = _area(cases, platform, partition, cycles_of)
    late = any(case.fast_ms > deadline_ms for case in planned)
    verdict: Verdict = "FAIL" if late or len(planned) < len(priced) or not fits else "PASS"
    margin = nominal = None
    cause: Cause | None = None
    share: float | None = None
    words: str | None = None
    if planned:
        longest = max(planned, key=lambda case: case.worst_ms)
        margin = deadline_ms - longest.worst_ms
        nominal = deadline_ms - max(case.time_ms for case in planned)
        if verdict == "PASS" and margin < 0.0:
            verdict = "MARGINAL"
        [decides] = (case for case in cases if case.number == longest.case)
        timeline = simulate(decides.trace, platform, partition, cycles_of(decides))
        causes = {found: picoseconds for (found,), picoseconds in timeline.totals("cause").items()}
        cause, share, words = bottleneck_of(causes)
    return DeadlineReport(
        platform.name, partition.name, "estimated" if cycles_of is estimated_cycles else "exact", deadline_ms,
        verdict, margin, nominal, cause, share, words, fits, area_words, _scope(cases), priced,
    )  # fmt: skip


def _scope(cases: Sequence[Case]) -> str:
    """What the cases' times are of."""
    whole = sum("outer_loop" in case.trace for case in cases)
    if whole == len(cases):
        return "whole plans, the outer loop counted"
    some = f"; in {whole} the outer loop is counted" if whole else ""
    return f"conic solves and problem generation without the outer loop{some}"


def _plan(scenario: Any, number: int, seed: int) -> tuple[Case, tuple[Problem, ...]]:
    """One case, and a problem of each of its patterns."""
    from orbsoc.conic.pattern import pattern_digest
    from orbsoc.missions.registry import dispersible

    from .emulation import PsScheduler
    from .outer_loop import outer_loop_of, with_outer_loop

    scheduler, mission = PsScheduler(), dispersible(scenario)
    dispersed = mission.disperse(scenario, number, seed)
    found = mission.plan(dispersed, solve=scheduler)
    if found.status.name == "INTERRUPTED":
        raise KeyboardInterrupt
    iterations = tuple(row.solution.iterations for row in found.subproblems)
    digests = tuple(pattern_digest(problem).hex()[:16] for problem in scheduler.patterns)
    trace = with_outer_loop(scheduler.trace, outer_loop_of(mission, dispersed, found))
    case = Case(number, found.status.value, len(iterations), iterations, trace, digests)
    return case, scheduler.patterns


def _keep(problems: Sequence[Problem], folder: Path) -> None:
    """Write one problem of each pattern that the folder lacks."""
    from orbsoc.conic.pattern import pattern_digest

    for problem in problems:
        place = _pattern_file(folder, pattern_digest(problem).hex()[:16])
        if not place.exists():
            problem.save(place)


def _pattern_file(folder: Path, digest: str) -> Path:
    return folder / f"pattern-{digest}.json"


def _price(case: Case, platform: Platform, partition: Partition, cycles: StageCycles) -> PricedCase:
    """Times of one case."""
    from hw_model import parse_trace
    from hw_model.report.prices import at_each_price
    from hw_model.report.run import durations_of
    from hw_model.timing.actions import actions_of
    from hw_model.timing.timeline import makespan_picoseconds, tally_of

    time_ms = fast_ms = worst_ms = 0.0
    if case.trace["solves"]:
        trace = parse_trace(case.trace)
        actions = actions_of(trace, partition)
        tally = tally_of(actions)
        nominal = durations_of(trace, platform, partition, cycles)
        time_ms = makespan_picoseconds(actions, nominal, tally=tally) / 1e9

        def at(end: End) -> list[float]:
            ends = (nominal.on(price.corner(end, end, end)) for price in at_each_price(platform, trace))
            return [
                makespan_picoseconds(actions, each, worst=end == "slow", tally=tally) / 1e9 for each in ends
            ]

        fast_ms, worst_ms = min(at("fast")), max(at("slow"))
    return PricedCase(
        case.number, case.status, case.scp_iterations, sum(case.ipm_iterations), time_ms, fast_ms, worst_ms
    )


def _area(
    cases: Sequence[Case], platform: Platform, partition: Partition, cycles_of: Callable[[Case], StageCycles]
) -> tuple[bool, str]:
    """Whether the engine fits with the microcode and buffers of every case; one of each set of patterns is asked."""
    from hw_model import parse_trace
    from hw_model.area.budget import budget

    distinct = {case.patterns: case for case in cases if case.trace["patterns"]}.values()
    budgets = [budget(parse_trace(case.trace), platform, partition, cycles_of(case)) for case in distinct]
    if not budgets or not partition.uses_pl:
        return True, "no engine is needed"
    largest = max(budgets, key=lambda found: found.tightest.share / found.tightest.ceiling)
    return largest.fits, largest.words


def _write(case: Case, key: str, place: Path) -> None:
    text = json.dumps({"schema": RECORD, "study": key, **asdict(case)})
    write_atomically(place, gzip.compress(text.encode(), mtime=0))


def _read(place: Path, key: str) -> Case:
    try:
        document = json.loads(gzip.decompress(place.read_bytes()))
        study = document.pop("study")
        if document.pop("schema") != RECORD:
            raise CaseError(f"{place}: another schema; this version reads {RECORD!r}")
        for name in ("ipm_iterations", "patterns"):
            document[name] = tuple(document[name])
        case = Case(**document)
    except (OSError, EOFError, ValueError, KeyError, TypeError) as error:
        if isinstance(error, CaseError):
            raise
        raise CaseError(
            f"{place}: not a recorded case ({error}); delete it, or start again without --resume"
        ) from error
    if study != key:
        raise CaseError(
            f"{place}: recorded for another scenario, seed or version; start again without --resume"
        )
    return case


def _quantiles(values: Sequence[float]) -> dict[str, float | None]:
    """Minimum, median, 95 %, 99 % and maximum; the upper of two neighbours, so that each is a case's."""
    ordered = sorted(values)
    if not ordered:
        return dict.fromkeys(("min", "p50", "p95", "p99", "max"))
    shares = {"min": 0.0, "p50": 0.5, "p95": 0.95, "p99": 0.99, "max": 1.0}
    last = len(ordered) - 1
    return {name: ordered[min(last, -int(-share * last // 1))] for name, share in shares.items()}


def _counted(values: Iterable[int]) -> dict[str, int]:
    """How often each value occurs, ascending."""
    return {str(value): count for value, count in sorted(Counter(values).items())}
