"""The answer to "how fast, and why": a modelled run compared with a baseline, its assumptions first."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from html import escape
from typing import TYPE_CHECKING, Any, Literal

from hw_model.area.budget import Budget, budget
from hw_model.energy.joules import EnergyUse, counter_of, energy_use
from hw_model.errors import HwModelError
from hw_model.platform.partition import BEST
from hw_model.timing.actions import Action, actions_of
from hw_model.timing.durations import Durations
from hw_model.timing.ps import price_words
from hw_model.timing.stage_cycles import StageCycles, estimated
from hw_model.timing.timeline import Timeline, as_partition, as_platform, lay_out, makespan_picoseconds
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import CAUSES, PICOSECONDS_PER_MS, Cause, Datapath, Side

from . import markdown
from .assumptions import Assumption, assumptions
from .bands import Band, band_of, corners_of
from .baselines import Beside, baselines, without_pl
from .best import chosen_partition
from .bottleneck import bottleneck_of
from .loading import Loading, loading
from .prices import at_each_price
from .rows import (
    CopyRow,
    IterationRow,
    ModuleRow,
    SolveRow,
    StageRow,
    copy_rows,
    iteration_rows,
    module_rows,
    solve_rows,
    stage_rows,
)
from .throughput import Throughput, throughputs
from .usage import WORST_CASE_USAGE, ParameterUse

if TYPE_CHECKING:
    from pathlib import Path

    from hw_model.platform.partition import Partition
    from hw_model.platform.platform import Platform
    from hw_model.timing.programs import Programs
    from hw_model.timing.trace import Trace

Verdict = Literal["PASS", "FAIL", "MARGINAL"]
SCHEMA = "orbsoc.hardware-report/1"

ASSUMED_GENERATION = (
    "Generating a problem is priced by its nonzeros, from an assumed cost each; of the rest of the outer loop, nothing.",
)
NOT_MODELLED = (
    "No contention between PS and PL for memory beyond the jitter's bound.",
    "Copies inside a stage are free unless the trace counts them as moves.",
)
ESTIMATED_WORDS = "; PL cycles are estimated, not scheduled"
"""The end of a headline without schedules."""
ESTIMATED = (
    "PL cycles are an estimate between bounds: banks, ports, crossbar and instruction fetch are left out.",
)


@dataclass(frozen=True, slots=True)
class Deadline:
    """PASS: met by the worst case; FAIL: missed even at the fast end without jitter, or by an engine that the device does not
    hold; MARGINAL: in between.

    Of the prices of the PS's work, the worst case takes the dearest and the fast end the cheapest. Margins are deadline
    minus time, negative when it is missed: nominally, and in the worst case.
    """

    deadline_ms: float
    verdict: Verdict
    margin_ms: float
    worst_case_margin_ms: float
    worst_case_price: str
    """The price at which the worst case is, as in `PricedTimes`."""

    @property
    def words(self) -> str:
        """The deadline and both margins."""
        return (
            f"against {self.deadline_ms:g} ms, margin {self.margin_ms:+.3f} ms nominally; worst case"
            f" (by {self.worst_case_price}; with jitter) {self.deadline_ms - self.worst_case_margin_ms:.3f} ms,"
            f" margin {self.worst_case_margin_ms:+.3f} ms"
        )


@dataclass(frozen=True, slots=True)
class PricedTimes:
    """Makespans and speedup with the PS's stages at one price."""

    price: str
    """"flop a cycle, assumed" or "executed instructions (Cortex-A53, NEON)"."""
    makespan_ms: Band
    baseline_ms: Band
    speedup: Band
    worst_case_ms: float
    """Slow end of every band and every jitter at its bound."""

    @property
    def words(self) -> str:
        """Speedup and times at this price."""
        ratio = f"{self.speedup.nominal:.2f}× ({self.speedup.low:.2f}–{self.speedup.high:.2f}×)"
        return f"by {self.price} {ratio}, {_ms(self.makespan_ms)} against {_ms(self.baseline_ms)}"


@dataclass(frozen=True, slots=True)
class Report:
    """A modelled run of one trace; every number in it is modelled, none measured."""

    device: str
    description: str
    core: str
    partition: str
    modules_on_pl: tuple[str, ...]
    baseline: str
    datapath: Datapath
    lanes: int
    pl_clock_mhz: float
    makespan_ms: Band
    baseline_ms: Band
    speedup: Band
    """Baseline makespan over this one's, both at the same parameters."""
    worst_case_ms: float
    """Slow end of every band and every jitter at its bound, at the platform's price of the PS's work: no run at that price
    takes longer."""
    jitter_ms: float
    """How much of a nominal run jitter can add at most."""
    makespan_picoseconds: int
    cycles: dict[Side, int]
    """Computing cycles of each side, in its own clock."""
    causes_picoseconds: dict[Cause, int]
    modules: tuple[ModuleRow, ...]
    stages: tuple[StageRow, ...]
    iterations: tuple[IterationRow, ...]
    solves: tuple[SolveRow, ...]
    copies: tuple[CopyRow, ...]
    interrupts: int
    launches: int
    deadline: Deadline | None
    energy: EnergyUse
    baseline_energy: EnergyUse
    """With the PL there, and drawing what it draws when it does nothing."""
    bare_energy: EnergyUse
    """Of the baseline on a chip without a PL."""
    beside: tuple[Beside, ...]
    """The gain over one core and over all, and what they draw."""
    area: Budget
    """What the engine takes of the device."""
    loading: Loading
    """What loading the programs takes."""
    prices: tuple[PricedTimes, ...]
    """The same comparison at each price of the PS's work; one where the trace has no counts to price."""
    throughput: tuple[Throughput, ...]
    """Problems of these patterns back to back, with one, two and four in flight."""
    outer_loop: str
    """How what happens around the solves was counted; empty where only an assumed generation of problems is priced."""
    assumptions: tuple[Assumption, ...]

    def __repr__(self) -> str:
        return f"Report({self.partition} on {self.device}: {_ms(self.makespan_ms)}, modelled)"

    def _repr_html_(self) -> str:
        rows = {
            "modelled time": _ms(self.makespan_ms),
            self.baseline: _ms(self.baseline_ms),
            "speedup": f"{self.speedup.nominal:.2f}× ({self.speedup.low:.2f}–{self.speedup.high:.2f}×)",
            "energy": self.energy.words,
            "deadline": self.deadline.words if self.deadline else "none given",
            "most time goes into": self.bottleneck,
        }
        cells = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in rows.items()
        )
        return f"<table><caption>{escape(f'{self.partition} on {self.device}')}</caption>{cells}</table>"

    @property
    def headline(self) -> str:
        """One sentence: how this partition does against the baseline, at which clock, whether it does not fit, and whether PL
        cycles are estimated."""
        clock = f"; {self._pl_clock}" if self.modules_on_pl else ""
        fit = "" if self.area.fits else f"; {self.area.words}"
        return self._comparison + clock + fit + (ESTIMATED_WORDS if self.estimated else "")

    @property
    def _pl_clock(self) -> str:
        (known,) = (row for row in self.assumptions if row.key == "pl.clock_mhz")
        return f"PL at {self.pl_clock_mhz:g} MHz ({known.tag})"

    @property
    def _is_baseline(self) -> bool:
        """Whether there is nothing to compare: the baseline itself, also where it is the best."""
        return self.partition in (self.baseline, f"{BEST} ({self.baseline})")

    @property
    def _comparison(self) -> str:
        times = f"{_ms(self.makespan_ms)} against {_ms(self.baseline_ms)}"
        what = f"modelled: {self.partition} on {self.device}"
        if self._is_baseline:
            return f"{what} takes {_ms(self.makespan_ms)} on one {self.core}"
        ratio = f"{self.speedup.nominal:.2f}× ({self.speedup.low:.2f}–{self.speedup.high:.2f}×)"
        if self.speedup.high < 1.0:
            return f"{what} is SLOWER than {self.baseline}: speedup {ratio}, {times}"
        if self.speedup.low > 1.0:
            return f"{what} is faster than {self.baseline}: speedup {ratio}, {times}"
        leaning = "slower" if self.speedup.nominal < 1.0 else "faster"
        return f"{what} may be faster or slower than {self.baseline}, nominally {leaning}: speedup {ratio}, {times}"

    @property
    def estimated(self) -> bool:
        """Whether cycles of the PL are estimated; schedules, which equal the RTL, give other ones."""
        return any(row.origin == "estimate" for row in self.stages)

    @property
    def deadline_line(self) -> str:
        """One sentence on the deadline; empty when none was given."""
        if self.deadline is None:
            return ""
        found = self.deadline
        return f"modelled deadline verdict: {found.verdict}: {_ms(self.makespan_ms)} {found.words}; binding is {self.bottleneck}"

    @property
    def energy_line(self) -> str:
        """One sentence on the energy, PS and PL, waiting and idle included."""
        if self._is_baseline:
            return f"modelled energy: {self.energy.words}"
        return (
            f"modelled energy: {self.energy.words}; {self.baseline} "
            f"{self.baseline_energy.nominal_mj:.2f} mJ ({self.baseline_energy.low_mj:.2f}–{self.baseline_energy.high_mj:.2f}),"
            f" {self.bare_energy.nominal_mj:.2f} mJ on a chip without a PL"
        )

    @property
    def price_line(self) -> str:
        """One sentence that holds the speedups at every price of the PS's work side by side."""
        if self._is_baseline:
            times = "; ".join(f"by {found.price} {_ms(found.makespan_ms)}" for found in self.prices)
            return f"modelled PS: {times}"
        return f"modelled PS: {'; '.join(found.words for found in self.prices)}"

    @property
    def bottleneck(self) -> str:
        """The resource that most of the time is spent on, and its share."""
        _, share, name = bottleneck_of(self.causes_picoseconds)
        return f"{name} ({100 * share:.0f} % of the time)"

    @property
    def not_modelled(self) -> tuple[str, ...]:
        """What the numbers leave out."""
        return ESTIMATED * self.estimated + ASSUMED_GENERATION * (not self.outer_loop) + NOT_MODELLED

    @property
    def slower_modules(self) -> tuple[ModuleRow, ...]:
        """Modules on the PL that take longer there, copies and interrupts included, than in the baseline."""
        return tuple(
            row for row in self.modules if row.side == "pl" and row.picoseconds > row.baseline_picoseconds
        )

    def to_dict(self) -> dict[str, Any]:
        """Everything as JSON-able plain data."""
        return {
            "schema": SCHEMA,
            "headline": self.headline,
            "deadline_line": self.deadline_line,
            "energy_line": self.energy_line,
            "price_line": self.price_line,
            "loading_line": self.loading.words,
            "binding": self.bottleneck,
            "slower_modules": [row.module for row in self.slower_modules],
            "not_modelled": list(self.not_modelled),
            **asdict(self, dict_factory=_json_object),
        }

    def to_markdown(self) -> str:
        """The report as Markdown: verdict, assumptions, then times."""
        parts = [
            f"# Modelled cycle budget: {self.partition} on {self.device}",
            f"**{self.headline}.**",
            f"{self.price_line}.",
            f"{self.loading.words}; {self.area.words if self.modules_on_pl else 'no engine is needed'}.",
            *([f"**{self.deadline_line}.**"] if self.deadline else []),
            *markdown.slower_modules(self.slower_modules, self.baseline),
            f"{self.description}. {self.core} as PS; PL engine of {self.lanes} lanes; {self._pl_clock}; "
            f"datapath {self.datapath}; on the PL: {', '.join(self.modules_on_pl) or 'nothing'}. "
            "Brackets hold the band over the assumed ranges.",
            "## Assumptions",
            markdown.assumption_table(self.assumptions),
            "Not modelled:\n\n" + "\n".join(f"- {line}" for line in self.not_modelled),
            "## Modelled time by cause",
            markdown.cause_table(self.causes_picoseconds),
            "## Modelled time by module",
            markdown.module_table(self.modules, self.baseline),
            "## Modelled cycles of one run of each stage",
            markdown.stage_table(self.stages),
            "## Modelled time by iteration",
            markdown.iteration_table(self.iterations, self.solves),
            "## Modelled energy",
            f"{self.energy_line}.",
            markdown.energy_table(self.energy),
            "## Beside the processor alone, modelled",
            markdown.beside_table(self.beside),
            "## Modelled throughput",
            "\n".join(f"- {found.words}" for found in self.throughput),
            "## Transfers and interrupts",
            f"{self.launches} launches, {self.interrupts} interrupts.\n{markdown.copy_table(self.copies)}",
        ]
        return "\n\n".join(parts) + "\n"


def speedup(
    trace: Mapping[str, Any] | Trace,
    platform: Platform | str | Path,
    partition: Partition | str | Path,
    deadline_ms: float | None = None,
    baseline: Partition | str | Path = "all_ps",
    cycles: StageCycles = estimated,
    baseline_trace: Mapping[str, Any] | Trace | None = None,
) -> Report:
    """Compare `partition` with `baseline` on the same `platform` and trace (objects, names or paths; "best" is the fastest
    partition that fits).

    Bands come from the parameters that have `low` and `high`: PS, fabric (PL, link and interrupts) and generation
    of the problems are taken to their slow and fast ends independently. `deadline_ms` is for the whole trace. `baseline_trace`
    is of the same solves as the baseline runs them: a core alone may be faster in another order of elimination.
    Raises TraceError, PlatformError, PartitionError, or HwModelError for an impossible deadline.
    """
    if deadline_ms is not None and not (math.isfinite(deadline_ms) and deadline_ms > 0.0):
        raise HwModelError(f"`deadline_ms` = {deadline_ms!r}: must be a positive number of milliseconds")
    trace, platform = parse_trace(trace), as_platform(platform)
    partition = chosen_partition(partition, trace, platform, cycles)
    base = as_partition(baseline)
    area = budget(trace, platform, partition, cycles)
    actions, durations, timeline = _run(trace, platform, partition, cycles, area.programs)
    base_trace = trace if baseline_trace is None else parse_trace(baseline_trace)
    base_area = budget(base_trace, platform, base, cycles)
    base_actions, base_durations, before = _run(base_trace, platform, base, cycles, base_area.programs)
    if not before.makespan_picoseconds or not timeline.makespan_picoseconds:
        raise HwModelError("the trace takes no time at all: its solves run no operations")
    times_ms, base_ms = _times_ms(actions, durations), _times_ms(base_actions, base_durations)
    makespan_ms = band_of(times_ms)
    jitter = makespan_picoseconds(actions, durations, worst=True) - timeline.makespan_picoseconds
    kinds = [action.work.kind for action in actions]
    computed: dict[Side, int] = {"ps": 0, "pl": 0}
    for segment in timeline.segments:
        computed[segment.side] += segment.cycles
    causes = timeline.totals("cause")
    prices = _priced((actions, durations), (base_actions, base_durations))
    energies = _energy(base_actions, base_durations, base), without_pl(base_actions, base_durations, base)
    return Report(
        device=platform.name,
        description=platform.description,
        core=platform.ps.core,
        partition=partition.name,
        modules_on_pl=tuple(name for name, side in partition.modules.items() if side == "pl"),
        baseline=base.name,
        datapath=trace.datapath,
        lanes=platform.pl.lanes.value,
        pl_clock_mhz=platform.pl.clock_mhz.value,
        makespan_ms=makespan_ms,
        baseline_ms=band_of(base_ms),
        speedup=band_of([before / after for before, after in zip(base_ms, times_ms, strict=True)]),
        worst_case_ms=_worst_ms(actions, durations),
        jitter_ms=jitter / PICOSECONDS_PER_MS,
        makespan_picoseconds=timeline.makespan_picoseconds,
        cycles=computed,
        causes_picoseconds={cause: causes.get((cause,), 0) for cause in CAUSES},
        modules=tuple(module_rows(actions, timeline, partition, before)),
        stages=tuple(stage_rows(actions, durations)),
        iterations=tuple(iteration_rows(timeline)),
        solves=tuple(solve_rows(timeline, durations)),
        copies=tuple(copy_rows(actions, durations)),
        interrupts=kinds.count("interrupt"),
        launches=kinds.count("launch"),
        throughput=tuple(throughputs(trace, platform, partition, base, cycles)),
        deadline=None if deadline_ms is None else _judge(deadline_ms, makespan_ms, prices, fits=area.fits),
        energy=_energy(actions, durations, partition),
        baseline_energy=energies[0],
        bare_energy=energies[1],
        beside=baselines(
            trace,
            platform,
            partition,
            base,
            cycles,
            speedups=[(found.price, found.speedup.nominal) for found in prices],
            energies=energies,
        ),
        area=area,
        loading=loading(platform, area.programs),
        prices=prices,
        outer_loop=trace.outer_loop.source if trace.outer_loop else "",
        assumptions=tuple(assumptions(platform, _usage(trace, (partition, base), platform, cycles))),
    )


def _usage(
    trace: Trace, partitions: tuple[Partition, Partition], platform: Platform, cycles: StageCycles
) -> ParameterUse:
    """What a comparison of two partitions reads."""
    with_pl = max(partitions, key=lambda partition: partition.uses_pl)
    asked = replace(WORST_CASE_USAGE, off_pl=not all(partition.uses_pl for partition in partitions))
    return asked.of(trace, with_pl, platform, cycles)


def _run(
    trace: Trace, platform: Platform, partition: Partition, cycles: StageCycles, loaded: Programs
) -> tuple[list[Action], Durations, Timeline]:
    actions = actions_of(trace, partition)
    durations = Durations(trace, platform, partition, cycles, loaded)
    return actions, durations, lay_out(actions, durations, partition.name)


def _times_ms(actions: list[Action], durations: Durations) -> list[float]:
    """Makespans at the corners of the assumed bands."""
    return [
        makespan_picoseconds(actions, durations.on(corner)) / PICOSECONDS_PER_MS
        for corner in corners_of(durations.platform)
    ]


def _priced(
    run: tuple[list[Action], Durations], base: tuple[list[Action], Durations]
) -> tuple[PricedTimes, ...]:
    """Both runs at each price that the trace and the core have."""
    found: list[PricedTimes] = []
    for priced in at_each_price(run[1].platform, run[1].trace):
        times, before = (_times_ms(actions, durations.on(priced)) for actions, durations in (run, base))
        ratios = [slow / fast for slow, fast in zip(before, times, strict=True)]
        bands = band_of(times), band_of(before), band_of(ratios)
        found.append(PricedTimes(price_words(priced.ps), *bands, _worst_ms(run[0], run[1].on(priced))))
    return tuple(found)


def _worst_ms(actions: list[Action], durations: Durations) -> float:
    """At the slow end of every band, every jitter at its bound."""
    slowest = durations.on(durations.platform.corner("slow", "slow", "slow"))
    return makespan_picoseconds(actions, slowest, worst=True) / PICOSECONDS_PER_MS


def _energy(actions: list[Action], durations: Durations, partition: Partition) -> EnergyUse:
    """Over the corners of the assumed bands."""
    corners = [durations.on(corner) for corner in corners_of(durations.platform)]
    return energy_use(corners, counter_of(actions, partition))


def _json_object(fields: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Fields under the schema's keys, which say `picos`."""
    return {name.replace("picoseconds", "picos"): value for name, value in fields}


def _judge(deadline_ms: float, times: Band, prices: Sequence[PricedTimes], *, fits: bool) -> Deadline:
    worst = max(prices, key=lambda found: found.worst_case_ms)
    if not fits:
        verdict: Verdict = "FAIL"
    elif worst.worst_case_ms <= deadline_ms:
        verdict = "PASS"
    elif min(found.makespan_ms.low for found in prices) > deadline_ms:
        verdict = "FAIL"
    else:
        verdict = "MARGINAL"
    return Deadline(
        deadline_ms, verdict, deadline_ms - times.nominal, deadline_ms - worst.worst_case_ms, worst.price
    )


def _ms(band: Band) -> str:
    return f"{band.nominal:.3f} ms ({band.low:.3f}–{band.high:.3f})"
