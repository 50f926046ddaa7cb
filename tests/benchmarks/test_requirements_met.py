"""From measurements to verdicts: what holds, what does not, and what was not measured."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import phases, requirements, warm
from benchmarks.batch_measure import BatchTimes, Loop, measure_batch
from benchmarks.batch_measure import table as batch_table
from benchmarks.batches import Batch
from benchmarks.compare import least
from benchmarks.guidance import powered_descent
from benchmarks.measure import Measurement, Spread
from benchmarks.overhead import Overhead, measure_overhead
from benchmarks.peer_comparison import comparisons, median_residual
from benchmarks.peers import solvers
from benchmarks.phases import Results
from benchmarks.records import from_json, to_json
from benchmarks.results import main as results_command
from benchmarks.results_page import family_table, page, ratio_table
from benchmarks.warm import WarmStart
from orbsoc.conic.verify import Verification


def measurement(
    solver: str,
    us: float,
    *,
    group: str = "g",
    problem: str = "p",
    iterations: int = 10,
    residual: float = 1e-9,
) -> Measurement:
    spread = Spread(us, us, us)
    failure = "" if residual <= 1e-7 else "not verified"
    found = Verification(residual, 0.0, 0.0)
    return Measurement(
        problem, group, 5, 2, 3, solver, "", "solved", iterations, found, spread, spread, spread, failure
    )


def results(**changes: object) -> Results:
    families = {
        "powered_descent": [
            measurement("orbsoc", 10.0, group="small", problem="a"),
            measurement("ECOS", 30.0, group="small", problem="a", residual=1e-8),
            measurement("QOCO", 5.0, group="small", problem="a", residual=1.0),
            measurement("orbsoc", 10.0, group="large", problem="b", iterations=12),
            measurement("Clarabel", 14.0, group="large", problem="b", residual=1e-8),
        ]
    }
    empty = Results({"date": "d", "machine": "m", "commit": "c", "solvers": "s"}, families, [], [], None, [])
    header = {**empty.header, "tolerance": "1e-8", "repeats": "3"}
    return replace(empty, header=header, **changes)  # type: ignore[arg-type]


def rows(found: Results, number: str) -> list[requirements.Requirement]:
    return [row for row in requirements.requirements(found) if row.number == number]


def test_a_group_is_compared_with_the_best_peer_that_verifies() -> None:
    small, large = comparisons(results().families["powered_descent"], requirements.CONIC)
    assert (small.best, small.ratio) == ("ECOS", 3.0)  # QOCO's answer does not count
    assert (large.best, large.ratio) == ("Clarabel", pytest.approx(1.4))
    assert large.iteration_ratio == pytest.approx(1.2)
    assert small.iteration_ratio != small.iteration_ratio  # no reference there


def test_each_size_and_the_mean_of_all_are_judged() -> None:
    each, mean, generated = rows(results(), "1")
    assert (each.holds, mean.holds, generated.holds) == (False, True, None)
    assert "least 1.40 × (large); 1 of 2 below" in each.measured
    assert mean.measured == f"{np.sqrt(3.0 * 1.4):.2f} ×"


def test_iterations_are_the_mean_of_the_families_ratios() -> None:
    [row] = rows(results(), "5")
    assert (row.holds, row.measured.split()[0]) == (False, "1.200")


def test_residuals_are_compared_with_the_median_peer() -> None:
    members = results().families["powered_descent"]
    assert median_residual(members, ["ECOS", "Clarabel", "QOCO"]) == 1e-8
    [row] = rows(results(), "1–4")
    assert row.holds
    worse = {"x": [measurement("orbsoc", 1.0, residual=5e-8), measurement("ECOS", 1.0, residual=1e-8)]}
    [row] = rows(results(families=worse), "1–4")
    assert not row.holds
    assert "x (5.0e-08, median peer 1.0e-08)" in row.measured


def test_the_time_of_large_cones_must_be_linear_in_them() -> None:
    def cones(power: float) -> dict[str, list[Measurement]]:
        return {
            "large_cones": [
                m
                for d in (61, 531, 2475)
                for m in (
                    measurement("orbsoc", d**power, group=f"one cone of {d}", problem=f"{d}"),
                    measurement("Clarabel", 2.0 * d**power, group=f"one cone of {d}", problem=f"{d}"),
                )
            ]
        }

    assert [row.holds for row in rows(results(families=cones(1.0)), "4")] == [True, True]
    assert [row.holds for row in rows(results(families=cones(1.5)), "4")] == [True, False]


def test_a_batch_is_judged_by_the_peers_that_solve_all_of_it() -> None:
    loops = (Loop("hasty", 1.0, 1.0, 63), Loop("QOCO", 70.0, 90.0, 64), Loop("ECOS", 80.0, 85.0, 64))
    batch = BatchTimes("b", "scp", 64, 10.0, 64, 1e-9, 2.0, 20.0, loops)
    assert (batch.best, batch.ratio, batch.total_ratio) == (loops[1], 7.0, 7.5)
    [row] = rows(results(batches=[batch]), "2")
    assert row.holds
    assert "7.00 × (SCP 7.00; with all set-ups 7.50)" in row.measured
    assert "| b | 64 of 64 | 10.0 | 20.0 | 70.0 (QOCO) | 7.00 | 7.50 |" in batch_table([batch])
    assert BatchTimes.from_record(json.loads(json.dumps(asdict(batch)))) == batch


def test_a_batch_is_measured_beside_loops_over_the_same_problems() -> None:
    found, _ = solvers(("orbsoc", "clarabel"))
    make = Batch("b", "scp", lambda: [powered_descent(5, seed) for seed in range(4)])
    batch = measure_batch(make, found, repeats=1, tol=1e-8)
    assert (batch.size, batch.verified, batch.loops[0].verified) == (4, 4, 4)
    assert batch.residual <= 1e-7
    assert 0.0 < batch.loops[0].solve_us < batch.loops[0].total_us


def test_warm_starts_are_judged_by_mean_worst_and_fall_backs() -> None:
    good = WarmStart("g", "sequence", "step", cold=10, warm=5, fell_back=False, verified=True)
    sequence, perturbed = rows(results(warm=[good] * 10), "6")
    assert (sequence.holds, perturbed.holds) == (True, None)
    for bad in (
        replace(good, warm=12),
        replace(good, verified=False),
        replace(good, warm=200, cold=200),
    ):
        assert not rows(results(warm=[good, bad]), "6")[0].holds
    assert not rows(results(warm=[good, replace(good, fell_back=True)]), "6")[0].holds


def test_warm_starts_are_measured_where_the_build_has_them() -> None:
    found = warm.measure_warm(1e-8, quick=True)
    assert bool(found) == warm.available()
    assert all(row.verified for row in found)


def test_pairs_for_warm_starts_share_their_pattern() -> None:
    steps = list(warm._steps(quick=True))
    assert len(steps) >= 6
    for _, _, before, after in [*steps, *warm._changes(quick=True)]:
        for name in ("P", "A", "G"):
            assert np.array_equal(getattr(before, name).indices, getattr(after, name).indices)


def test_overhead_is_what_python_adds() -> None:
    found = measure_overhead(repeats=5)
    assert found.numbers == 297
    assert 0.0 < found.solve_us < found.both_us
    assert Overhead.from_record(json.loads(json.dumps(asdict(found)))) == found
    [row] = rows(results(overhead=replace(found, both_us=9.0)), "9")
    assert row.holds


def test_measurements_come_back_from_their_file() -> None:
    members = [*results().families["powered_descent"], measurement("SCS", 100.0 / 3.0, residual=math.inf)]
    header, found = from_json(to_json({"date": "d"}, members))
    assert header == {"date": "d"}
    assert found == members
    with pytest.raises(ValueError, match=r"other.*orbsoc.bench/1"):
        from_json('{"schema": "other"}')


def test_the_page_has_the_requirements_and_every_table() -> None:
    found = results()
    text = page(found, {"all": "figures/p.png"})
    assert "| 1 | one SCP-type SOCP" in text
    assert "![Performance profiles, all](figures/p.png)" in text
    assert "| powered_descent | 3.00 (3.00) | – | 1.40 (1.40) |" in ratio_table(found.families)
    assert "| powered_descent | 2 of 2 | 12.00 | 10.00 | 1.200 | 1.0e-09 | 1.0e-08 |" in family_table(
        found.families
    )


def test_of_two_commits_each_line_is_the_run_where_its_median_was_least() -> None:
    head = "# label: x\nproblem,part,calls,median_us\n"
    merged = least([head + "a,solve,1,5.0\na,setup,1,1.0\n", head + "a,solve,1,4.0\na,setup,1,2.0\n"])
    assert merged == "problem,part,calls,median_us\na,solve,1,4.0\na,setup,1,1.0\n"


def test_the_command_measures_writes_and_does_not_measure_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    one = Batch("one", "scp", lambda: [powered_descent(5, seed) for seed in range(2)])
    monkeypatch.delenv("ORBSOC_PROBLEMS", raising=False)
    monkeypatch.setattr(phases, "BATCHES", {"one": one})
    monkeypatch.setattr(phases, "DEFAULT", ("orbsoc", "clarabel"))
    monkeypatch.setattr(phases, "measure_warm", lambda tol, quick: [])
    monkeypatch.setattr(phases, "measure_overhead", lambda: measure_overhead(repeats=3))
    command = ["--quick", "--family", "small_lp", "--out", str(tmp_path)]
    assert results_command(command) == 0
    assert "| 5 | mean iterations" in capsys.readouterr().out
    text = (tmp_path / "results.md").read_text()
    assert "### small_lp" in text
    monkeypatch.setattr(phases, "measure", None)  # a second run needs none
    monkeypatch.setattr(phases, "measure_batch", None)
    assert results_command(command) == 0
    again = (tmp_path / "results.md").read_text()
    assert again.splitlines()[6:] == text.splitlines()[6:]
