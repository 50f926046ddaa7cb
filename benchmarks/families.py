"""The families of problems of the comparison: generated here, with fixed seeds, or recorded from this repository.

`python -m benchmarks.families --out out/problems [FAMILY …]` writes them as `orbsoc.problem/1` files, one folder a
family, for `rust/orbsoc-bench`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from benchmarks.estimation import robust_kalman
from benchmarks.guidance import powered_descent, quadrotor, rendezvous
from benchmarks.large_cones import sum_of_norms
from benchmarks.recorded import insertion, mission004
from benchmarks.regression import group_lasso, huber, svm
from benchmarks.six_dof import landing
from benchmarks.statistics import lasso, portfolio, small_lp
from orbsoc.conic.problem import Problem


@dataclass(frozen=True, slots=True, eq=False)
class Instance:
    """One problem; instances of one `group` (of one size, as a rule) share a row of the tables."""

    name: str
    group: str
    problem: Problem


@dataclass(frozen=True, slots=True)
class Family:
    """Problems of one kind; `generate` makes the same ones every time."""

    name: str
    about: str
    generate: Callable[[], Iterator[Instance]]


def _sized(
    kind: str, make: Callable[[int, int], Problem], sizes: Sequence[int], unit: str, count: int = 5
) -> Callable[[], Iterator[Instance]]:
    """`count` seeds of each size."""

    def generate() -> Iterator[Instance]:
        for size in sizes:
            for seed in range(count):
                yield Instance(f"{kind}-{size}-{seed}", f"{kind}, {size} {unit}", make(size, seed))

    return generate


def _mission004() -> Iterator[Instance]:
    return (Instance(name, group, problem) for name, group, problem in mission004())


def _insertion() -> Iterator[Instance]:
    for nodes in (12, 30, 60):
        for name, group, problem in insertion(nodes, count=4):
            yield Instance(name, group, problem)


def _landing() -> Iterator[Instance]:
    for nodes in (10, 20, 30):
        for k, problem in enumerate(landing(nodes, seed=0, count=5)):
            yield Instance(f"6-DoF landing-{nodes}-{k}", f"6-DoF landing, {nodes} nodes", problem)


def _large_cones() -> Iterator[Instance]:
    for dimension in (61, 151, 531, 1275, 2475):
        for seed in range(3):
            name, group = f"one cone-{dimension}-{seed}", f"one cone of {dimension}"
            yield Instance(name, group, sum_of_norms(dimension, seed))
    for dimension in (151, 531):
        for seed in range(3):
            name, group = f"three cones-{dimension}-{seed}", f"three cones of {dimension}"
            yield Instance(name, group, sum_of_norms(dimension, seed, cones=3))


def _small_lp() -> Iterator[Instance]:
    for rows in (100, 112, 128, 150):
        for seed in range(5):
            name = f"small LP-{rows}-{seed}"
            yield Instance(name, f"LP, 16 × {rows}", small_lp(16, seed, rows=rows))


FAMILIES = {
    family.name: family
    for family in (
        Family("mission004", "SOCP subproblems of the insertions of paper 004, as recorded", _mission004),
        Family(
            "orbit_insertion", "SOCP subproblems of the insertion rec1 on 12, 30 and 60 nodes", _insertion
        ),
        Family(
            "powered_descent",
            "SOCP: fuel-optimal landing, cones of 3 and 4",
            _sized("powered descent", powered_descent, (10, 20, 50, 100), "nodes"),
        ),
        Family("six_dof", "SOCP subproblems of a landing with attitude, cones of 3, 4 and 18", _landing),
        Family(
            "rendezvous",
            "SOCP: fuel-optimal relative motion with an approach cone",
            _sized("rendezvous", rendezvous, (20, 60), "nodes"),
        ),
        Family(
            "quadrotor",
            "SOCP with quadratic cost: predictive control of twelve states",
            _sized("quadrotor", quadrotor, (20, 50), "nodes"),
        ),
        Family("portfolio", "QP: factor model", _sized("portfolio", portfolio, (50, 100, 200), "assets")),
        Family("lasso", "QP: sparse regression", _sized("lasso", lasso, (20, 50, 100), "features")),
        Family("huber", "QP: regression with outliers", _sized("huber", huber, (10, 20, 50), "features")),
        Family("svm", "QP: support vector machine", _sized("svm", svm, (10, 20, 50), "features")),
        Family(
            "group_lasso",
            "SOCP with quadratic cost: sparse regression by groups of ten",
            _sized("group lasso", group_lasso, (2, 5, 10), "groups"),
        ),
        Family(
            "robust_kalman",
            "SOCP with quadratic cost: a track from measurements with outliers",
            _sized("robust Kalman filter", robust_kalman, (25, 50, 100), "steps"),
        ),
        Family("large_cones", "SOCP: sums of norms, cones of 61 to 2475", _large_cones),
        Family("small_lp", "LP: 16 variables, 100 to 150 dense rows", _small_lp),
    )
}


def instances(names: Sequence[str]) -> list[Instance]:
    """Every instance of the families named; raises ValueError for a name that is none."""
    unknown = [name for name in names if name not in FAMILIES]
    if unknown:
        raise ValueError(f"no family {unknown[0]!r}; there are {', '.join(FAMILIES)}")
    return list(chain.from_iterable(FAMILIES[name].generate() for name in names))


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.families", description=__doc__)
    parser.add_argument(
        "families", nargs="*", metavar="FAMILY", help=f"of {', '.join(FAMILIES)}; default all"
    )
    parser.add_argument("--out", type=Path, required=True, help="folder to write to")
    chosen = parser.parse_args(arguments)
    for name in chosen.families or FAMILIES:
        folder = chosen.out / name
        folder.mkdir(parents=True, exist_ok=True)
        try:
            generated = instances([name])
        except ValueError as error:
            parser.error(str(error))
        for instance in generated:
            instance.problem.save(folder / f"{instance.name.replace(' ', '_')}.json")
        sys.stdout.write(f"{folder}: {len(generated)} problems\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
