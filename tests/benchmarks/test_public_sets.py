"""Folders of problems: what counts as verified and as false, crashes and limits, and going on where one left."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.answer import Answer
from benchmarks.folder import measure_sets, read_rows
from benchmarks.folder_report import counts_table, missed, report, requirement
from benchmarks.grading import Graded, graded, lost
from benchmarks.peers import solvers
from benchmarks.processes import SolverProcess
from benchmarks.public_sets import Listed, listed, load
from orbsoc.conic.problem import Cones, Problem

SQUARE = Problem(P=[[2.0]], c=[-2.0], G=[[1.0], [-1.0]], h=[3.0, 0.0], cones=Cones(l=2))
EMPTY = Problem(c=[1.0], G=[[1.0], [-1.0]], h=[1.0, -2.0], cones=Cones(l=2))
RIGHT = np.array([1.0]), np.zeros(0), np.zeros(2)


def row(
    problem: Problem,
    point: tuple[np.ndarray, ...],
    claim: str,
    expected: str,
    solver: str = "orbsoc",
    name: str = "a",
) -> Graded:
    answer = Answer(*point, claim.lower(), 7, 1e-3, 2e-3, claim, "in words")
    return graded(problem, answer, where=("set", name, expected), who=(solver, "1", "default"), tol=1e-8)


def write_set(folder: Path) -> list[Listed]:
    """The square and the empty set as .npz files with an index."""
    entries = []
    for name, problem, expect in (("square", SQUARE, "optimal"), ("none", EMPTY, "primal_infeasible")):
        arrays = {"c": problem.c, "b": problem.b, "h": problem.h, "l": problem.cones.l, "q": np.zeros(0, int)}
        for matrix in "PAG":
            values = getattr(problem, matrix)
            for part in ("data", "indices", "indptr"):
                arrays[f"{matrix}_{part}"] = getattr(values, part)
        np.savez(folder / f"{name}.npz", **arrays)
        entries.append({"file": f"{name}.npz", "set": "tiny", "name": name, "expect": expect})
    (folder / "index.json").write_text(json.dumps(entries))
    return listed(folder)


def test_a_file_is_the_problem_it_came_from(tmp_path: Path) -> None:
    square, none = write_set(tmp_path)
    assert (square.expected, none.expected) == ("SOLVED", "PRIMAL_INFEASIBLE")
    for entry, problem in ((square, SQUARE), (none, EMPTY)):
        found = load(Path(entry.path))
        assert np.array_equal(found.P.toarray(), problem.P.toarray())
        assert np.array_equal(found.G.toarray(), problem.G.toarray())
        assert np.array_equal(found.h, problem.h)


def test_a_folder_without_index_is_its_problem_files(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="neither"):
        listed(tmp_path)
    SQUARE.save(tmp_path / "square.json")
    [entry] = listed(tmp_path)
    assert (entry.name, entry.expected) == ("square", "")
    assert load(Path(entry.path)).n == 1


def test_what_is_verified_does_not_depend_on_what_is_claimed() -> None:
    assert row(SQUARE, RIGHT, "", "SOLVED").verified(1e-8)
    near = (RIGHT[0] + 1e-7, *RIGHT[1:])
    assert row(SQUARE, near, "SOLVED", "SOLVED").verified(1e-6)
    assert not row(SQUARE, near, "SOLVED", "SOLVED").verified(1e-8)
    assert not lost(where=("s", "p", "SOLVED"), who=("x", "1", ""), tol=1e-8, outcome="crashed").verified(1e9)


def test_false_claims_are_found() -> None:
    assert not row(SQUARE, RIGHT, "SOLVED", "SOLVED").falsehood()
    far = (RIGHT[0] + 1e-3, *RIGHT[1:])
    assert "says solved, residual" in row(SQUARE, far, "SOLVED", "SOLVED").falsehood()
    assert not row(SQUARE, far, "", "SOLVED").falsehood()
    assert "is SOLVED" in row(SQUARE, RIGHT, "PRIMAL_INFEASIBLE", "SOLVED").falsehood()
    proof = (np.zeros(1), np.zeros(0), np.array([1.0, 1.0]))
    assert row(EMPTY, proof, "PRIMAL_INFEASIBLE", "PRIMAL_INFEASIBLE").verified(1e-8)
    no_proof = (np.zeros(1), np.zeros(0), np.array([1.0, 0.9]))
    unproved = row(EMPTY, no_proof, "PRIMAL_INFEASIBLE", "PRIMAL_INFEASIBLE")
    assert not unproved.verified(1e-6)
    assert "radius 4.0" in unproved.falsehood()  # 0.8 / 0.1 over scale 2
    assert not replace(unproved, solver="other").falsehood()


def test_an_instance_infeasible_within_the_tolerance_may_be_solved() -> None:
    solved = row(SQUARE, RIGHT, "SOLVED", "PRIMAL_INFEASIBLE", name="lpi_cplex2")
    assert solved.verified(1e-8)
    assert not solved.falsehood()
    assert row(SQUARE, RIGHT, "SOLVED", "PRIMAL_INFEASIBLE").falsehood()


def test_the_report_lists_what_a_peer_solves_and_we_do_not() -> None:
    far = (RIGHT[0] + 1e-3, *RIGHT[1:])
    rows = [row(SQUARE, far, "", "SOLVED"), row(SQUARE, RIGHT, "SOLVED", "SOLVED", "Peer")]
    assert "- set/a (Peer): , residual 1.0e-03. in words" in missed(rows, 1e-6)
    assert "**does not hold**: set at 1e-06: 0, best peer 1 (Peer)" in requirement(rows)
    assert "| set, 1 problems | orbsoc | 1 | 0 | 0 | 0 | 0 | 3.0 |" in counts_table(rows)
    assert "- none" in missed(rows[1:], 1e-6)


def test_a_run_goes_on_where_it_was_left(tmp_path: Path) -> None:
    problems = write_set(tmp_path)
    asked: list[str] = []
    first = measure_sets(problems[:1], ("orbsoc", "clarabel"), out=tmp_path, tol=1e-8)
    text = (tmp_path / "sets.csv").read_text()
    (tmp_path / "sets.csv").write_text(text + "tiny,none,PRIMAL")  # cut short by an interruption
    rows = measure_sets(
        problems, ("orbsoc", "clarabel"), out=tmp_path, tol=1e-8, progress=lambda line: asked.append(line)
    )
    kept = read_rows(tmp_path / "sets.csv")
    assert [(r.problem, r.solve_s) for r in kept] == [(r.problem, r.solve_s) for r in rows]
    assert [r.solve_s for r in kept[:2]] == [r.solve_s for r in first]
    assert [r.solver for r in rows] == ["orbsoc", "Clarabel"] * 2
    assert all(r.verified(1e-6) and not r.falsehood() for r in rows)
    assert "tiny, 2 problems" in report(rows)


def test_a_process_that_dies_or_dawdles_is_an_outcome_and_the_next_question_starts_afresh(
    tmp_path: Path,
) -> None:
    square, none = write_set(tmp_path)
    [solver], _ = solvers(("orbsoc",))
    process = SolverProcess("orbsoc", solver)
    try:
        answered = process.ask(square, 1e-8, 60.0)
        assert [row.verified(1e-6) for row in answered] == [True]
        silent = tmp_path / "silent.npz"
        os.mkfifo(silent)  # no process writes to it: opening it waits
        late = process.ask(replace(none, path=str(silent)), 1e-8, 0.1)
        assert [row.outcome for row in late] == ["time limit of 0.1 s"]
        missing = process.ask(replace(square, path=str(tmp_path / "no.npz")), 1e-8, 60.0)
        assert [row.outcome for row in missing] == ["crashed"]
        with np.load(square.path) as file:
            concave = {name: -file[name] if name == "P_data" else file[name] for name in file.files}
        np.savez(tmp_path / "concave.npz", **concave)
        [row] = process.ask(replace(square, path=str(tmp_path / "concave.npz")), 1e-8, 60.0)
        assert "not posed: `P` is not positive semidefinite" in row.outcome
        again = process.ask(square, 1e-8, 60.0)
        assert [row.verified(1e-6) for row in again] == [True]
    finally:
        process.close()
