"""The conic solver on board: each pattern analysed once, every solve recorded stage by stage so that a computer can price it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from orbsoc import _core
from orbsoc.conic.pattern import pattern_digest
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Solution, Status
from orbsoc.solving.solver import DEFAULTS, engine, solution_of

PatternKey = tuple[bytes, str, int]
"""What shapes the operations of a solve: sparsity, order of elimination, passes of equilibration."""


_Sizes = tuple[int, int, int, Cones, Settings]


class Ran(NamedTuple):
    """One solve as it ran: its pattern, and the stages in order with their iterations."""

    pattern: PatternKey
    status: str
    iterations: int
    events: tuple[tuple[str, int], ...]


class Pattern(NamedTuple):
    """What the hardware model needs to know of a pattern: one problem of it, its settings, and the sizes that a solve tells."""

    problem: Problem
    settings: Settings
    words: dict[str, int]
    nnz_kkt: int
    nnz_l: int


@dataclass(slots=True, eq=False)
class OnboardSolver:
    """A callable with the call shape of `orbsoc.solve`. A solve begins where the one before it in the same answer ended, if that
    was of the same pattern; `begin` starts a new answer, from nothing that was known before.

    So an answer depends on its own problems alone, whatever was solved before. `ran` are the solves since `begin`.
    """

    patterns: dict[PatternKey, Pattern] = field(default_factory=dict)
    ran: list[Ran] = field(default_factory=list)
    _engines: dict[_Sizes, list[tuple[PatternKey, _core.Engine]]] = field(default_factory=dict)
    _last: dict[PatternKey, Solution] = field(default_factory=dict)

    def begin(self) -> None:
        """A new answer."""
        self.ran = []
        self._last.clear()

    def __call__(self, problem: Problem, settings: Settings | None = None, /) -> Solution:
        """Solve; Ctrl-C is a status, as it is of `orbsoc.solve`."""
        chosen = settings or DEFAULTS
        key, native = self._analysed(problem, chosen)
        last = self._last.get(key)
        solution = solution_of(native.solve(None, None if last is None else (last.x, last.y, last.z, last.s)))
        if key not in self.patterns:
            words = dict(native.buffer_words())
            self.patterns[key] = Pattern(problem, chosen, words, solution.nnz_kkt, solution.nnz_l)
        if solution.status is Status.SOLVED:
            self._last[key] = solution
        self.ran.append(Ran(key, solution.status.name, solution.iterations, tuple(native.events())))
        return solution

    def _analysed(self, problem: Problem, settings: Settings) -> tuple[PatternKey, _core.Engine]:
        """The engine of the problem's pattern, which holds its numbers; an engine refuses those of another pattern."""
        sizes = (problem.n, problem.p, problem.m, problem.cones, settings)
        known = self._engines.setdefault(sizes, [])
        for key, native in known:
            try:
                native.update(problem)
            except _core.CoreError:
                continue
            return key, native
        key = (pattern_digest(problem), settings.ordering, settings.ruiz_passes)
        known.append((key, engine(problem, settings)))
        return known[-1]
