"""The families of problems of the comparison: generated here, with fixed seeds, or recorded from this repository.

`python -m benchmarks.families --out out/problems [FAMILY …]` writes them as `orbsoc.problem/1` files, one folder a
family, for `rust/orbsoc-bench`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path

from benchmarks.guidance import powered_descent, quadrotor, rendezvous
from benchmarks.recorded import mission004
from benchmarks.statistics import lasso, portfolio, small_lp
from orbsoc.problem import Problem


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


FAMILIES = {
    family.name: family
    for family in (
        Family("mission004", "SOCP subproblems of the insertions of paper 004, as recorded", _mission004),
        Family(
            "powered_descent",
            "SOCP: fuel-optimal landing, cones of 3 and 4",
            _sized("powered descent", powered_descent, (10, 20, 50), "nodes"),
        ),
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
        Family(
            "small_lp",
            "LP: 128 dense rows",
            _sized("small LP", partial(small_lp, rows=128), (16,), "variables", count=10),
        ),
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
