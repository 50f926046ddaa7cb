"""A solver in a process of its own: what crashes or takes too long there ends there."""

from __future__ import annotations

import multiprocessing
import os
import sys
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from benchmarks.answer import Solver, Variant
from benchmarks.grading import DEFAULTS, LOOSE, TIGHT, Graded, graded, lost
from benchmarks.peers import solvers
from benchmarks.public_sets import Listed, load
from orbsoc.conic.errors import ProblemError
from orbsoc.conic.problem import Problem

START_S = 60.0
"""Time that a process may take to begin."""
PATIENCE = 5.0
"""On a busy machine a process may take this many times its limit on the clock."""


@dataclass(frozen=True, slots=True)
class Question:
    listed: Listed
    tol: float


def _serve(name: str, pipe: Connection) -> None:
    """The process: says that it is there, then answers questions until the pipe closes."""
    [solver], _ = solvers((name,))
    pipe.send("ready")
    while True:
        try:
            question: Question = pipe.recv()
        except EOFError:
            return
        pipe.send(_answered(solver, question))


def _answered(solver: Solver, question: Question) -> list[Graded]:
    """The row of the solver's defaults; where they do not verify, the best of its other settings, too.

    Empty where the solver is not made for the problem. Data that are no convex problem (`VALUES`: P is indefinite) are
    no solver's: the row says so.
    """
    asked = question.listed
    try:
        problem = load(Path(asked.path))
    except ProblemError as error:
        where = (asked.set, asked.name, asked.expected)
        who = (solver.name, solver.version, DEFAULTS)
        return [lost(where=where, who=who, tol=question.tol, outcome=f"not posed: {error}")]
    if not solver.applies(problem):
        return []
    default, *others = solver.variants
    rows = [_row(solver, default, problem, question)]
    if others and not rows[0].verified(TIGHT):
        tried = [_row(solver, variant, problem, question) for variant in others]
        rows.append(min(tried, key=lambda row: (not row.verified(LOOSE), row.residual)))
    return rows


def _row(solver: Solver, variant: Variant, problem: Problem, question: Question) -> Graded:
    asked = question.listed
    where = (asked.set, asked.name, asked.expected)
    who = (solver.name, solver.version, variant.label or DEFAULTS)
    try:
        answer = variant.solve(problem, question.tol)
    except Exception as error:
        return lost(where=where, who=who, tol=question.tol, outcome=f"raises {type(error).__name__}")
    return graded(problem, answer, where=where, who=who, tol=question.tol)


class SolverProcess:
    """One solver, asked one problem after the other, under a time limit for each."""

    def __init__(self, name: str, solver: Solver) -> None:
        self.name = name
        self.solver = solver
        self._process: BaseProcess | None = None
        self._pipe: Connection | None = None

    def ask(self, listed: Listed, tol: float, limit_s: float) -> list[Graded]:
        """The rows, none where the solver does not take part. After a crash or the limit the next starts afresh."""
        pipe = self._started()
        pipe.send(Question(listed, tol))
        outcome = "crashed"
        try:
            if self._answers(pipe, limit_s):
                rows: list[Graded] = pipe.recv()
                return rows
            outcome = f"time limit of {limit_s:g} s"
        except (EOFError, ConnectionError):
            pass
        self.close()
        where = (listed.set, listed.name, listed.expected)
        who = (self.solver.name, self.solver.version, DEFAULTS)
        return [lost(where=where, who=who, tol=tol, outcome=outcome)]

    def _answers(self, pipe: Connection, limit_s: float) -> bool:
        """Whether an answer comes before the process has worked for `limit_s`, or that has passed `PATIENCE` times."""
        before, started = self._worked_s(), time.monotonic()
        waiting_s = limit_s
        while not pipe.poll(waiting_s):
            if time.monotonic() - started >= PATIENCE * limit_s:
                return False
            left_s = limit_s - (self._worked_s() - before)
            if left_s <= 0.0:
                return False
            waiting_s = max(left_s, 0.05)
        return True

    def _worked_s(self) -> float:
        """CPU time of the process so far; where the system does not tell, the time on the clock."""
        if self._process is None or not sys.platform.startswith("linux"):
            return time.monotonic()
        try:
            text = Path(f"/proc/{self._process.pid}/stat").read_text(encoding="utf-8")
        except OSError:
            return time.monotonic()
        user, system = text.rpartition(")")[2].split()[11:13]  # fields 14 and 15 of proc(5)
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def close(self) -> None:
        """End the process, if there is one."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None
        if self._pipe is not None:
            self._pipe.close()
            self._pipe = None

    def _started(self) -> Connection:
        if self._pipe is not None and self._process is not None and self._process.is_alive():
            return self._pipe
        self.close()
        context = multiprocessing.get_context("spawn")
        here, there = context.Pipe()
        self._process = context.Process(target=_serve, args=(self.name, there), daemon=True)
        self._process.start()
        there.close()
        self._pipe = here
        if not here.poll(START_S):
            self.close()
            raise TimeoutError(f"the process of {self.name} did not begin within {START_S:.0f} s")
        here.recv()
        return here
