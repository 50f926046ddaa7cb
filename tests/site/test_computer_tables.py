"""Tables of docs/hardware-model.md and docs/hardware-experiments.md of devices, throughput, precision and the five missions on NG-Ultra
are those of the commands that the pages name. Answers that miss the tolerance are held by their word alone: they follow the last bits."""

from __future__ import annotations

import csv
import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import orbsoc
from benchmarks.guidance import rendezvous
from hw_model import load_partition, load_platform, parse_trace, speedup
from hw_model.area.budget import budget
from hw_model.platform.parameter import Parameter
from hw_model.platform.platform import Platform
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.exact_cycles import exact_cycles
from scripts.write_mpc_problem import in_three_axes, mpc
from tests.printed import NUMBER, near
from tests.site.test_numbers import missing, numbers_of
from tests.site.test_schedule_tables import rows

ROOT = Path(__file__).resolve().parents[2]
SCENARIOS = ROOT / "scenarios"
MODEL, EXPERIMENTS = "hardware-model.md", "hardware-experiments.md"


def run(tmp_path: Path, *words: str) -> list[dict[str, str]]:
    """The table that an `orbsoc hw` command writes."""
    command = [sys.executable, "-m", "orbsoc", "hw", *words, "--out", str(tmp_path / "run")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "run" / f"{words[0]}.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def band(parameter: Parameter[Any], digits: int) -> str:
    """As the page prints one; a number alone where it has no band."""
    if parameter.low is None or parameter.high is None:
        return f"{parameter.value:.{digits}f}"
    return f"{parameter.value:.{digits}f} ({parameter.low:.{digits}f}–{parameter.high:.{digits}f})"


@pytest.mark.parametrize("row", rows(MODEL, "| name | PS | clock, MHz"), ids=lambda row: row[0].strip("`"))
def test_a_device_is_as_the_page_says(row: list[str]) -> None:
    name, ps, clock, rate, size = row
    machine: Platform = load_platform(name.strip("`"))
    assert ps.startswith(f"{machine.ps.cores.value} ×")
    assert clock.removesuffix(", a name") == band(machine.ps.clock_mhz, 0)
    assert rate == band(machine.ps.flop_per_cycle, 3 if name == "`rocket_soc`" else 2)
    if size == "no limit":
        return
    found = [getattr(machine.resources, kind).value for kind in ("lut", "ff", "dsp", "bram36")]
    if size.startswith("as `xc7z045`"):
        other = load_platform("xc7z045").resources
        assert found == [getattr(other, kind).value for kind in ("lut", "ff", "dsp", "bram36")]
        return
    stated = re.findall(r"\d[\d ]*\d", size.replace("(of four inputs)", ""))
    assert [int(number.replace(" ", "")) for number in stated] == found


@pytest.mark.parametrize("row", rows(MODEL, "| engine | microcode of all | stays"), ids=lambda row: row[0])
def test_programs_of_a_plan(row: list[str], tmp_path: Path) -> None:
    lanes, banks, form = re.fullmatch(r"(\d+) lanes, (\d+) banks, (\w+)", row[0]).groups()  # type: ignore[union-attr]
    engine = (f"pl.lanes={lanes}", f"pl.banks={banks}", f"pl.microcode_format={form}")
    command = [
        sys.executable, "-m", "orbsoc", "hw", "trace", str(SCENARIOS / "paper003_socp.toml"), "--partition", "resident",
        *(word for one in engine for word in ("--set", one)), "--out", str(tmp_path / "run"),
    ]  # fmt: skip
    printed = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    microcode, stays, loads, of_the_run = row[1:]
    stated = " ".join((microcode.split(",")[0], stays, loads if loads != "0" else "", of_the_run))
    assert missing(stated, list(numbers_of(printed))) == [], printed
    assert (loads == "0") == ("stay together" in printed)


STREAMED: dict[str, Callable[[], Problem]] = {
    "MPC, 40 steps": lambda: in_three_axes(40),
    "rendezvous, 60 steps": lambda: rendezvous(60, 0, approach_cone=False),
}


@pytest.mark.parametrize("name", STREAMED)
def test_streamed_engines(name: str) -> None:
    """With what holds the microcode in block RAM they do not fit."""
    scheduler, resident = PsScheduler(), load_partition("resident")
    assert scheduler(STREAMED[name](), Settings(ordering="nested_dissection")).status is Status.SOLVED
    trace = parse_trace(scheduler.trace)
    cycles = exact_cycles(scheduler.patterns, settings=scheduler.pattern_settings)
    problem, held = "", 0
    for first, engine, in_all, streamed, bram36, nearest, time, _ in rows(
        MODEL, "| problem | lanes, dividers"
    ):
        problem = first or problem
        if problem != name:
            continue
        shape, _, depth = engine.partition("; ")
        lanes, dividers, clusters = map(int, shape.split(", "))
        one = load_platform("zu9eg").with_values({
            "pl.lanes": lanes, "pl.dividers": dividers, "pl.clusters": clusters, "pl.banks": 16 if lanes == 4 else 32,
            "pl.storage_depth": "exact" if depth == "exact depth" else "power_of_two",
        })  # fmt: skip
        loaded = budget(trace, one, resident, cycles)
        assert not loaded.fits
        assert loaded.microcode_bram36 == int(in_all.replace(" ", ""))
        platform = one.with_values({
            "pl.microcode_memory": "streamed", "pl.stream_ports": lanes // 4, "pl.stream_bytes_per_cycle": 16.0,
        })  # fmt: skip
        found = budget(trace, platform, resident, cycles)
        assert found.fits
        assert found.microcode_bram36 == int(streamed)
        assert next(use.used for use in found.uses if use.kind == "bram36") == int(bram36)
        tightest = {"bram36": "block RAM", "lut": "LUT"}[found.tightest.kind]
        assert nearest == f"{tightest}, {100 * found.tightest.share / found.tightest.ceiling:.0f} %"
        made = speedup(trace, platform, "resident", cycles=cycles).makespan_ms
        assert time == f"{made.nominal:.3f} ({made.low:.2f}–{made.high:.2f})"
        held += 1
    assert held == 2


def fly_around_cells() -> list[tuple[str, str, str]]:
    """Partition, device and cell of the first problem's two rows."""
    devices = ("zu9eg", "zu7ev", "k26", "xc7z045")
    return [
        (partition.strip("`"), device, cell)
        for _, partition, *cells in rows(MODEL, "| problem | partition | ZU9EG")[:2]
        for device, cell in zip(devices, cells, strict=True)
        if cell
    ]


@pytest.mark.parametrize(("partition", "device", "cell"), fly_around_cells())
def test_what_would_hold_the_fly_around(partition: str, device: str, cell: str, tmp_path: Path) -> None:
    command = [
        sys.executable, "-m", "orbsoc", "hw", "budget", str(SCENARIOS / "paper001_fewest.toml"), "--device", device,
        "--partition", partition, "--set", "pl.clock_mhz=150", "--out", str(tmp_path / "run"),
    ]  # fmt: skip
    printed = subprocess.run(command, capture_output=True, text=True, check=False).stdout
    assert " 5 programs" in printed
    workload = json.loads((tmp_path / "run" / "budget.json").read_text(encoding="utf-8"))["workload"]
    (solves,) = re.findall(
        r"fly-around, a plan \((\d+) solves, five patterns", (ROOT / "docs" / MODEL).read_text("utf-8")
    )
    assert f"({solves} solves," in workload
    if cell.startswith("fits"):
        (share,) = re.findall(r"(\d+) % of its ceiling", cell)
        used = re.search(r"^bram36 .* ([\d.]+) % +80 %", printed, re.MULTILINE)
        assert used
        assert near(share, str(float(used[1]) / 0.8))
        assert ": FITS" in printed
        return
    (time,) = re.findall(r"([\d.]+) ms", cell)
    would = dict(re.findall(r"^would fit: (.*): ([\d.]+) ms", printed, re.MULTILINE))
    words = (
        "streamed_start" if "start streamed" in cell else "best (" if "best" in cell else "streamed",
        "ultra_ram" * ("UltraRAM" in cell),
    )
    assert any(near(time, made) and all(word in how for word in words) for how, made in would.items()), would


SHAPE = re.compile(r"(\d) of (\d+) lanes(?:, (\d+) dividers)?(?:, (\d+) clusters)?")


def hold_throughput(
    head: str, found: list[dict[str, str]], relative: float
) -> dict[tuple[int, ...], dict[str, str]]:
    by_set = {
        tuple(int(row[key]) for key in ("engines", "lanes", "dividers", "clusters", "interleaved")): row
        for row in found
    }
    for engines, interleaved, a_second, gain, *_, tightest in rows(MODEL, head):
        match = SHAPE.fullmatch(engines)
        assert match
        one = by_set[*(int(number or 1) for number in match.groups()), int(interleaved)]
        assert one["fits"] == "True"
        assert near(a_second.replace(" ", ""), f"{float(one['solves_per_s']):.0f}", relative)
        assert near(NUMBER.findall(gain)[0], f"{float(one['gain']):.6f}", relative)
        share = NUMBER.findall(tightest)[0] if "%" in tightest else ""
        assert share == f"{100 * float(one['share']):.0f}"
        assert tightest.lower().startswith(
            {"bram36": "block ram"}.get(one["tightest"], one["tightest"]),
        )
    return by_set


def test_throughput_of_predictive_control(tmp_path: Path) -> None:
    """Schedules and one solve of a problem that is given: the same everywhere."""
    mpc().save(tmp_path / "mpc.json")
    head = "| engines | interleaved in each | solves/s | over four cores, by operations"
    found = hold_throughput(head, run(tmp_path, "throughput", "mpc.json"), 0.001)
    wide = found[1, 16, 4, 8, 8]
    assert wide["fits"] == "False"
    assert f"(16 lanes, 8 problems: {float(wide['gain']):.2f})" in (ROOT / "docs" / MODEL).read_text(
        encoding="utf-8"
    )


def test_throughput_of_the_fly_around(tmp_path: Path) -> None:
    words = (
        "throughput", str(SCENARIOS / "paper001_fewest.toml"), "--pattern", "most", "--set", "pl.clock_mhz=150",
        "--set", "ps.price=executed_instructions",
    )  # fmt: skip
    head = "| engines | interleaved in each | solves/s | over four cores | tightest"
    hold_throughput(head, run(tmp_path, *words), 0.01)


PRECISION = {"mission 004": "rec1.toml", "rendezvous": "rendezvous_lp.json"}


def precision_rows() -> dict[str, list[list[str]]]:
    """The rows of each problem's file."""
    of: dict[str, list[list[str]]] = {"rendezvous_40.json": rows(EXPERIMENTS, "\n| bits | narrow modules")}
    name = ""
    for problem, *row in rows(EXPERIMENTS, "| problem | bits | narrow modules"):
        name = PRECISION.get(problem, name)
        of.setdefault(name, []).append(row)
    return of


@pytest.mark.parametrize(("file", "stated"), precision_rows().items())
def test_precision(file: str, stated: list[list[str]], tmp_path: Path) -> None:
    found = run(tmp_path, "precision", str(SCENARIOS / file), "--set", "pl.clock_mhz=210")
    assert len(stated) == len(found) == 8
    for (bits, modules, status, *figures, dsp), one in zip(stated, found, strict=True):
        named = one["narrow_modules"].replace("+", " and ").replace("_", " ")
        assert (bits, modules.strip("()"), dsp) == (one["bits"], named, one["dsp"])
        if status != "SOLVED":
            assert one["reached"] == "False"
            continue
        worst = max(float(one[key]) for key in ("primal_residual", "dual_residual", "gap"))
        made = [one["iterations"], one["refinements"], f"{worst:.1e}", one["pl_cycles"], one["modelled_ms"]]
        assert one["status"] == status
        assert all(map(near, (each.replace(" ", "") for each in figures), made)), (figures, made)


@pytest.mark.parametrize("row", rows(MODEL, "| scenario | fastest | ms (band)"), ids=lambda row: row[0].strip("`"))  # fmt: skip
def test_a_mission_on_ng_ultra(row: list[str]) -> None:
    scenario, fastest, *figures, verdict = row
    made = orbsoc.plan(
        SCENARIOS / f"{scenario.strip('`')}.toml", device="ng_ultra", partition="best", deadline_ms=250.0
    ).to_dict()["hardware"]
    assert made["verdict"] == verdict
    assert made["partition"] == f"best ({'all_ps' if fastest == 'the PS alone' else fastest.strip('`')})"
    assert missing(" ".join(figures).replace("–", " ").replace("(", "").replace(")", ""), list(numbers_of(made["headline"]))) == []  # fmt: skip
