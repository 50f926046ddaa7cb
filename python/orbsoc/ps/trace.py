"""The record of solves that the hardware model reads: schema "orbsoc.trace/2", plain data, JSON-able.

A trace holds each sparsity pattern once, with its stages, buffers, operation counts and critical paths, and
every solve as the list of stages it ran. No number of a problem or a solution is in it. Solves of one pattern
share one entry of `patterns`, so that a plan of many subproblems stays small.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.problem import Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution

SCHEMA = "orbsoc.trace/2"
Latencies = Mapping[str, Mapping[str, int]]
"""Preset of floating-point units → operation → cycles; a trace carries the critical paths of each preset."""


def method_of(core: Any) -> dict[str, Any]:
    """The step lists that solves run, and which stages decide, from the extension module."""
    names = ("startup", "warm_startup", "iteration", "closing")
    lists = {name: [list(step) for step in getattr(core, name)()] for name in names}
    return {**lists, "flags": {stage: info.flag[0] for stage, info in core.stages().items() if info.flag}}


class Recorded(Protocol):
    """What a trace asks of an engine that has finished a solve."""

    def events(self) -> Sequence[tuple[str, int]]:
        """(stage, iteration) in execution order."""
        ...

    def buffer_words(self) -> Mapping[str, int]:
        """Size of each buffer in words."""
        ...


class TraceRecorder:
    """Collects solves into one trace.

    `core` is the extension module: it has the dataflow table and counts the operations of a new pattern.
    """

    def __init__(self, core: Any, latencies: Latencies) -> None:
        self._core = core
        self._latencies = latencies
        self._position: dict[tuple[bytes, str, int], int] = {}
        self._patterns: list[dict[str, Any]] = []
        self.problems: list[Problem] = []
        """The first problem of each pattern, in the order of the trace: what schedules are made from."""
        self.settings: list[Settings] = []
        """The settings of that problem: order of elimination and passes of equilibration shape the operations, too."""
        self._solves: list[dict[str, Any]] = []

    def add(
        self,
        problem: Problem,
        settings: Settings,
        engine: Recorded,
        solution: Solution,
        resident: Sequence[Sequence[str]] | None = None,
    ) -> None:
        """Append one finished solve; `resident`: the segments that the PL ran by itself, where it controlled the solve."""
        key = (pattern_digest(problem), settings.ordering, settings.ruiz_passes)
        if key not in self._position:
            sizes = (solution.nnz_kkt, solution.nnz_l)
            entry = pattern_of(self._core, self._latencies, problem, settings, engine.buffer_words(), sizes)
            self._patterns.append(entry)
            self._position[key] = len(self._patterns) - 1
            self.problems.append(problem)
            self.settings.append(settings)
        solve: dict[str, Any] = {
            "pattern": self._position[key],
            "status": solution.status.name,
            "iterations": solution.iterations,
            "events": [[stage, iteration] for stage, iteration in engine.events()],
        }
        if resident is not None:
            solve["resident"] = ["+".join(stages) for stages in resident]
        self._solves.append(solve)

    def as_dict(self) -> dict[str, Any]:
        """The trace so far; later solves do not change what was handed out."""
        return {
            "schema": SCHEMA,
            "datapath": "f64",
            "method": method_of(self._core),
            "patterns": list(self._patterns),
            "solves": list(self._solves),
        }


def pattern_of(
    core: Any,
    latencies: Latencies,
    problem: Problem,
    settings: Settings,
    words: Mapping[str, int],
    nonzeros: tuple[int, int],
) -> dict[str, Any]:
    """The entry of a pattern in a trace; `nonzeros` are those of the KKT matrix and of its factor."""
    counted = core.operation_counts(problem, settings, latencies)
    stages = {
        stage: {
            "module": info.module,
            "reads": list(info.reads),
            "writes": list(info.writes),
            "operations": dict(counted[stage]["operations"]),
            "critical_path": dict(counted[stage]["critical_path"]),
        }
        for stage, info in core.stages().items()
    }
    return {
        "n": problem.n,
        "p": problem.p,
        "m": problem.m,
        "cones": {"l": problem.cones.l, "q": list(problem.cones.q)},
        "nnz_kkt": nonzeros[0],
        "nnz_l": nonzeros[1],
        "buffers": dict(words),
        "stages": stages,
    }
