"""Studies: a point is what `speedup` says, a front holds exactly what nothing beats, and a sweep is its grid."""

from __future__ import annotations

from pathlib import Path

import pytest

from hw_model.errors import HwModelError, PartitionError, PlatformError
from hw_model.figures.study import amdahl_figure, pareto_figure, roofline_figure
from hw_model.platform.partition import all_partitions, load_partition
from hw_model.platform.platform import load_platform
from hw_model.report.partition_verdict import verdicts
from hw_model.report.speedup import speedup
from hw_model.report.study import Point, Study, pareto
from hw_model.report.sweep import SweepError, load_sweep, run
from hw_model.timing.limits import limits, roofs
from hw_model.timing.trace import parse_trace
from hw_model.vocabulary import PL_MODULES
from tests.hw_model.synthetic import synthetic_trace

TRACE = parse_trace(synthetic_trace(iterations=3))
PNG = b"\x89PNG\r\n\x1a\n"


def points(*devices: str) -> list[Point]:
    study = Study(TRACE)
    platforms = [
        load_platform(device).with_value("pl.lanes", lanes) for device in devices for lanes in (1, 4, 16)
    ]
    return [point for platform in platforms for point in study.points(platform, all_partitions())]


def test_all_partitions_are_all_and_the_shipped_ones_keep_their_names() -> None:
    found = all_partitions()
    assert len({tuple(partition.modules.items()) for partition in found}) == len(found) == 128
    assert {"all_ps", "paper", "factor_only"} <= {partition.name for partition in found}
    more = [partition.name for partition in all_partitions(programs=True)[len(found) :]]
    assert more == ["paper_streams", "resident"]


def test_modules_joined_by_plus_are_a_partition() -> None:
    partition = load_partition("linear_solve+factorization")
    assert partition.name == "factorization+linear_solve"
    assert {name for name, side in partition.modules.items() if side == "pl"} == {
        "factorization",
        "linear_solve",
    }
    with pytest.raises(PartitionError, match=r"no module 'line_serch'; allowed: matrix_update, "):
        load_partition("factorization+line_serch")


def test_a_point_is_what_the_report_says() -> None:
    platform = load_platform("xc7z045").with_value("runtime.cores_used", 2)
    for partition in (
        load_partition("paper"),
        load_partition("factorization+cone_ops"),
        load_partition("all_ps"),
    ):
        [point] = Study(TRACE).points(platform, [partition])
        report = speedup(TRACE, platform, partition)
        assert point.time_ms == report.makespan_ms
        assert point.speedup == report.speedup
        assert point.worst_case_ms == report.worst_case_ms


def test_an_overlapped_point_is_what_the_report_says() -> None:
    platform = load_platform("zu9eg").with_values({"runtime.schedule": "overlapped", "runtime.cores_used": 2})
    [point] = Study(TRACE).points(platform, [load_partition("paper")])
    report = speedup(TRACE, platform, "paper")
    assert (point.time_ms, point.worst_case_ms) == (report.makespan_ms, report.worst_case_ms)


def test_the_front_is_what_nothing_beats() -> None:
    found = points("zu9eg", "xc7z020")
    front = pareto(found)
    kept = {id(point) for point in front}
    for point in found:
        same = [other for other in found if other.device == point.device and other.budget.fits]
        beaten = any(other.beats(point) for other in same) or not point.budget.fits
        twin = any(other.equals(point) and id(other) in kept for other in same)
        assert (id(point) in kept) == (not beaten and not (twin and id(point) not in kept))
    assert {point.device for point in front} == {"zu9eg", "xc7z020"}
    assert all(point.budget.fits for point in front)


def test_a_verdict_names_a_partition_that_is_no_worse_in_anything() -> None:
    found = points("zu9eg")
    judged = verdicts(found)
    assert [verdict.point.lanes for verdict in judged] == [1, 4, 16]
    for verdict in judged:
        rivals = [
            point for point in found if point.lanes == verdict.point.lanes and point.beats(verdict.point)
        ]
        assert verdict.optimal == (not rivals)
        if verdict.better is not None:
            assert verdict.better in rivals
            assert "NOT Pareto-optimal" in verdict.words
            assert verdict.robust == verdict.better.beats(verdict.point, everywhere=True)
    assert not judged[0].optimal  # on one lane, one A53 is faster than the PL
    best = verdicts(found, partition=judged[0].fastest.partition)[0]
    assert best.optimal
    assert "is Pareto-optimal" in best.words


def test_limits_are_above_what_is_reached_and_in_their_order() -> None:
    for lanes in (1, 8):
        platform = load_platform("zu9eg").with_value("pl.lanes", lanes)
        found = limits(TRACE, platform, load_partition("paper"))
        assert found.speedup == pytest.approx(speedup(TRACE, platform, "paper").speedup.nominal, rel=1e-12)
        assert found.speedup < found.free_pl < found.free_pl_and_link
    idle = limits(TRACE, platform, load_partition("all_ps"))
    assert (idle.speedup, idle.free_pl, idle.free_pl_and_link) == (1.0, 1.0, 1.0)


def test_no_module_is_above_its_roof() -> None:
    platform = load_platform("zu9eg")
    rows = roofs(TRACE, platform, load_partition("paper"))
    assert {row.module for row in rows} == set(PL_MODULES) - {"statistics"}
    peak = platform.pl.lanes.value * platform.pl.clock_mhz.value * 1e-3
    assert all(row.gops_with_link < row.gops <= peak for row in rows)


def test_figures_are_drawn(tmp_path: Path) -> None:
    found = points("zu9eg")
    platform, partition = load_platform("zu9eg"), load_partition("paper")
    pareto_figure(found, pareto(found), tmp_path / "a.png")
    curve = {
        point.lanes: (point.speedup, limits(TRACE, platform.with_value("pl.lanes", point.lanes), partition))
        for point in found
        if point.partition == "paper"
    }
    figure = amdahl_figure({"paper": curve}, "zu9eg", tmp_path / "b.png")
    assert next(line.get_ydata()[0] for line in figure.axes[0].lines) == curve[1][0].nominal
    roofline_figure(roofs(TRACE, platform, partition), platform, tmp_path / "c.png")
    for name in "abc":
        assert (tmp_path / f"{name}.png").read_bytes().startswith(PNG)
    with pytest.raises(HwModelError, match="`points` is empty"):
        pareto_figure([], [])


def sweep_file(folder: Path, text: str) -> Path:
    path = folder / "sweep.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_sweep_is_its_grid(tmp_path: Path) -> None:
    text = """
[axes]
device = ["zu9eg", "xc7z020"]
partition = ["paper", "factorization+linear_solve"]
"runtime.completion" = ["interrupt", "polling"]
[axes.pl]
lanes = [2, 4, 8]
"""
    sweep = load_sweep(sweep_file(tmp_path, text))
    seen: list[int] = []
    found, refused = run(TRACE, sweep, progress=seen.append)
    assert sweep.size == len(found) == seen[-1] == 2 * 2 * 2 * 3
    assert not refused
    rows = {
        tuple(point.row()[key] for key in ("device", "partition", "runtime.completion", "lanes"))
        for point in found
    }
    assert len(rows) == len(found)
    one = next(
        point for point in found if point.row()["runtime.completion"] == "polling" and point.lanes == 8
    )
    platform = load_platform(one.device).with_values({"runtime.completion": "polling", "pl.lanes": 8})
    assert one.time_ms == speedup(TRACE, platform, one.partition).makespan_ms


def test_a_computer_that_cannot_be_leaves_the_others_in_a_sweep(tmp_path: Path) -> None:
    text = "[axes]\n'pl.lanes' = [0, 4, 64]\n'pl.banks' = [12, 16]\n"
    found, refused = run(TRACE, load_sweep(sweep_file(tmp_path, text)))
    assert [point.lanes for point in found] == [4]
    assert len(refused) == 5
    why = {(each.settings["pl.lanes"], each.settings["pl.banks"]): each.why for each in refused}
    assert "`pl.lanes` = 0" in why[0, 16]
    assert "`pl.lanes` = 64: no engine of rtl/ has more than 16" in why[64, 16]
    assert "no power of two" in why[4, 12]
    with pytest.raises(HwModelError, match=r"`pl\.lanes` = 64: no engine"):
        run(TRACE, load_sweep(sweep_file(tmp_path, "[axes]\n'pl.lanes' = [64, 128]\n")))


@pytest.mark.parametrize(
    ("text", "error", "says"),
    [
        ("[axis]\n", SweepError, r"sweep sweep\.toml: `axis` is not a known key; allowed: axes, workload"),
        ("workload = 'a'\n", SweepError, r"`axes` is missing"),
        ("workload = 1\n[axes]\n", SweepError, r"`workload` = 1: must be the path"),
        (
            "[axes]\n'pl.lanes' = []\n",
            SweepError,
            r"`axes\.pl\.lanes` = \[\]: must be a list of at least one",
        ),
        ("[axes]\n'pl.lanes' = 4\n", SweepError, r"`axes\.pl\.lanes` = 4: must be a list"),
        ("[axes]\n'pl.lanes' = [4, 4]\n", SweepError, r"names a value twice"),
        ("[axes]\ndevice = [4]\n", SweepError, r"`axes\.device` = \[4\]: must be a list of names"),
        ("[axes]\n'pl.lane' = [4]\n", PlatformError, r"`pl\.lane` is not a parameter"),
        ("[axes]\n'pl.clock_mhz' = [-4.0]\n", PlatformError, r"`pl\.clock_mhz` = -4\.0"),
        ("[axes]\ndevice = ['zu1']\n", PlatformError, r"platform 'zu1' is not known"),
        ("[axes]\npartition = ['all_pl']\n", PartitionError, r"partition 'all_pl' is not known"),
        ("[axes\n", SweepError, r"not a TOML file"),
        (
            f"[axes]\n'pl.lanes' = {list(range(1, 1001))}\n'pl.banks' = {list(range(1, 102))}\n",
            SweepError,
            "101000 points",
        ),
    ],
)
def test_a_bad_sweep_is_refused_by_name(tmp_path: Path, text: str, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        load_sweep(sweep_file(tmp_path, text))


def test_a_missing_sweep_is_named(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r"sweep none\.toml: cannot be read"):
        load_sweep(tmp_path / "none.toml")
