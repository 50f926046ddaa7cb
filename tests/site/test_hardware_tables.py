"""Tables of the hardware guides are those of a run: times of rec1; by `make long` quantiles and every mission."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from hw_model import load_partition, load_platform, speedup
from hw_model.platform.platform import Platform, platform_names
from hw_model.report.quantiles import speedup_quantiles
from orbsoc.hw.exact_cycles import exact_cycles
from orbsoc.hw.workload import Workload, load_workload
from tests.printed import NUMBER, near, shows

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "docs" / "hardware-experiments.md").read_text(encoding="utf-8")
LANES = (4, 8, 16)


def rows(head: str) -> list[str]:
    """The lines of the table whose head begins so, below its rule."""
    lines = TEXT[TEXT.index(head) :].splitlines()
    return [
        one for one, _ in pairwise(lines[2 : 2 + next(k for k, line in enumerate(lines[2:]) if not line) + 1])
    ]


def numbers(text: str) -> list[str]:
    return NUMBER.findall(text)


@pytest.fixture(scope="module")
def rec1() -> Workload:
    return load_workload(ROOT / "scenarios" / "rec1.toml", "amd")


def hold(stated: str, found: list[float]) -> None:
    assert len(numbers(stated)) == len(found)
    assert all(map(near, numbers(stated), [f"{value:.9g}" for value in found])), (stated, found)


def test_times_of_the_partitions_on_three_engines(rec1: Workload) -> None:
    cycles = exact_cycles(rec1.problems, (), rec1.settings)
    for row in rows("| partition | 4 lanes"):
        name, *cells = (cell.strip(" `") for cell in row.strip("|").split("|"))
        for lanes, cell in zip(LANES, cells, strict=True):
            machine = load_platform("zu9eg").with_values(
                {"pl.lanes": lanes, "pl.clock_mhz": 150.0, "pl.dividers": 1}
            )
            report = speedup(rec1.trace, machine, name, cycles=cycles)
            hold(cell, [report.makespan_ms.nominal, report.speedup.nominal])


FOUR_DIVIDERS = {
    "rec1.toml amd": "With four dividers `resident` takes # ms on 8 lanes and # on 16;",
    "rendezvous_40.json nested_dissection": "takes # ms on 8 lanes with four dividers and # on 16",
}
"""By problem and order what the page says of its times at 150 MHz."""


@pytest.mark.parametrize("problem", FOUR_DIVIDERS)
def test_times_with_four_dividers(problem: str) -> None:
    scenario, order = problem.split()
    work = load_workload(ROOT / "scenarios" / scenario, order)
    cycles = exact_cycles(work.problems, (), work.settings)
    shown = re.search(re.escape(FOUR_DIVIDERS[problem]).replace(r"\#", r"([\d.]+)"), " ".join(TEXT.split()))
    assert shown
    for lanes, stated in zip((8, 16), shown.groups(), strict=True):
        machine = load_platform("zu9eg").with_values(
            {"pl.lanes": lanes, "pl.clock_mhz": 150.0, "pl.dividers": 4}
        )
        hold(stated, [speedup(work.trace, machine, "resident", cycles=cycles).makespan_ms.nominal])


def band_rows() -> Iterator[tuple[str, Platform, list[str]]]:
    """Partition, device and cells of each row of the second table."""
    prices = {"operations": "flop_per_cycle", "executed instructions": "executed_instructions"}
    for row in rows("| partition | price of the core"):
        name, price, *cells = (cell.strip(" `") for cell in row.strip("|").split("|"))
        yield name, load_platform("zu9eg").with_value("ps.price", prices[price]), cells


def test_bands(rec1: Workload) -> None:
    cycles = exact_cycles(rec1.problems, (), rec1.settings)
    for name, machine, cells in band_rows():
        found = speedup(rec1.trace, machine, name, cycles=cycles).speedup
        hold(" ".join(cells[:3]), [found.nominal, found.low, found.high, found.high / found.low])


def test_quantiles(rec1: Workload) -> None:
    cycles = exact_cycles(rec1.problems, (), rec1.settings)
    for name, machine, cells in band_rows():
        drawn = speedup_quantiles(rec1.trace, machine, load_partition(name), cycles=cycles, draws=300)
        hold(cells[3], [drawn.low, drawn.nominal, drawn.high])


def test_every_mission(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "benchmarks.computer", "--out", str(tmp_path)]
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    made = [line for line in printed.splitlines() if re.match(r"\| (?!mission|---)", line)]
    shown = rows("| mission | solves |")
    assert len(shown) == 18
    assert all(map(shows, shown, made[: len(shown)]))


def test_the_papers_partition_is_beaten_on_as_many_computers_as_the_page_says(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "orbsoc", "hw", "partition", "scenarios/rec1.toml", "--all"]
    done = subprocess.run(
        [*command, "--out", str(tmp_path)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    verdict = (
        r"Pareto-optimal on 0 of (\d+) computers; it is beaten on (\d+), on (\d+) of them over the whole band"
    )
    found = re.search(verdict, done.stdout)
    assert found
    computers, beaten, over_the_band = found.groups()
    assert computers == beaten
    said = f"none of {computers} computers; another is better on all of them, on {over_the_band} over the whole band"
    assert said in " ".join(TEXT.split())
    priced = re.search(r": (\d+) configurations", done.stdout)
    assert priced
    assert f"{int(priced[1]):,} configurations".replace(",", " ") in TEXT


def test_the_page_counts_the_computers_of_all_platforms() -> None:
    """On four numbers of lanes at three clocks."""
    assert f"none of {12 * len(platform_names())} computers" in " ".join(TEXT.split())


DESIGNS = {
    "rec1.toml --memories block_ram,streamed": ("The paper's design takes", "time fastest smallest share"),
    "rendezvous_40.json": ("There the paper's design takes", "time alone share fastest"),
}
"""By search, where the page tells of it, and what the numbers there are."""


@pytest.mark.parametrize(("search", "told"), DESIGNS.items(), ids=["rec1", "rendezvous"])
def test_where_the_papers_design_lies(search: str, told: tuple[str, str], tmp_path: Path) -> None:
    command = [sys.executable, "-m", "orbsoc", "hw", "design", *search.split(), "--out", str(tmp_path)]
    subprocess.run(command, cwd=ROOT / "scenarios", capture_output=True, check=True)
    found = json.loads((tmp_path / "design.json").read_text(encoding="utf-8"))
    standing = found["paper"]
    figures = {
        "time": standing["paper"]["time_ms"],
        "fastest": standing["fastest"]["time_ms"],
        "alone": found["baseline_ms"],
        "share": 100.0 * standing["paper"]["area_share"],
        "smallest": 100.0 * standing["smallest"]["area_share"],
    }
    said, names = told
    stated = numbers(TEXT[TEXT.index(said) :])[:4]
    assert all(map(near, stated, [f"{figures[name]:.9g}" for name in names.split()])), (stated, figures)


CASES = {
    "zu9eg": "interior-point iterations, (# to #) ms nominally and at worst (#) ms: (WORD) at (#) ms, which is (#) ms short of that",
    "xc7z045": "they take (# to #) ms and at worst (#) ms: (WORD) at (#) ms with (#) ms to spare",
}
"""What the page says of its two commands."""


def test_dispersed_cases(tmp_path: Path) -> None:
    commands = re.findall(r"^orbsoc (plan \S+ --cases .*) --out", TEXT, re.MULTILINE)
    assert len(commands) == len(CASES)
    for words, (device, sentence) in zip(commands, CASES.items(), strict=True):
        command = [sys.executable, "-m", "orbsoc", *words.split(), "--out", str(tmp_path)]
        subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
        found = json.loads((tmp_path / "deadline.json").read_text(encoding="utf-8"))
        assert found["device"] == device
        told = re.search(sentence.replace("#", r"[\d.]+\d").replace("WORD", "[A-Z]+"), " ".join(TEXT.split()))
        assert told
        nominal, worst, verdict, deadline, margin = told.groups()
        hold(nominal, [found["time_ms"]["min"], found["time_ms"]["max"]])
        hold(worst, [found["worst_ms"]["max"]])
        hold(deadline, [found["deadline_ms"]])
        hold(margin, [abs(found["margin_ms"])])
        assert found["verdict"] == verdict
        assert (found["margin_ms"] < 0) == ("short" in sentence)
        iterations = [int(each) for each in found["ipm_iterations"]]
        assert f"take {min(iterations)} to {max(iterations)} interior-point iterations" in TEXT
        if device == "zu9eg":
            ((many, most),) = re.findall(r"(\d+) of them take at most ([\d.]+) ms at worst", TEXT)
            assert sum(case["worst_ms"] <= float(most) for case in found["cases"]) == int(many)
