"""`orbsoc reach` from a shell: files, resume, Ctrl-C and kill, bad input by name, and the product read back."""

from __future__ import annotations

import errno
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc.reach
from orbsoc.missions.reachable_domain import Scenario, load_scenario
from orbsoc.missions.reachable_domain.record.ephemeris import fly_point, oem, opm
from orbsoc.missions.reachable_domain.record.results_folder import solve_into
from orbsoc.missions.reachable_domain.search.continuation.domain import Domain
from orbsoc.missions.reachable_domain.search.continuation.tasks import grid_shards, solve_grid_shard
from orbsoc.orbit import Elements
from orbsoc.sweep import DaskCluster, Processes, Report, ShardStore, StoreError, Task, run
from tests.missions.reachable_domain.cases import SCENARIOS, small_scenario
from tests.processes import started

ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}


def orbsoc_reach(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "orbsoc", "reach", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=ENVIRONMENT, timeout=600)


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, str]:
    """Scenario, results folder and standard output of one small sweep."""
    place = tmp_path_factory.mktemp("reach")
    scenario = small_scenario(place)
    done = orbsoc_reach(scenario, "--out", place / "out", "--threads", "2", "--json", "--deadline-ms", "1000")
    assert done.returncode == 0, done.stderr
    return scenario, place / "out", done.stdout


def test_the_run_writes_what_it_says(solved: tuple[Path, Path, str]) -> None:
    _scenario, folder, stdout = solved
    document = json.loads(stdout)
    assert document == json.loads((folder / "summary.json").read_text())
    assert document["points"] == 60
    assert sum(document["status"].values()) == 60
    assert document["status"]["reached"] >= 40
    assert document["worst"]["sma_error_rel"] <= 1e-6
    assert document["hardware"]["provenance"] == "modelled"
    assert document["hardware"]["points_within_deadline"] > 0
    hardware = document["hardware"]
    coarse, *finer = hardware["patterns"]
    assert coarse["nodes"] == 12
    assert 8.0 <= coarse["iterations"] <= 14.0
    assert coarse["cycles"] == pytest.approx(coarse["iterations"] * coarse["cycles_per_iteration"])
    assert all(pattern["cycles_per_iteration"] > coarse["cycles_per_iteration"] for pattern in finer)
    assert sum(p["subproblems"] for p in hardware["patterns"]) == document["work"][
        "sequence_iterations"
    ] - edge_work(folder)
    priced = {(row["device"], row["partition"]): row["domain_s"] for row in document["hardware_table"]}
    assert priced[("zu9eg", "paper")] == document["hardware"]["domain_s"] > 0.0
    assert len(priced) >= 15
    assert {row["limit"] for row in document["envelope"]} >= {"lowest inclination", "highest node"}
    for name in document["files"]:
        assert (folder / name).stat().st_size > 0, name
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "of 60 points are reached" in page
    assert not re.search(r'(?:src|href)="https?:', page)


def test_what_no_report_leaves_out_is_written_by_resume(
    solved: tuple[Path, Path, str], tmp_path: Path
) -> None:
    scenario, folder, _stdout = solved
    other = tmp_path / "out"
    bare = orbsoc_reach(scenario, "--out", other, "--threads", "2", "--no-report", "--json")
    assert bare.returncode == 0, bare.stderr
    document = json.loads(bare.stdout)
    assert document["files"] == ["boundary.parquet", "points.parquet", "summary.json"]
    assert not {path.suffix for path in other.iterdir()} & {".png", ".html", ".nc"}
    again = orbsoc_reach(scenario, "--out", other, "--threads", "2", "--resume", "--json")
    assert again.returncode == 0, again.stderr
    whole = json.loads((folder / "summary.json").read_text())
    assert json.loads(again.stdout)["files"] == whole["files"]
    assert document["status"] == whole["status"]


def edge_work(folder: Path) -> int:
    """Subproblems of the edge, which belong to no point."""
    return int(orbsoc.reach.load(folder).boundary["sequence_iterations"].sum())


def test_every_point_has_its_modelled_cycles_in_both_exports(solved: tuple[Path, Path, str]) -> None:
    """Subproblems × iterations × cycles per iteration of the grid's pattern; who says so is in the metadata."""
    import pyarrow.parquet as parquet
    import xarray

    _scenario, folder, stdout = solved
    hardware = json.loads(stdout)["hardware"]
    table = parquet.read_table(folder / "points.parquet")
    cycles = table.column("modelled_pl_cycles").to_numpy()
    expected = sum(
        table.column(f"subproblems_{p['nodes']}").to_numpy() * p["iterations"] * p["cycles_per_iteration"]
        for p in hardware["patterns"]
    )
    np.testing.assert_allclose(cycles, expected, rtol=1e-12)
    held = (
        table.column("origin").to_numpy(zero_copy_only=False)
        == "plan of a lower bound, whose perigee is high enough"
    )
    assert (cycles[held] == 0.0).all()
    assert (cycles > 0.0).sum() >= 20
    assert cycles.sum() / hardware["pl_clock_mhz"] / 1e6 == pytest.approx(hardware["domain_s"])
    assert hardware["points_within_deadline"] == int(60 / hardware["domain_s"])
    about = {k.decode(): v.decode() for k, v in table.schema.field("modelled_pl_cycles").metadata.items()}
    assert (about["provenance"], about["device"], about["partition"]) == ("modelled", "zu9eg", "paper")
    assert about["unit"] == f"cycles of the PL clock at {hardware['pl_clock_mhz']:g} MHz"
    assert "modelled, not measured" in about["source"]
    with xarray.open_dataset(folder / "domain.nc", engine="h5netcdf") as cube:
        np.testing.assert_array_equal(cube["modelled_pl_cycles"].values.ravel(), cycles)
        assert cube["modelled_pl_cycles"].attrs["provenance"] == "modelled"
        assert cube["modelled_pl_cycles"].attrs["long_name"] == about["unit"]


def test_the_exports_agree_with_the_table(solved: tuple[Path, Path, str]) -> None:
    import pyarrow.parquet as parquet
    import xarray

    _scenario, folder, _stdout = solved
    found = orbsoc.reach.load(folder)
    with xarray.open_dataset(folder / "domain.nc", engine="h5netcdf") as cube:
        np.testing.assert_array_equal(cube["a_km"].values.ravel(), found.points["a_km"])
        reached = cube["status"].values.ravel() == 0
    np.testing.assert_array_equal(reached, found.points["status"] == "reached")
    edge = parquet.read_table(folder / "boundary.parquet")
    np.testing.assert_array_equal(edge.column("tilt_deg").to_numpy(), found.boundary["tilt_deg"])


def test_margins_agree_with_exact_ones_within_their_error(solved: tuple[Path, Path, str]) -> None:
    found = orbsoc.reach.load(solved[1])
    plane = np.deg2rad([27.3, 337.0])
    inside = Elements(6.678e6, 0.0, plane[0], plane[1], 0.0, 0.0)
    rough, exact = found.can_reach(inside), found.can_reach(inside, exact=True)
    assert rough.verdict is orbsoc.reach.Verdict.NOT_RULED_OUT
    assert exact.verdict == "within reach"
    assert abs(rough.tilt_deg - exact.tilt_deg) <= rough.tilt_error_deg + exact.tilt_error_deg
    assert abs(rough.sma_km - exact.sma_km) <= rough.sma_error_km + exact.sma_error_km
    ellipse = found.can_reach(Elements(9.0e6, 0.25, plane[0], plane[1], 0.0, 0.0))
    assert ellipse.verdict is orbsoc.reach.Verdict.NOT_RULED_OUT
    too_large = Elements(2.6e7, 0.74, plane[0], plane[1], 0.0, 0.0)
    assert found.can_reach(too_large, exact=True).verdict == "beyond reach"
    assert re.search(r"km \(± [\d.]+\) beyond the largest semi-major axis", found.can_reach(too_large).words)
    with pytest.raises(TypeError, match=r"`orbit` is of type int; it must be an orbsoc\.orbit\.Elements"):
        found.can_reach(3)
    elsewhere = found.can_reach(Elements(7.0e6, 0.02, np.deg2rad(60.0), plane[1], 0.0, 0.0))
    assert elsewhere.verdict == "beyond reach"
    assert not elsewhere.inside_box
    with pytest.raises(ValueError, match="below the surface"):
        found.can_reach(Elements(6.0e6, 0.1, plane[0], plane[1], 0.0, 0.0))


def test_messages_are_read_back_by_an_independent_reader(
    solved: tuple[Path, Path, str], tmp_path: Path
) -> None:
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io", reason="the independent reader is not installed").NdmIo
    found = orbsoc.reach.load(solved[1])
    row = int(np.flatnonzero(found.points["status"] == "reached")[0])
    point = (found.points[name][row] for name in ("inc_deg", "raan_deg", "perigee_bound_km"))
    flown = fly_point(found, *map(float, point))
    (tmp_path / "a.oem").write_text(oem(flown))
    (tmp_path / "a.opm").write_text(opm(flown))
    ephemeris = ndm_io().from_path(tmp_path / "a.oem")
    states = ephemeris.body.segment[0].data.state_vector
    assert len(states) == len(flown.times_s)
    last = states[-1]
    read = [float(getattr(last, name).value) for name in ("x", "y", "z", "x_dot", "y_dot", "z_dot")]
    np.testing.assert_allclose(read, flown.states[-1] / 1e3, atol=1e-8)
    assert ephemeris.body.segment[0].metadata.ref_frame == "SCENARIO_ECI"
    assert "x towards the meridian of Greenwich at launch" in " ".join(ephemeris.header.comment)
    message = ndm_io().from_path(tmp_path / "a.opm")
    assert message.body.segment.metadata.ref_frame == "SCENARIO_ECI"
    assert "the scenario gives no date" in " ".join(message.header.comment)
    orbit = message.body.segment.data
    assert float(orbit.keplerian_elements.semi_major_axis.value) == pytest.approx(
        found.points["a_km"][row], rel=1e-7
    )
    assert float(orbit.spacecraft_parameters.mass.value) == pytest.approx(88000.0)
    with pytest.raises(ValueError, match="is outside the search box"):
        fly_point(found, 1.0, 2.0, 3.0)
    with pytest.raises(ValueError, match="is not on the grid"):
        fly_point(found, 25.0, 335.25, 100.0)


def test_a_killed_sweep_resumes_to_the_same_table(solved: tuple[Path, Path, str], tmp_path: Path) -> None:
    scenario, folder, _stdout = solved
    out = tmp_path / "killed"
    command = [sys.executable, "-m", "orbsoc", "reach", str(scenario), "--out", str(out), "--threads", "1"]
    with started(command, env=ENVIRONMENT, stdout=subprocess.PIPE) as process:
        deadline = time.monotonic() + 300.0
        while not list(out.glob("points/shard=*/part.parquet")) and time.monotonic() < deadline:
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGKILL)
    before = {path: path.stat().st_mtime_ns for path in out.rglob("part.parquet")}
    assert before
    refused = orbsoc_reach(scenario, "--out", out)
    assert refused.returncode == 2
    assert "add --resume" in refused.stderr
    point = "24.3 335.25 100"
    done = orbsoc_reach(scenario, "--out", out, "--resume", "--threads", "2", "--ephemeris", point)
    assert done.returncode == 0, done.stderr
    assert (out / "point.oem").read_text().startswith("CCSDS_OEM_VERS = 3.0")
    assert "SEMI_MAJOR_AXIS" in (out / "point.opm").read_text()
    assert {path: path.stat().st_mtime_ns for path in before} == before
    same_tables(folder, out)


def test_ctrl_c_keeps_the_finished_shards_and_a_resumed_sweep_has_the_same_table(
    solved: tuple[Path, Path, str], tmp_path: Path
) -> None:
    scenario, out = solved[0], tmp_path / "out"
    command = [sys.executable, "-m", "orbsoc", "reach", str(scenario), "--out", str(out), "--threads", "1"]
    with started(command, env=ENVIRONMENT, stderr=subprocess.PIPE) as process:
        deadline = time.monotonic() + 300.0
        while not list(out.glob("boundary/shard=*/part.parquet")) and time.monotonic() < deadline:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _output, words = process.communicate(timeout=120)
    assert process.returncode == 130, words
    assert "finished shards are in" in words
    assert "Traceback" not in words
    kept = {path: path.stat().st_mtime_ns for path in out.rglob("part.parquet")}
    assert kept
    done = orbsoc_reach(scenario, "--out", out, "--resume", "--threads", "2")
    assert done.returncode == 0, done.stderr
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    same_tables(solved[1], out)


def test_a_disk_that_fills_up_while_figures_are_drawn_keeps_the_shards(
    solved: tuple[Path, Path, str], tmp_path: Path
) -> None:
    """A file that cannot be replaced stands for a disk that is full: what fails is named, and --resume repairs it."""
    scenario, folder, _stdout = solved
    out = tmp_path / "copy"
    shutil.copytree(folder, out)
    (out / "band.html").unlink()
    (out / "band.html").mkdir()
    failed = orbsoc_reach(scenario, "--out", out, "--resume")
    assert failed.returncode == 2
    assert "tables and figures cannot be written" in failed.stderr
    assert "Traceback" not in failed.stderr
    (out / "band.html").rmdir()
    done = orbsoc_reach(scenario, "--out", out, "--resume")
    assert done.returncode == 0, done.stderr
    assert (out / "band.html").stat().st_size == (folder / "band.html").stat().st_size


def test_a_folder_that_lacks_shards_is_not_read_as_a_whole(
    solved: tuple[Path, Path, str], tmp_path: Path
) -> None:
    out = tmp_path / "copy"
    shutil.copytree(solved[1], out)
    shutil.rmtree(out / "points" / "shard=0001")
    with pytest.raises(StoreError, match=r"has 3\d of 60 rows of `points`; resume the sweep"):
        orbsoc.reach.load(out)


BAD = {
    "an empty grid": ("inclination_deg", "inclination_deg = { first = 30.0, last = 20.0, step = 1.0 }", "makes the grid empty"),
    "a perigee below the surface": (
        "perigee_height_km", "perigee_height_km = { first = -10.0, last = 20.0, step = 10.0 }", "at or below the surface",
    ),
    "a wrap written as an angle": (
        "raan_deg", "raan_deg = { first = 350.25, last = 10.25, step = 5.0 }", "to pass through 360, write last = 370.25",
    ),
    "planes twice around": ("raan_deg", "raan_deg = { first = 0.0, last = 360.0, step = 10.0 }", "holds planes twice"),
    "no propellant": ("dry_mass_kg", "dry_mass_kg = 160000.0", "leaves no propellant"),
    "a burn longer than the tank": ("duration_s", "duration_s = 3000.0", "burns more than there is"),
    "a step of zero": ("raan_deg", "raan_deg = { first = 330.0, last = 340.0, step = 0.0 }", "greater than 0"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_scenarios_are_refused_and_nothing_is_written(tmp_path: Path, case: str) -> None:
    key, line, words = BAD[case]
    scenario = small_scenario(tmp_path, **{key: line})
    done = orbsoc_reach(scenario, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_scheduler_that_does_not_answer_leaves_no_folder(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="the extra `reach` is not installed")
    done = orbsoc_reach(small_scenario(tmp_path), "--out", tmp_path / "out", "--dask", "tcp://127.0.0.1:9")
    assert done.returncode == 2
    assert "no scheduler answers" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("point", "words"),
    [
        ("24.3 335.25", "must be three numbers"),
        ("24.3 335.25 120", "perigee bound 120 is not on the grid: 100 to 500 in steps of 200"),
    ],
)
def test_a_wrong_point_is_refused_before_anything_is_solved(tmp_path: Path, point: str, words: str) -> None:
    done = orbsoc_reach(small_scenario(tmp_path), "--out", tmp_path / "out", "--ephemeris", point)
    assert done.returncode == 2
    assert words in done.stderr
    assert not (tmp_path / "out").exists()


def test_an_insertion_is_not_a_reachable_domain(tmp_path: Path) -> None:
    done = orbsoc_reach(SCENARIOS / "rec1.toml", "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "mission = 'reachable_insertion'" in done.stderr


def test_a_folder_of_another_scenario_is_left_alone(solved: tuple[Path, Path, str], tmp_path: Path) -> None:
    _scenario, folder, _stdout = solved
    shutil.copytree(folder, tmp_path / "copy")
    other = small_scenario(tmp_path, thrust_n="thrust_n = 260000.0")
    done = orbsoc_reach(other, "--out", tmp_path / "copy", "--resume")
    assert done.returncode == 2
    assert "another scenario" in done.stderr
    assert (tmp_path / "copy" / "summary.json").read_text() == (folder / "summary.json").read_text()


def same_tables(one: Path, other: Path) -> None:
    """Every column of both datasets, attitude programmes included, is identical."""
    left, right = ShardStore.load(one), ShardStore.load(other)
    for dataset in ("points", "boundary"):
        mine, theirs = left.read(dataset), right.read(dataset)
        assert list(mine) == list(theirs)
        for name, values in mine.items():
            for a, b in zip(values, theirs[name], strict=True):
                np.testing.assert_array_equal(a, b, err_msg=name)


def reach_tasks() -> tuple[Scenario, list[Task]]:
    """The grid of the small scenario, as the command cuts it."""
    scenario = load_scenario(small_scenario(Path(tempfile.mkdtemp())))
    shards = enumerate(grid_shards(Domain.of(scenario)))
    return scenario, [Task("points", k, rows, payload) for k, (rows, payload) in shards]


def solved_but_for_a_lost_worker(payload: dict[str, Any]) -> dict[str, np.ndarray]:
    """The real work of a shard; the first time, of the first shard, the worker is killed in the middle of it."""
    flag = Path(payload["flag"])
    if payload["first"] and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return dict(solve_grid_shard({k: v for k, v in payload.items() if k not in ("flag", "first")}))


def unwatched(_report: Report, _task: Task, _columns: Any) -> None:
    pass


@pytest.mark.filterwarnings("ignore")
def test_a_sweep_that_loses_a_dask_worker_has_the_same_table(
    solved: tuple[Path, Path, str], tmp_path: Path
) -> None:
    pytest.importorskip("distributed", reason="the extra `reach` is not installed")
    scenario, tasks = reach_tasks()
    flag = str(tmp_path / "flag")
    fragile = [
        Task(t.dataset, t.number, t.rows, {**t.payload, "flag": flag, "first": t.number == 0}) for t in tasks
    ]
    store = ShardStore.open(tmp_path / "out", scenario.model_dump(mode="json"), resume=False)
    run(store, fragile, solved_but_for_a_lost_worker, DaskCluster(None, workers=1), unwatched)
    assert (tmp_path / "flag").exists()
    shutil.copytree(solved[1] / "boundary", tmp_path / "out" / "boundary")
    same_tables(solved[1], tmp_path / "out")


def test_a_sweep_whose_disk_fills_up_resumes_to_the_same_table(
    solved: tuple[Path, Path, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`solve_into`, the whole of the command's sweep; the third shard finds no space."""
    scenario = load_scenario(solved[0])
    sync, calls = os.fsync, list[int]()

    def full(descriptor: int) -> None:
        calls.append(descriptor)
        if len(calls) == 3:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(descriptor)

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(StoreError, match="No space left on device; finished shards are kept"):
        solve_into(tmp_path / "out", scenario, Processes(1), unwatched)
    monkeypatch.undo()
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("part.parquet")}
    assert len(kept) == 2
    solve_into(tmp_path / "out", scenario, Processes(1), unwatched, resume=True)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    same_tables(solved[1], tmp_path / "out")
