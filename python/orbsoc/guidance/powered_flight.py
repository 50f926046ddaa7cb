"""Powered flight in canonical units, and its linearisation on Legendre–Gauss nodes as rows of a conic problem.

State x = (r, v). The mass is known in advance (constant flow), so it is eliminated: with τ ∈ [−1, 1] over the
burn, m(τ)/m₀ = 1 − qT(τ + 1)/2 and dx/dτ = g(x, u, T) = (T/2)[v; −r/|r|³ + k u], k = F/m. The thrust
direction is relaxed to ‖u‖ ≤ 1. Source: Li et al. 2025, eqs. 1–4 and 14–15; the elimination of the mass and its
derivative by T are ours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from orbsoc.conic.builder import ConicBuilder, HasPoint, Term, Variable
from orbsoc.orbit import CanonicalUnits, Thruster
from orbsoc.orbit.array import Array, Index
from orbsoc.orbit.propagate import Steering

from .collocation import LegendreGauss

SHORTEST = 1e-9
"""Canonical burn time that a linearisation can still be made about."""


@dataclass(frozen=True, slots=True)
class Burn:
    """A constant-thrust burn in canonical units, from `start` (6,).

    `acceleration` is F/m₀ and `flow` is ṁ/m₀; `longest` is the burn time that leaves the dry mass.
    """

    start: Array
    acceleration: float
    flow: float
    longest: float

    @classmethod
    def of(cls, state_si: ArrayLike, thruster: Thruster, longest_s: float, units: CanonicalUnits) -> Burn:
        """Canonical burn of a vehicle in SI units."""
        return cls(
            start=units.state_from_si(np.asarray(state_si, dtype=np.float64)),
            acceleration=thruster.thrust_n / thruster.mass_kg / units.acceleration_m_s2,
            flow=thruster.mass_flow_kg_s / thruster.mass_kg * units.time_s,
            longest=longest_s / units.time_s,
        )

    def thrust_acceleration(self, elapsed: Array) -> Array:
        """k = F/m after the given canonical times."""
        return self.acceleration / (1.0 - self.flow * elapsed)


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A powered arc on a grid of N nodes, canonical: states (N, 6), controls (N, 3), end state (6,), duration."""

    grid: LegendreGauss
    states: Array
    controls: Array
    end: Array
    duration: float

    def elapsed(self) -> Array:
        """Time since ignition at the nodes, (N,)."""
        return 0.5 * self.duration * (self.grid.nodes + 1.0)

    def change_from(self, other: Trajectory) -> float:
        """Largest change of a node state, the end state or the duration."""
        return max(
            float(np.abs(self.states - other.states).max()),
            float(np.abs(self.end - other.end).max()),
            abs(self.duration - other.duration),
        )


@dataclass(frozen=True, slots=True)
class BurnVariables:
    """Unknowns of the collocated burn; `duration` is None when the burn time is fixed."""

    states: Variable
    controls: Variable
    end: Variable
    duration: Variable | None


@dataclass(frozen=True, slots=True, eq=False)
class Linearisation:
    """g at each node to first order about a reference: A, B blocks, ∂g/∂T, and the constant term.

    g ≈ constant + by_state · x + by_control · u + by_duration · T; shapes (N, 6), (N, 6, 6), (N,), (N, 6).
    `by_control` is the scalar of its only non-zero block, (T/2) k I in the velocity rows.
    """

    constant: Array
    by_state: Array
    by_control: Array
    by_duration: Array


def derivative(burn: Burn, at: Trajectory) -> Array:
    """g = dx/dτ at the nodes, shape (N, 6)."""
    position, velocity = at.states[:, :3], at.states[:, 3:]
    radius = _radius(position)[:, None]
    thrust = burn.thrust_acceleration(at.elapsed())[:, None] * at.controls
    return 0.5 * at.duration * np.hstack([velocity, thrust - position / (radius * radius * radius)])


def linearise(burn: Burn, at: Trajectory, *, free_duration: bool) -> Linearisation:
    """First-order expansion of g about `at`; with a fixed duration ∂g/∂T is zero.

    Products for powers and sums in a stated order: `flight/missions/linearise.c` makes the same bits on every machine.
    """
    half = 0.5 * at.duration
    position = at.states[:, :3]
    radius = _radius(position)[:, None, None]
    cube = radius * radius * radius
    outer = position[:, :, None] * position[:, None, :]
    by_state = np.zeros((at.grid.size, 6, 6))
    by_state[:, :3, 3:] = half * np.eye(3)
    by_state[:, 3:, :3] = half * (3.0 * outer / (cube * radius * radius) - np.eye(3) / cube)

    elapsed = at.elapsed()
    thrust = burn.thrust_acceleration(elapsed)
    by_control = half * thrust
    value = derivative(burn, at)
    by_duration = np.zeros_like(value)
    if free_duration:
        # A longer burn moves every node later, where the vehicle is lighter: ∂k/∂T = k q (τ+1)/(2m).
        lightening = thrust * burn.flow * (elapsed / at.duration) / (1.0 - burn.flow * elapsed)
        by_duration = value / at.duration
        by_duration[:, 3:] += half * lightening[:, None] * at.controls
    moved = np.hstack([half * at.states[:, 3:], _dot(by_state[:, 3:, :3], position[:, None, :])])
    constant = value - moved - by_duration * at.duration
    constant[:, 3:] -= by_control[:, None] * at.controls
    return Linearisation(constant, by_state, by_control, by_duration)


def add_burn(
    builder: ConicBuilder, burn: Burn, reference: Trajectory, *, free_duration: bool
) -> BurnVariables:
    """Add the collocated, linearised burn: unknowns, dynamics, end state, ‖uᵢ‖ ≤ 1 and bounds on the duration.

    The bounds are the paper's trust region |T − T̂| ≤ T̂ (eq. 18) and its propellant (eq. 5). The sparsity
    pattern depends on the grid only, so every iteration of a mission has the same one.
    """
    count, grid = reference.grid.size, reference.grid
    variables = BurnVariables(
        states=builder.variable("states", (count, 6)),
        controls=builder.variable("controls", (count, 3)),
        end=builder.variable("end", 6),
        duration=builder.variable("duration", 1) if free_duration else None,
    )
    linear = linearise(burn, reference, free_duration=free_duration)
    _add_dynamics(builder, burn, grid, linear, variables)
    _add_unit_balls(builder, variables.controls)
    if variables.duration is not None:
        longest = min(2.0 * reference.duration, burn.longest)
        builder.nonnegative([(variables.duration, [[-1.0], [1.0]])], [0.0, longest])
    return variables


def read_burn(
    builder: ConicBuilder, solution: HasPoint, reference: Trajectory, *, free_duration: bool
) -> Trajectory:
    """The trajectory at a solution of the built problem."""
    duration = builder.value(solution, "duration")[0] if free_duration else reference.duration
    return Trajectory(
        grid=reference.grid,
        states=builder.value(solution, "states"),
        controls=builder.value(solution, "controls"),
        end=builder.value(solution, "end"),
        duration=max(float(duration), SHORTEST),
    )


def commanded(grid: LegendreGauss, controls: Array, duration_s: float) -> Steering:
    """The steering an attitude programme of nodal directions stands for."""

    def steering(t_s: float, _state: Array) -> Array:
        return np.asarray(grid.interpolate(controls, 2.0 * t_s / duration_s - 1.0)[0])

    return steering


def _dot(a: Array, b: Array) -> Array:
    """Over a last axis of three."""
    products = a * b
    return np.asarray(products[..., 0] + (products[..., 1] + products[..., 2]))


def _radius(position: Array) -> Array:
    return np.asarray(np.sqrt(_dot(position, position)))


def weighted_sum(weights: Array, rows: Array) -> Array:
    """Σ wᵢ rowᵢ, row after row."""
    return np.asarray(sum(weight * row for weight, row in zip(weights, rows, strict=True)))


def stored(block: ArrayLike) -> sparse.coo_array:
    """A dense block with every entry stored, so that a value that happens to be 0 stays in the pattern."""
    dense = np.atleast_2d(np.asarray(block, dtype=np.float64))
    rows, columns = np.indices(dense.shape)
    return sparse.coo_array((dense.ravel(), (rows.ravel(), columns.ravel())), shape=dense.shape)


def _add_dynamics(
    builder: ConicBuilder, burn: Burn, grid: LegendreGauss, linear: Linearisation, variables: BurnVariables
) -> None:
    """Σⱼ Dᵢⱼ xⱼ = gᵢ at every node, where the initial state is data, and x(t_f) = x₀ + Σᵢ wᵢ gᵢ."""
    differentiation = sparse.kron(stored(grid.differentiation[:, 1:]), sparse.eye_array(6))
    from_start = grid.differentiation[:, :1] * burn.start
    one = np.ones(grid.size)
    terms = [(variables.states, differentiation), *_less(one, linear, variables, summed=False)]
    builder.equality(terms, (linear.constant - from_start).ravel())
    weights = grid.weights
    terms = [(variables.end, sparse.eye_array(6)), *_less(weights, linear, variables, summed=True)]
    builder.equality(terms, burn.start + weighted_sum(weights, linear.constant))


def _less(weights: Array, linear: Linearisation, variables: BurnVariables, *, summed: bool) -> list[Term]:
    """−wᵢ gᵢ without its constant, of every node or summed over the nodes."""
    by_state, by_control = -weights[:, None, None] * linear.by_state, -weights * linear.by_control
    terms: list[Term] = [
        (variables.states, _state_blocks(by_state, summed=summed)),
        (variables.controls, _control_blocks(by_control, summed=summed)),
    ]
    if variables.duration is not None:
        column = weighted_sum(weights, linear.by_duration) if summed else linear.by_duration
        terms.append((variables.duration, stored(-column.reshape(-1, 1))))
    return terms


def _add_unit_balls(builder: ConicBuilder, controls: Variable) -> None:
    """(1, uᵢ) ∈ Q⁴ for every node."""
    count = controls.shape[0]
    pick = np.vstack([np.zeros(3), -np.eye(3)])
    heads = np.tile([1.0, 0.0, 0.0, 0.0], count)
    builder.second_order([(controls, sparse.kron(sparse.eye_array(count), pick))], heads, size=4)


def _state_blocks(blocks: Array, *, summed: bool = False) -> sparse.coo_array:
    """∂g/∂x blocks (N, 6, 6) on the diagonal of (6N, 6N), or side by side in (6, 6N) when summed over the nodes.

    Stores the diagonal of the upper right block and the whole lower left one, zero or not.
    """
    count = blocks.shape[0]
    i = np.concatenate([[0, 1, 2], np.repeat([3, 4, 5], 3)])
    j = np.concatenate([[3, 4, 5], np.tile([0, 1, 2], 3)])
    offset: Index = 6 * np.arange(count)[:, None]
    rows: Index = (np.zeros_like(offset) if summed else offset) + i
    entries = (blocks[:, i, j].ravel(), (rows.ravel(), (offset + j).ravel()))
    return sparse.coo_array(entries, shape=(6 if summed else 6 * count, 6 * count))


def _control_blocks(scales: Array, *, summed: bool = False) -> sparse.coo_array:
    """Blocks [0; scale · I] of shape (6, 3), arranged as in `_state_blocks`."""
    count = scales.size
    offset: Index = 6 * np.arange(count)[:, None]
    rows = (np.zeros_like(offset) if summed else offset) + [3, 4, 5]
    entries = (np.repeat(scales, 3), (rows.ravel(), np.arange(3 * count)))
    return sparse.coo_array(entries, shape=(6 if summed else 6 * count, 3 * count))
