"""Impulses as unknowns of a conic problem: states that depend on them, costs, conditions, and the primer vector."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from orbsoc.conic.builder import ConicBuilder, HasPoint, Term, Variable
from orbsoc.conic.named_rows import HasDuals
from orbsoc.orbit.array import Array
from orbsoc.orbit.relative import ClohessyWiltshire, LinearMotion

from .programme import ImpulseProgramme

Cost = Literal["norms", "absolutes", "largest"]

KICK = np.vstack([np.zeros((3, 3)), np.eye(3)])
"""What a velocity change does to a state, (6, 3)."""
POSITION = np.eye(6)[:3]
"""The position of a state, (3, 6)."""


class ImpulsesError(ValueError):
    """Times or shapes given to `Impulses` are wrong."""


@dataclass(frozen=True, slots=True, eq=False)
class Affine:
    """Σ block · x[columns] + offset: what depends on the unknowns of a builder; `matrix @ affine` is one too."""

    terms: tuple[Term, ...]
    offset: Array

    def __rmatmul__(self, matrix: Array) -> Affine:
        return Affine(tuple((columns, matrix @ block) for columns, block in self.terms), matrix @ self.offset)

    # NumPy would otherwise take an Affine for a scalar of type object.
    __array_ufunc__ = None


@dataclass(frozen=True, slots=True)
class _Condition:
    """Rows `matrices[k]` · state(times[k]) under one name; `flipped` where the builder stores them negated."""

    name: str
    times_s: Array
    matrices: Array
    kind: Literal["equality", "nonnegative", "norm", "cone"]
    before: bool


@dataclass(frozen=True, slots=True, eq=False)
class Pull:
    """A condition's multipliers as a vector (6,) on the state at the start: at a time, before its impulse or after it."""

    at_s: float
    before: bool
    cone: bool
    pull: Array


def spread_kick(motion: LinearMotion, t_s: float, from_s: float, until_s: float) -> Array:
    """What a unit of velocity change, spread evenly over a span, has made of the state at a time, (6, 3): about a circular target
    in closed form, otherwise by Gauss's rule of 8 nodes on pieces of a tenth of the span, exact to rounding for spans of up to a
    revolution.
    """
    end = min(t_s, until_s)
    found = np.zeros((6, 3))
    if end <= from_s:
        return found
    if isinstance(motion, ClohessyWiltshire):
        pushed = motion.held(np.asarray(end - from_s))
        return np.asarray(motion.transition(t_s, end) @ pushed / (until_s - from_s))
    nodes, weights = np.polynomial.legendre.leggauss(8)
    edges = np.linspace(from_s, end, 11)
    for low, high in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        half = 0.5 * (high - low)
        for node, weight in zip(nodes.tolist(), weights.tolist(), strict=True):
            found += half * weight * motion.transition(t_s, low + half * (1.0 + node)) @ KICK
    return np.asarray(found / (until_s - from_s))


class Impulses:
    """N velocity changes at given times as a variable (N, 3) of a builder, and the states that follow from them.

    With `axes`, the variable is (N, axes): of (R, T, N), those along which the engine fires; (0, 1) stays in the plane.

    `start` is the state (6,) at `start_s`, the first impulse's time by default; `motion` and all vectors are in the
    frame (R, T, N). `forced`, if given, is the state at a time that a known disturbance alone makes of 0 at `start_s`.
    States are functions of all impulses before them, or, `linked`, of a state variable at the last one: many more
    unknowns and far fewer entries, better where states are bounded at many times. With axes in the plane the state variable
    has the four components in it; the others, of which no impulse knows, are those of the coast from the start.
    With `movable`, velocity changes (N, 3) near the ones sought, the impulses may move by `move`, a variable (N,), s:
    to first order, as if impulse k were the one given. The caller bounds the moves.
    With `until_s` (N,) each velocity change is no impulse but spread from its time until then, at one acceleration.

    >>> from orbsoc.orbit.relative import ClohessyWiltshire
    >>> import orbsoc
    >>> builder = orbsoc.ConicBuilder()
    >>> impulses = Impulses(builder, ClohessyWiltshire(1e-3), [0.0, 900.0], np.zeros(6))
    >>> impulses.cost("norms")
    >>> impulses.meet(900.0, [0.0, 100.0, 0.0, 0.0, 0.0, 0.0], name="capture")
    >>> found = orbsoc.solve(builder.build())
    >>> round(impulses.programme(found).total_m_s, 4)
    0.2388
    """

    def __init__(
        self,
        builder: ConicBuilder,
        motion: LinearMotion,
        times_s: ArrayLike,
        start: ArrayLike,
        *,
        start_s: float | None = None,
        forced: Callable[[float], Array] | None = None,
        linked: bool = False,
        axes: Sequence[int] = (0, 1, 2),
        movable: ArrayLike | None = None,
        until_s: ArrayLike | None = None,
        name: str = "dv",
    ) -> None:
        times = np.array(times_s, dtype=np.float64)
        if times.ndim != 1 or not times.size or np.any(np.diff(times) <= 0.0):
            raise ImpulsesError(f"times_s = {times!r}: must be a non-empty vector of increasing times")
        self.builder, self.motion, self.times_s, self.name = builder, motion, times, name
        self.start_s = float(times[0]) if start_s is None else start_s
        if self.start_s > times[0]:
            raise ImpulsesError(
                f"start_s = {self.start_s:g}: must not be after the first impulse at {times[0]:g}"
            )
        self.start = np.asarray(start, dtype=np.float64)
        if self.start.shape != (6,):
            raise ImpulsesError(
                f"start has shape {self.start.shape}; it must be (6,), a position and a velocity"
            )
        self._forced = forced
        self.axes = tuple(axes)
        self._engine = KICK[:, self.axes]
        self._conditions: list[_Condition] = []
        self._cost: Cost | None = None
        self.bounds: Variable | None = None
        """Of the cost: of each norm (N,), of each component (N · axes,), or of the largest norm (1,)."""
        self._until = times if until_s is None else np.asarray(until_s, dtype=np.float64)
        if (
            self._until.shape != times.shape
            or np.any(self._until[:-1] > times[1:])
            or np.any(self._until < times)
        ):
            raise ImpulsesError("until_s: must be a vector of times, each from an impulse to the next one")
        if movable is not None and until_s is not None:
            raise ImpulsesError("until_s: what is spread cannot move; leave movable out")
        self.dv: Variable = builder.variable(name, (times.size, len(self.axes)))
        self.move: Variable | None = None
        self._moves = np.zeros((times.size, 6))
        if movable is not None:
            self.move = builder.variable(f"{name} move", times.size)
            self._moves = self._moved(np.asarray(movable, dtype=np.float64))
        self._states: Variable | None = None
        self.driven = np.array([0, 1, 3, 4] if set(self.axes) <= {0, 1} else range(6))
        """Components of a state that impulses change."""
        if linked and times.size > 1:
            kept = np.eye(6)[self.driven]
            self._states = builder.variable(f"{name} state", (times.size - 1, self.driven.size))
            for k in range(1, times.size):
                arrival = kept @ self._after(k - 1, float(times[k]))
                own = (self._states.index[k - 1], -np.eye(self.driven.size))
                builder.equality([*arrival.terms, own], -arrival.offset)

    def state(self, t_s: float, *, before: bool = False) -> Affine:
        """The state (6,) at a time; at an impulse's own time that after it, or that before it."""
        k = int(np.searchsorted(self.times_s, t_s, side="left" if before else "right")) - 1
        if t_s < self.start_s:
            raise ImpulsesError(f"t_s = {t_s:g}: must not be before the start at {self.start_s:g}")
        if self._states is None:
            terms = [term for j in range(k + 1) for term in self._kick(t_s, j)]
            return Affine(tuple(terms), self._coasted(t_s, self.start_s, self.start))
        return self._after(k, t_s)

    def state_columns(self, k: int) -> NDArray[np.intp]:
        """Of the driven components of the state just before impulse k, linked, (driven,); none before the first one."""
        none = np.zeros(0, np.intp)
        return self._states.index[k - 1] if k and self._states is not None else none

    def known_before(self, which: NDArray[np.intp]) -> Array:
        """What is known of the states just before impulses (S,), linked: (S, 6), zero where it is sought."""
        found = np.zeros((self.times_s.size, 6))
        found[0] = self._coasted(float(self.times_s[0]), self.start_s, self.start)
        across = self.driven.size < 6 and bool(self.start[2::3].any())
        for k in range(1, self.times_s.size if across else 0):
            found[k, 2::3] = self._coasted(float(self.times_s[k]), self.start_s, self.start)[2::3]
        return found[which]

    def cost(self, kind: Cost = "norms", weight: float = 1.0) -> None:
        """Add to the cost the sum of the 2-norms or of the absolute components, or the largest 2-norm."""
        builder, dv, name = self.builder, self.dv, f"{self.name} {kind}"
        identity = np.eye(dv.index.size)
        if kind == "norms":
            self.bounds = builder.sum_of_norms(name, [(dv, identity)], size=len(self.axes), weight=weight)
        elif kind == "absolutes":
            self.bounds = builder.sum_of_absolutes(name, [(dv, identity)], weight=weight)
        else:
            self.bounds = largest = builder.variable(name, 1)
            bounds = np.repeat(largest.index, len(dv.index))
            builder.norm([(dv, identity)], bound=bounds, size=len(self.axes), name=name)
            builder.cost(largest, weight)
        self._cost = kind

    def meet(
        self,
        t_s: float,
        target: ArrayLike,
        *,
        matrix: ArrayLike | None = None,
        before: bool = False,
        name: str = "meet",
    ) -> None:
        """Require matrix · state = target at a time; without a matrix, target is a whole state, or a position (3,)."""
        value = np.asarray(target, dtype=np.float64)
        rows = np.eye(6)[: value.size] if matrix is None else np.asarray(matrix, dtype=np.float64)
        found = rows @ self.state(t_s, before=before)
        self.builder.equality(found.terms, value - found.offset, name=name)
        self._note(name, [t_s], [rows], "equality", before)

    def below(
        self,
        t_s: float,
        matrix: ArrayLike,
        limit: ArrayLike,
        *,
        extra: Sequence[Term] = (),
        before: bool = False,
        zeros: bool = False,
        name: str,
    ) -> None:
        """Require matrix · state + extra ≤ limit at a time; matrix (rows, 6), limit (rows,) or one number.

        With `zeros`, here and below, the builder stores them: other numbers make the same pattern.
        """
        rows = np.atleast_2d(np.asarray(matrix, dtype=np.float64))
        found = rows @ self.state(t_s, before=before)
        side = np.asarray(limit) - found.offset
        self.builder.nonnegative([*found.terms, *extra], side, zeros=zeros, name=name)
        self._note(name, [t_s], [rows], "nonnegative", before)

    def cone(
        self,
        t_s: float,
        matrix: ArrayLike,
        offset: ArrayLike,
        *,
        extra: Sequence[Term] = (),
        zeros: bool = False,
        name: str,
    ) -> None:
        """Require matrix · state + offset ∈ Q at a time: its first row is at least the norm of the others.

        `extra` terms are added to the rows, for bounds that depend on other unknowns.
        """
        rows = np.asarray(matrix, dtype=np.float64)
        found = -rows @ self.state(t_s)
        less = [(columns, -np.asarray(block)) for columns, block in extra]
        side = np.asarray(offset) - found.offset
        self.builder.second_order([*found.terms, *less], side, zeros=zeros, name=name)
        self._note(name, [t_s], [rows], "cone", False)

    def within(
        self,
        times_s: Sequence[float] | Array,
        centres: ArrayLike,
        bound: float | Variable,
        *,
        margin: float = 0.0,
        name: str,
        also: Sequence[Term] = (),
    ) -> None:
        """Require ‖position(t) − centre‖ ≤ bound − margin at times on one arc, (K,), with centres (K, 3).

        The state at an impulse's time is that after it: one position. `bound` is a number or a variable of one column.
        `also` are further terms of the 3K rows.
        """
        times, points = np.asarray(times_s, dtype=np.float64), np.asarray(centres, dtype=np.float64)
        last = np.searchsorted(self.times_s, times, side="right")
        if times.size == 0 or np.any(last != last[0]):
            raise ImpulsesError(f"times_s = {times!r}: must lie on one arc, between two impulses")
        states = [POSITION @ self.state(float(t)) for t in times]
        terms = [
            (columns, np.vstack([each.terms[j][1] for each in states]))
            for j, (columns, _) in enumerate(states[0].terms)
        ]
        offset = np.concatenate([each.offset for each in states]) - points.ravel()
        limit = np.repeat(bound.index.ravel(), times.size) if isinstance(bound, Variable) else bound
        self.builder.norm([*terms, *also], offset, bound=limit, margin=margin, size=3, name=name)
        self._note(name, times, [POSITION] * times.size, "norm", False)

    def primer(self, solution: HasDuals, times_s: ArrayLike) -> Array:
        """The primer vector (K, 3) at times, from the multipliers of the conditions.

        It is along each impulse that is not zero, and of length 1 there, or of the cost's weight. Impulses at other
        times save nothing where it is nowhere longer; of absolute components, its largest component is what counts.
        Source: Lawden, Optimal Trajectories for Space Navigation, 1963.
        """
        events = self.pulls(solution)
        at = np.atleast_1d(np.asarray(times_s, dtype=np.float64))
        found = np.zeros((at.size, 3))
        for k, t in enumerate(at):
            ahead = [each.pull for each in events if each.at_s > t or (each.at_s == t and not each.before)]
            if ahead:
                found[k] = -KICK.T @ self.motion.transition(self.start_s, float(t)).T @ np.sum(ahead, axis=0)
        return found

    def pulls(self, solution: HasDuals) -> list[Pull]:
        """What the multipliers of every condition want of the state, in the order of the conditions."""
        found: list[Pull] = []
        for condition in self._conditions:
            dual = self.builder.dual(solution, condition.name)
            weights = -dual[:, 1:] if condition.kind == "norm" else dual.reshape(len(condition.times_s), -1)
            weights = -weights if condition.kind == "cone" else weights
            for t, rows, weight in zip(condition.times_s, condition.matrices, weights, strict=True):
                to_start = self.motion.transition(float(t), self.start_s).T
                pull = to_start @ (rows.T @ weight)
                found.append(Pull(float(t), condition.before, condition.kind == "cone", pull))
        return found

    def primer_size(self, solution: HasDuals, times_s: ArrayLike) -> Array:
        """Of the primer at times, (K,), the norm that is dual to the cost's: 2-norm, or largest component."""
        return self.lengths(self.primer(solution, times_s))

    def lengths(self, primer: Array) -> Array:
        """Of primer vectors (K, 3), the norm that is dual to the cost's, (K,)."""
        if self._cost not in ("norms", "absolutes"):
            raise ImpulsesError(
                "the primer bounds a cost that is the sum of norms or of absolutes; call cost first"
            )
        order = 2 if self._cost == "norms" else np.inf
        return np.asarray(np.linalg.norm(primer[:, self.axes], ord=order, axis=1))

    def programme(self, solution: HasPoint) -> ImpulseProgramme:
        """The impulses of a solution."""
        found = np.zeros((self.times_s.size, 3))
        found[:, self.axes] = self.builder.value(solution, self.name)
        return ImpulseProgramme(self.times_s, found)

    def _note(
        self,
        name: str,
        times_s: Sequence[float] | Array,
        matrices: Sequence[Array],
        kind: Literal["equality", "nonnegative", "norm", "cone"],
        before: bool,
    ) -> None:
        self._conditions.append(_Condition(name, np.asarray(times_s), np.asarray(matrices), kind, before))

    def _kick(self, t_s: float, k: int) -> list[Term]:
        """What impulse k, and its move, add to the state at a later time."""
        at, until = float(self.times_s[k]), float(self._until[k])
        if until > at:
            return [(self.dv.index[k], spread_kick(self.motion, t_s, at, until)[:, self.axes])]
        transition = self.motion.transition(t_s, at)
        terms: list[Term] = [(self.dv.index[k], transition @ self._engine)]
        if self.move is not None:
            terms.append((self.move.index[k : k + 1], (transition @ self._moves[k])[:, None]))
        return terms

    def _moved(self, dv_m_s: Array) -> Array:
        """Of each impulse, what a second's delay does to the state at its time: −A (0, dv), with ẋ = A x."""
        found = np.empty((self.times_s.size, 6))
        for k, t in enumerate(self.times_s.tolist()):
            rate = 0.5 * (self.motion.transition(t + 1.0, t) - self.motion.transition(t - 1.0, t))
            found[k] = -rate @ self._engine @ dv_m_s[k]
        return found

    def _coasted(self, t_s: float, from_s: float, state: Array) -> Array:
        """A known state carried on, with what the disturbance adds."""
        transition = self.motion.transition(t_s, from_s)
        if self._forced is None:
            return transition @ state
        return transition @ (state - self._forced(from_s)) + self._forced(t_s)

    def _after(self, k: int, t_s: float) -> Affine:
        """The state on the arc of impulse k, by the state variable at it; −1 is the coast before the first."""
        if k < 1:
            return Affine(
                tuple(self._kick(t_s, 0) if k == 0 else ()), self._coasted(t_s, self.start_s, self.start)
            )
        assert self._states is not None
        at = float(self.times_s[k])
        state = (self._states.index[k - 1], self.motion.transition(t_s, at)[:, self.driven])
        offset = self._coasted(t_s, at, np.zeros(6))
        if self.driven.size < 6:
            offset[2::3] = self._coasted(t_s, self.start_s, self.start)[2::3]
        return Affine((state, *self._kick(t_s, k)), offset)
