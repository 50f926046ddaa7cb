"""Calibration: what was measured on a core comes back as its throughput, and the platform file that says so loads."""

from __future__ import annotations

from pathlib import Path

import pytest

from hw_model.platform.platform import load_platform, platform_names
from hw_model.platform.platform_toml import to_toml
from hw_model.timing import ps
from hw_model.timing.calibrate import CalibrationError, Measured, calibrate, read_measurements
from hw_model.timing.trace import parse_trace
from tests.hw_model.synthetic import synthetic_trace

TRACE = parse_trace(synthetic_trace(iterations=2))
PLATFORM = load_platform("zu9eg")


def times_on(flop_per_cycle: float) -> list[Measured]:
    """What a core of that throughput would have measured."""
    core = PLATFORM.with_value("ps.flop_per_cycle", flop_per_cycle).ps
    stages = TRACE.patterns[0].stages
    return [
        Measured(name, 10, 10 * ps.stage_cycles(stage, core, "f64") / core.clock_mhz.value)
        for name, stage in stages.items()
        if sum(stage.operations.values())
    ]


@pytest.mark.parametrize("truth", [0.1, 0.32, 1.5])
def test_a_core_of_known_throughput_is_found(truth: float) -> None:
    found = calibrate(TRACE, PLATFORM, times_on(truth), "test")
    assert found.flop_per_cycle == pytest.approx(truth, rel=0.01)
    assert found.low <= found.flop_per_cycle <= found.high
    assert found.platform.ps.flop_per_cycle.tag == "measured"
    assert all(abs(row.error) < 0.01 for row in found.modules if row.measured_us > 1.0)


def test_modules_that_differ_make_the_band() -> None:
    slow, fast = times_on(0.2), times_on(0.8)
    stages = TRACE.patterns[0].stages
    mixed = [fast[k] if stages[row.stage].module == "factorization" else row for k, row in enumerate(slow)]
    found = calibrate(TRACE, PLATFORM, mixed, "test")
    assert found.low == pytest.approx(0.2, rel=0.02)
    assert found.high == pytest.approx(0.8, rel=0.02)
    assert found.low < found.flop_per_cycle < found.high


@pytest.mark.parametrize("name", platform_names())
def test_a_written_platform_reads_back_as_the_same(tmp_path: Path, name: str) -> None:
    platform = load_platform(name)
    path = tmp_path / "copy.toml"
    path.write_text(to_toml(platform), encoding="utf-8")
    assert load_platform(path) == platform


def test_rows_are_read(tmp_path: Path) -> None:
    path = tmp_path / "times.csv"
    path.write_text("microseconds,stage,runs\n12.5,factorize,3\n", encoding="utf-8")
    assert read_measurements(path) == [Measured("factorize", 3, 12.5)]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("stage,runs\n", r"times\.csv: columns are stage, runs; wanted: stage, runs, microseconds"),
        ("stage,runs,microseconds,core\n", r"columns are stage, runs, microseconds, core"),
        ("stage,runs,microseconds\n", r"holds no measurement"),
        ("stage,runs,microseconds\na,x,1\n", r"line 2: runs = 'x', microseconds = '1'"),
        ("stage,runs,microseconds\na,0,1\n", r"line 2: runs = 0, microseconds = 1\.0: must be positive"),
        ("stage,runs,microseconds\na,1,nan\n", r"microseconds = nan: must be positive"),
        ("stage,runs,microseconds\na,1,2\nb,1,2\na,3,4\n", r"times\.csv: stage 'a' stands there twice"),
        ("stage,runs,microseconds\na,1\n", r"line 2: runs = '1', microseconds = None"),
    ],
)
def test_bad_rows_are_refused_by_line(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "times.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CalibrationError, match=says):
        read_measurements(path)


def test_what_gives_no_throughput_is_refused() -> None:
    with pytest.raises(CalibrationError, match=r"stage 'warp' is not in the workload; it has equilibrate, "):
        calibrate(TRACE, PLATFORM, [Measured("warp", 1, 1.0)], "test")
    with pytest.raises(CalibrationError, match="no stage took longer than its divisions and roots"):
        calibrate(TRACE, PLATFORM, [Measured("factorize", 1, 1e-3)], "test")


def test_one_module_leaves_the_relative_band_as_it_was() -> None:
    stages = TRACE.patterns[0].stages
    rows = [row for row in times_on(0.5) if stages[row.stage].module == "factorization"]
    found = calibrate(TRACE, PLATFORM, rows, "test")
    before, after = PLATFORM.ps.flop_per_cycle, found.platform.ps.flop_per_cycle
    assert before.low is not None
    assert before.high is not None
    assert before.low < before.high
    assert found.low / found.flop_per_cycle == pytest.approx(before.low / before.value)
    assert found.high / found.flop_per_cycle == pytest.approx(before.high / before.value)
    assert "one module measured" in after.source
