"""The conic problem about a reference flight: points, holds, corridor, speed and engine, the keep-out by half-spaces.

Every condition holds at instants on the arc after an impulse, as rows on the state just before it and the impulse. The arc has rows
for a number of instants, zeros where they are not needed: all problems of a plan have one sparsity pattern, or few.
Beyond its planes a flight is outside; one slack, at a price, tells by how much that cannot be.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from orbsoc.conic import csc
from orbsoc.conic.builder import ConicBuilder
from orbsoc.conic.problem import Problem
from orbsoc.conic.solution import Solution
from orbsoc.guidance.impulses import ImpulseProgramme, Impulses
from orbsoc.guidance.safety import states_after
from orbsoc.orbit.array import Array, Index

from .approach import Approach
from .instants import AWAY, KEEP_OUT, KINDS, Instants, Room
from .rows import WORTH_M, Reference, heights, rows_of

ENTERED = "metres inside the keep-out"
PRICE = 1.0
"""Of a metre inside, in m/s: far above what a metre of the keep-out costs."""


def flown(approach: Approach, programme: ImpulseProgramme) -> Array:
    """What arcs begin with: states just after each impulse, (K, 6), the first of them at the start.

    With thrust that is held, the states there, and the velocity change of the arc, (K, 9).
    """
    if approach.held:
        return _pushed(approach, programme)
    return states_after(programme, approach.start, approach.motion, float(approach.times_s[0]))


def _pushed(approach: Approach, programme: ImpulseProgramme) -> Array:
    count = len(programme)
    ends = approach.responses(approach.ends_s, np.arange(count), np.ones(count))
    begun = np.zeros((count, 9))
    begun[:, 6:] = programme.dv_m_s
    begun[0, :6] = approach.start
    for k in range(1, count):
        begun[k, :6] = ends[k - 1] @ begun[k - 1]
    return begun


@dataclass(frozen=True, slots=True, eq=False)
class Filled:
    """A problem with the instants that it asks for, and where their rows are."""

    form: Form
    problem: Problem
    instants: Instants
    where: dict[str, Index]
    """Of each condition the rows of its instants in h, (S, rows)."""

    def programme(self, solution: Solution) -> ImpulseProgramme:
        """The impulses of a solution."""
        return self.form.impulses.programme(solution)

    def entered(self, solution: Solution) -> float:
        """The slack, m."""
        return max(float(self.form.builder.value(solution, ENTERED)[0]), 0.0)

    def slacks(self, solution: Solution) -> dict[str, Array]:
        """By how much each row is kept, (S,) of each condition, in metres or what they are worth."""
        found = {}
        for kind, rows in self.where.items():
            s = solution.s[rows]
            found[kind] = WORTH_M[kind] * (s[:, 0] - np.linalg.norm(s[:, 1:], axis=1))
        return found

    def why(self, solution: Solution) -> str:
        """Of a problem that is proved infeasible, the conditions that contradict each other."""
        return self.form.builder.why(solution, self.problem.h)


class Form:
    """The pattern of all problems of an approach with some room, and where the numbers of its instants go."""

    def __init__(self, approach: Approach, room: Room) -> None:
        self.approach, self.room, self.builder = approach, room, ConicBuilder()
        axes = (0, 1) if approach.planar else (0, 1, 2)
        self.impulses = Impulses(
            self.builder, approach.motion, approach.times_s, approach.start, linked=True, axes=axes,
            until_s=approach.ends_s if approach.held else None,
        )  # fmt: skip
        self._convex()
        self._entered = int(self.builder.variable(ENTERED, 1).index[0])
        self.builder.cost([self._entered], PRICE)
        self.builder.nonnegative([([self._entered], [[-1.0]])], 0.0)
        self._heights = heights(approach)
        self._names = {kind: self._reserve(kind) for kind in KINDS}

    def _convex(self) -> None:
        """What does not depend on instants."""
        engine, impulses, builder = self.approach.scenario.engine, self.impulses, self.builder
        impulses.cost(engine.cost)
        dv, bounds = impulses.dv, impulses.bounds
        most = self.approach.largest_m_s
        by_axis = np.repeat(most, len(impulses.axes))
        if (engine.limit, engine.cost) in (("norm", "norms"), ("axes", "absolutes")):
            assert bounds is not None  # what is counted is what is limited
            each = most if engine.limit == "norm" else by_axis
            builder.nonnegative([(bounds, np.eye(bounds.index.size))], each, name="engine")
        elif engine.limit == "axes":
            builder.bounds(dv, -by_axis, by_axis, name="engine")
        else:
            size = len(impulses.axes)
            builder.norm([(dv, np.eye(dv.index.size))], bound=most, size=size, name="engine")
        plane = np.eye(6)[[0, 1, 3, 4]] if self.approach.planar else np.eye(6)
        many = len(plane) // 2
        begun_s = float(self.approach.times_s[0])
        for name, point in self.approach.scenario.points.items():
            position, velocity = point.position(), point.velocity()
            ahead = point.arrive_s > begun_s
            if ahead:
                impulses.meet(
                    point.arrive_s, position[:many], matrix=plane[:many], before=True, name=f"reach {name}"
                )
            if velocity is not None and (ahead or (point.hold_s and point.arrive_s == begun_s)):
                impulses.meet(
                    point.arrive_s, velocity[:many], matrix=plane[many:],
                    before=self.approach.held or not point.hold_s,
                    name=f"velocity at {name}",
                )  # fmt: skip

    def _reserve(self, kind: str) -> list[list[str]]:
        """Rows for every arc, zeros but stored."""
        height, names = self._heights[kind], []
        for arc, count in enumerate(self.room.counts[kind].tolist()):
            columns = self._columns(arc, kind)
            zeros, ones = np.zeros((height, len(columns))), np.eye(height)[0]
            after = f"{kind.replace('_', '-')} after {self.approach.times_s[arc]:.0f} s"
            own = [f"{after} (row {number})" for number in range(1, count + 1)]
            for name in own:
                if height == 1:
                    self.builder.nonnegative([(columns, zeros)], ones, zeros=True, name=name)
                else:
                    self.builder.second_order([(columns, zeros)], ones, zeros=True, name=name)
            names.append(own)
        return names

    def _columns(self, arc: int, kind: str) -> list[int]:
        """Of the state before an impulse, the impulse, and the slack: what the rows after it depend on."""
        state = self.impulses.state_columns(arc)
        slack = [self._entered] if kind == KEEP_OUT else []
        return [*state.tolist(), *self.impulses.dv.index[arc].tolist(), *slack]

    @cached_property
    def _template(self) -> Problem:
        return self.builder.build()

    @cached_property
    def _places(self) -> dict[str, tuple[Index, Index, Index]]:
        """Of each condition: of each arc's first place the number (K,), and of each place the positions in G's numbers
        (places, rows, columns) and the rows in h (places, rows). Arc 0 has no state: its numbers go nowhere."""
        G = self._template.G
        found: dict[str, tuple[Index, Index, Index]] = {}
        keys = np.repeat(np.arange(G.shape[1]), np.diff(G.indptr)) * G.shape[0] + G.indices
        full = len(self.impulses.driven)
        for kind in KINDS:
            height, counts = self._heights[kind], self.room.counts[kind]
            width = full + len(self.impulses.axes) + (kind == KEEP_OUT)
            positions, sides = [np.empty((0, height, width), np.intp)], [np.empty((0, height), np.intp)]
            for arc, names in enumerate(self._names[kind]):
                columns = np.array(self._columns(arc, kind), np.intp)
                for name in names:
                    rows = self.builder.rows(name)
                    at = np.searchsorted(keys, columns[None] * G.shape[0] + rows[:, None])
                    nowhere = np.full((height, width - len(columns)), G.nnz)
                    positions.append(np.concatenate([nowhere, at], axis=1)[None])
                    sides.append(rows[None])
            first = np.concatenate([[0], np.cumsum(counts)[:-1]])
            found[kind] = first, np.concatenate(positions), np.concatenate(sides)
        return found

    def filled(
        self, instants: Instants, about: Reference, normals: Array | None, away: Array | None
    ) -> Filled:
        """The problem that asks for these instants; all planes have the normals (K, 3) of their arcs, or are seen from
        the reference. Drifts move away as the normals `away` do."""
        template = self._template
        where: dict[str, Index] = {}
        G, numbers, h = template.G, np.append(template.G.data, 0.0), template.h.copy()
        impulses, driven = self.impulses, self.impulses.driven
        for kind in KINDS:
            wanted = instants.of(kind)
            first, positions, sides = self._places[kind]
            if not wanted:
                where[kind] = np.empty((0, self._heights[kind]), np.intp)
                continue
            matrix, constant = rows_of(about.approach, kind, wanted, about, away if kind == AWAY else normals)
            taken: dict[int, int] = {}
            places = []
            for each in wanted:
                places.append(first[each.arc] + taken.get(each.arc, 0))
                taken[each.arc] = taken.get(each.arc, 0) + 1
            arcs = np.array([each.arc for each in wanted])
            fractions = np.array([each.fraction for each in wanted])
            state, kick = matrix[:, :, :6], matrix[:, :, 6:]
            if not self.approach.held:  # an impulse that is flown by a fraction
                kick = fractions[:, None, None] * matrix[:, :, 3:]
            parts = [-state[:, :, driven], -kick[:, :, list(impulses.axes)]]
            if kind == KEEP_OUT:
                parts.append(np.full((len(wanted), 1, 1), -1.0))
            numbers[positions[places]] = np.concatenate(parts, axis=2)
            known = np.einsum("srj,sj->sr", state, impulses.known_before(arcs))
            h[sides[places]] = constant + known
            where[kind] = sides[places]
        filled = csc.from_parts(numbers[:-1], G.indices, G.indptr, G.shape)
        problem = Problem(c=template.c, A=template.A, b=template.b, G=filled, h=h, cones=template.cones)
        return Filled(self, problem, instants, where)


class Forms:
    """The pattern of an approach as it is; another one only where rows that matter would have no room."""

    def __init__(self, approach: Approach) -> None:
        self.form = Form(approach, Room.of(approach))

    def begun(self, first: Instants, more: Instants) -> Instants:
        """What the first problem of a sequence asks for."""
        unknown = {kind: np.zeros(len(first.of(kind))) for kind in KINDS}
        return self._in_room(*self.form.room.fitted(first, unknown, more))

    def fitted(self, filled: Filled, solution: Solution, new: Instants) -> Instants:
        """What the next problem asks for: of the instants of this one and new ones those that matter."""
        return self._in_room(*self.form.room.fitted(filled.instants, filled.slacks(solution), new))

    def _in_room(self, instants: Instants, room: Room) -> Instants:
        if room is not self.form.room:
            self.form = Form(self.form.approach, room)
        return instants
