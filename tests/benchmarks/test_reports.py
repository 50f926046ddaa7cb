"""From answers to tables: what counts, what is compared, and what is said of it."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from benchmarks.answer import Answer, Solver, Variant
from benchmarks.families import Instance
from benchmarks.measure import Measurement, Spread, measure, undisturbed
from benchmarks.profile_figure import factors
from benchmarks.records import to_csv, to_json
from benchmarks.run import insert
from benchmarks.tables import comparison_table, group_table
from benchmarks.verdict import verdict
from orbsoc.conic.problem import Cones, Problem


@pytest.fixture(autouse=True)
def _a_quiet_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    """Times here are made up: no context switch may scale them."""
    monkeypatch.setattr("benchmarks.measure.forced_switches", lambda: 0)


PROBLEM = Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=Cones(1))
RIGHT = np.array([2.0]), np.zeros(0), np.array([1.0])
WRONG = np.array([2.1]), np.zeros(0), np.array([1.0])


def solver(name: str, *variants: tuple[str, tuple[np.ndarray, ...], float]) -> Solver:
    """One that gives the same answer, and the same solve time in µs, every time."""

    def variant(label: str, point: tuple[np.ndarray, ...], time_us: float) -> Variant:
        return Variant(label, lambda problem, tol: Answer(*point, "solved", 7, 1e-6, time_us * 1e-6))

    return Solver(name, "1", tuple(variant(*v) for v in variants))


def measured(*solvers: Solver) -> list[Measurement]:
    return measure([Instance("a", "g", PROBLEM)], solvers, repeats=3, tol=1e-8)


def test_the_first_variant_that_verifies_is_timed() -> None:
    [found] = measured(solver("s", ("", WRONG, 1.0), ("careful", RIGHT, 5.0), ("more careful", RIGHT, 9.0)))
    assert (found.variant, found.counts) == ("careful", True)
    assert found.solve == pytest.approx(Spread(5.0, 5.0, 5.0))
    assert found.total.median == pytest.approx(6.0)


def test_a_time_without_a_verified_answer_does_not_count() -> None:
    ours, wrong = measured(solver("orbsoc", ("", RIGHT, 5.0)), solver("hasty", ("", WRONG, 1.0)))
    assert ours.counts
    assert not wrong.counts
    assert "verified residual" in wrong.failure
    assert "not verified (says: solved), so no time" in group_table([ours, wrong])
    assert "hasty" not in comparison_table([ours, wrong])
    assert factors([ours, wrong])["hasty"][0] == np.inf


def test_iterations_that_differ_between_cold_solves_do_not_count() -> None:
    counts = iter(range(100))
    wandering = Variant("", lambda problem, tol: Answer(*RIGHT, "solved", next(counts), 1e-6, 1e-6))
    [found] = measured(Solver("s", "1", (wandering,)))
    assert "iterations differ" in found.failure


def test_the_verdict_names_each_requirement_that_fails() -> None:
    rows = measured(
        solver("orbsoc", ("", RIGHT, 5.0)),
        solver("Clarabel", ("", RIGHT, 6.0)),
        solver("ECOS", ("", RIGHT, 4.0)),
    )
    text = verdict(rows)
    assert "**does not hold**: solve time" in text
    assert "1 of 2 pairs; not a (5 µs, ECOS 4 µs)" in text
    assert "7.00 against 7.00, 1.00 ×" in text
    slower = [replace(m, iterations=9) if m.solver == "orbsoc" else m for m in rows]
    assert "**does not hold**: mean iterations" in verdict(slower)


def test_factors_are_of_the_fastest_that_counts() -> None:
    rows = measured(
        solver("a", ("", RIGHT, 4.0)), solver("b", ("", RIGHT, 6.0)), solver("c", ("", WRONG, 1.0))
    )
    found = factors(rows)
    assert (found["a"][0], found["b"][0]) == (1.0, pytest.approx(1.5))


def test_the_files_carry_the_header_and_every_measurement() -> None:
    rows = measured(solver("a", ("", RIGHT, 4.0)), solver("b", ("", (np.array([np.nan]), *RIGHT[1:]), 1.0)))
    header = {"date": "2026-01-01", "machine": "2 cores"}
    lines = to_csv(header, rows).splitlines()
    assert lines[:2] == ["# date: 2026-01-01", "# machine: 2 cores"]
    assert len(lines) == 2 + 1 + 2
    document = json.loads(to_json(header, rows))
    assert document["header"] == header
    assert [m["counts"] for m in document["measurements"]] == [True, False]
    assert document["measurements"][1]["gap"] is None


def test_a_block_is_replaced_and_a_file_without_one_refused(tmp_path: Path) -> None:
    path = tmp_path / "README.md"
    path.write_text("top\n<!-- benchmarks:begin (generated) -->\nold\n<!-- benchmarks:end -->\nbottom\n")
    insert(path, "new \\1")
    assert (
        path.read_text()
        == "top\n<!-- benchmarks:begin (generated) -->\nnew \\1\n<!-- benchmarks:end -->\nbottom\n"
    )
    path.write_text("top\n")
    with pytest.raises(ValueError, match="benchmarks:begin"):
        insert(path, "new")


def test_a_solve_that_never_keeps_its_core_counts_by_its_share_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    switches, wall, cpu = count(), count(step=4), count(step=1)
    monkeypatch.setattr("benchmarks.measure.forced_switches", lambda: next(switches))
    monkeypatch.setattr("benchmarks.measure.time.perf_counter", lambda: float(next(wall)))
    monkeypatch.setattr("benchmarks.measure.time.process_time", lambda: float(next(cpu)))
    [variant] = solver("s", ("", RIGHT, 8.0)).variants
    assert undisturbed(variant, PROBLEM, 1e-8).solve_s == pytest.approx(2e-6)
