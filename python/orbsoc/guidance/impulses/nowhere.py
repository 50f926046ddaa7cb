"""No time will do: infeasibility proved for a whole interval of a time on which the impulse times of a problem depend.

Between the times that are built, every row r(t) − M(t) x changes with t. Over a piece of the interval, about its middle and
about the middle x̄ of a box that holds x, the row is f(t) − M(t) dx with f = r − M x̄; f is a straight line in t, a
variable, up to its bend, and M(t) dx is M(middle) dx up to the change of M times the box. With these slacks in the
right-hand sides one conic problem holds for every time of the piece. Where its certificate proves it infeasible the piece
is done; otherwise the same problem narrows the box and the piece by the bounds of its duals, and what is left is halved.
Both tests hold for any multipliers, whatever a solver says of them, for all unknowns are in a box.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.conic.verify import project_dual
from orbsoc.orbit.array import Array

from ..scp import Solve

TOLERANCE = 1e-9
ROUNDED = 1e-10
"""Of the sum of all terms of a bound: far above what rounding makes of it."""
PROBES = (0.13, 0.37, 0.61, 0.89)
"""Of the interval, where entries are compared: α + β t + γ cos ωt + δ sin ωt that is the same at four times of less than a
revolution is constant."""
NARROWED = 0.7
"""A round of narrowing that leaves more of the largest width than this is the last before a piece is halved."""
ROUNDS = 6
"""Of narrowing, a piece."""
MOST_SOLVES = 6000
"""After which there is no proof."""


@dataclass(frozen=True, slots=True, eq=False)
class Family:
    """Problems of one shape by a time, their unknowns within ±`largest` (n,), and above |d²/dt²| of their entries.

    Every entry that is not constant is α + β t + γ cos ωt + δ sin ωt, over less than a revolution of ω.
    """

    build: Callable[[float], Problem]
    interval_s: tuple[float, float]
    largest: Array
    matrix_bend: float
    side_bend: float


@dataclass(frozen=True, slots=True)
class Nowhere:
    """A proof: the pieces the interval was cut into, and how many conic problems were solved for it."""

    pieces: int
    solves: int


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    low_s: float
    high_s: float
    low: Array
    high: Array


class _Proven(Exception):
    """The multipliers of a relaxed problem prove that it has no point."""


def nowhere_feasible(family: Family, solve: Solve, least_s: float = 1e-3) -> Nowhere | None:
    """Prove that no time of the interval has a feasible problem; None where a piece shorter than `least_s` is left, or
    after `MOST_SOLVES`."""
    prover = _Prover(family, solve)
    left = [_Piece(*family.interval_s, -family.largest, family.largest.copy())]
    done = 0
    while left:
        piece = left.pop()
        try:
            piece = prover.narrowed(piece)
        except _Proven:
            done += 1
            continue
        middle = 0.5 * (piece.low_s + piece.high_s)
        if piece.high_s - piece.low_s < least_s or prover.solves > MOST_SOLVES:
            return None
        left += [
            _Piece(piece.low_s, middle, piece.low, piece.high),
            _Piece(middle, piece.high_s, piece.low, piece.high),
        ]
    return Nowhere(done, prover.solves)


class _Prover:
    def __init__(self, family: Family, solve: Solve) -> None:
        self.family, self.solve, self.solves = family, solve, 0
        first = family.build(family.interval_s[0])
        self.equalities, self.cones = first.p, first.cones
        self._built: dict[float, tuple[Array, Array]] = {}
        low, high = family.interval_s
        probes = [self._rows(low + share * (high - low)) for share in PROBES]
        matrices, sides = (np.array(each) for each in zip(*probes, strict=True))
        self.moving = np.ptp(matrices, axis=0) > 1e-13 * (1.0 + abs(matrices[0]))
        self.moving_side = np.ptp(sides, axis=0) > 1e-13 * (1.0 + abs(sides[0]))
        self._built.clear()

    def _rows(self, t_s: float) -> tuple[Array, Array]:
        """Matrix and right-hand side, equalities first."""
        if t_s not in self._built:
            problem = self.family.build(t_s)
            matrix = np.vstack([problem.A.toarray(), problem.G.toarray()])
            self._built[t_s] = matrix, np.concatenate([problem.b, problem.h])
        return self._built[t_s]

    def relaxed(self, piece: _Piece) -> tuple[Problem, Array, Array]:
        """What holds at every time of a piece, of unknowns in [−1, 1] that are, but for the last, (x − x̄)/radius; x̄, radius."""
        half = 0.5 * (piece.high_s - piece.low_s)
        centre, radius = 0.5 * (piece.low + piece.high), 0.5 * (piece.high - piece.low)
        (one, left), (middle, side), (two, right) = (
            self._rows(t) for t in (piece.low_s, 0.5 * (piece.low_s + piece.high_s), piece.high_s)
        )
        at, between, to = left - one @ centre, side - middle @ centre, right - two @ centre
        bend = self.family.side_bend * self.moving_side + self.family.matrix_bend * (
            self.moving @ abs(centre)
        )
        straight, slope = 0.5 * (at + to), 0.5 * (to - at)
        bowed = np.minimum(0.5 * half**2 * bend, abs(between - straight) + 0.125 * half**2 * bend)
        change = np.where(
            self.moving,
            np.maximum(abs(one - middle), abs(two - middle)) + 0.125 * half**2 * self.family.matrix_bend,
            0.0,
        )
        slack = bowed + change @ radius
        return self._problem(np.column_stack([middle * radius, -slope]), straight, slack), centre, radius

    def _problem(self, matrix: Array, side: Array, slack: Array) -> Problem:
        """Rows side − matrix · v with their slack, and −1 ≤ v ≤ 1; equalities without slack stay what they are."""
        p, count = self.equalities, matrix.shape[1]
        exact = slack[:p] <= 0.0
        loose, given, room = matrix[:p][~exact], side[:p][~exact], slack[:p][~exact]
        rows, right, wide = matrix[p:], side[p:], slack[p:].copy()
        for head, size in self._blocks():
            wide[head] += np.linalg.norm(wide[head + 1 : head + size])
            wide[head + 1 : head + size] = 0.0
        above, first = right + wide, self.cones.l
        box = np.eye(count)
        return Problem(
            c=np.zeros(count),
            A=matrix[:p][exact],
            b=side[:p][exact],
            G=np.vstack([box, -box, loose, -loose, rows]),
            h=np.concatenate([np.ones(2 * count), given + room, room - given, above]),
            cones=Cones(first + 2 * count + 2 * int((~exact).sum()), self.cones.q),
        )

    def _blocks(self) -> list[tuple[int, int]]:
        """First rows and sizes of the cones, of the rows of G."""
        heads = self.cones.l + np.concatenate([[0], np.cumsum(self.cones.q)]).astype(int)
        return list(zip(heads[:-1].tolist(), self.cones.q, strict=True))

    def narrowed(self, piece: _Piece) -> _Piece:
        """The piece with its box and its ends drawn in. Raises _Proven where no time of it will do."""
        self._ask(self.relaxed(piece)[0], None)
        for _ in range(ROUNDS):
            problem, centre, radius = self.relaxed(piece)
            turning = np.append(self.moving.any(axis=0) & (radius > 0.0), True)
            low, high = -np.ones(turning.size), np.ones(turning.size)
            for k in np.flatnonzero(turning).tolist():
                high[k] = min(1.0, self._ask(problem, (k, 1.0)))
                low[k] = max(-1.0, -self._ask(problem, (k, -1.0)))
                if low[k] > high[k]:
                    raise _Proven
            middle, half = 0.5 * (piece.low_s + piece.high_s), 0.5 * (piece.high_s - piece.low_s)
            piece = _Piece(
                middle + half * float(low[-1]),
                middle + half * float(high[-1]),
                centre + radius * low[:-1],
                centre + radius * high[:-1],
            )
            if (0.5 * (high - low))[turning].max() > NARROWED:
                break
        return piece

    def _ask(self, problem: Problem, towards: tuple[int, float] | None) -> float:
        """Above sign · v[k] of every point of a problem, for `towards` = (k, sign). Raises _Proven where there is none."""
        wanted = np.zeros(problem.n)
        if towards is not None:
            wanted[towards[0]] = towards[1]
        solution = self.solve(
            Problem(c=-wanted, A=problem.A, b=problem.b, G=problem.G, h=problem.h, cones=problem.cones),
            Settings(tol=TOLERANCE),
        )
        self.solves += 1
        y, z = np.asarray(solution.y), np.asarray(solution.z)
        size = float(abs(y).sum() + abs(z).sum())
        if not np.isfinite(size):
            return float("inf")
        if solution.status is Status.PRIMAL_INFEASIBLE and size > 0.0:
            if above(problem, y / size, z / size, np.zeros(problem.n)) < 0.0:
                raise _Proven
            return float("inf")
        return above(problem, y, z, wanted)


def above(problem: Problem, y: Array, z: Array, wanted: Array) -> float:
    """Above wantedᵀv of every feasible v, whose box −1 ≤ v ≤ 1 is the first 2n rows, by any multipliers.

    wantedᵀv ≤ wantedᵀv + zᵀ(h − Gv) + yᵀ(b − Av) ≤ hᵀz + bᵀy + ‖wanted − Gᵀz − Aᵀy‖₁, without the box's own rows.
    Below 0 with nothing wanted, there is no feasible v.
    """
    z = project_dual(problem, z)
    z[: 2 * problem.n] = 0.0
    matrix, equal = problem.G.toarray(), problem.A.toarray()
    left = wanted - matrix.T @ z - equal.T @ y
    terms = abs(z) @ (abs(problem.h) + abs(matrix).sum(axis=1)) + abs(y) @ (
        abs(problem.b) + abs(equal).sum(axis=1)
    )
    value = float(problem.h @ z + problem.b @ y + abs(left).sum())
    return value + ROUNDED * float(terms + abs(wanted).sum())
