"""Failure bundles: written when a solve does not end with SOLVED, and enough to repeat it bit for bit."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given

import orbsoc
from orbsoc.conic.errors import FileError
from orbsoc.solving.bundle import read_bundle
from orbsoc.solving.iteration_table import COLUMNS
from tests.fuzz_budget import fuzz_budget
from tests.strategies import problems

LP = orbsoc.Problem(
    c=[1.0, 1.0], G=[[-1.0, 0.0], [0.0, -2.0]], h=[-2.0, 1.0], cones=orbsoc.Cones(l=2)
)  # fmt: skip
DISC = orbsoc.Problem(
    c=[1.0, 2.0], G=[[0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]], h=[1.0, 0.3, 0.1], cones=orbsoc.Cones(q=[3])
)  # its solution is irrational: no double reaches a tolerance of 1e-30
INFEASIBLE = orbsoc.Problem(c=[1.0], G=[[-1.0], [1.0]], h=[-2.0, 1.0], cones=orbsoc.Cones(l=2))
UNBOUNDED = orbsoc.Problem(c=[-1.0], G=[[-1.0]], h=[0.0], cones=orbsoc.Cones(l=1))


def same_bits(one: orbsoc.Solution, other: orbsoc.Solution) -> bool:
    """Whether two solves took the same path; times differ."""
    vectors = all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in "xyzs")
    counts = (one.status, one.iterations, one.refinements, one.message)
    return vectors and counts == (other.status, other.iterations, other.refinements, other.message)


def test_what_is_no_path_is_refused_before_the_solve() -> None:
    with pytest.raises(TypeError, match="`bundle` is 3; it must be the path of a file"):
        orbsoc.solve(LP, bundle=3)  # type: ignore[arg-type]


def test_a_solved_problem_leaves_no_bundle(tmp_path: Path) -> None:
    path = tmp_path / "b.json"
    assert orbsoc.solve(LP, bundle=path).status is orbsoc.Status.SOLVED
    assert not path.exists()


@pytest.mark.parametrize(
    ("problem", "overrides", "status"),
    [
        (LP, {"max_iterations": 1}, orbsoc.Status.MAX_ITERATIONS),
        (DISC, {"tol": 1e-30}, orbsoc.Status.SOLVED_INACCURATE),
        (INFEASIBLE, {}, orbsoc.Status.PRIMAL_INFEASIBLE),
        (UNBOUNDED, {}, orbsoc.Status.DUAL_INFEASIBLE),
    ],
)
def test_a_bundle_repeats_the_solve_bit_for_bit(
    tmp_path: Path, problem: orbsoc.Problem, overrides: dict[str, Any], status: orbsoc.Status
) -> None:
    path = tmp_path / "b.json"
    solution = orbsoc.solve(problem, bundle=path, **overrides)
    assert solution.status is status
    bundle = read_bundle(path)
    assert bundle.settings == orbsoc.Settings(**overrides)
    assert same_bits(bundle.solution, solution)
    assert same_bits(orbsoc.solve(bundle.problem, bundle.settings), solution)
    assert [entry["iteration"] for entry in bundle.history] == list(range(1, len(bundle.history) + 1))
    assert all(set(entry) == set(COLUMNS) for entry in bundle.history)
    assert bundle.versions["orbsoc"] == orbsoc.__version__


@given(problems())
@fuzz_budget(40)
def test_recording_changes_no_bit_and_every_bundle_replays(
    tmp_path_factory: pytest.TempPathFactory, problem: orbsoc.Problem
) -> None:
    path = tmp_path_factory.mktemp("bundle") / "b.json"
    plain = orbsoc.solve(problem, max_iterations=6)
    assert same_bits(orbsoc.solve(problem, max_iterations=6, bundle=path), plain)
    assert path.exists() == (plain.status is not orbsoc.Status.SOLVED)
    if path.exists():
        bundle = read_bundle(path)
        assert same_bits(orbsoc.solve(bundle.problem, bundle.settings), plain)


def test_a_solver_bundles_the_data_it_was_updated_to(tmp_path: Path) -> None:
    solver = orbsoc.Solver(LP, max_iterations=2)
    solver.update(c=np.array([3.0, 5.0]))
    solution = solver.solve(bundle=tmp_path / "b.json")
    bundle = read_bundle(tmp_path / "b.json")
    assert bundle.problem.c.tolist() == [3.0, 5.0]
    assert same_bits(orbsoc.solve(bundle.problem, bundle.settings), solution)


def test_what_a_callback_does_with_its_statistics_is_its_own_affair(tmp_path: Path) -> None:
    orbsoc.solve(LP, max_iterations=2, callback=lambda progress: progress.clear(), bundle=tmp_path / "b.json")
    assert [entry["iteration"] for entry in read_bundle(tmp_path / "b.json").history] == [1.0, 2.0]


def test_a_callback_still_sees_each_iteration_and_can_stop_the_solve(tmp_path: Path) -> None:
    seen: list[float] = []

    def stop(progress: Any) -> bool:
        seen.append(progress["iteration"])
        return len(seen) == 2

    solution = orbsoc.solve(LP, callback=stop, bundle=tmp_path / "b.json")
    assert solution.status is orbsoc.Status.INTERRUPTED
    assert seen == [1, 2]
    assert read_bundle(tmp_path / "b.json").solution.status is orbsoc.Status.INTERRUPTED


def test_a_place_that_cannot_be_written_is_refused_before_the_solve(tmp_path: Path) -> None:
    def called(_: object) -> None:
        pytest.fail("the solve had begun")

    with pytest.raises(FileNotFoundError, match="there is no folder"):
        orbsoc.solve(LP, callback=called, bundle=tmp_path / "none" / "b.json")
    with pytest.raises(IsADirectoryError, match="is a folder"):
        orbsoc.solve(LP, callback=called, bundle=tmp_path)


DAMAGE: list[tuple[Callable[[dict[str, Any]], Any], str]] = [
    (lambda d: d.update(schema="orbsoc.problem/1"), "field `schema` is 'orbsoc.problem/1'"),
    (lambda d: d.update(extra=1), "field `extra` is unknown"),
    (lambda d: d.pop("problem"), "field `problem` must be one JSON object"),
    (lambda d: d["problem"].update(c=[1, "x"]), "field `problem.c[1]` is 'x'"),
    (lambda d: d["problem"]["G"].update(indices=[0, 9]), "field `problem.G.indices` must lie in 0 … 1"),
    (
        lambda d: d["problem"].update(h=[1, "nan"]),
        'field `problem.h[1]` is \'nan\'; it must be a number, "inf" or "-inf"',
    ),
    (
        lambda d: d["settings"].update(tolerance=1),
        "field `settings.tolerance` is unknown; known fields are tol, ",
    ),
    (lambda d: d["settings"].update(tol="small"), "field `settings.tol` is 'small'; it must be a number"),
    (lambda d: d["settings"].update(tol=-1), "settings: tol = -1.0 must be a positive number"),
    (lambda d: d["settings"].update(max_iterations=2.5), "settings: max_iterations = 2.5 must be an integer"),
    (lambda d: d["solution"].pop("x") and d["solution"].update(status=3), "field `solution.status` is 3"),
    (lambda d: d.update(history={}), "field `history` is {}; it must be a list"),
    (lambda d: d["history"].append(3), "must be one JSON object"),
    (lambda d: d["versions"].update(orbsoc=1), "field `versions.orbsoc` is 1; it must be text"),
]


@pytest.mark.parametrize(("damage", "message"), DAMAGE, ids=[row[1] for row in DAMAGE])
def test_a_damaged_bundle_is_refused_by_field(
    tmp_path: Path, damage: Callable[[dict[str, Any]], Any], message: str
) -> None:
    path = tmp_path / "b.json"
    orbsoc.solve(LP, max_iterations=2, bundle=path)
    document = json.loads(path.read_text())
    damage(document)
    path.write_text(json.dumps(document))
    with pytest.raises(FileError, match=re.escape(message)) as caught:
        read_bundle(path)
    assert str(caught.value).startswith(str(path))


def test_ctrl_c_inside_a_callback_is_a_status_too(tmp_path: Path) -> None:
    def interrupt(_: object) -> None:
        raise KeyboardInterrupt

    solution = orbsoc.solve(LP, callback=interrupt, bundle=tmp_path / "b.json")
    assert solution.status is orbsoc.Status.INTERRUPTED
    assert len(read_bundle(tmp_path / "b.json").history) == 1
