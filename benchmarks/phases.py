"""The parts of a full measurement, each kept in a file of its own, so that an interrupted one goes on where it was left.

The files of one build are in `<out>/<fingerprint>/`; the rows of public sets, which peers share between builds, in
`<out>/sets.csv`.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.answer import Solver
from benchmarks.batch_measure import BatchTimes, measure_batch
from benchmarks.batches import BATCHES, Batch
from benchmarks.environment import environment
from benchmarks.families import FAMILIES, Instance, instances
from benchmarks.fingerprint import fingerprint
from benchmarks.folder import NAMES, measure_sets
from benchmarks.grading import Graded
from benchmarks.measure import Measurement, measure
from benchmarks.overhead import Overhead, measure_overhead
from benchmarks.peers import DEFAULT, solvers
from benchmarks.peers.installed import MissingSolver
from benchmarks.peers.qocogen import prepare
from benchmarks.public_sets import listed
from benchmarks.records import from_json, to_json
from benchmarks.warm import WarmStart, measure_warm

GENERATED = ("powered_descent", "orbit_insertion", "rendezvous", "quadrotor")
"""Families whose smallest patterns code is generated for."""
GENERATED_ROWS = 720
"""n + p + m of the largest of them: half a minute of compiling."""
GENERATING_S = 240.0
"""Time after which no other pattern's code is begun; the next run goes on with it."""
BATCH_PEERS = ("orbsoc", "clarabel", "ecos", "qoco", "piqp_sparse", "piqp_dense")

Say = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Effort:
    """How long to measure.

    `patience_s` bounds the repetitions of one solver on one problem, `batch_patience_s` the rounds over a batch;
    `limit_s` is the time for one problem of a public set.
    """

    repeats: int
    patience_s: float
    batch_repeats: int
    batch_patience_s: float
    problems_a_group: int | None
    limit_s: float
    quick: bool


FULL = Effort(
    repeats=20,
    patience_s=0.5,
    batch_repeats=5,
    batch_patience_s=15.0,
    problems_a_group=None,
    limit_s=20.0,
    quick=False,
)
QUICK = Effort(
    repeats=5,
    patience_s=0.1,
    batch_repeats=2,
    batch_patience_s=3.0,
    problems_a_group=2,
    limit_s=3.0,
    quick=True,
)


@dataclass(frozen=True, slots=True)
class Results:
    """All that was measured; `header` says when, on what and with what."""

    header: dict[str, str]
    families: dict[str, list[Measurement]]
    batches: list[BatchTimes]
    warm: list[WarmStart]
    overhead: Overhead | None
    sets: list[Graded]


def measure_all(
    out: Path, effort: Effort, *, problems: Path | None, tol: float, names: Sequence[str], say: Say
) -> Results:
    """Measure what is not in `out` yet. Without a folder of problems the public sets are left out."""
    folder = out / (fingerprint() + ("-quick" if effort.quick else ""))
    folder.mkdir(parents=True, exist_ok=True)
    if not effort.quick:
        _generate_code(say)
    found, missing = solvers((*DEFAULT, "qocogen"))
    for line in missing:
        say(line)
    families: dict[str, list[Measurement]] = {}
    header = environment(found, repeats=effort.repeats, tol=tol)
    header["effort"] = "quick" if effort.quick else "full"
    for name in names:
        families[name] = _family(folder, name, found, effort, tol, header, say)
    few, _ = solvers(BATCH_PEERS)
    chosen = list(BATCHES.values())[:: 4 if effort.quick else 1]
    batches: list[BatchTimes] = []
    for batch in chosen:
        path = folder / f"batch {batch.name.replace('×', 'x')}.json"
        record = _kept(path, partial(_batch, batch, few, effort, tol, say))
        batches.append(BatchTimes.from_record(record))
    say("warm starts")
    warm = _kept(folder / "warm.json", lambda: [asdict(row) for row in measure_warm(tol, quick=effort.quick)])
    say("overhead of Python")
    overhead = _kept(folder / "overhead.json", lambda: asdict(measure_overhead()))
    return Results(
        header=header,
        families=families,
        batches=batches,
        warm=[WarmStart.from_record(record) for record in warm],
        overhead=Overhead.from_record(overhead),
        sets=_sets(out, problems, effort, tol, say),
    )


def _generate_code(say: Say) -> None:
    """QOCOGEN's code for the smallest patterns of some families; what cannot be had is said and left out."""
    started = time.monotonic()
    for family in GENERATED:
        for instance in _first_of_groups(instances([family]), 1):
            size = instance.problem.n + instance.problem.p + instance.problem.m
            if size > GENERATED_ROWS or time.monotonic() - started > GENERATING_S:
                continue
            try:
                say(f"{instance.group}: {prepare(instance.problem)}")
            except MissingSolver as error:
                say(str(error))
                return


def _family(
    folder: Path,
    name: str,
    found: Sequence[Solver],
    effort: Effort,
    tol: float,
    header: dict[str, str],
    say: Say,
) -> list[Measurement]:
    path = folder / f"{name}.json"
    if not path.is_file():
        say(f"{name}: {FAMILIES[name].about}")
        members = _first_of_groups(instances([name]), effort.problems_a_group)
        measured = measure(members, found, repeats=effort.repeats, tol=tol, patience_s=effort.patience_s)
        _write(path, to_json(header, measured))
    return from_json(path.read_text(encoding="utf-8"))[1]


def _batch(batch: Batch, found: Sequence[Solver], effort: Effort, tol: float, say: Say) -> dict[str, Any]:
    say(f"batch: {batch.name}")
    times = measure_batch(
        batch, found, repeats=effort.batch_repeats, tol=tol, patience_s=effort.batch_patience_s
    )
    return asdict(times)


def _sets(out: Path, problems: Path | None, effort: Effort, tol: float, say: Say) -> list[Graded]:
    if problems is None:
        say("no folder of problems: public sets are left out")
        return []
    return measure_sets(listed(problems), NAMES, out=out, tol=tol, limit_s=effort.limit_s, progress=say)


def _first_of_groups(members: Sequence[Instance], count: int | None) -> list[Instance]:
    taken: dict[str, int] = {}
    kept: list[Instance] = []
    for instance in members:
        taken[instance.group] = taken.get(instance.group, 0) + 1
        if count is None or taken[instance.group] <= count:
            kept.append(instance)
    return kept


def _kept(path: Path, make: Callable[[], Any]) -> Any:
    """What the file holds, or what `make` gives, written to it."""
    if not path.is_file():
        _write(path, json.dumps(make(), indent=1) + "\n")
    return json.loads(path.read_text(encoding="utf-8"))


def _write(path: Path, text: str) -> None:
    """Whole or not at all."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)
