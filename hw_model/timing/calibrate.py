"""The PS's throughput from a user's own measurement: stage times on his core give `ps.flop_per_cycle` and its band.

The CSV has a header and the columns `stage`, `runs` and `microseconds` (of all runs together); stages are those of the
workload's first pattern, run on one core, with nothing on the PL.
"""

from __future__ import annotations

import csv
import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from hw_model.errors import HwModelError
from hw_model.platform.parameter import Parameter

from . import ps

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

    from .trace import Pattern, Trace

COLUMNS = ("stage", "runs", "microseconds")


class CalibrationError(HwModelError):
    """A measurement file that gives no throughput; the message names the line and what is allowed."""


@dataclass(frozen=True, slots=True)
class Measured:
    """One row: a stage, how often it ran, and how long all runs took."""

    stage: str
    runs: int
    microseconds: float


@dataclass(frozen=True, slots=True)
class ModuleFit:
    """Throughput within one module, and how far the calibrated core is from its measured time."""

    module: str
    flop_per_cycle: float
    measured_us: float
    modelled_us: float

    @property
    def error(self) -> float:
        """Relative error of the modelled time."""
        return self.modelled_us / self.measured_us - 1.0


@dataclass(frozen=True, slots=True)
class Calibration:
    """The throughput of all stages together, its spread over modules, and the platform that has it."""

    flop_per_cycle: float
    low: float
    high: float
    band_words: str
    """Where the band comes from."""
    modules: tuple[ModuleFit, ...]
    skipped: tuple[str, ...]
    """Stages whose divisions and roots alone are modelled longer than they took."""
    platform: Platform


def read_measurements(path: str | Path) -> list[Measured]:
    """The rows of a CSV. Raises CalibrationError naming line and column."""
    where = Path(path).name
    try:
        with Path(path).open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            found = tuple(reader.fieldnames or ())
            if sorted(found) != sorted(COLUMNS):
                raise CalibrationError(
                    f"{where}: columns are {', '.join(found) or 'none'}; wanted: {', '.join(COLUMNS)}"
                )
            rows = [_row(row, f"{where}: line {reader.line_num}") for row in reader]
            _refuse_twins(rows, where)
    except OSError as error:
        raise CalibrationError(f"{where}: cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise CalibrationError(f"{where}: not CSV: {error}") from error
    if not rows:
        raise CalibrationError(f"{where}: holds no measurement")
    return rows


def calibrate(trace: Trace, platform: Platform, measured: list[Measured], source: str) -> Calibration:
    """`platform` with its `ps.flop_per_cycle` measured; the band is the spread over the modules, with one module the
    platform's relative band.

    Divisions and roots keep their modelled cycles. Raises CalibrationError for unknown stages or no usable time.
    """
    pattern = trace.patterns[0]
    flops: defaultdict[str, float] = defaultdict(float)
    streaming: defaultdict[str, float] = defaultdict(float)
    skipped: list[str] = []
    for row in measured:
        if row.stage not in pattern.stages:
            raise CalibrationError(
                f"stage {row.stage!r} is not in the workload; it has {', '.join(pattern.stages)}"
            )
        cycles = row.microseconds * platform.ps.clock_mhz.value - row.runs * _fixed(
            trace, platform, row.stage
        )
        work = row.runs * ps.flops(pattern.stages[row.stage])
        if cycles <= 0.0 or not work:
            skipped.append(row.stage)
            continue
        module = pattern.stages[row.stage].module
        flops[module] += work
        streaming[module] += cycles
    if not streaming:
        raise CalibrationError(
            "no stage took longer than its divisions and roots: check the clock of the platform"
        )
    rates = {module: flops[module] / streaming[module] for module in streaming}
    overall = sum(flops.values()) / sum(streaming.values())
    low, high = min(rates.values()), max(rates.values())
    words = "over the modules"
    if len(rates) == 1:  # which says nothing about the others
        words = "one module measured: the relative band is that of before"
        assumed = platform.ps.flop_per_cycle
        low, high = (
            overall * assumed.at(end, more_is_faster=True).value / assumed.value for end in ("slow", "fast")
        )
        source += f"; {words}"
    parameter = Parameter[float](value=overall, tag="measured", source=source, low=low, high=high)
    core = platform.ps.model_copy(update={"flop_per_cycle": parameter})
    calibrated = platform.model_copy(update={"ps": core})
    fits = _fits(trace, calibrated, measured, rates)
    return Calibration(overall, low, high, words, fits, tuple(skipped), calibrated)


def _fits(
    trace: Trace, platform: Platform, measured: list[Measured], rates: dict[str, float]
) -> tuple[ModuleFit, ...]:
    """Measured and modelled time of each module on the calibrated core."""
    pattern: Pattern = trace.patterns[0]
    times: defaultdict[str, list[float]] = defaultdict(lambda: [0.0, 0.0])
    for row in measured:
        stage = pattern.stages[row.stage]
        cycles = row.runs * ps.stage_cycles(stage, platform.ps, trace.datapath)
        times[stage.module][0] += row.microseconds
        times[stage.module][1] += cycles / platform.ps.clock_mhz.value
    return tuple(
        ModuleFit(module, rates.get(module, math.nan), took, said) for module, (took, said) in times.items()
    )


def _fixed(trace: Trace, platform: Platform, stage: str) -> int:
    """Cycles of a stage's divisions and roots."""
    found = trace.patterns[0].stages[stage]
    streaming = math.ceil(ps.flops(found) / platform.ps.flop_per_cycle.value)
    return ps.stage_cycles(found, platform.ps, trace.datapath) - streaming


def _refuse_twins(rows: list[Measured], where: str) -> None:
    seen: set[str] = set()
    for row in rows:
        if row.stage in seen:
            raise CalibrationError(
                f"{where}: stage {row.stage!r} stands there twice: give one row a stage, of all its runs"
            )
        seen.add(row.stage)


def _row(row: dict[str, str | None], where: str) -> Measured:
    try:
        runs, microseconds = int(row["runs"] or ""), float(row["microseconds"] or "")
    except ValueError:
        raise CalibrationError(
            f"{where}: runs = {row['runs']!r}, microseconds = {row['microseconds']!r}: must be a whole number and a number"
        ) from None
    if runs < 1 or not (math.isfinite(microseconds) and microseconds > 0.0):
        raise CalibrationError(f"{where}: runs = {runs}, microseconds = {microseconds}: must be positive")
    return Measured(row["stage"] or "", runs, microseconds)
