"""The order of elimination on the PL: the fastest that fits is taken, by default and everywhere, and host solves keep theirs."""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchmarks.guidance import rendezvous
from hw_model import Platform, load_platform
from orbsoc import Cones, Problem, PsScheduler, Settings, Solution, Status, solve
from orbsoc.commands import hw_options as options
from orbsoc.commands.app import app
from orbsoc.guidance.scp import Iteration
from orbsoc.hw.cycle_budget import CycleBudget, cycle_budget
from orbsoc.hw.elimination import HOST, ORDERS, OrderedRun, differing_orders, fastest_order, ordered_run
from orbsoc.hw.workload import load_workload
from tests.integration.small_problem import small_problem

CHAINED = rendezvous(12, 0, approach_cone=False)
"""Pivots wait for one another in the host's order."""
WIDE = {"pl.lanes": 8, "pl.dividers": 2, "pl.banks": 32}


@pytest.fixture(scope="module")
def chained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("elimination") / "chained.json"
    CHAINED.save(path)
    return path


def computer(settings: dict[str, int]) -> Platform:
    return load_platform("zu9eg").with_values(settings)


@pytest.mark.parametrize("partition", ["paper", "resident"])
@pytest.mark.parametrize("settings", [{"pl.lanes": 1}, {}, WIDE])
def test_the_default_is_within_five_per_cent_of_the_best_order(
    chained: Path, settings: dict[str, int], partition: str
) -> None:
    platform = computer(settings)

    def run(ordering: str | None) -> OrderedRun:
        work = options.recorded(chained, ordering, platform, partition)
        name = work.settings[0].ordering
        return ordered_run(work, name, platform, partition, options.stage_cycles(work))

    every, found = [run(name) for name in ORDERS], run(None)
    best = min(each.makespan_picoseconds for each in every if each.fits)
    assert found.fits
    assert found.makespan_picoseconds <= 1.05 * best
    assert run("automatic") == found


def test_on_a_wide_engine_the_shallow_tree_is_taken(chained: Path) -> None:
    work = options.recorded(chained, None, computer(WIDE), "resident")
    assert work.settings[0].ordering == "nested_dissection"
    assert work.origin.endswith(", eliminated in the order nested_dissection")
    estimated = options.recorded(chained, None, computer(WIDE), "resident", exact=False)
    assert estimated.settings[0].ordering == "nested_dissection"


def test_what_fits_goes_before_what_is_faster_and_the_host_before_an_equal() -> None:
    slow, fast = OrderedRun(HOST, True, 200), OrderedRun("nested_dissection", False, 100)
    assert min([fast, slow], key=lambda run: run.rank) is slow
    assert min([fast, replace(slow, fits=False)], key=lambda run: run.rank) is fast
    equal = replace(slow, ordering="nested_dissection")
    assert min([equal, slow], key=lambda run: run.rank) is slow


def test_orders_with_the_same_factor_are_not_scheduled_twice(tmp_path: Path) -> None:
    path = tmp_path / "diagonal.json"
    Problem(c=[1.0, 1.0], G=[[-1.0, 0.0], [0.0, -1.0]], h=[-2.0, -1.0], cones=Cones(l=2)).save(path)
    work = load_workload(path)

    def never(*_: object) -> OrderedRun:
        raise AssertionError("there is nothing to choose")

    assert differing_orders(work) == ()
    assert fastest_order(work, never) == HOST


def test_a_trace_and_a_choice_by_hand_stay(chained: Path, tmp_path: Path) -> None:
    made = options.recorded(chained, HOST, computer(WIDE), "resident")
    assert made.settings[0].ordering == HOST
    place = tmp_path / "recorded.json"
    place.write_text(made.trace.model_dump_json(by_alias=True), encoding="utf-8")
    CHAINED.save(tmp_path / "pattern_0.json")
    again = options.recorded(place, None, computer(WIDE), "resident")
    assert again.settings[0].ordering == HOST


def budget_of(answer: Solution, partition: str = "resident") -> CycleBudget:
    row = Iteration(1, 1e-8, CHAINED, answer, 0.0, 0.0, {})
    return cycle_budget(
        [row], device="zu9eg", partition=partition, deadline_ms=None, verified=True, exact=True
    )


def test_a_plan_is_priced_in_the_faster_order_against_the_core_in_its_own() -> None:
    answer = solve(CHAINED, tol=1e-8)
    found = budget_of(answer)
    assert found.same_bits
    assert (found.ordering, found.summary()["ordering"]) == ("nested_dissection", "nested_dissection")
    assert "eliminated in the order nested_dissection" in found.headline
    alone = budget_of(answer, "all_ps")
    assert alone.ordering == HOST
    assert found.report.baseline_ms == alone.report.makespan_ms
    assert Settings().ordering == HOST


def test_a_plan_that_ends_otherwise_in_the_other_order_is_priced_in_the_hosts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole: Callable[..., Solution] = PsScheduler.__call__

    def other(self: PsScheduler, *arguments: object, **options: object) -> Solution:
        found = whole(self, *arguments, **options)
        return found if self._ordering is None else replace(found, status=Status.NUMERICAL_LIMIT)

    monkeypatch.setattr(PsScheduler, "__call__", other)
    assert budget_of(solve(CHAINED, tol=1e-8)).ordering == HOST


def test_a_point_of_a_sweep_is_the_faster_order_and_an_axis_has_both(chained: Path, tmp_path: Path) -> None:
    def rows(axis: str) -> list[dict[str, str]]:
        file, folder = tmp_path / "sweep.toml", tmp_path / "out"
        file.write_text(f"[axes]\n{axis}partition = ['resident']\n'pl.lanes' = [2, 8]\n", encoding="utf-8")
        result = CliRunner().invoke(
            app, ["hw", "sweep", str(file), str(chained), "--out", str(folder)], catch_exceptions=False
        )
        assert result.exit_code == 0, result.output
        with (folder / "sweep.csv").open(encoding="utf-8") as text:
            return list(csv.DictReader(text))

    chosen, every = rows(""), rows("ordering = ['amd', 'nested_dissection']\n")
    assert (len(chosen), len(every)) == (2, 4)
    for row in chosen:
        same = [each for each in every if each["lanes"] == row["lanes"]]
        best = min(same, key=lambda each: float(each["time_ms"]))
        assert (row["ordering"], row["time_ms"]) == (best["ordering"], best["time_ms"])
        baselines = {float(each["speedup"]) * float(each["time_ms"]) for each in same}
        assert max(baselines) == pytest.approx(min(baselines))


@pytest.mark.parametrize(
    ("axis", "says"),
    [
        ("ordering = ['metis']", "`axes.ordering` = 'metis': allowed are amd, nested_dissection"),
        ("ordering = [1]", "`axes.ordering` = [1]: must be a list of names"),
    ],
)
def test_an_axis_of_orders_that_the_solver_does_not_know_is_refused(
    tmp_path: Path, axis: str, says: str
) -> None:
    file, problem = tmp_path / "sweep.toml", tmp_path / "small.json"
    small_problem().save(problem)
    file.write_text(f"[axes]\n{axis}\n", encoding="utf-8")
    result = CliRunner().invoke(app, ["hw", "sweep", str(file), str(problem), "--out", str(tmp_path)])
    assert result.exit_code == 2
    assert says in result.output + result.stderr
