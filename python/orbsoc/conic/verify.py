"""Independent verification: residuals, gap and certificates recomputed from the data of the problem.

Plain NumPy on the problem as the user gave it; nothing here is shared with the code that iterates. Norms are
∞-norms unless they say otherwise, and dist_K(v) is the norm of v − Π_K(v), Π_K the Euclidean projection.
An R₊ row with h = +inf does not constrain: it takes no part in primal norms, and its multiplier must be zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from . import csc
from .cones import Cones
from .csc import Array
from .outcome import Certificate, Start, Status
from .problem import Problem

RADIUS_FACTOR = 50.0
"""An infeasibility status needs a certified radius of at least this factor times the scale of the data.

Certificates of the infeasible NETLIB problems reach 99 and more; the false one known for the feasible POWELL20, 0.4.
"""


class HasPoint(Protocol):
    """Anything with a primal-dual point: x (n,), y (p,), z (m,)."""

    @property
    def x(self) -> Array: ...
    @property
    def y(self) -> Array: ...
    @property
    def z(self) -> Array: ...


class HasStatus(HasPoint, Protocol):
    """A primal-dual point with slacks s (m,) and its status."""

    @property
    def s(self) -> Array: ...
    @property
    def status(self) -> Status: ...


@dataclass(frozen=True, slots=True)
class Verification:
    """How far (x, y, z) is from optimal, one formula for every solver; infinite where the point is not finite."""

    pres: float
    """max(‖Ax − b‖, dist_K(h − Gx)) / (1 + max(‖b‖, ‖h‖))"""
    dres: float
    """max(‖Px + c + Aᵀy + Gᵀz‖, dist_K(z)) / (1 + ‖c‖)"""
    gap: float
    """|p − d| / (1 + min(|p|, |d|)) with p = ½xᵀPx + cᵀx and d = −½xᵀPx − bᵀy − hᵀz"""

    @property
    def worst(self) -> float:
        return max(self.pres, self.dres, self.gap)


@dataclass(frozen=True, slots=True)
class Residuals:
    """The residuals that must support a status, each to be compared with the tolerance ε (radius: with the scale).

    Infinite where the point is not finite. `radius` and `scale` are NaN unless the status is an infeasibility.
    """

    equality: float
    """‖Ax − b‖ / (1 + max(‖Ax‖, ‖b‖))"""
    inequality: float
    """‖Gx + s − h‖ / (1 + max(‖Gx‖, ‖h‖))"""
    slack_cone: float
    """dist_K(s) / (1 + ‖s‖)"""
    stationarity: float
    """‖Px + c + Aᵀy + Gᵀz‖ / (1 + max(‖Px‖, ‖Aᵀy‖, ‖Gᵀz‖, ‖c‖))"""
    dual_cone: float
    """dist_K(z) / (1 + ‖z‖)"""
    gap: float
    """|p − d| / (1 + min(|p|, |d|))"""
    radius: float
    """ρ: no feasible point of the infeasible side has an ∞-norm below it"""
    scale: float
    """max(1, s, s / (100 × largest entry of A, G)), where s is max(‖b‖, ‖h‖) for primal infeasibility, ‖c‖ for dual, and the larger of
    both for dual where P is not zero, for a dual point has an x in it then."""
    own_radius: float = float("nan")
    """The radius in the certificate's own scale, the same in all units of rows, variables and cost; 50 are as good as 50 scales"""

    def worst_line(self) -> tuple[str, float]:
        """The name and value of the largest of the six residual ratios."""
        names = ("equality", "inequality", "slack_cone", "stationarity", "dual_cone", "gap")
        return max(((name, float(getattr(self, name))) for name in names), key=lambda line: line[1])

    def supports(self, status: Status, tol: float) -> bool:
        """Whether these numbers allow `status` to be returned at tolerance `tol` (always, where it is a limit)."""
        if status in (Status.SOLVED, Status.SOLVED_INACCURATE):
            return self.worst_line()[1] <= tol
        if status in (Status.PRIMAL_INFEASIBLE, Status.DUAL_INFEASIBLE):
            return self.radius >= RADIUS_FACTOR * self.scale or self.own_radius >= RADIUS_FACTOR
        return True

    def certificate(self) -> Certificate:
        """The summary that a `Solution` carries."""
        return Certificate(
            primal_residual=max(self.equality, self.inequality, self.slack_cone),
            dual_residual=max(self.stationarity, self.dual_cone),
            gap=self.gap,
            radius=self.radius,
        )


def verify(problem: Problem, solution: HasPoint) -> Verification:
    """The residuals of any solver's x, y, z; the slack is recomputed as h − Gx.

    Raises ProblemError if a vector does not have the problem's size, or is none of real numbers; TypeError for no problem, or
    no point.
    """
    at = _point(problem, solution)
    with np.errstate(all="ignore"):
        x, y, z = at.x, at.y, at.z
        finite_h, constrains = _constraining(problem)
        slack = np.where(constrains, problem.h - problem.G @ x, 0.0)
        primal = _largest(_norm(problem.A @ x - problem.b), _norm(_outside(slack, problem.cones)))
        stationarity = problem.P @ x + problem.c + problem.A.T @ y + problem.G.T @ z
        dual = _largest(_norm(stationarity), _norm(z - project_dual(problem, z)))
        return Verification(
            pres=_or_inf(primal / (1.0 + max(_norm(problem.b), _norm(finite_h)))),
            dres=_or_inf(dual / (1.0 + _norm(problem.c))),
            gap=_gap(*objectives(problem, at)),
        )


def check_certificate(problem: Problem, solution: HasStatus) -> Residuals:
    """The residuals behind the status of `solution`, recomputed on the problem's data.

    Raises ProblemError if a vector does not have the problem's size, or is none of real numbers.
    """
    at = _point(problem, solution, slack=solution.s)
    x, y, z, s = at.x, at.y, at.z, at.s
    radius = scale = own_radius = float("nan")
    if solution.status is Status.PRIMAL_INFEASIBLE:
        radius = primal_infeasibility_radius(problem, y, z)
        own_radius = _own_primal_radius(problem, y, z)
        scale = _data_scale(problem, _largest_side(problem))
    elif solution.status is Status.DUAL_INFEASIBLE:
        radius = dual_infeasibility_radius(problem, x)
        own_radius = _own_dual_radius(problem, x)
        of_x = _largest_side(problem) if problem.P.nnz else 0.0
        scale = _data_scale(problem, max(_norm(problem.c), of_x))
    with np.errstate(all="ignore"):
        finite_h, constrains = _constraining(problem)
        Ax, Gx = problem.A @ x, np.where(constrains, problem.G @ x, 0.0)
        slack = np.where(constrains, s, 0.0)
        Px, Ay, Gz = problem.P @ x, problem.A.T @ y, problem.G.T @ z
        dual_norm = _largest(_norm(Px), _norm(Ay), _norm(Gz), _norm(problem.c))
        return Residuals(
            equality=_ratio(Ax - problem.b, _largest(_norm(Ax), _norm(problem.b))),
            inequality=_ratio(Gx + slack - finite_h, _largest(_norm(Gx), _norm(finite_h))),
            slack_cone=_ratio(_outside(slack, problem.cones), _norm(slack)),
            stationarity=_ratio(Px + problem.c + Ay + Gz, dual_norm),
            dual_cone=_ratio(z - project_dual(problem, z), _norm(z)),
            gap=_gap(*objectives(problem, at)),
            radius=radius,
            scale=scale,
            own_radius=own_radius,
        )


def primal_infeasibility_radius(problem: Problem, y: Array, z: Array) -> float:
    """ρ = −(bᵀy + hᵀz) / ‖Aᵀy + Gᵀz‖₁ with z projected onto K first: no feasible x has ‖x‖∞ < ρ.

    For feasible x, 0 ≤ zᵀ(h − Gx) = hᵀz + bᵀy − xᵀ(Aᵀy + Gᵀz). Zero if the pair proves nothing; infinite if
    Aᵀy + Gᵀz vanishes.
    """
    with np.errstate(all="ignore"):
        z = project_dual(problem, z)
        finite_h, _ = _constraining(problem)
        gain = -float(problem.b @ y + finite_h @ z)
        return _radius(gain, problem.A.T @ y + problem.G.T @ z)


def dual_infeasibility_radius(problem: Problem, x: Array) -> float:
    """ρ = −cᵀx / ‖(Px, Ax, −Gx − Π_K(−Gx))‖₁: no dual feasible (x', y, z) has an ∞-norm below ρ.

    For dual feasible (x', y, z), −cᵀx = x'ᵀPx + yᵀAx + zᵀGx, and zᵀGx ≤ zᵀ(Gx + Π_K(−Gx)). Zero if x proves
    nothing; infinite if the denominator vanishes.
    """
    with np.errstate(all="ignore"):
        _, constrains = _constraining(problem)
        direction = np.where(constrains, -(problem.G @ x), 0.0)
        obstacles = np.concatenate([problem.P @ x, problem.A @ x, _outside(direction, problem.cones)])
        return _radius(-float(problem.c @ x), obstacles)


def _own_primal_radius(problem: Problem, y: Array, z: Array) -> float:
    """The same with x_j counted in (|b|ᵀ|y| + |h|ᵀ|z|) / (|A|ᵀ|y| + |G|ᵀ|z|)_j: as large as the right-hand side's terms."""
    with np.errstate(all="ignore"):
        z = project_dual(problem, z)
        finite_h, _ = _constraining(problem)
        gain = -(problem.b @ y + finite_h @ z)
        terms = np.abs(problem.b) @ np.abs(y) + np.abs(finite_h) @ np.abs(z)
        sizes = _sizes(problem.A.T, y) + _sizes(problem.G.T, z)
        return _radius(gain / terms, _shares(problem.A.T @ y + problem.G.T @ z, sizes))


def _own_dual_radius(problem: Problem, x: Array) -> float:
    """The same of the dual: rows count in |c|ᵀ|x| over the sum of their own terms, a cone's in that of all of its rows."""
    with np.errstate(all="ignore"):
        _, constrains = _constraining(problem)
        direction = np.where(constrains, -(problem.G @ x), 0.0)
        rows = np.where(constrains, _sizes(problem.G, x), 0.0)
        for cone in problem.cones.second_order():
            rows[cone] = rows[cone].sum()
        obstacles = np.concatenate([problem.P @ x, problem.A @ x, _outside(direction, problem.cones)])
        sizes = np.concatenate([_sizes(problem.P, x), _sizes(problem.A, x), rows])
        terms = np.abs(problem.c) @ np.abs(x)
        return _radius(-(problem.c @ x) / terms, _shares(obstacles, sizes))


def _sizes(matrix: csc.Matrix, v: Array) -> Array:
    """|M| |v|."""
    values, rows, columns = csc.entries(matrix)
    out = np.zeros(matrix.shape[0])
    np.add.at(out, rows, np.abs(values * v[columns]))
    return out


def _shares(errors: Array, sizes: Array) -> Array:
    """Errors over the magnitudes of the terms that they are left of."""
    return np.divide(errors, sizes, out=np.zeros_like(errors), where=sizes > 0.0)


def _data_scale(problem: Problem, side: float) -> float:
    """The scale of right-hand sides of this size; no less than how near points can be where entries are small, over 100."""
    entry = max(_norm(csc.entries(matrix)[0]) for matrix in (problem.A, problem.G))
    return max(1.0, side, side / entry / 100.0 if entry >= np.finfo(float).tiny else 0.0)


def _largest_side(problem: Problem) -> float:
    return max(_norm(problem.b), _norm(_constraining(problem)[0]))


def objectives(problem: Problem, solution: HasPoint) -> tuple[float, float]:
    """The primal objective ½xᵀPx + cᵀx and the dual objective −½xᵀPx − bᵀy − hᵀz."""
    x = solution.x
    finite_h, _ = _constraining(problem)
    with np.errstate(all="ignore"):
        curvature = 0.5 * float(x @ (problem.P @ x))
        primal = curvature + float(problem.c @ x)
        return primal, -curvature - float(problem.b @ solution.y) - float(finite_h @ solution.z)


def project(v: Array, cones: Cones) -> Array:
    """The Euclidean projection of v (m,) onto K."""
    out = v.copy()
    np.maximum(out[: cones.l], 0.0, out=out[: cones.l])
    for rows in cones.second_order():
        out[rows] = _project_second_order(v[rows])
    return out


def project_dual(problem: Problem, z: Array) -> Array:
    """The projection of multipliers onto K, which is self-dual, with {0} for rows that do not constrain."""
    return np.where(_constraining(problem)[1], project(z, problem.cones), 0.0)


def _project_second_order(v: Array) -> Array:
    head, tail_norm = np.float64(v[0]), np.float64(np.linalg.norm(v[1:]))  # by which 0 divides to NaN
    if tail_norm <= head:
        return v
    if tail_norm <= -head:
        return np.zeros_like(v)
    # Outside K and its polar (or not finite): the nearest point is on the ray (1, u/‖u‖).
    t = 0.5 * (head + tail_norm)
    return np.concatenate([[t], (t / tail_norm) * v[1:]])


def _outside(v: Array, cones: Cones) -> Array:
    return v - project(v, cones)


def _constraining(problem: Problem) -> tuple[Array, NDArray[np.bool_]]:
    """h with zeros for its infinite entries, and which rows constrain."""
    constrains = np.isfinite(problem.h)
    return np.where(constrains, problem.h, 0.0), constrains


def _norm(v: Array) -> float:
    return float(np.max(np.abs(v))) if v.size else 0.0


def _largest(*values: float) -> float:
    """The maximum, NaN if any is NaN (the built-in `max` would drop it)."""
    return float(np.max(values))


def _or_inf(value: float) -> float:
    """NaN compares false with everything; infinity fails every tolerance."""
    return float("inf") if np.isnan(value) else float(value)


def _ratio(residual: Array, norm: float) -> float:
    return _or_inf(_norm(residual) / (1.0 + norm))


def _gap(primal: float, dual: float) -> float:
    with np.errstate(all="ignore"):
        return _or_inf(np.float64(abs(primal - dual)) / (1.0 + float(np.minimum(abs(primal), abs(dual)))))


def _radius(gain: float | np.float64, obstacles: Array) -> float:
    total = float(np.sum(np.abs(obstacles)))
    if not (gain > 0.0 and np.isfinite(gain) and np.isfinite(total)):
        return 0.0
    return float("inf") if total == 0.0 else float(gain / total)


def _point(problem: Problem, solution: HasPoint, slack: Array | None = None) -> Start:
    """The entries of a solution as float64 vectors of the problem's sizes."""
    if not isinstance(problem, Problem):
        raise TypeError(f"`problem` is of type {type(problem).__name__}; it must be an orbsoc.Problem")
    if not all(hasattr(solution, name) for name in "xyz"):
        raise TypeError(
            f"`solution` is of type {type(solution).__name__}; it must have x, y and z, as an orbsoc.Solution has"
        )
    return Start(
        x=csc.sized_vector("solution.x", solution.x, problem.n),
        y=csc.sized_vector("solution.y", solution.y, problem.p),
        z=csc.sized_vector("solution.z", solution.z, problem.m),
        s=csc.sized_vector("solution.s", np.zeros(problem.m) if slack is None else slack, problem.m),
    )
