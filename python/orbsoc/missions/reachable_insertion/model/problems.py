"""The three convex subproblems of the mission: shortest burn, and largest orbit with the perigee fixed or free.

Each is a `linearise` for `orbsoc.guidance.scp`: about a reference it builds the conic problem and reads the next one.

Terminal conditions H(x_f) = S_H H_f and L(x_f) = S_L L_f of the paper (eqs. 6–7) are six equations of rank
five, because H·L = 0 on any orbit; linearised, all six together have no solution from any propagated guess.
With n, l the directions of H_f, L_f and q = n × l, these five say the same:
l·H = 0, q·H = 0, n·H = S_H |H_f|, l·L = S_L |L_f|, q·L = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from orbsoc.conic.builder import ConicBuilder, Term, Variable
from orbsoc.conic.solution import Solution
from orbsoc.guidance.powered_flight import Burn, BurnVariables, Trajectory, add_burn, read_burn, stored
from orbsoc.guidance.scp import Step, Subproblem
from orbsoc.orbit.array import Array

from .. import tuning
from ..targets.rows import PLANE_ROWS, TERMINAL_ROWS, Row
from ..targets.target import Target
from ..targets.target_orbit import LargestOrbit, LinearVectors
from .attitude_rate import RateBound

Figures = Callable[[Trajectory], Mapping[str, float]]
"""A mission's own columns of the iteration table."""
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class Iterate:
    """A reference of the sequence: the trajectory, the paper's S_H and S_L, and the slack of each terminal row."""

    trajectory: Trajectory
    momentum_scale: float = 1.0
    laplace_scale: float = 1.0
    slack: tuple[tuple[Row, float], ...] = ()


@dataclass(frozen=True, slots=True)
class _BurnProblem(Generic[T]):
    """What the three have in common; `slack_weight` is the L1 penalty of terminal rows, without which they are hard."""

    burn: Burn
    target: T
    slack_weight: float | None
    figures: Figures
    turn: RateBound | None = None

    def _begun(self, reference: Trajectory, worth: float) -> tuple[ConicBuilder, BurnVariables]:
        """The collocated burn and the bound on its turn, where a unit of time without thrust adds `worth` to the cost."""
        builder = ConicBuilder()
        variables = add_burn(builder, self.burn, reference, free_duration=isinstance(self, MinTime))
        if self.turn is not None:
            self.turn.add(builder, variables, reference, worth)
        return builder, variables

    def _step(
        self,
        builder: ConicBuilder,
        solution: Solution,
        reference: Iterate,
        slack: Slack | None,
        scales: tuple[float, float] = (1.0, 1.0),
    ) -> Step[Iterate]:
        """The next iterate, how far it moved, and its total slack."""
        last, free = reference.trajectory, isinstance(self, MinTime)
        trajectory = read_burn(builder, solution, last, free_duration=free)
        violations = slack.read(builder, solution) if slack else ()
        total = sum(abs(value) for _, value in violations)
        iterate = Iterate(trajectory, *scales, violations)
        return Step(iterate, trajectory.change_from(last), total, self.figures(trajectory))


@dataclass(frozen=True, slots=True)
class MinTime(_BurnProblem[Target]):
    """Problem A (eqs. 13, 20): the shortest burn onto the target orbit; S_H = S_L = 1. Elements left free have no row."""

    def __call__(self, reference: Iterate) -> Subproblem[Iterate]:
        builder, variables = self._begun(reference.trajectory, worth=1.0)
        assert variables.duration is not None
        assert self.slack_weight is not None
        builder.cost(variables.duration, [1.0])
        block, rhs = self.target.linear_rows(reference.trajectory.end)
        slack = Slack.add(builder, self.target.rows, self.slack_weight)
        builder.equality([(variables.end, stored(block)), *slack.terms()], rhs)
        return Subproblem(builder.build(), lambda solution: self._step(builder, solution, reference, slack))


@dataclass(frozen=True, slots=True)
class MaxEnergyFixedPerigee(_BurnProblem[LargestOrbit]):
    """Problem B (eqs. 10, 19): the largest S_H with the perigee radius and direction given; S_L ≥ 0.

    r_p = r_pf means S_H² p_f = r_pf (1 + S_L e_f), linearised in S_H.
    """

    def __call__(self, reference: Iterate) -> Subproblem[Iterate]:
        end, target, gain = reference.trajectory.end, self.target, tuning.GAIN
        worth = gain * self.burn.acceleration * float(np.linalg.norm(end[:3])) / target.momentum
        builder, variables = self._begun(reference.trajectory, worth)
        assert self.slack_weight is not None
        gains = builder.variable("gains", 2)
        reached = np.array([reference.momentum_scale, reference.laplace_scale])
        builder.nonnegative([(gains, -np.eye(2) / gain)], reached)
        builder.cost(gains, [-1.0, 0.0])

        block, rhs = target.scaled_rows(end)
        by_scales = np.zeros((5, 2))
        by_scales[2, 0], by_scales[3, 1] = -target.momentum, -target.eccentricity
        slack = Slack.add(builder, TERMINAL_ROWS, gain * self.slack_weight)
        terms = [(variables.end, stored(block)), (gains, by_scales / gain), *slack.terms()]
        builder.equality(terms, rhs - by_scales @ reached)

        p, radius = target.momentum**2, target.perigee_radius
        perigee_row = np.array([2.0 * reached[0] * p, -radius * target.eccentricity], ndmin=2)
        builder.equality([(gains, perigee_row / gain)], radius + reached[0] ** 2 * p - perigee_row @ reached)

        def read(solution: Solution) -> Step[Iterate]:
            s_h, s_l = reached + builder.value(solution, "gains") / gain
            return self._step(builder, solution, reference, slack, (float(s_h), float(s_l)))

        return Subproblem(builder.build(), read)


@dataclass(frozen=True, slots=True)
class MaxEnergyFreePerigee(_BurnProblem[LargestOrbit]):
    """Largest energy on the target's plane with at least its perigee radius, its direction free.

    e ≤ |H|²/r_p − 1 is one three-dimensional cone in the in-plane components of L, well defined at e = 0; the
    square (n·H)² is linearised.
    """

    def __call__(self, reference: Iterate) -> Subproblem[Iterate]:
        end = reference.trajectory.end
        position, velocity = end[:3], end[3:]
        worth = self.burn.acceleration * float(np.linalg.norm(velocity))
        builder, variables = self._begun(reference.trajectory, worth)
        builder.cost(variables.end, -np.concatenate([position / np.linalg.norm(position) ** 3, velocity]))
        linear, in_plane = LinearVectors.about(end), np.vstack([self.target.perigee, self.target.ahead])
        slack = None
        if self.slack_weight is not None:
            slack = Slack.add(builder, PLANE_ROWS, self.slack_weight, one_sided=(Row.PERIGEE_RADIUS,))
        plane: list[Term] = [(variables.end, stored(in_plane @ linear.momentum_jacobian))]
        builder.equality([*plane, *(slack.terms() if slack else ())], -in_plane @ linear.momentum_value)
        self._add_perigee_cone(builder, variables, end, linear, slack)
        return Subproblem(builder.build(), lambda solution: self._step(builder, solution, reference, slack))

    def _add_perigee_cone(
        self,
        builder: ConicBuilder,
        variables: BurnVariables,
        end: Array,
        linear: LinearVectors,
        slack: Slack | None,
    ) -> None:
        """‖in-plane L‖ ≤ (n·H)²/r_p − 1 with (n·H)² ≈ ĥ² + 2ĥ (n·J)(x − x̂)."""
        normal = self.target.normal
        h = normal @ (linear.momentum_value + linear.momentum_jacobian @ end)
        slope = 2.0 * h * (normal @ linear.momentum_jacobian) / self.target.perigee_radius
        head = h**2 / self.target.perigee_radius - 1.0 - slope @ end
        in_plane = np.vstack([self.target.perigee, self.target.ahead])
        block = -np.vstack([slope, in_plane @ linear.laplace_jacobian])
        terms: list[Term] = [(variables.end, stored(block))]
        if slack is not None:
            terms += slack.one_sided_terms(size=3)
        builder.second_order(terms, np.concatenate([[head], in_plane @ linear.laplace_value]))


@dataclass(frozen=True, slots=True, eq=False)
class Slack:
    """Slack with an L1 penalty on named rows, two-sided on equalities and one-sided on cone heads.

    The unknown is `weight` × the violation. Its cost is then 1 and its coefficient 1/weight, so that the weight
    is not part of the scale against which a solver judges its dual residual.
    """

    rows: tuple[Row, ...]
    one_sided: tuple[Row, ...]
    weight: float
    above: Variable
    below: Variable
    head: Variable | None

    @classmethod
    def add(
        cls, builder: ConicBuilder, rows: tuple[Row, ...], weight: float, *, one_sided: tuple[Row, ...] = ()
    ) -> Slack:
        """New non-negative unknowns with unit cost."""
        above, below = (
            builder.variable("slack_above", len(rows)),
            builder.variable("slack_below", len(rows)),
        )
        head = builder.variable("slack_head", len(one_sided)) if one_sided else None
        for variable in (above, below) if head is None else (above, below, head):
            builder.nonnegative([(variable, -np.eye(variable.index.size))], np.zeros(variable.index.size))
            builder.cost(variable, 1.0)
        return cls(rows, one_sided, weight, above, below, head)

    def terms(self) -> list[Term]:
        """+ above − below for the equality rows."""
        identity = np.eye(len(self.rows)) / self.weight
        return [(self.above, identity), (self.below, -identity)]

    def one_sided_terms(self, *, size: int) -> list[Term]:
        """+ head on the first row of one cone of `size`."""
        if self.head is None:
            return []
        block = np.zeros((size, 1))
        block[0, 0] = -1.0 / self.weight
        return [(self.head, block)]

    def read(self, builder: ConicBuilder, solution: Solution) -> tuple[tuple[Row, float], ...]:
        """Violation of each named row, signed on equalities: (row − rhs) at the solution."""
        signed = builder.value(solution, "slack_below") - builder.value(solution, "slack_above")
        values = [*zip(self.rows, signed / self.weight, strict=True)]
        if self.head is not None:
            values += zip(self.one_sided, builder.value(solution, "slack_head") / self.weight, strict=True)
        return tuple((row, float(value)) for row, value in values)
